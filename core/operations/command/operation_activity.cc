#include "core/operations/command/operation_activity.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/command/check.h"
#include "core/command/command_tree.h"
#include "core/operations/command/command_collisions.h"
#include "core/operations/command/command_review.h"

namespace takt::operations {
namespace {

/// Who asks for a blend is the last that its transaction does.
void check_left(const CommandBuilder& tree, const command::TreeEnd& end, Diagnostics& found) {
  for (const CommandBuilder::Part& part : tree.parts()) {
    const bool left = part.made.command.node().get() == end.left;
    if (part.request->left_arm().empty() || left) continue;
    found.error(
        Code::kConflict, part.request->pointer,
        fmt::format("'{}' cannot be left for the motion after the transaction: something else may still happen, "
                    "or it is more than a plain motion of one arm",
                    part.request->name),
        "End with a plain motion that begins when all others have completed and whose end starts nothing, or remove "
        "the blend");
  }
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

/// An arm that rests before it begins where it is; where it is afterwards is for the operation to say.
void begin_at_rest(const activity::PlanningContext& planning, activity::ArmAfter arms,
                   activity::PlannedActivity& planned) {
  for (auto& [actuator, end_state] : planned.end_states) {
    const auto before = planning.predecessors.find(actuator);
    if (before == planning.predecessors.end() || !before->second.at_end.q) continue;
    const activity::ActuatorState& state = before->second.at_end;
    if (arms == activity::ArmAfter::kStays) end_state.after = state;
    device::Seam seam;
    seam.q = *state.q;
    seam.dq = seam.ddq = kinematics::JointVector::Zero(state.q->size());
    planned.begins[actuator].push_back(seam);
  }
}

class RefusedActivity final : public activity::ActivityModel {
 public:
  RefusedActivity(std::string name, std::string actuator, Diagnostics why)
      : activity::ActivityModel(std::move(name)), actuator_(std::move(actuator)), why_(std::move(why)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {actuator_}; }
  [[nodiscard]] Result<activity::PlannedActivity> prepare(const activity::PlanningContext&) const override {
    return std::unexpected(why_);
  }

 private:
  std::string actuator_;
  Diagnostics why_;
};

}  // namespace

Diagnostics plan_commands(const CommandBuilder& tree, const expression::Cell& cell, expression::Places& places,
                          command::TreeEnd& end) {
  Diagnostics found;
  for (const CommandBuilder::Part& part : tree.parts()) part.request->check(cell, found);
  // What is planned is checked as a plan.
  const Diagnostics planned = command::plan(tree.command(), places, &end);
  command::append_new(tree.in_file(command::check(tree.command(), false)), found);
  command::append_new(tree.in_file(planned), found);
  if (!found.has_errors()) check_left(tree, end, found);
  return found;
}

Diagnostics below(const OperationCommand& root, const Diagnostics& diagnostics) {
  Diagnostics inside;
  for (Diagnostic diagnostic : diagnostics.list()) {
    if (diagnostic.pointer.starts_with(root.pointer)) diagnostic.pointer.erase(0, root.pointer.size());
    inside.add(std::move(diagnostic));
  }
  return inside;
}

OperationActivity::OperationActivity(RootPtr root, activity::Context& context, Options options)
    : activity::ActivityModel(options.name.empty() ? root->name : options.name),
      root_(std::move(root)),
      context_(context),
      options_(std::move(options)),
      biases_(context.variables.biases),
      meanwhile_(meanwhile_of(*root_, context.meanwhile)) {
  Diagnostics notes;
  const CommandBuilder tree(*root_, {.cell = context.cell, .biases = biases_, .notes = notes, .meanwhile = meanwhile_});
  if (options_.actuators.empty()) options_.actuators = driven_by(tree);
  for (const CommandBuilder::Part& part : tree.parts()) keys_.emplace_back(part.request, part.key);
}

Result<activity::PlannedActivity> OperationActivity::prepare(const activity::PlanningContext& planning) const {
  Diagnostics notes;  // of planners; what there is to say of a file was said in the rehearsal
  const CommandBuilder tree(*root_, {.cell = planning.cell,
                                     .biases = biases_,
                                     .notes = notes,
                                     .tell = options_.tell,
                                     .meanwhile = meanwhile_,
                                     .is_part = planning.is_part});
  expression::Places places = activity::places_before(planning);
  command::TreeEnd end;
  if (const Diagnostics wrong = plan_commands(tree, planning.cell, places, end); wrong.has_errors())
    return std::unexpected(below(*root_, wrong));
  activity::PlannedActivity planned = activity::planned_activity(tree.command(), options_.actuators, end);
  planned.touching = touching(tree);
  if (options_.arms) begin_at_rest(planning, *options_.arms, planned);
  if (!options_.judged) return planned;
  planned.can_fail = command::CommandTree(tree.command()).can_fail(0);
  planned.verdict = [root = root_, keys = keys_, &context = context_](const activity::RunView& run) {
    Diagnostics found;
    for (const auto& [request, key] : keys) request->report(run, key, /*cancelled=*/false, context, found);
    return below(*root, found);
  };
  return planned;
}

activity::ActivityPtr operation_activity(std::string name, std::unique_ptr<const OperationCommand> command,
                                         std::string actuator, activity::Context& context, activity::ArmAfter arms) {
  return std::make_shared<const OperationActivity>(
      std::move(command), context,
      OperationActivity::Options{.name = std::move(name), .actuators = {std::move(actuator)}, .arms = arms});
}

activity::ActivityPtr refused_activity(std::string name, std::string actuator, Diagnostics why) {
  return std::make_shared<const RefusedActivity>(std::move(name), std::move(actuator), std::move(why));
}

}  // namespace takt::operations
