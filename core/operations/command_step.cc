#include "core/operations/command_step.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/mode_change.h"
#include "core/command/actions/motion_action.h"
#include "core/command/check.h"
#include "core/command/mapping.h"
#include "core/operations/command_builder.h"
#include "core/operations/compliance.h"
#include "core/operations/operation_command.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// Checks and plans a tree. @return diagnostics with locations of the file
/// @param[in,out] places  as command::plan() has them
Diagnostics plan(const CommandBuilder& tree, const command::Cell& cell, command::Places& places) {
  Diagnostics found;
  for (const CommandBuilder::Part& part : tree.parts()) part.request->check(cell, found);
  // What is planned is checked as a plan.
  const Diagnostics planned = command::plan(tree.command(), places);
  command::add_news(tree.in_file(command::check(tree.command(), false)), found);
  command::add_news(tree.in_file(planned), found);
  return found;
}

/// A tree of commands that was made for one execution. Its locations are those below the step.
struct MadeStep {
  MadeStep(const OperationCommand& root, Context& context, const command::ExternalHandler& tell)
      : tree(root, {.cell = context.cell, .biases = context.variables.biases, .notes = notes, .tell = tell}) {}
  Diagnostics notes;  ///< of planners; what there is to say was said in the rehearsal
  CommandBuilder tree;
};

/// Locations are whole; those of a step are below it.
Diagnostics below(const OperationCommand& root, const Diagnostics& diagnostics) {
  Diagnostics inside;
  for (Diagnostic diagnostic : diagnostics.list()) {
    if (diagnostic.pointer.starts_with(root.pointer)) diagnostic.pointer.erase(0, root.pointer.size());
    inside.add(std::move(diagnostic));
  }
  return inside;
}

/// The devices that a tree drives, each once.
std::vector<std::string> driven_by(const CommandBuilder& tree) {
  std::vector<std::string> devices;
  for (const CommandBuilder::Part& part : tree.parts()) {
    if (!part.made.actuator) continue;
    for (std::string& device : part.made.actuator->model().devices())
      if (std::ranges::find(devices, device) == devices.end()) devices.push_back(std::move(device));
  }
  return devices;
}

/// The tree as an activity that begins at rest; where it leaves its arms depends on the run.
class TreeActivity final : public ActivityModel {
 public:
  TreeActivity(const OperationCommand& root, std::shared_ptr<MadeStep> made)
      : ActivityModel(root.name), root_(root), made_(std::move(made)), actuators_(driven_by(made_->tree)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return actuators_; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    command::Places places;
    for (const auto& [device, before] : planning.predecessors)
      if (before.at_end.q) places[device] = *before.at_end.q;
    if (const Diagnostics wrong = plan(made_->tree, planning.cell, places); wrong.has_errors())
      return std::unexpected(below(root_, wrong));
    PlannedActivity prepared;
    prepared.command = made_->tree.command();
    for (const std::string& device : actuators_) prepared.end_states[device] = {};
    return prepared;
  }

 private:
  const OperationCommand& root_;
  std::shared_ptr<MadeStep> made_;
  std::vector<std::string> actuators_;
};

class CommandRun final : public ScheduledRun {
 public:
  explicit CommandRun(const OperationCommand& root) : root_(root) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    const auto tell = [&context, step = root_.name](const command::ExternalEvent& event) {
      context.variables.monitors[step][event.name] = std::to_string(event.count);
      context.event(step, "told",
                    event.cycle ? fmt::format("{} (cycle {})", event.name, *event.cycle)
                                : fmt::format("{} (cycle not known)", event.name));
    };
    const auto made = std::make_shared<MadeStep>(root_, context, tell);
    keys_.clear();
    for (const CommandBuilder::Part& part : made->tree.parts()) keys_.emplace_back(part.request, part.key);
    return std::make_shared<const TreeActivity>(root_, made);
  }

  Progress finish(Context& context, Diagnostics& diagnostics) override {
    if (run()->first_cycle() < 0) return Progress::kDone;  // it was called off before its start
    Diagnostics own;
    for (const auto& [request, key] : keys_) {
      request->finish(*run(), key, cancelled(), context, own);
      if (request->transaction() != nullptr) keep_captures(*request, key, context);
    }
    diagnostics.append(below(root_, own));
    return own.has_errors() ? Progress::kFailed : Progress::kDone;
  }

  /// What was captured, for `monitor(step, name)` in expressions.
  void keep_captures(const OperationCommand& transaction, const std::string& key, Context& context) const {
    for (const CaptureParameters& capture : transaction.transaction()->captures) {
      const std::string name = CommandBuilder::capture_name(key, capture.name);
      if (!run()->observes(name)) continue;
      const auto number = run()->value<net::Real>(name);
      const auto level = run()->value<net::Boolean>(name);
      const std::string text = number ? Json(*number).dump() : level ? Json(*level).dump() : "null";
      context.variables.monitors[root_.name][capture.name] = text;
      context.event(root_.name, capture.name, text);
    }
  }

  const OperationCommand& root_;
  std::vector<std::pair<const OperationCommand*, std::string>> keys_;
};

// -- Names ------------------------------------------------------------------------------------------------------------

/// What names mean: all of them are known once the whole tree is read.
class NameCheck {
 public:
  NameCheck(const OperationCommand& root, Diagnostics& diagnostics) : root_(root), diagnostics_(diagnostics) {}

  void run() {
    for (const OperationCommand* command : root_.all()) {
      for (const HandlerParameters& handler : command->handlers) check_handler(*command, handler);
      if (!command->follows().empty())
        check_command(*command, command->follows(), command->pointer + "/value/progress");
      if (command->transaction() == nullptr) continue;
      for (const CaptureParameters& capture : command->transaction()->captures) {
        if (capture.value.kind == ValueParameters::Kind::kProgress)
          check_command(*command, capture.value.of, capture.pointer + "/value/progress");
        if (capture.when) check_state(*command, *capture.when);
      }
      for (std::size_t i = 0; i < command->transaction()->forward_to.size(); ++i) {
        check_command(*command, command->transaction()->forward_to[i],
                      command->pointer + "/on_cancel" + pointer_segment(i));
      }
    }
  }

 private:
  void check_handler(const OperationCommand& owner, const HandlerParameters& handler) {
    check_state(owner, handler.state);
    for (const HandlerParameters::Effect& effect : handler.effects) {
      if (effect.kind == Kind::kExternal) {
        if (effect.name.empty())
          diagnostics_.error(Code::kMissing, effect.pointer, "an empty text", "the text to report");
      } else if (effect.kind == Kind::kRaise) {
        check_raised(owner, effect.name, effect.pointer);
      } else {
        check_command(owner, effect.name, effect.pointer);
      }
    }
  }

  void check_state(const OperationCommand& owner, const StateParameters& state) {
    for (const StateParameters& operand : state.operands) check_state(owner, operand);
    if (state.kind == StateParameters::Kind::kRaised) check_raised(owner, state.of, state.pointer + "/raised");
    if (state.kind == StateParameters::Kind::kCommand) check_command(owner, state.of, state.pointer + "/" + state.is);
    if (state.kind == StateParameters::Kind::kAction) check_command(owner, state.of, state.pointer + "/action");
  }

  void check_command(const OperationCommand& owner, const std::string& name, const std::string& pointer) {
    if (owner.find(name) != nullptr) return;
    std::vector<std::string> names;
    for (const OperationCommand* command : root_.all()) names.push_back(command->name);
    diagnostics_.error(Code::kUnknownName, pointer,
                       fmt::format("C6: there is no command '{}' in '{}'", name, root_.name),
                       nearest_choice(name, names));
  }

  void check_raised(const OperationCommand& owner, const std::string& name, const std::string& pointer) {
    if (owner.find_raised(name) != nullptr) return;
    std::vector<std::string> names;
    for (const OperationCommand* command : root_.all()) {
      if (command->transaction() == nullptr) continue;
      names.insert(names.end(), command->transaction()->raised.begin(), command->transaction()->raised.end());
    }
    const std::string nearest = names.empty() ? "" : nearest_choice(name, names) + "; ";
    diagnostics_.error(Code::kUnknownName, pointer, fmt::format("C10: no transaction has the raised state '{}'", name),
                       nearest + "'raised' of a transaction around this place");
  }

  const OperationCommand& root_;
  Diagnostics& diagnostics_;
};

std::unique_ptr<OperationCommand> read_root(const OperationSource& source) {
  const auto& [json, pointer, cell, diagnostics] = source;
  auto root = read_any_command(source);
  if (!json.is_object()) return root;
  Diagnostics unheard;
  ObjectReader reader(json, pointer, unheard);
  root->name = read_name(reader, root->name);
  if (json.contains("start")) {
    diagnostics.error(Code::kConflict, pointer + "/start",
                      "'start' belongs to commands of a transaction, not to a step",
                      "a command inside of a transaction");
  }
  NameCheck(*root, diagnostics).run();
  return root;
}

class CommandStep final : public Step {
 public:
  explicit CommandStep(std::unique_ptr<OperationCommand> root) : root_(std::move(root)) {}

  /// Arms go to the natural end of what moves them; where that is not known before they stay.
  void rehearse(Rehearsal& rehearsal, const std::string&, Diagnostics& diagnostics) const override {
    const command::Biases untared;
    Diagnostics notes;
    const BuildContext making{.cell = rehearsal.cell, .biases = untared, .notes = notes};
    const CommandBuilder tree(*root_, making);
    command::Places places = rehearsal.q;
    const Diagnostics wrong = plan(tree, rehearsal.cell, places);
    diagnostics.append(notes);
    if (wrong.has_errors()) return diagnostics.append(wrong);
    const auto mapped = command::map(tree.command());
    if (!mapped) return diagnostics.append(tree.in_file(mapped.error()));
    for (const CommandBuilder::Part& part : tree.parts()) {
      const auto mode = part.made.action ? part.made.action->model().mode() : std::nullopt;
      if (!mode) continue;
      for (const std::string& arm : part.made.actuator->model().devices())
        rehearse_mode(rehearsal, arm, *mode, part.request->pointer, diagnostics);
    }
    rehearse_net(mapped->net, rehearsal, root_->pointer, diagnostics);
    for (const CommandBuilder::Part& part : tree.parts()) {
      if (part.made.action) rehearsal.duration += part.made.command.node()->model().duration();
    }
    rehearsal.q = std::move(places);
    for (const CommandBuilder::Part& part : tree.parts()) part.request->rehearse(rehearsal, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<CommandRun>(*root_); }

 private:
  std::unique_ptr<OperationCommand> root_;
};

}  // namespace

std::unique_ptr<Step> step_of_command(const OperationSource& source) {
  return std::make_unique<CommandStep>(read_root(source));
}

}  // namespace takt::activity
