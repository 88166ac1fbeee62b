// What is wrong with the states and transitions of a chart as a whole.
#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "languages/scxml/reader.h"

namespace takt::languages {
namespace {

using Kind = ChartState::Kind;

class ChartChecks {
 public:
  ChartChecks(const Chart& chart, Diagnostics& diagnostics) : chart_(chart), diagnostics_(diagnostics) {}

  void run() {
    if (state(0).children.empty()) error(state(0).at, Code::kMissing, "a chart without states", "Add a <state>");
    for (int i = 0; i < size(); ++i) {
      check_initial(i);
      check_history(i);
    }
    for (const ChartTransition& transition : chart_.transitions) check_targets(transition);
    if (!diagnostics_.has_errors()) note_unreachable();
  }

 private:
  [[nodiscard]] int size() const { return static_cast<int>(chart_.states.size()); }
  [[nodiscard]] const ChartState& state(int index) const { return chart_.states[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const ChartTransition& transition(int index) const {
    return chart_.transitions[static_cast<std::size_t>(index)];
  }
  void error(const TextLocation& at, Code code, std::string message, std::string hint) {
    error_at(at, code, std::move(message), std::move(hint), diagnostics_);
  }

  void check_initial(int index) {
    const ChartState& own = state(index);
    if (own.initial < 0) return;
    for (const int target : transition(own.initial).targets) {
      if (chart_.is_inside(target, index)) continue;
      error(transition(own.initial).at, Code::kInvalidValue,
            fmt::format("initial state '{}' does not lie in '{}'", state(target).id, own.id),
            "Name a state inside of it");
    }
  }

  void check_history(int index) {
    const ChartState& own = state(index);
    if (!own.is_history()) return;
    if (own.transitions.size() != 1) {
      error(own.at, Code::kMissing, fmt::format("history '{}' has {} transitions", own.id, own.transitions.size()),
            "Give it one: where it leads before its state was visited");
      return;
    }
    const ChartTransition& only = transition(own.transitions.front());
    if (!only.events.empty() || !only.condition.empty() || !only.sensors.empty() || only.targets.empty())
      error(only.at, Code::kInvalidValue, "the transition of a history has an event or a condition, or no target",
            "Give it a target alone");
    for (const int target : only.targets) {
      const bool fits =
          own.kind == Kind::kDeepHistory ? chart_.is_inside(target, own.parent) : state(target).parent == own.parent;
      if (!fits)
        error(only.at, Code::kInvalidValue,
              fmt::format("'{}' is no state that history '{}' could remember", state(target).id, own.id),
              own.kind == Kind::kDeepHistory ? "Name a state inside of the history's parent"
                                             : "Name a child of the history's parent, or write type=\"deep\"");
    }
  }

  /// Two states can be active at the same time.
  [[nodiscard]] bool compatible(int a, int b) const {
    if (a == b || chart_.is_inside(a, b) || chart_.is_inside(b, a)) return true;
    int around = state(a).parent;
    while (!chart_.is_inside(b, around)) around = state(around).parent;
    return state(around).kind == Kind::kParallel;
  }
  void check_targets(const ChartTransition& one) {
    for (std::size_t i = 0; i < one.targets.size(); ++i)
      for (std::size_t j = i + 1; j < one.targets.size(); ++j)
        if (!compatible(one.targets[i], one.targets[j]) || one.targets[i] == one.targets[j])
          error(one.at, Code::kConflict,
                fmt::format("'{}' and '{}' cannot be active together", state(one.targets[i]).id,
                            state(one.targets[j]).id),
                "Name states in different regions of a parallel");
  }

  /// What no transition leads to from what is entered.
  void note_unreachable() {
    std::vector<char> reached(static_cast<std::size_t>(size()), 0);
    std::vector<int> left;
    const auto reach = [&](int index) {
      for (; index >= 0 && !reached[static_cast<std::size_t>(index)]; index = state(index).parent) {
        reached[static_cast<std::size_t>(index)] = 1;
        left.push_back(index);
      }
    };
    reach(0);
    while (!left.empty()) {
      const int index = left.back();
      left.pop_back();
      const ChartState& own = state(index);
      for (const int one : own.transitions)
        for (const int target : transition(one).targets) reach(target);
      if (own.initial >= 0) {
        for (const int target : transition(own.initial).targets) reach(target);
      } else if (own.is_compound()) {
        reach(own.children.front());
      }
      if (own.kind == Kind::kParallel) std::ranges::for_each(own.children, reach);
    }
    for (int i = 1; i < size(); ++i)
      if (!reached[static_cast<std::size_t>(i)] && reached[static_cast<std::size_t>(state(i).parent)] &&
          !state(i).is_history())
        warning_at(state(i).at, Code::kNeverFires, fmt::format("no transition leads to '{}'", state(i).id),
                   "Remove the state, or add a transition to it", diagnostics_);
  }

  const Chart& chart_;
  Diagnostics& diagnostics_;
};

}  // namespace

void check_chart(const Chart& chart, Diagnostics& diagnostics) { ChartChecks(chart, diagnostics).run(); }

}  // namespace takt::languages
