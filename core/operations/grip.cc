#include "core/operations/grip.h"

#include <fmt/format.h>

#include "core/activity/command_activity.h"
#include "core/command/actions/device_action.h"
#include "core/expression/device_sensors.h"
#include "core/operations/goal.h"
#include "core/operations/operation_command.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

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
void tell_payload(device::Arm& arm, const CarriedPart& part, double mass) {
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
  if (part.told) tell_payload(device, part, parameters.part_mass);
  context.variables.carried[parameters.gripper] = part;
}

command::GripCommand grip_command_of(const FingerMotion& parameters, const device::GripperDescription& gripper) {
  return {.gripper = parameters.gripper,
          .width = parameters.width.value_or(parameters.opens ? gripper.stroke : 0.0),
          .speed = parameters.speed.value_or(0.25 * gripper.speed_max),
          .force = parameters.force.value_or(0.5 * gripper.force_max)};
}

/// @return false with diagnostics below `pointer`: figures that the gripper does not have.
bool check_figures(const FingerMotion& parameters, const device::GripperDescription& gripper,
                   const std::string& pointer, Diagnostics& diagnostics) {
  const command::GripCommand command = grip_command_of(parameters, gripper);
  bool right = true;
  const auto check = [&](const char* key, double value, double low, double high) {
    if (value >= low && value <= high) return;
    diagnostics.error(Code::kOutOfRange, pointer + key, fmt::format("{:g} is not for '{}'", value, command.gripper),
                      fmt::format("{:g} to {:g}", low, high));
    right = false;
  };
  check("/width_m", command.width, 0.0, gripper.stroke);
  check("/speed_m_s", command.speed, gripper.speed_min, gripper.speed_max);
  check("/force_N", command.force, gripper.force_min, gripper.force_max);
  return right;
}

/// What has come of it: whether that is what was expected, and what the arm carries now.
Progress note_grip(const FingerMotion& parameters, const GripOutcome& outcome, Context& context,
                   Diagnostics& diagnostics) {
  const auto& [holding, width, q] = outcome;
  if (!holding || !width) {
    diagnostics.error(Code::kSensorSilent, {}, fmt::format("'{}' did not answer", parameters.gripper),
                      "check its power and its wiring");
    return Progress::kFailed;
  }
  context.event(parameters.gripper, *holding ? "holding" : "standing", fmt::format("{:.5f} m", *width));
  if (parameters.expect == GripParameters::Expect::kPart && !*holding) {
    diagnostics.error(Code::kConditionNotMet, {},
                      fmt::format("no part was found; the fingers stand {:.1f} mm apart", 1e3 * *width),
                      "\"expect\": \"any\", where that is no fault");
    return Progress::kFailed;
  }
  if (parameters.expect == GripParameters::Expect::kNothing && *holding) {
    diagnostics.error(Code::kConditionNotMet, {},
                      fmt::format("something stopped the fingers at {:.1f} mm", 1e3 * *width),
                      "\"expect\": \"any\", where that is no fault");
    return Progress::kFailed;
  }
  leave_former(parameters, q, context, diagnostics);
  if (*holding && !parameters.opens) take(parameters, q, context);
  return Progress::kDone;
}

/// The same for a rehearsal, in which every grip finds its part.
void rehearse_grip(const FingerMotion& parameters, Rehearsal& rehearsal, Diagnostics& diagnostics) {
  const command::MountedGripper& mounted = rehearsal.cell.grippers.find(parameters.gripper)->second;
  const device::GripperDescription& gripper = mounted.device->description();
  rehearsal.duration += gripper.stroke / grip_command_of(parameters, gripper).speed;
  const kinematics::JointVector& q = rehearsal.q[mounted.arm];
  if (const auto carried = rehearsal.carried.find(parameters.gripper); carried != rehearsal.carried.end()) {
    leave_part(rehearsal.cell, mounted.arm, q, carried->second, diagnostics);
    rehearsal.carried.erase(carried);
  }
  if (parameters.opens || !parameters.part) return;
  rehearsal.carried[parameters.gripper] = {.object = *parameters.part,
                                           .X_TO = part_in_tool(rehearsal.cell, mounted.arm, q, *parameters.part)};
}

// -- As a step --------------------------------------------------------------------------------------------------------

command::RuntimeCommand gripping(const FingerMotion& parameters, const command::Cell& cell) {
  const auto& gripper = cell.grippers.find(parameters.gripper)->second.device->description();
  return command::grip_command(grip_command_of(parameters, gripper), cell);
}

class GripRun final : public ScheduledRun {
 public:
  explicit GripRun(const FingerMotion& parameters) : parameters_(parameters) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context&) override {
    return command_activity(
        "grip " + parameters_.gripper, {parameters_.gripper},
        [parameters = parameters_](const PlanningContext& planning) { return gripping(parameters, planning.cell); });
  }

  Progress finish(Context& context, Diagnostics& diagnostics) override {
    if (cancelled()) return Progress::kDone;
    const std::string& arm = context.cell.grippers.find(parameters_.gripper)->second.arm;
    const GripOutcome outcome{.holding = run()->value<net::Boolean>(command::observed::kHolding),
                              .width = run()->value<net::Real>(command::observed::kWidth),
                              .q = context.cell.arms.find(arm)->second.device->set_point().q};
    return note_grip(parameters_, outcome, context, diagnostics);
  }

  const FingerMotion& parameters_;
};

class GripStep final : public Step {
 public:
  explicit GripStep(FingerMotion parameters) : parameters_(std::move(parameters)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const auto& gripper = rehearsal.cell.grippers.find(parameters_.gripper)->second.device->description();
    if (!check_figures(parameters_, gripper, pointer, diagnostics)) return;
    rehearse_command(gripping(parameters_, rehearsal.cell), "grip " + parameters_.gripper, rehearsal, pointer,
                     diagnostics);
    rehearse_grip(parameters_, rehearsal, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<GripRun>(parameters_); }

 private:
  FingerMotion parameters_;
};

// -- As a command -----------------------------------------------------------------------------------------------------

class GripperCommand final : public OperationCommand {
 public:
  explicit GripperCommand(FingerMotion parameters) : parameters_(std::move(parameters)) {}

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    const command::MountedGripper& mounted = making.cell.grippers.find(parameters_.gripper)->second;
    const command::GripCommand figures = grip_command_of(parameters_, mounted.device->description());
    const command::FingerParameters wish{.width = figures.width, .speed = figures.speed, .force = figures.force};
    const command::Actuator actuator = command::gripper(making.cell, parameters_.gripper);
    const command::Action action = parameters_.opens ? command::release(wish) : command::grip(wish);
    command::RuntimeCommand gripped(name, actuator, action);
    // Later commands may move on before anybody looks.
    const command::State stands = gripped.completed() && !gripped.cancelled();
    gripped.observe(key + " stands", BooleanSensor(stands.node()));
    gripped.capture(key + " holding",
                    BooleanSensor(command::gripper_state(making.cell, parameters_.gripper, "holding").node()), stands);
    gripped.capture(key + " width", command::gripper_width(making.cell, parameters_.gripper), stands);
    gripped.capture(key + " q", command::commanded_joints(making.cell, mounted.arm), stands);
    return {.command = gripped, .action = action, .actuator = actuator};
  }

  void check(const command::Cell& cell, Diagnostics& diagnostics) const override {
    (void)check_figures(parameters_, cell.grippers.find(parameters_.gripper)->second.device->description(), pointer,
                        diagnostics);
  }
  void rehearse(Rehearsal& rehearsal, Diagnostics& diagnostics) const override {
    rehearse_grip(parameters_, rehearsal, diagnostics);
  }

  void finish(const ActivityRun& ended, const std::string& key, bool, Context& context,
              Diagnostics& diagnostics) const override {
    if (!ended.was_true(key + " stands")) return;
    const auto q = ended.value<net::JointArray>(key + " q");
    GripOutcome outcome{.holding = ended.value<net::Boolean>(key + " holding"),
                        .width = ended.value<net::Real>(key + " width"),
                        .q = {}};
    if (q) outcome.q = q->map();
    Diagnostics own;
    (void)note_grip(parameters_, outcome, context, own);
    diagnostics.append(own, pointer);
  }

 private:
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

template <auto table, auto motion>
std::unique_ptr<Step> read_grip_step(const OperationSource& source) {
  return std::make_unique<GripStep>(motion(read_parameters<table>(source)));
}

template <auto table, auto motion>
std::unique_ptr<OperationCommand> read_grip_command(const OperationSource& source) {
  return std::make_unique<GripperCommand>(motion(read_parameters<table>(source)));
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
          .read_step = read_grip_step<grip_parameters, closing>,
          .read_command = read_grip_command<grip_parameters, closing>};
}

Operation release_operation() {
  return {.name = "release",
          .doc = "Opens a gripper.",
          .parameters = rows_of<release_parameters>,
          .read_step = read_grip_step<release_parameters, opening>,
          .read_command = read_grip_command<release_parameters, opening>};
}

}  // namespace takt::activity
