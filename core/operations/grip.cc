#include "core/operations/grip.h"

#include <fmt/format.h>

#include "core/command/actions/device_action.h"
#include "core/expression/device_sensors.h"
#include "core/operations/command_step.h"
#include "core/operations/goal.h"
#include "core/operations/operation_command.h"

namespace takt::activity {
namespace {

using command::BooleanSensor;

/// Of a grip or a release.
struct FingerMotion : GripParameters {
  bool opens = false;
};

/// How things were when the fingers stood.
struct GripOutcome {
  std::optional<bool> holding;  ///< nothing: it did not answer
  std::optional<double> width;  ///< m
  kinematics::JointVector q;    ///< of the arm that carries the gripper, as sent
};

// -- What the arm carries ---------------------------------------------------------------------------------------------

/// Pose of the part in the tool centre point, with the arm at q; identity if either has no place.
Eigen::Isometry3d part_in_tool(const command::Cell& cell, const std::string& arm, const kinematics::JointVector& q,
                               const std::string& part) {
  const auto X_BO = cell.frames.pose(part, arm);
  return X_BO ? tool_pose(cell.arms.find(arm)->second, q).inverse() * *X_BO : Eigen::Isometry3d::Identity();
}

/// Puts the frame of a carried part where the tool now is.
void leave_part(command::Cell& cell, const std::string& arm, const kinematics::JointVector& q, const CarriedPart& part,
                Diagnostics& diagnostics) {
  const auto X_WB = cell.frames.pose(arm);
  if (!X_WB || part.object.empty()) return;
  diagnostics.append(cell.frames.set(part.object, std::string(world::FrameGraph::kWorld),
                                     *X_WB * tool_pose(cell.arms.find(arm)->second, q) * part.X_TO));
}

/// The arm's payload with the part, a point mass at the origin of its frame.
void set_payload(device::Arm& arm, const CarriedPart& part, double mass) {
  device::ToolSetting tool = part.before;
  const device::PayloadSetting load{.mass = mass, .p_FC = (tool.X_FT * part.X_TO).translation()};
  tool.payload = device::combine(tool.payload, load);
  arm.set_tool(tool);
}

/// Whatever it carried before, it has let go.
void leave_former(const FingerMotion& parameters, const kinematics::JointVector& q, Context& context,
                  Diagnostics& diagnostics) {
  const auto carried = context.variables.carried.find(parameters.gripper);
  if (carried == context.variables.carried.end()) return;
  const std::string& arm = context.cell.grippers.find(parameters.gripper)->second.arm;
  device::Arm& device = *context.cell.arms.find(arm)->second.device;
  leave_part(context.cell, arm, q, carried->second, diagnostics);
  if (carried->second.told && !device.held()) device.set_tool(carried->second.before);
  context.variables.carried.erase(carried);
}

void take(const FingerMotion& parameters, const kinematics::JointVector& q, Context& context) {
  const std::string& arm = context.cell.grippers.find(parameters.gripper)->second.arm;
  device::Arm& device = *context.cell.arms.find(arm)->second.device;
  CarriedPart part{.object = parameters.part.value_or(""), .before = device.tool()};
  if (parameters.part) part.X_TO = part_in_tool(context.cell, arm, q, *parameters.part);
  // The payload of an arm changes between nets only; one that moves while it grips keeps what it believes.
  part.told = parameters.part_mass > 0.0 && !device.held();
  if (part.told) set_payload(device, part, parameters.part_mass);
  context.variables.carried[parameters.gripper] = part;
}

/// What has come of it: whether that is what was expected, and what the arm carries now.
void note_grip(const FingerMotion& parameters, const GripOutcome& outcome, Context& context, Diagnostics& diagnostics) {
  const auto& [holding, width, q] = outcome;
  if (!holding || !width) {
    return diagnostics.error(Code::kSensorSilent, {}, fmt::format("'{}' did not answer", parameters.gripper),
                             "check its power and its wiring");
  }
  context.event(parameters.gripper, *holding ? "holding" : "standing", fmt::format("{:.5f} m", *width));
  if (parameters.expect == GripParameters::Expect::kPart && !*holding) {
    return diagnostics.error(Code::kConditionNotMet, {},
                             fmt::format("no part was found; the fingers are {:.1f} mm apart", 1e3 * *width),
                             "\"expect\": \"any\", where that is no fault");
  }
  if (parameters.expect == GripParameters::Expect::kNothing && *holding) {
    return diagnostics.error(Code::kConditionNotMet, {},
                             fmt::format("something stopped the fingers at {:.1f} mm", 1e3 * *width),
                             "\"expect\": \"any\", where that is no fault");
  }
  leave_former(parameters, q, context, diagnostics);
  if (*holding && !parameters.opens) take(parameters, q, context);
}

/// The same for a rehearsal, in which every grip finds its part.
void rehearse_grip(const FingerMotion& parameters, Rehearsal& rehearsal, Diagnostics& diagnostics) {
  const command::MountedGripper& mounted = rehearsal.cell.grippers.find(parameters.gripper)->second;
  const device::GripperDescription& gripper = mounted.device->description();
  rehearsal.duration += gripper.stroke / parameters.speed.value_or(0.25 * gripper.speed_max);
  const kinematics::JointVector& q = rehearsal.q[mounted.arm];
  if (const auto carried = rehearsal.carried.find(parameters.gripper); carried != rehearsal.carried.end()) {
    leave_part(rehearsal.cell, mounted.arm, q, carried->second, diagnostics);
    rehearsal.carried.erase(carried);
  }
  const bool grips = !parameters.opens && parameters.part.has_value();
  note_fingers(rehearsal, parameters.gripper, parameters.width.value_or(parameters.opens ? gripper.stroke : 0.0),
               grips ? *parameters.part : std::string());
  if (!grips) return;
  rehearsal.carried[parameters.gripper] = {.object = *parameters.part,
                                           .X_TO = part_in_tool(rehearsal.cell, mounted.arm, q, *parameters.part)};
}

// -- As a command -----------------------------------------------------------------------------------------------------

class GripperCommand final : public OperationCommand {
 public:
  explicit GripperCommand(FingerMotion parameters) : parameters_(std::move(parameters)) {}

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    const command::FingerParameters fingers{
        .width = parameters_.width, .speed = parameters_.speed, .force = parameters_.force};
    MadeCommand made = on_actuator(command::gripper(making.cell, parameters_.gripper),
                                   parameters_.opens ? command::release(fingers) : command::grip(fingers));
    made.places = {{"/width", "/width_m"}, {"/speed", "/speed_m_s"}, {"/force", "/force_N"}};
    command::Command& gripped = made.command;
    if (is_alone()) {
      // Nothing comes after it: what it shows when it has ended is what counts.
      gripped.observe(key + " holding", BooleanSensor(made.action->state("holding").node()));
      gripped.observe(key + " width", made.action->value("width"));
      return made;
    }
    // Later commands may move on before anybody looks.
    const command::State stands = gripped.completed() && !gripped.cancelled();
    gripped.observe(key + " stands", BooleanSensor(stands.node()));
    gripped.capture(key + " holding",
                    BooleanSensor(command::gripper_state(making.cell, parameters_.gripper, "holding").node()), stands);
    gripped.capture(key + " width", command::gripper_width(making.cell, parameters_.gripper), stands);
    gripped.capture(key + " q", command::commanded_joints(making.cell, arm(making.cell)), stands);
    return made;
  }

  [[nodiscard]] bool is_called_by_type() const override { return true; }
  [[nodiscard]] MeantTouch meant_touch() const override { return {.devices = {parameters_.gripper}}; }
  void rehearse(Rehearsal& rehearsal, Diagnostics& diagnostics) const override {
    rehearse_grip(parameters_, rehearsal, diagnostics);
  }

  void finish(const ActivityRun& ended, const std::string& key, bool cancelled, Context& context,
              Diagnostics& diagnostics) const override {
    if (is_alone() ? cancelled : !ended.was_true(key + " stands")) return;
    GripOutcome outcome{.holding = ended.value<net::Boolean>(key + " holding"),
                        .width = ended.value<net::Real>(key + " width"),
                        .q = {}};
    if (is_alone()) outcome.q = context.cell.arms.find(arm(context.cell))->second.device->set_point().q;
    if (const auto q = ended.value<net::JointArray>(key + " q")) outcome.q = q->map();
    Diagnostics own;
    note_grip(parameters_, outcome, context, own);
    diagnostics.append(own, pointer);
  }

 private:
  [[nodiscard]] const std::string& arm(const command::Cell& cell) const {
    return cell.grippers.find(parameters_.gripper)->second.arm;
  }

  FingerMotion parameters_;
};

/// What grip and release have in common.
template <class P>
ParameterTable<P> finger_parameters() {
  ParameterTable<P> table;
  table.name("gripper", NameOf::kGripper, &P::gripper, "Gripper that moves.")
      .number("width_m", "m", &P::width, kNotNegative, "Width to move to: 0 to close, the stroke to open.")
      .number("speed_m_s", "m/s", &P::speed, kPositive, "Speed of the fingers: a quarter of the fastest.")
      .number("force_N", "N", &P::force, kPositive, "Gripping force: half of the largest.");
  return table;
}

FingerMotion closing(const GripParameters& parameters) { return {parameters, false}; }

FingerMotion opening(const ReleaseParameters& parameters) {
  return {{.gripper = parameters.gripper,
           .width = parameters.width,
           .speed = parameters.speed,
           .force = parameters.force,
           .expect = GripParameters::Expect::kAny,
           .name = parameters.name,
           .pointer = parameters.pointer},
          true};
}

}  // namespace

const ParameterTable<GripParameters>& grip_parameters() {
  using Expect = GripParameters::Expect;
  static const auto table = [] {
    const std::vector<std::pair<std::string, Expect>> words{
        {"part", Expect::kPart}, {"nothing", Expect::kNothing}, {"any", Expect::kAny}};
    return finger_parameters<GripParameters>()
        .choice("expect", &GripParameters::expect, words, "What has to be between the fingers at the end.")
        .name("part", NameOf::kObject, &GripParameters::part, "Object that is gripped.")
        .number("part_mass_kg", "kg", &GripParameters::part_mass, kNotNegative, "Mass that the arm is to expect.");
  }();
  return table;
}

const ParameterTable<ReleaseParameters>& release_parameters() {
  static const auto table = finger_parameters<ReleaseParameters>();
  return table;
}

std::unique_ptr<OperationCommand> close_command(const GripParameters& parameters) {
  return std::make_unique<GripperCommand>(closing(parameters));
}

std::unique_ptr<OperationCommand> open_command(const ReleaseParameters& parameters) {
  return std::make_unique<GripperCommand>(opening(parameters));
}

Operation grip_operation() {
  return {.name = "grip",
          .doc = "Closes a gripper until a part stops its fingers.",
          .parameters = rows_of<grip_parameters>,
          .read_step = step_of_command,
          .read_command = make_command<grip_parameters, close_command>};
}

Operation release_operation() {
  return {.name = "release",
          .doc = "Opens a gripper.",
          .parameters = rows_of<release_parameters>,
          .read_step = step_of_command,
          .read_command = make_command<release_parameters, open_command>};
}

}  // namespace takt::activity
