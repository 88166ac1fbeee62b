#include "core/operations/command/command_step.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/mode_change.h"
#include "core/command/actions/motion_action.h"
#include "core/command/check.h"
#include "core/command/mapping.h"
#include "core/operations/command/command_builder.h"
#include "core/operations/command/command_collisions.h"
#include "core/operations/command/command_review.h"
#include "core/operations/command/operation_activity.h"
#include "core/operations/command/operation_command.h"
#include "core/operations/table/compliance.h"
#include "core/operations/table/rehearsed_net.h"
#include "core/operations/table/scheduled_run.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;

/// Those of its devices that are compliant with it: of an arm on a base the arm alone.
std::vector<std::string> compliant_devices(const command::ActuatorModel& actuator) {
  const auto arms = actuator.arms(), compliant = actuator.compliant_arms();
  std::vector<std::string> devices = actuator.devices();
  std::vector<std::string> result;
  for (std::size_t i = 0; i < arms.size(); ++i)
    if (std::ranges::find(compliant, arms[i]) != compliant.end()) result.push_back(std::move(devices[i]));
  return result;
}

class CommandRun final : public ScheduledRun {
 public:
  /// @param left  the motion that may be left for the next step; null: none
  CommandRun(OperationActivity::RootPtr root, const OperationCommand* left)
      : root_(std::move(root)), left_(left), left_parts_(left != nullptr ? left->left_steps().size() : 0) {}

  [[nodiscard]] bool can_blend_out() const override {
    return left_ != nullptr && run() && run()->part() == left_parts_ - 1;
  }

 private:
  [[nodiscard]] activity::ActivityPtr activity(activity::Context& context) override {
    context.variables.monitors.erase(root_->name);  // an earlier run says nothing of this one
    const auto tell = [&context, step = root_->name](const command::ExternalEvent& event) {
      context.variables.monitors[step][event.name] = std::to_string(event.count);
      context.event(step, "told",
                    event.cycle ? fmt::format("{} (cycle {})", event.name, *event.cycle)
                                : fmt::format("{} (cycle not known)", event.name));
    };
    auto tree = std::make_shared<const OperationActivity>(root_, context,
                                                          OperationActivity::Options{.tell = tell, .judged = false});
    keys_ = tree->keys();
    return tree;
  }

  /// When the motion that may be left moves, everything else is over.
  Progress watch(activity::Context& context, Diagnostics& diagnostics) override {
    if (run()->started()) show_captures(context);
    if (!can_blend_out() || std::exchange(reported_, true)) return Progress::kRunning;
    const Progress progress = report(context, diagnostics, [this](const auto& one) { return &one != left_; });
    return progress == Progress::kDone ? Progress::kRunning : progress;
  }

  Progress finish(activity::Context& context, Diagnostics& diagnostics) override {
    if (run()->first_cycle() < 0) return Progress::kDone;  // it was called off before its start
    return report(context, diagnostics, [this](const auto& one) { return !reported_ || &one == left_; });
  }

  /// What has come of those commands that count.
  Progress report(activity::Context& context, Diagnostics& diagnostics,
                  const std::function<bool(const OperationCommand&)>& counts) const {
    Diagnostics own;
    for (const auto& [request, key] : keys_) {
      if (counts(*request)) request->report(*run(), key, cancelled(), context, own);
      if (request->transaction() != nullptr) keep_captures(*request, key, context);
    }
    diagnostics.append(below(*root_, own));
    return own.has_errors() ? Progress::kFailed : Progress::kDone;
  }

  /// What was captured, for `monitor(step, name)` in expressions.
  void keep_captures(const OperationCommand& transaction, const std::string& key, activity::Context& context) const {
    for (const CaptureParameters& capture : transaction.transaction()->captures) keep(capture, key, context);
  }
  /// The same of those that are due in this cycle.
  void show_captures(activity::Context& context) const {
    for (const auto& [request, key] : keys_) {
      if (request->transaction() == nullptr) continue;
      for (const CaptureParameters& capture : request->transaction()->captures)
        if (capture.rate && is_due(*capture.rate, context)) keep(capture, key, context);
    }
  }
  void keep(const CaptureParameters& capture, const std::string& key, activity::Context& context) const {
    const std::string name = CommandBuilder::capture_name(key, capture.name);
    if (!run()->observes(name)) return;
    const auto number = run()->value<net::Real>(name);
    const auto level = run()->value<net::Boolean>(name);
    const std::string text = number ? Json(*number).dump() : level ? Json(*level).dump() : "null";
    context.variables.monitors[root_->name][capture.name] = text;
    context.event(root_->name, capture.name, text);
  }

  OperationActivity::RootPtr root_;
  const OperationCommand* left_;
  std::size_t left_parts_;
  bool reported_ = false;
  OperationActivity::Keys keys_;
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
          diagnostics_.error(Code::kMissing, effect.pointer, "an empty text", "Give the text to report");
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
                       nearest + "Name the state 'raised' of a transaction around it");
  }

  const OperationCommand& root_;
  Diagnostics& diagnostics_;
};

/// The tools of all commands of a tree. One arm works with one tool in it: what its controller is told does not change
/// while a net runs.
ArmTools tools_of(const OperationCommand& root) {
  ArmTools tools;
  for (const OperationCommand* command : root.all())
    for (ArmTool& one : command->arm_tools()) tools.push_back(std::move(one));
  return tools;
}

void check_tools(const OperationCommand& root, Diagnostics& diagnostics) {
  const ArmTools tools = tools_of(root);
  for (const ArmTool& one : tools) {
    const auto first = std::ranges::find(tools, one.arm, &ArmTool::arm);
    if (first->choice == one.choice) continue;
    diagnostics.error(Code::kConflict, one.pointer + (first->choice.tool == one.choice.tool ? "/tcp" : "/tool"),
                      fmt::format("'{}' works with two tools in one transaction", one.arm),
                      "Use one tool and one tool centre point for an arm, or two steps");
  }
}

std::unique_ptr<OperationCommand> read_root(const OperationSource& source) {
  const auto& [json, pointer, cell, diagnostics] = source;
  auto root = read_any_command(source);
  if (!json.is_object()) return root;
  Diagnostics ignored;
  ObjectReader reader(json, pointer, ignored);
  if (!root->is_called_by_type()) root->name = read_name(reader, root->name);
  if (json.contains("start")) {
    diagnostics.error(Code::kConflict, pointer + "/start",
                      "'start' belongs to commands of a transaction, not to a step",
                      "Use 'start' on a command inside of a transaction");
  }
  NameCheck(*root, diagnostics).run();
  check_tools(*root, diagnostics);
  return root;
}

class CommandStep final : public Step {
 public:
  explicit CommandStep(std::unique_ptr<OperationCommand> root) : root_(std::move(root)) {
    for (const OperationCommand* one : root_->all())
      if (!one->left_arm().empty()) left_ = one;
  }

  [[nodiscard]] std::string moved_arm() const override { return left_ != nullptr ? left_->left_arm() : std::string(); }
  [[nodiscard]] Json left_steps() const override { return left_ != nullptr ? left_->left_steps() : Json(); }
  [[nodiscard]] ArmTools arm_tools() const override { return tools_of(*root_); }

  /// Arms go to the natural end of what moves them; where that is not known before they stay.
  void rehearse(Rehearsal& rehearsal, const std::string&, Diagnostics& diagnostics) const override {
    settle_rehearsal(rehearsal, diagnostics);
    const expression::Biases untared;
    Diagnostics notes, wrong;
    expression::Places places;
    command::TreeEnd end;
    std::optional<CommandBuilder> made;
    CommandReview review(*root_, rehearsal);
    do {
      notes = {};
      places = rehearsal.q;
      end = {};
      made.emplace(*root_, BuildContext{.cell = rehearsal.cell,
                                        .biases = untared,
                                        .notes = notes,
                                        .meanwhile = review.meanwhile(),
                                        .widths = rehearsal.collisions.widths});
      wrong = plan_commands(*made, rehearsal.cell, places, end);
    } while (review.plan_again(*made, wrong));
    diagnostics.append(notes);
    review.finish(diagnostics);
    if (wrong.has_errors()) return diagnostics.append(wrong);
    const CommandBuilder& tree = *made;
    const auto mapped = command::map(tree.command());
    if (!mapped) return diagnostics.append(tree.in_file(mapped.error()));
    for (const CommandBuilder::Part& part : tree.parts()) {
      const auto mode = part.made.action ? part.made.action->model().mode() : std::nullopt;
      if (!mode) continue;
      for (const std::string& arm : compliant_devices(part.made.actuator->model()))
        rehearse_mode(rehearsal, arm, *mode, part.request->pointer, diagnostics);
    }
    rehearse_net(mapped->net, rehearsal, root_->pointer, diagnostics);
    check_motions(tree, rehearsal, diagnostics);
    rehearse_time(tree, rehearsal);
    rehearsal.q = std::move(places);
    for (const CommandBuilder::Part& part : tree.parts()) part.request->rehearse(rehearsal, diagnostics);
    if (left_ != nullptr) rehearsal.open = {left_->left_arm(), left_->pointer};
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<CommandRun>(root_, left_); }

 private:
  OperationActivity::RootPtr root_;
  const OperationCommand* left_ = nullptr;  ///< the motion that asks for a blend into the next step
};

}  // namespace

std::unique_ptr<Step> step_of_command(const OperationSource& source) {
  return std::make_unique<CommandStep>(read_root(source));
}

}  // namespace takt::operations
