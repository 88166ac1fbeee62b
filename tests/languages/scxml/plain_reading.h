#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "languages/scxml/chart.h"

namespace takt::languages::test {

/// The algorithm of SCXML 1.0, appendix D, as it is written there, for charts whose content is <raise> alone and whose
/// conditions are In('state'). It shares nothing with the interpreter but the chart as data: ancestors are found by
/// walking, sets are made anew. The trace has "+state" and "-state".
class PlainReading {
 public:
  explicit PlainReading(const Chart& chart) : c(chart) {}

  std::string trace;
  bool running = true, endless = false;
  std::set<int> configuration;

  void interpret() {
    std::set<int> to_enter, by_default;
    std::map<int, int> content;
    for (const int s : initial_of(0)) add_descendants(s, to_enter, by_default, content);
    for (const int s : effective(initial_of(0))) add_ancestors(s, 0, to_enter, by_default, content);
    enter(to_enter, by_default, content);
    macrostep();
  }
  void event(const std::string& name) {
    if (!running) return;
    const auto enabled = select(name, false);
    if (!enabled.empty()) microstep(enabled);
    macrostep();
  }

 private:
  using Kind = ChartState::Kind;
  const Chart& c;
  std::map<int, std::vector<int>> history;
  std::deque<std::string> internal;

  const ChartState& at(int s) const { return c.states[static_cast<std::size_t>(s)]; }
  const ChartTransition& tr(int t) const { return c.transitions[static_cast<std::size_t>(t)]; }
  std::vector<int> initial_of(int s) const {
    if (at(s).initial >= 0) return tr(at(s).initial).targets;
    return {at(s).children.front()};
  }
  bool compound(int s) const { return at(s).kind != Kind::kParallel && !at(s).children.empty(); }
  bool atomic(int s) const {
    return at(s).kind == Kind::kFinal || (at(s).kind == Kind::kState && at(s).children.empty());
  }
  bool descendant(int s, int of) const {
    for (int p = at(s).parent; p >= 0; p = at(p).parent)
      if (p == of) return true;
    return false;
  }
  std::vector<int> ancestors(int s, int until) const {
    std::vector<int> all;
    for (int p = at(s).parent; p >= 0 && p != until; p = at(p).parent) all.push_back(p);
    return all;
  }
  bool in(const std::string& id) const {
    return std::ranges::any_of(configuration, [&](int s) { return s > 0 && at(s).id == id; });
  }

  void macrostep() {
    for (int steps = 0; running;) {
      if (++steps > 2000) {
        endless = true;
        running = false;
        return;
      }
      auto enabled = select({}, true);
      if (enabled.empty()) {
        if (internal.empty()) return;
        const std::string name = internal.front();
        internal.pop_front();
        enabled = select(name, false);
      }
      if (!enabled.empty()) microstep(enabled);
    }
  }

  std::vector<int> select(const std::string& name, bool eventless) {
    std::vector<int> enabled;
    for (const int s : configuration) {
      if (!atomic(s)) continue;
      std::vector<int> up = ancestors(s, -1);
      up.insert(up.begin(), s);
      bool found = false;
      for (const int one : up) {
        for (const int t : at(one).transitions) {
          if (tr(t).events.empty() != eventless) continue;
          const auto& events = tr(t).events;
          const bool named = std::ranges::any_of(events, [&](const std::string& e) { return e == name || e == "*"; });
          if (!eventless && !named) continue;
          const std::string& condition = tr(t).condition.text;
          if (!condition.empty() && !in(condition.substr(4, condition.size() - 6))) continue;
          if (std::ranges::find(enabled, t) == enabled.end()) enabled.push_back(t);
          found = true;
          break;
        }
        if (found) break;
      }
    }
    std::vector<int> filtered;
    for (const int t1 : enabled) {
      bool preempted = false;
      std::set<int> remove;
      for (const int t2 : filtered) {
        const auto a = exits({t1}), b = exits({t2});
        std::vector<int> both;
        std::ranges::set_intersection(a, b, std::back_inserter(both));
        if (both.empty()) continue;
        if (descendant(tr(t1).source, tr(t2).source)) {
          remove.insert(t2);
        } else {
          preempted = true;
          break;
        }
      }
      if (preempted) continue;
      std::erase_if(filtered, [&](int t) { return remove.contains(t); });
      filtered.push_back(t1);
    }
    return filtered;
  }

  void run(const ChartBlock& block) {
    for (const ChartAction& action : block) internal.push_back(action.text("event"));
  }

  void microstep(const std::vector<int>& enabled) {
    const auto leaving = exits(enabled);
    for (const int s : leaving) {
      for (const int h : at(s).histories) {
        history[h].clear();
        for (const int one : configuration) {
          const bool keep = at(h).kind == Kind::kDeepHistory ? atomic(one) && descendant(one, s) : at(one).parent == s;
          if (keep) history[h].push_back(one);
        }
      }
    }
    for (auto s = leaving.rbegin(); s != leaving.rend(); ++s) {
      for (const auto& block : at(*s).on_exit) run(block);
      configuration.erase(*s);
      trace += "-" + at(*s).id;
    }
    for (const int t : enabled) run(tr(t).block);
    std::set<int> to_enter, by_default;
    std::map<int, int> content;
    for (const int t : enabled) {
      for (const int s : tr(t).targets) add_descendants(s, to_enter, by_default, content);
      const int ancestor = domain(t);
      for (const int s : effective(tr(t).targets)) add_ancestors(s, ancestor, to_enter, by_default, content);
    }
    enter(to_enter, by_default, content);
  }

  void enter(const std::set<int>& to_enter, const std::set<int>& by_default, const std::map<int, int>& content) {
    for (const int s : to_enter) {
      configuration.insert(s);
      trace += "+" + at(s).id;
      for (const auto& block : at(s).on_entry) run(block);
      if (by_default.contains(s) && at(s).initial >= 0) run(tr(at(s).initial).block);
      if (content.contains(s)) run(tr(content.at(s)).block);
      if (at(s).kind != Kind::kFinal) continue;
      const int parent = at(s).parent;
      if (parent == 0) {
        running = false;
        continue;
      }
      internal.push_back("done.state." + at(parent).id);
      const int grandparent = at(parent).parent;
      if (at(grandparent).kind == Kind::kParallel &&
          std::ranges::all_of(at(grandparent).children, [&](int child) { return in_final(child); }))
        internal.push_back("done.state." + at(grandparent).id);
    }
  }
  bool in_final(int s) const {
    if (compound(s))
      return std::ranges::any_of(at(s).children,
                                 [&](int k) { return at(k).kind == Kind::kFinal && configuration.contains(k); });
    return at(s).kind == Kind::kParallel && std::ranges::all_of(at(s).children, [&](int k) { return in_final(k); });
  }

  std::set<int> exits(const std::vector<int>& transitions) const {
    std::set<int> all;
    for (const int t : transitions) {
      if (tr(t).targets.empty()) continue;
      for (const int s : configuration)
        if (descendant(s, domain(t))) all.insert(s);
    }
    return all;
  }
  std::vector<int> effective(const std::vector<int>& targets) const {
    std::vector<int> all;
    for (const int s : targets) {
      if (!at(s).is_history()) {
        all.push_back(s);
      } else if (history.contains(s)) {
        all.insert(all.end(), history.at(s).begin(), history.at(s).end());
      } else {
        const auto more = effective(tr(at(s).transitions.front()).targets);
        all.insert(all.end(), more.begin(), more.end());
      }
    }
    return all;
  }
  int domain(int t) const {
    const auto targets = effective(tr(t).targets);
    const int source = tr(t).source;
    const auto all_in = [&](int s) {
      return std::ranges::all_of(targets, [&](int one) { return descendant(one, s); });
    };
    if (tr(t).internal && compound(source) && all_in(source)) return source;
    for (const int s : ancestors(source, -1))
      if (compound(s) && all_in(s)) return s;
    return 0;
  }

  void add_descendants(int s, std::set<int>& to_enter, std::set<int>& by_default, std::map<int, int>& content) const {
    if (at(s).is_history()) {
      const int parent = at(s).parent, only = at(s).transitions.front();
      const bool known = history.contains(s);
      if (!known) content[parent] = only;
      const std::vector<int> targets = known ? history.at(s) : tr(only).targets;
      for (const int one : targets) add_descendants(one, to_enter, by_default, content);
      for (const int one : targets) add_ancestors(one, parent, to_enter, by_default, content);
      return;
    }
    to_enter.insert(s);
    if (compound(s)) {
      by_default.insert(s);
      for (const int one : initial_of(s)) add_descendants(one, to_enter, by_default, content);
      for (const int one : initial_of(s)) add_ancestors(one, s, to_enter, by_default, content);
    } else if (at(s).kind == Kind::kParallel) {
      add_children(s, to_enter, by_default, content);
    }
  }
  void add_ancestors(int s, int until, std::set<int>& to_enter, std::set<int>& by_default,
                     std::map<int, int>& content) const {
    for (const int one : ancestors(s, until)) {
      to_enter.insert(one);
      if (at(one).kind == Kind::kParallel) add_children(one, to_enter, by_default, content);
    }
  }
  void add_children(int s, std::set<int>& to_enter, std::set<int>& by_default, std::map<int, int>& content) const {
    for (const int child : at(s).children) {
      const bool some = std::ranges::any_of(to_enter, [&](int one) { return descendant(one, child); });
      if (!some) add_descendants(child, to_enter, by_default, content);
    }
  }
};

}  // namespace takt::languages::test
