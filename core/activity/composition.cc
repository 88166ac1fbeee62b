#include "core/activity/composition.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace takt::activity {
namespace {

using command::State;
using command::TransactionCommand;

State at_first(const State& state) {
  const auto known = command::apply(net::ValueType::kBoolean, "DefaultToBoolean", {{"input", {.node = state.node()}}},
                                    {{"fallback", false}});
  return State(command::apply(net::ValueType::kBoolean, "SnapshotBoolean",
                              {{"input", {.node = known}}, {"trigger", {.node = {}, .constant = true}}}));
}

std::string joined(const std::vector<ActivityPtr>& parts, const char* between) {
  std::string name;
  for (const ActivityPtr& part : parts) name += (name.empty() ? "" : between) + part->name();
  constexpr std::size_t kLongest = 60;
  return name.size() <= kLongest ? name : fmt::format("{} parts{}", parts.size(), between);
}

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
  /// What is known before part `i` when those before it are done.
  [[nodiscard]] PlanningContext before(std::size_t i, const PlanningContext& planning, const PlannedActivity& so_far,
                                       bool may_leave) const {
    PlanningContext own{.cell = planning.cell, .period = planning.period, .predecessors = {}};
    for (const std::string& name : parts_[i]->actuators()) {
      Predecessor& predecessor = own.predecessors[name];
      const auto done = so_far.end_states.find(name);
      if (done != so_far.end_states.end()) {
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

  [[nodiscard]] Result<PlannedActivity> prepare_part(std::size_t i, const PlanningContext& own) const {
    if (parts_[i]->begins_alone())
      return failure(Code::kConflict, fmt::format("/{}", i),
                     fmt::format("'{}' changes a control mode, which no part of a net can", parts_[i]->name()),
                     "an activity of its own, before or after the others");
    auto prepared = parts_[i]->prepare(own);
    if (prepared) {
      // Commands of one transaction have names of their own.
      prepared->command->node()->name = fmt::format("{} {}", i + 1, prepared->command->name());
      return prepared;
    }
    Diagnostics diagnostics;
    diagnostics.append(prepared.error(), fmt::format("/{}", i));
    return std::unexpected(std::move(diagnostics));
  }

  /// Takes over how part begins its actuators, where no other one had them before.
  static void add_begins(PlannedActivity& whole, const PlannedActivity& part) {
    for (const auto& [name, ways] : part.begins)
      if (!whole.end_states.contains(name)) whole.begins[name] = ways;
    for (const std::string& name : part.taken_over)
      if (!whole.end_states.contains(name)) whole.taken_over.insert(name);
  }
  static void add_end_states(PlannedActivity& whole, const PlannedActivity& part) {
    for (const auto& [name, end_state] : part.end_states) whole.end_states[name] = end_state;
  }

  std::vector<ActivityPtr> parts_;
};

class SequenceActivity final : public CompositeActivity {
 public:
  explicit SequenceActivity(const std::vector<ActivityPtr>& parts) : CompositeActivity(joined(parts, ", "), parts) {}

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    PlannedActivity whole;
    TransactionCommand all(name());
    std::optional<command::Command> last;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      auto part = prepare_part(i, before(i, planning, whole, i == 0));
      if (!part) return part;
      if (!last) {
        all.add_started(*part->command);
      } else {
        all.add(*part->command);
        all.on_entered(last->completed(), start(*part->command));
      }
      last = part->command;
      add_begins(whole, *part);
      add_end_states(whole, *part);
    }
    whole.command = all;
    return whole;
  }
};

class ParallelActivity final : public CompositeActivity {
 public:
  explicit ParallelActivity(const std::vector<ActivityPtr>& parts) : CompositeActivity(joined(parts, " | "), parts) {}

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    PlannedActivity whole;
    TransactionCommand all(name());
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      auto part = prepare_part(i, before(i, planning, {}, true));
      if (!part) return part;
      all.add_started(*part->command);
      add_begins(whole, *part);
      add_end_states(whole, *part);
    }
    whole.command = all;
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
    const State decided = at_first(condition_);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      auto part = prepare_part(i, before(i, planning, {}, false));
      if (!part) return part;
      both.add(*part->command);
      both.on_entered(i == 0 ? decided : !decided, start(*part->command));
      for (const auto& [name, ways] : part->begins)
        whole.begins[name].insert(whole.begins[name].end(), ways.begin(), ways.end());
      agree(whole, *part, planning);
    }
    // What only one of them moves may also stay where it is.
    for (auto& [name, end_state] : whole.end_states) {
      const bool in_both = std::ranges::all_of(
          parts_, [&name](const ActivityPtr& part) { return std::ranges::count(part->actuators(), name) > 0; });
      const auto given = planning.predecessors.find(name);
      if (!in_both && given != planning.predecessors.end())
        end_state.after = common(end_state.after, given->second.at_end);
    }
    whole.command = both;
    return whole;
  }

 private:
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
    all.add_started(*main->command);
    add_begins(whole, *main);
    add_end_states(whole, *main);
    for (std::size_t i = 0; i < subtasks_.size(); ++i) {
      const auto when = trigger(i, *main);
      if (!when) return std::unexpected(when.error());
      auto part = prepare_part(i + 1, before(i + 1, planning, {}, false));
      if (!part) return part;
      all.add(*part->command);
      all.on_entered(*when, start(*part->command), {.first_only = true});
      add_begins(whole, *part);
      add_end_states(whole, *part);
    }
    for (auto& [name, end_state] : whole.end_states) end_state.last.clear();
    whole.command = all;
    return whole;
  }

 private:
  [[nodiscard]] Result<State> trigger(std::size_t i, const PlannedActivity& main) const {
    const Subtask& subtask = subtasks_[i];
    const std::string pointer = fmt::format("/subtasks/{}", i);
    if (subtask.when) return *subtask.when;
    if (!subtask.at_share) return failure(Code::kMissing, pointer, "it never begins", "`at_share` or `when`");
    if (!main.at_share)
      return failure(Code::kConflict, pointer,
                     fmt::format("'{}' is not a motion, so it has no share of a path", parts_[0]->name()), "`when`");
    if (!(*subtask.at_share >= 0.0 && *subtask.at_share <= 1.0))
      return failure(Code::kOutOfRange, pointer, fmt::format("share {}", *subtask.at_share), "from 0 to 1");
    return main.at_share(*subtask.at_share);
  }

  std::vector<Subtask> subtasks_;
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
  if (parts.empty()) why.error(Code::kMissing, "", "a composition without parts", "at least one");
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (&parts[i].runtime() == &parts.front().runtime()) continue;
    why.error(Code::kRequires, pointer_segment(i),
              fmt::format("'{}' belongs to another runtime than '{}'", parts[i].model()->name(),
                          parts.front().model()->name()),
              "activities of one Runtime");
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
        "one after the other, by sequence()");
  }
}

}  // namespace

Activity sequence(const std::vector<Activity>& parts) {
  Runtime& runtime = runtime_of(parts);
  std::vector<ActivityPtr> models;
  for (ActivityPtr& model : models_of(parts)) {
    ActivityPtr one = models.empty() ? nullptr : models.back()->blended_into(*model);
    if (one) {
      models.back() = std::move(one);
    } else {
      models.push_back(std::move(model));
    }
  }
  if (models.size() == 1) return {runtime, models.front()};
  return {runtime, std::make_shared<const SequenceActivity>(models)};
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

}  // namespace takt::activity
