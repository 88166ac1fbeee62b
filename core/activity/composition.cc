#include "core/activity/composition.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "core/activity/command_activity.h"
#include "core/command/command_tree.h"

namespace takt::activity {
namespace {

using command::TransactionCommand;
using expression::State;

State at_first(const State& state) {
  const auto known = expression::apply(net::ValueType::kBoolean, "DefaultToBoolean",
                                       {{"input", {.node = state.node()}}}, {{"fallback", false}});
  return State(expression::apply(net::ValueType::kBoolean, "SnapshotBoolean",
                                 {{"input", {.node = known}}, {"trigger", {.node = {}, .constant = true}}}));
}

std::string joined(const std::vector<ActivityPtr>& parts, const char* between) {
  std::string name;
  for (const ActivityPtr& part : parts) name += (name.empty() ? "" : between) + part->name();
  constexpr std::size_t kLongest = 60;
  return name.size() <= kLongest ? name : fmt::format("{} parts{}", parts.size(), between);
}

/// A part has a name of its own in its transaction, shows how it went, and what it observes is named by its number.
void name_part(command::Command& command, std::size_t i, const std::string& part) {
  command::CommandNode& node = *command.node();
  const std::string number = fmt::format("{} ", i + 1);
  if (!node.name.starts_with(number)) node.name.insert(0, number);
  node.part = part;
  observe_once(node, kPartStarted, command.started().node());
  observe_once(node, kPartCompleted, command.completed().node());
  observe_once(node, kPartCancelled, command.cancelled().node());
  observe_once(node, kPartFailed, command.failed().node());
}

/// A part of a composition that is over, with what it says of its end.
struct PartEnd {
  std::string part, name;  ///< "/1"; of its activity
  std::function<Diagnostics(const RunView&)> verdict;

  [[nodiscard]] Diagnostics judge(const RunView& run) const {
    if (run.state() == RunState::kQueued) return {};  // it was not begun
    Diagnostics wrong = verdict ? verdict(run) : Diagnostics();
    if (!wrong.has_errors() && run.state() == RunState::kFailed)
      wrong.error(Code::kConditionNotMet, "", "it has failed", "Remove the cause and ask for it again");
    return wrong;
  }
};

Diagnostics judge(const RunView& run, const std::vector<PartEnd>& ends) {
  Diagnostics all;
  for (const PartEnd& end : ends) {
    const Diagnostics wrong = end.judge(run.inside(end.part));
    for (Diagnostic diagnostic : wrong.list()) {
      diagnostic.pointer.insert(0, end.part);
      diagnostic.message = fmt::format("'{}': {}", end.name, diagnostic.message);
      all.add(std::move(diagnostic));
    }
  }
  return all;
}

bool can_fail(const command::Command& command) { return command::CommandTree(command).can_fail(0); }

/// Parts that are prepared one by one against what the ones before leave behind.
class CompositeActivity : public ActivityModel {
 public:
  CompositeActivity(std::string name, std::vector<ActivityPtr> parts)
      : ActivityModel(std::move(name)), parts_(std::move(parts)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override {
    std::vector<std::string> all;
    for (const ActivityPtr& part : parts_)
      for (const std::string& name : part->actuators())
        if (std::ranges::find(all, name) == all.end()) all.push_back(name);
    return all;
  }

 protected:
  using EndStates = std::map<std::string, EndState, std::less<>>;

  /// What is known before part `i` when those before it are done.
  [[nodiscard]] PlanningContext before(std::size_t i, const PlanningContext& planning, const EndStates& so_far,
                                       bool may_leave) const {
    PlanningContext own{.cell = planning.cell, .period = planning.period, .predecessors = {}};
    for (const std::string& name : parts_[i]->actuators()) {
      Predecessor& predecessor = own.predecessors[name];
      const auto done = so_far.find(name);
      if (done != so_far.end()) {
        predecessor.at_end = done->second.after;
        continue;
      }
      const auto given = planning.predecessors.find(name);
      if (given == planning.predecessors.end()) continue;
      predecessor.at_end = given->second.at_end;
      if (may_leave) predecessor.leaving = given->second.leaving;
    }
    return own;
  }

  /// @param part  of the whole, "/1"
  [[nodiscard]] Result<PlannedActivity> prepare_part(std::size_t i, PlanningContext own,
                                                     const std::string& part) const {
    if (parts_[i]->begins_alone())
      return failure(Code::kConflict, place_of(i),
                     fmt::format("'{}' changes a control mode, which no part of a net can", parts_[i]->name()),
                     "Make it an activity of its own, before or after the others");
    own.is_part = true;
    auto prepared = parts_[i]->prepare(own);
    if (prepared) {
      name_part(*prepared->command, i, part);
      return prepared;
    }
    Diagnostics diagnostics;
    diagnostics.append(prepared.error(), place_of(i));
    return std::unexpected(std::move(diagnostics));
  }
  [[nodiscard]] Result<PlannedActivity> prepare_part(std::size_t i, const PlanningContext& own) const {
    return prepare_part(i, own, place_of(i));
  }
  /// Where the part is among those that the program has named.
  [[nodiscard]] virtual std::string place_of(std::size_t i) const { return pointer_segment(i); }

  [[nodiscard]] PartEnd end_of(std::size_t i, PlannedActivity& planned, const std::string& part) const {
    return {part, parts_[i]->name(), std::move(planned.verdict)};
  }
  [[nodiscard]] PartEnd end_of(std::size_t i, PlannedActivity& planned) const {
    return end_of(i, planned, place_of(i));
  }
  /// It fails where one of its parts has.
  static void finish(PlannedActivity& whole, const TransactionCommand& all, std::vector<PartEnd> ends) {
    whole.command = all;
    whole.can_fail = can_fail(all);
    whole.verdict = [ends = std::move(ends)](const RunView& run) { return judge(run, ends); };
  }
  /// A part that has failed ends the others in order, and nothing begins any more.
  static void end_at_failure(TransactionCommand& all, const std::vector<command::Command>& parts) {
    std::optional<State> failed;
    for (const command::Command& part : parts)
      if (can_fail(part)) failed = failed ? *failed || part.failed() : part.failed();
    if (failed) all.on_entered(*failed, cancel(all));
  }

  /// Takes over how part begins its actuators, where no other one had them before.
  static void add_begins(PlannedActivity& whole, const PlannedActivity& part) {
    for (const auto& [name, ways] : part.begins)
      if (!whole.end_states.contains(name)) whole.begins[name] = ways;
    for (const auto& [name, hand_over] : part.taken_over)
      if (!whole.end_states.contains(name)) whole.taken_over[name] = hand_over;
    whole.touching.insert(part.touching.begin(), part.touching.end());
  }
  static void add_end_states(PlannedActivity& whole, const PlannedActivity& part) {
    for (const auto& [name, end_state] : part.end_states) whole.end_states[name] = end_state;
  }

  std::vector<ActivityPtr> parts_;
};

class SequenceActivity final : public CompositeActivity {
 public:
  /// @param places  of each part among those that the program has named: some are one motion
  SequenceActivity(const std::vector<ActivityPtr>& parts, std::vector<std::size_t> places)
      : CompositeActivity(joined(parts, ", "), parts), places_(std::move(places)) {}

  /// A part after one with several endings is planned for each of them, where that makes a difference.
  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    PlannedActivity whole;
    TransactionCommand all(name());
    std::vector<Branch> branches(1);
    std::vector<PartEnd> ends;
    std::optional<command::Command> last;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      auto planned = plan_part(i, planning, branches);
      if (!planned) return std::unexpected(std::move(planned.error()));
      const command::Command command = command_of(i, *planned, branches);
      if (last) {
        all.add(command).on_entered(last->completed(), start(command));
      } else {
        all.add_started(command);
      }
      last = command;
      for (const PlannedActivity& part : *planned) add_begins(whole, part);
      add_ends(i, *planned, ends);
      branches = after(branches, *planned);
      if (branches.size() > kMostEndings)
        return failure(Code::kTooLarge, place_of(i), fmt::format("{} ways in which it may end", branches.size()),
                       fmt::format("Keep it to {} at most", kMostEndings));
      whole.end_states = common_states(branches);
    }
    if (branches.size() > 1)
      for (const Branch& branch : branches) whole.endings.push_back({*branch.taken, states_of(branch)});
    finish(whole, all, std::move(ends));
    return whole;
  }

 private:
  static constexpr std::size_t kMostEndings = 8;

  [[nodiscard]] std::string place_of(std::size_t i) const override { return pointer_segment(places_[i]); }
  /// @param count  how often the part is planned. @param k  for which of the branches
  [[nodiscard]] std::string part_of(std::size_t i, std::size_t count, std::size_t k) const {
    return count == 1 ? place_of(i) : place_of(i) + pointer_segment(k);
  }
  void add_ends(std::size_t i, std::vector<PlannedActivity>& planned, std::vector<PartEnd>& ends) const {
    for (std::size_t k = 0; k < planned.size(); ++k)
      ends.push_back(end_of(i, planned[k], part_of(i, planned.size(), k)));
  }

  /// The endings until now; without a state: the only one.
  struct Branch {
    std::optional<State> taken;
    EndStates end_states;
  };

  [[nodiscard]] static std::map<std::string, ActuatorState, std::less<>> states_of(const Branch& branch) {
    std::map<std::string, ActuatorState, std::less<>> states;
    for (const auto& [name, end_state] : branch.end_states) states[name] = end_state.after;
    return states;
  }

  /// Part `i` once if it begins alike in all branches, else for each of them.
  [[nodiscard]] Result<std::vector<PlannedActivity>> plan_part(std::size_t i, const PlanningContext& planning,
                                                               const std::vector<Branch>& branches) const {
    std::vector<PlannedActivity> planned;
    const std::size_t count = begins_alike(i, branches) ? 1 : branches.size();
    for (std::size_t k = 0; k < count; ++k) {
      auto part = prepare_part(i, before(i, planning, branches[k].end_states, i == 0), part_of(i, count, k));
      if (!part) return std::unexpected(std::move(part.error()));
      if (count > 1) part->command->node()->name += fmt::format(" after end {}", k + 1);
      planned.push_back(std::move(*part));
    }
    return planned;
  }

  [[nodiscard]] bool begins_alike(std::size_t i, const std::vector<Branch>& branches) const {
    const auto state_in = [](const Branch& branch, const std::string& name) {
      const auto found = branch.end_states.find(name);
      return found == branch.end_states.end() ? std::nullopt : std::optional(found->second.after);
    };
    return std::ranges::all_of(parts_[i]->actuators(), [&](const std::string& name) {
      const auto first = state_in(branches.front(), name);
      return std::ranges::all_of(branches, [&](const Branch& one) { return state_in(one, name) == first; });
    });
  }

  /// What was planned, or a choice of it by the branch that was taken.
  [[nodiscard]] static command::Command command_of(std::size_t i, const std::vector<PlannedActivity>& planned,
                                                   const std::vector<Branch>& branches) {
    if (planned.size() == 1) return *planned.front().command;
    TransactionCommand choice(fmt::format("{} by where it begins", i + 1));
    for (std::size_t k = 0; k < planned.size(); ++k)
      choice.add(*planned[k].command).on_entered(*branches[k].taken, start(*planned[k].command));
    return choice;
  }

  [[nodiscard]] static std::vector<Branch> after(const std::vector<Branch>& branches,
                                                 const std::vector<PlannedActivity>& planned) {
    std::vector<Branch> all;
    for (std::size_t k = 0; k < branches.size(); ++k) {
      const PlannedActivity& part = planned.size() == 1 ? planned.front() : planned[k];
      Branch branch = branches[k];
      for (const auto& [name, end_state] : part.end_states) branch.end_states[name] = end_state;
      if (part.endings.empty()) all.push_back(branch);
      for (const Ending& ending : part.endings) {
        Branch& own = all.emplace_back(branch);
        own.taken = branch.taken ? *branch.taken && ending.taken : ending.taken;
        for (const auto& [name, state] : ending.after) own.end_states[name].after = state;
      }
    }
    const bool alike =
        std::ranges::all_of(all, [&](const Branch& one) { return states_of(one) == states_of(all.front()); });
    if (alike && all.size() > 1) {
      all.resize(1);
      all.front().taken.reset();
    }
    return all;
  }

  /// What is known whichever branch was taken.
  [[nodiscard]] static EndStates common_states(const std::vector<Branch>& branches) {
    EndStates states = branches.front().end_states;
    for (const Branch& branch : std::span(branches).subspan(1)) {
      for (auto& [name, end_state] : states)
        end_state = {.after = common(end_state.after, branch.end_states.at(name).after), .last = {}};
    }
    return states;
  }

  std::vector<std::size_t> places_;
};

class ParallelActivity final : public CompositeActivity {
 public:
  explicit ParallelActivity(const std::vector<ActivityPtr>& parts) : CompositeActivity(joined(parts, " | "), parts) {}

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    PlannedActivity whole;
    TransactionCommand all(name());
    std::vector<PartEnd> ends;
    std::vector<command::Command> commands;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      auto part = prepare_part(i, before(i, planning, EndStates(), true));
      if (!part) return part;
      all.add_started(*part->command);
      commands.push_back(*part->command);
      add_begins(whole, *part);
      add_end_states(whole, *part);
      ends.push_back(end_of(i, *part));
    }
    end_at_failure(all, commands);
    finish(whole, all, std::move(ends));
    return whole;
  }
};

class ConditionalActivity final : public CompositeActivity {
 public:
  ConditionalActivity(State condition, const std::vector<ActivityPtr>& parts)
      : CompositeActivity(joined(parts, " or "), parts), condition_(std::move(condition)) {}

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    PlannedActivity whole;
    TransactionCommand both(name());
    std::vector<PartEnd> ends;
    const State decided = at_first(condition_);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      auto part = prepare_part(i, before(i, planning, EndStates(), false));
      if (!part) return part;
      both.add(*part->command);
      both.on_entered(i == 0 ? decided : !decided, start(*part->command));
      for (const auto& [name, ways] : part->begins)
        whole.begins[name].insert(whole.begins[name].end(), ways.begin(), ways.end());
      whole.touching.insert(part->touching.begin(), part->touching.end());
      agree(whole, *part, planning);
      add_endings(whole, *part);
      ends.push_back(end_of(i, *part));
    }
    // What only one of them moves may also stay where it is.
    for (auto& [name, end_state] : whole.end_states) {
      const bool in_both = std::ranges::all_of(
          parts_, [&name](const ActivityPtr& part) { return std::ranges::count(part->actuators(), name) > 0; });
      const auto given = planning.predecessors.find(name);
      if (!in_both && given != planning.predecessors.end())
        end_state.after = common(end_state.after, given->second.at_end);
    }
    // What an ending does not move stays where it is.
    for (Ending& ending : whole.endings) {
      for (const auto& [name, end_state] : whole.end_states) {
        const auto given = planning.predecessors.find(name);
        if (given != planning.predecessors.end()) ending.after.try_emplace(name, given->second.at_end);
      }
    }
    finish(whole, both, std::move(ends));
    return whole;
  }

 private:
  static void add_endings(PlannedActivity& whole, const PlannedActivity& part) {
    if (!part.endings.empty())
      return (void)whole.endings.insert(whole.endings.end(), part.endings.begin(), part.endings.end());
    Ending& ending = whole.endings.emplace_back(Ending{part.command->started(), {}});
    for (const auto& [name, end_state] : part.end_states) ending.after[name] = end_state.after;
  }

  static void agree(PlannedActivity& whole, const PlannedActivity& part, const PlanningContext&) {
    for (const auto& [name, end_state] : part.end_states) {
      const auto known = whole.end_states.find(name);
      whole.end_states[name] = {
          .after = known == whole.end_states.end() ? end_state.after : common(known->second.after, end_state.after),
          .last = {}};
    }
  }

  State condition_;
};

class MainTaskActivity final : public CompositeActivity {
 public:
  MainTaskActivity(const std::vector<ActivityPtr>& parts, std::vector<Subtask> subtasks)
      : CompositeActivity(parts.front()->name() + " with subtasks", parts), subtasks_(std::move(subtasks)) {}

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    auto main = prepare_part(0, before(0, planning, {}, true));
    if (!main) return main;
    PlannedActivity whole;
    TransactionCommand all(name());
    std::vector<PartEnd> ends;
    std::vector<command::Command> commands{*main->command};
    all.add_started(*main->command);
    add_begins(whole, *main);
    add_end_states(whole, *main);
    for (std::size_t i = 0; i < subtasks_.size(); ++i) {
      const auto when = trigger(i, *main);
      if (!when) return std::unexpected(when.error());
      auto part = prepare_part(i + 1, before(i + 1, planning, EndStates(), false));
      if (!part) return part;
      all.add(*part->command);
      all.on_entered(*when, start(*part->command), {.first_only = true});
      commands.push_back(*part->command);
      add_begins(whole, *part);
      add_end_states(whole, *part);
      ends.push_back(end_of(i + 1, *part));
    }
    ends.push_back(end_of(0, *main));
    for (auto& [name, end_state] : whole.end_states) end_state.last.clear();
    end_at_failure(all, commands);
    finish(whole, all, std::move(ends));
    return whole;
  }

 private:
  [[nodiscard]] Result<State> trigger(std::size_t i, const PlannedActivity& main) const {
    const Subtask& subtask = subtasks_[i];
    const std::string pointer = fmt::format("/subtasks/{}", i);
    if (subtask.when) return *subtask.when && main.command->active();
    if (!subtask.at_share) return failure(Code::kMissing, pointer, "it never begins", "Give `at_share` or `when`");
    if (!main.at_share)
      return failure(Code::kConflict, pointer,
                     fmt::format("'{}' is not a motion, so it has no share of a path", parts_[0]->name()),
                     "Give `when`");
    if (!(*subtask.at_share >= 0.0 && *subtask.at_share <= 1.0))
      return failure(Code::kOutOfRange, pointer, fmt::format("share {}", *subtask.at_share),
                     "Choose a share from 0 to 1");
    return main.at_share(*subtask.at_share);
  }

  std::vector<Subtask> subtasks_;
};

/// An activity that is cancelled, and fails, when a state holds.
class AbortActivity final : public ActivityModel {
 public:
  AbortActivity(ActivityPtr inner, State state)
      : ActivityModel(inner->name()), inner_(std::move(inner)), state_(std::move(state)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return inner_->actuators(); }
  [[nodiscard]] bool begins_alone() const override { return inner_->begins_alone(); }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    auto prepared = inner_->prepare(planning);
    if (!prepared) return prepared;
    if (!prepared->command)
      return failure(Code::kUnsupported, "/abort_if",
                     fmt::format("'{}' is not a command, so nothing can end it", name()),
                     "Give an activity that moves something");
    if (!watches(*prepared->command)) add_abort(*prepared->command, state_, {});
    // What goes on with it would not watch the state any more.
    for (auto& [name, end_state] : prepared->end_states) end_state.last.clear();
    prepared->can_fail = true;
    prepared->verdict = [inner = std::move(prepared->verdict)](const RunView& run) {
      Diagnostics wrong = inner ? inner(run) : Diagnostics();
      wrong.append(abort_diagnostics(run, std::string()));
      return wrong;
    };
    return prepared;
  }

  [[nodiscard]] const ActivityPtr& inner() const { return inner_; }
  [[nodiscard]] const State& state() const { return state_; }

 private:
  /// A command of the program's own is carried out again and again.
  [[nodiscard]] bool watches(const command::Command& command) const {
    return std::ranges::any_of(command.node()->handlers, [&](const command::EventHandler& one) {
      return one.state.node() == state_.node() && one.effect.target == command.subject();
    });
  }

  ActivityPtr inner_;
  State state_;
};

std::vector<ActivityPtr> models_of(const std::vector<Activity>& parts) {
  std::vector<ActivityPtr> models;
  for (const Activity& part : parts) models.push_back(part.model());
  return models;
}

void throw_errors(Diagnostics diagnostics) {
  if (diagnostics.has_errors()) throw ActivityError(std::move(diagnostics));
}

/// The runtime of all parts. Throws for none, and for parts of several.
Runtime& runtime_of(const std::vector<Activity>& parts) {
  Diagnostics why;
  if (parts.empty()) why.error(Code::kMissing, "", "a composition without parts", "Give at least one");
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (&parts[i].runtime() == &parts.front().runtime()) continue;
    why.error(Code::kRequires, pointer_segment(i),
              fmt::format("'{}' belongs to another runtime than '{}'", parts[i].model()->name(),
                          parts.front().model()->name()),
              "Compose activities of one Runtime");
  }
  throw_errors(std::move(why));
  return parts.front().runtime();
}

/// What runs together drives actuators of its own.
void check_apart(const Activity& part, const Activity& other, const std::string& place, Diagnostics& diagnostics) {
  const auto others = other.model()->actuators();
  for (const std::string& name : part.model()->actuators()) {
    if (std::ranges::find(others, name) == others.end()) continue;
    diagnostics.error(
        Code::kResourceConflict, place,
        fmt::format("'{}' drives '{}' together with '{}'", part.model()->name(), name, other.model()->name()),
        "Put them one after the other, by sequence()");
  }
}

}  // namespace

Activity sequence(const std::vector<Activity>& parts) {
  Runtime& runtime = runtime_of(parts);
  std::vector<ActivityPtr> models;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ActivityPtr one = models.empty() ? nullptr : models.back()->blended_into(*parts[i].model());
    if (one) {
      models.back() = std::move(one);
      places.back() = i;
    } else {
      models.push_back(parts[i].model());
      places.push_back(i);
    }
  }
  if (models.size() == 1) return {runtime, models.front()};
  return {runtime, std::make_shared<const SequenceActivity>(models, std::move(places))};
}

Activity parallel(const std::vector<Activity>& parts) {
  Runtime& runtime = runtime_of(parts);
  Diagnostics shared;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t other = 0; other < i; ++other) check_apart(parts[i], parts[other], pointer_segment(i), shared);
  }
  throw_errors(std::move(shared));
  return {runtime, std::make_shared<const ParallelActivity>(models_of(parts))};
}

Activity conditional(const State& condition, const Activity& then, const Activity& otherwise) {
  return {runtime_of({then, otherwise}),
          std::make_shared<const ConditionalActivity>(condition, std::vector{then.model(), otherwise.model()})};
}

Activity with_subtasks(const Activity& main, const std::vector<Subtask>& subtasks) {
  std::vector<Activity> parts{main};
  for (const Subtask& subtask : subtasks) parts.push_back(subtask.activity);
  Runtime& runtime = runtime_of(parts);
  Diagnostics shared;
  for (std::size_t i = 0; i < subtasks.size(); ++i) {
    check_apart(subtasks[i].activity, main, fmt::format("/subtasks/{}", i), shared);
  }
  throw_errors(std::move(shared));
  return {runtime, std::make_shared<const MainTaskActivity>(models_of(parts), subtasks)};
}

Activity abort_if(const Activity& activity, const State& state) {
  if (const auto* other = dynamic_cast<const AbortActivity*>(activity.model().get()))
    return {activity.runtime(), std::make_shared<const AbortActivity>(other->inner(), other->state() || state)};
  return {activity.runtime(), std::make_shared<const AbortActivity>(activity.model(), state)};
}

}  // namespace takt::activity
