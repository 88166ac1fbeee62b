#include "languages/scxml/session.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "languages/scxml/system.h"

namespace takt::languages {
namespace {

using Kind = ChartState::Kind;

/// More of them without an event in between are a chart that never comes to rest.
constexpr int kMostMicrosteps = 10'000;
/// Events that wait at once.
constexpr std::size_t kMostEvents = 10'000;

}  // namespace

/// The states that a microstep enters, and what else is to be done for them.
struct ChartSession::Entry {
  std::set<int> states, by_default;
  std::map<int, int> of_history;  ///< state to the transition of its history
};

ChartSession::ChartSession(ChartSystem& system, std::shared_ptr<const Chart> chart, std::string id)
    : system_(system), chart_(std::move(chart)), id_(std::move(id)) {
  model_ = make_model(*chart_, id_, system_.seed(), [this](const std::string& name) {
    return std::ranges::any_of(configuration_, [&](int index) { return index > 0 && state(index).id == name; });
  });
}

ChartSession::~ChartSession() = default;

std::vector<std::string> ChartSession::configuration() const {
  std::vector<std::string> ids;
  for (const int index : configuration_)
    if (index > 0) ids.push_back(state(index).id);
  return ids;
}

void ChartSession::start(const std::map<std::string, Data>& given) {
  started_ = running_ = true;
  const auto& states = chart_->states;
  if (chart_->early_binding) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      for (const ChartVariable& one : states[i].variables) (void)model_->declare(one.id);
      initialized_.insert(static_cast<int>(i));
    }
    for (std::size_t i = 0; i < states.size(); ++i) initialize(states[i].variables, i == 0 ? &given : nullptr);
  } else {
    initialized_.insert(0);
    initialize(states.front().variables, &given);
  }
  if (!chart_->script.empty()) {
    if (const auto done = model_->execute(chart_->script); !done) error("error.execution", done.error());
  }
  Entry entry;
  configuration_.insert(0);
  const int initial = states.front().initial;
  if (initial >= 0) (void)run(transition(initial).block);
  for (const int target : default_targets(0)) add_descendants(target, entry);
  for (const int target : initial >= 0 ? effective_targets(transition(initial).targets) : default_targets(0))
    add_ancestors(target, 0, entry);
  for (const int index : entry.states) enter(index, entry);
}

bool ChartSession::step() {
  if (!running_) return false;
  bool did = settle();
  if (!running_) return true;
  if (external_.empty()) return did;
  const ChartEvent event = std::move(external_.front());
  external_.pop_front();
  take_external(event);
  (void)settle();
  return true;
}

/// Until no transition is enabled and no internal event waits, and what is to be invoked is.
bool ChartSession::settle() {
  int steps = 0;
  while (running_) {
    TransitionList enabled = select(nullptr);
    if (enabled.empty() && !internal_.empty()) {
      const ChartEvent event = std::move(internal_.front());
      internal_.pop_front();
      tell("event", event.name);
      model_->set_event(event);
      enabled = select(&event);
      ++steps;
    } else if (enabled.empty()) {
      if (to_invoke_.empty()) break;
      for (const int index : std::exchange(to_invoke_, {})) {
        for (const ChartInvoke& one : state(index).invokes) invoke(index, one);
      }
      ++steps;
      continue;
    }
    if (!enabled.empty()) microstep(enabled);
    if (++steps > kMostMicrosteps) fail(fmt::format("{} microsteps without coming to rest", kMostMicrosteps));
    if (internal_.size() + external_.size() > kMostEvents) fail(fmt::format("more than {} events wait", kMostEvents));
  }
  if (!running_ && started_) end();
  return steps > 0;
}

void ChartSession::take_external(const ChartEvent& event) {
  tell("event", event.name);
  model_->set_event(event);
  for (const Call& call : std::vector<Call>(calls_)) {
    if (!event.invokeid.empty() && call.id == event.invokeid) finalize(*call.invoke, event);
    if (call.invoke->autoforward && call.child != nullptr) call.child->post(event);
  }
  if (event.name.starts_with("done.invoke.") && !event.invokeid.empty())
    std::erase_if(calls_, [&](const Call& call) { return call.id == event.invokeid && call.child == nullptr; });
  const TransitionList enabled = select(&event);
  if (!enabled.empty()) microstep(enabled);
}

void ChartSession::cancel() {
  if (!running_) return;
  running_ = false;
  end();
}

/// exitInterpreter of appendix D.
void ChartSession::end() {
  if (!std::exchange(started_, false)) return;
  running_ = false;
  bool final_left = false;
  for (const int index : std::vector<int>(configuration_.rbegin(), configuration_.rend())) {
    if (index == 0) continue;
    leave(index);
    final_left = final_left || (state(index).kind == Kind::kFinal && state(index).parent == 0);
  }
  configuration_.clear();
  external_.clear();
  internal_.clear();
  system_.session_over(*this, final_left && failure_.empty());
}

void ChartSession::fail(std::string why) {
  if (failure_.empty()) failure_ = std::move(why);
  tell("failed", failure_);
  running_ = false;
}

ChartSession::TransitionList ChartSession::select(const ChartEvent* event) {
  TransitionList enabled;
  for (const int atomic : std::vector<int>(configuration_.begin(), configuration_.end())) {
    if (!state(atomic).is_atomic()) continue;
    bool found = false;
    for (int index = atomic; index >= 0 && !found; index = state(index).parent) {
      for (const int one : state(index).transitions) {
        if (!is_enabled(transition(one), event)) continue;
        if (std::ranges::find(enabled, one) == enabled.end()) enabled.push_back(one);
        found = true;
        break;
      }
    }
  }
  return without_conflicts(enabled);
}

bool ChartSession::is_enabled(const ChartTransition& transition, const ChartEvent* event) {
  if (transition.events.empty() != (event == nullptr)) return false;
  if (event != nullptr && !std::ranges::any_of(transition.events, [&](const std::string& descriptor) {
        return event_matches(descriptor, event->name);
      }))
    return false;
  if (!transition.condition.empty()) {
    const auto holds = model_->condition(transition.condition.text);
    if (!holds) return error("error.execution", holds.error());
    if (!*holds) return false;
  }
  if (transition.sensors.empty()) return true;
  const auto& sensors = system_.surroundings().sensors;
  return sensors && sensors(*this, transition).value_or(false);
}

ChartSession::TransitionList ChartSession::without_conflicts(const TransitionList& enabled) const {
  if (enabled.size() < 2) return enabled;
  TransitionList kept;
  for (const int one : enabled) {
    const std::set<int> exits = exit_set({one});
    bool preempted = false;
    TransitionList removed;
    for (const int other : kept) {
      const std::set<int> others = exit_set({other});
      if (!std::ranges::any_of(exits, [&](int index) { return others.contains(index); })) continue;
      if (chart_->is_inside(transition(one).source, transition(other).source)) {
        removed.push_back(other);
      } else {
        preempted = true;
        break;
      }
    }
    if (preempted) continue;
    std::erase_if(kept, [&](int other) { return std::ranges::find(removed, other) != removed.end(); });
    kept.push_back(one);
  }
  return kept;
}

void ChartSession::microstep(const TransitionList& transitions) {
  exit_states(transitions);
  for (const int one : transitions) (void)run(transition(one).block);
  enter_states(transitions);
}

void ChartSession::exit_states(const TransitionList& transitions) {
  const std::set<int> exits = exit_set(transitions);
  for (const int index : exits) to_invoke_.erase(index);
  for (const int index : exits) {
    for (const int history : state(index).histories) {
      std::vector<int>& remembered = history_[history];
      remembered.clear();
      for (const int active : configuration_) {
        const bool is_it = state(history).kind == Kind::kDeepHistory
                               ? state(active).is_atomic() && chart_->is_inside(active, index)
                               : state(active).parent == index;
        if (is_it) remembered.push_back(active);
      }
    }
  }
  for (auto index = exits.rbegin(); index != exits.rend(); ++index) leave(*index);
}

void ChartSession::leave(int index) {
  for (const Block& block : state(index).on_exit) (void)run(block);
  for (const Call& call : std::vector<Call>(calls_))
    if (call.state == index) cancel_call(call);
  std::erase_if(calls_, [&](const Call& call) { return call.state == index; });
  configuration_.erase(index);
  tell("left", state(index).id);
}

void ChartSession::enter_states(const TransitionList& transitions) {
  Entry entry;
  for (const int one : transitions) {
    for (const int target : transition(one).targets) add_descendants(target, entry);
    const int around = domain(transition(one));
    for (const int target : effective_targets(transition(one).targets)) add_ancestors(target, around, entry);
  }
  for (const int index : entry.states) enter(index, entry);
}

void ChartSession::enter(int index, const Entry& entry) {
  const ChartState& own = state(index);
  configuration_.insert(index);
  to_invoke_.insert(index);
  if (initialized_.insert(index).second) initialize(own.variables, nullptr);
  tell("entered", own.id);
  for (const Block& block : own.on_entry) (void)run(block);
  if (entry.by_default.contains(index) && own.initial >= 0) (void)run(transition(own.initial).block);
  const auto history = entry.of_history.find(index);
  if (history != entry.of_history.end()) (void)run(transition(history->second).block);
  if (own.kind == Kind::kFinal) finish(index);
}

/// A final state is entered: done events of what is around it.
void ChartSession::finish(int index) {
  const ChartDoneData& done = state(index).done;
  std::optional<Data> data;
  if (done.given) data = data_of(done.parameters, done.content, {}, true);
  const int parent = state(index).parent;
  if (parent == 0) {
    result_ = data.value_or(Data{});
    running_ = false;
    return;
  }
  raise({.name = "done.state." + state(parent).id, .type = ChartEvent::Type::kPlatform, .data = data.value_or(Data{})});
  const int grandparent = state(parent).parent;
  if (grandparent <= 0 || state(grandparent).kind != Kind::kParallel) return;
  if (std::ranges::all_of(state(grandparent).children, [&](int child) { return is_in_final(child); }))
    raise({.name = "done.state." + state(grandparent).id, .type = ChartEvent::Type::kPlatform});
}

std::set<int> ChartSession::exit_set(const TransitionList& transitions) const {
  std::set<int> exits;
  for (const int one : transitions) {
    if (transition(one).targets.empty()) continue;
    const int around = domain(transition(one));
    for (const int index : configuration_)
      if (chart_->is_inside(index, around)) exits.insert(index);
  }
  return exits;
}

std::vector<int> ChartSession::default_targets(int index) const {
  const ChartState& own = state(index);
  if (own.initial >= 0) return transition(own.initial).targets;
  return own.children.empty() ? std::vector<int>{} : std::vector<int>{own.children.front()};
}

std::vector<int> ChartSession::effective_targets(const std::vector<int>& targets) const {
  std::vector<int> result;
  for (const int target : targets) {
    if (!state(target).is_history()) {
      result.push_back(target);
      continue;
    }
    const auto remembered = history_.find(target);
    const std::vector<int> own = remembered != history_.end()
                                     ? remembered->second
                                     : effective_targets(transition(state(target).transitions.front()).targets);
    result.insert(result.end(), own.begin(), own.end());
  }
  return result;
}

int ChartSession::domain(const ChartTransition& transition) const {
  const std::vector<int> targets = effective_targets(transition.targets);
  const bool stays = transition.internal && state(transition.source).is_compound() &&
                     std::ranges::all_of(targets, [&](int one) { return chart_->is_inside(one, transition.source); });
  return stays ? transition.source : common_ancestor(transition.source, targets);
}

int ChartSession::common_ancestor(int first, const std::vector<int>& others) const {
  for (int around = state(first).parent; around >= 0; around = state(around).parent) {
    if (!state(around).is_compound()) continue;
    if (std::ranges::all_of(others, [&](int one) { return chart_->is_inside(one, around); })) return around;
  }
  return 0;
}

bool ChartSession::is_in_final(int index) const {
  const ChartState& own = state(index);
  if (own.is_compound()) {
    return std::ranges::any_of(
        own.children, [&](int child) { return state(child).kind == Kind::kFinal && configuration_.contains(child); });
  }
  return own.kind == Kind::kParallel &&
         std::ranges::all_of(own.children, [&](int child) { return is_in_final(child); });
}

void ChartSession::add_descendants(int index, Entry& entry) const {
  const ChartState& own = state(index);
  if (own.is_history()) {
    const auto remembered = history_.find(index);
    const int only = own.transitions.front();
    if (remembered == history_.end()) entry.of_history[own.parent] = only;
    const std::vector<int>& targets = remembered != history_.end() ? remembered->second : transition(only).targets;
    for (const int target : targets) add_descendants(target, entry);
    for (const int target : targets) add_ancestors(target, own.parent, entry);
    return;
  }
  entry.states.insert(index);
  if (own.is_compound()) {
    entry.by_default.insert(index);
    const std::vector<int> targets = default_targets(index);
    for (const int target : targets) add_descendants(target, entry);
    for (const int target : targets) add_ancestors(target, index, entry);
  } else if (own.kind == Kind::kParallel) {
    add_regions(index, entry);
  }
}

void ChartSession::add_ancestors(int index, int around, Entry& entry) const {
  for (int between = state(index).parent; between != around && between >= 0; between = state(between).parent) {
    entry.states.insert(between);
    if (state(between).kind == Kind::kParallel) add_regions(between, entry);
  }
}

/// The children of a parallel in which nothing is to be entered yet.
void ChartSession::add_regions(int index, Entry& entry) const {
  for (const int child : state(index).children) {
    const bool has = std::ranges::any_of(entry.states, [&](int one) { return chart_->is_inside(one, child); });
    if (!has) add_descendants(child, entry);
  }
}

}  // namespace takt::languages
