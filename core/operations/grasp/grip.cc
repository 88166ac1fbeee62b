#include "core/operations/grasp/grip.h"

#include <fmt/format.h>

#include "core/command/actions/device_action.h"
#include "core/expression/device_sensors.h"
#include "core/expression/tool_settings.h"
#include "core/operations/command/command_step.h"
#include "core/operations/command/operation_command.h"
#include "core/operations/grasp/held_part.h"

namespace takt::operations {
namespace {

using expression::BooleanSensor;

constexpr Range kFingerTime{.low = 0.0, .high = 3600.0, .low_open = true};

/// Of a grip or a release.
struct FingerMotion : GripParameters {
  bool opens = false;
  std::optional<std::string> onto = {};
};

/// Where the arm is, as it measures.
const kinematics::JointVector& position_of(const device::Arm& arm) {
  return arm.has_sample() ? arm.sample().q : arm.set_point().q;
}

/// How things were when the fingers stood.
struct GripOutcome {
  std::optional<bool> holding;  ///< nothing: it did not answer
  bool timed_out = false;       ///< the fingers were not at rest in time
  std::optional<double> width;  ///< m
  kinematics::JointVector q;    ///< of the arm that carries the gripper
};

// -- What the arm carries ---------------------------------------------------------------------------------------------

Gripping gripping_of(const FingerMotion& parameters, const kinematics::JointVector& q) {
  return {.gripper = parameters.gripper,
          .part = parameters.part,
          .part_mass = parameters.part_mass,
          .onto = parameters.onto,
          .q = q};
}

/// What the gripper reports, to notice later that it holds its part no more.
void note_report(world::Hold& hold, const device::Gripper& gripper, double width) {
  hold.width = width;
  hold.command = gripper.set_point().sequence;
  if (gripper.has_sample() && gripper.sample().state == device::GripperState::kHolding)
    hold.force = gripper.sample().force;
}

/// More than a part weighs cannot be told by its grippers together, but by each of them where the part is handed over;
/// less can, where another arm carries the rest.
Diagnostics check_told_mass(const expression::Cell& cell, const world::Hold& hold) {
  Diagnostics diagnostics;
  const auto mismatch = payload_mismatch(cell, hold.object);
  if (mismatch && mismatch->told > mismatch->known)
    diagnostics.error(Code::kPayloadMismatch, "/part_mass_kg",
                      fmt::format("'{}' weighs {:g} kg, not {:g} kg", hold.object, mismatch->known, mismatch->told),
                      "Remove 'part_mass_kg', or set it to the object's mass");
  return diagnostics;
}

/// Whatever it held before, it has let go; it holds what is between the fingers now.
void update_belief(const FingerMotion& parameters, const GripOutcome& outcome, activity::Context& context,
                   Diagnostics& diagnostics) {
  const Gripping gripping = gripping_of(parameters, outcome.q);
  const auto left = leave_part(context.cell, gripping);
  if (!left) return diagnostics.append(left.error());
  if (*outcome.holding && !parameters.opens) {
    const auto hold = take_part(context.cell, gripping);
    if (!hold) return diagnostics.append(hold.error());
    note_report(context.cell.held.find(parameters.gripper)->second,
                *context.cell.grippers.find(parameters.gripper)->second.device, *outcome.width);
    if (parameters.part) diagnostics.append(check_told_mass(context.cell, *hold));
  }
  expression::tell_tool_settings(context.cell);
}

command::FingerParameters fingers_of(const FingerMotion& parameters) {
  return {
      .width = parameters.width, .speed = parameters.speed, .force = parameters.force, .timeout = parameters.timeout};
}

/// Fingers that have not come to rest hold nothing that anybody could rely on.
void report_timeout(const FingerMotion& parameters, double width, const device::GripperDescription& figures,
                    Diagnostics& diagnostics) {
  const double wanted = parameters.width.value_or(parameters.opens ? figures.stroke : 0.0);
  diagnostics.error(
      Code::kTimeout, {},
      fmt::format(
          "the fingers of '{}' were not at rest within {:.3g} s: they were to {} to {:.1f} mm{}, and are {:.1f} mm "
          "apart",
          parameters.gripper, command::finger_timeout(fingers_of(parameters), figures),
          parameters.opens ? "open" : "close", 1e3 * wanted, parameters.opens ? "" : " or a part", 1e3 * width),
      "Free its fingers, check its power and its wiring, or give it a longer \"timeout_s\"");
}

/// What has come of it: whether that is what was expected, and what the arm carries now.
void note_grip(const FingerMotion& parameters, const GripOutcome& outcome, activity::Context& context,
               Diagnostics& diagnostics) {
  const auto& [holding, timed_out, width, q] = outcome;
  if (!holding || !width) {
    return diagnostics.error(Code::kSensorSilent, {}, fmt::format("'{}' did not answer", parameters.gripper),
                             "Check its power and its wiring");
  }
  if (timed_out) {
    const auto& gripper = *context.cell.grippers.find(parameters.gripper)->second.device;
    return report_timeout(parameters, *width, gripper.description(), diagnostics);
  }
  context.event(parameters.gripper, *holding ? "holding" : "standing", fmt::format("{:.5f} m", *width));
  if (parameters.expect == GripParameters::Expect::kPart && !*holding) {
    return diagnostics.error(Code::kConditionNotMet, {},
                             fmt::format("no part was found; the fingers are {:.1f} mm apart", 1e3 * *width),
                             "Set \"expect\": \"any\" where that is no fault");
  }
  if (parameters.expect == GripParameters::Expect::kNothing && *holding) {
    return diagnostics.error(Code::kConditionNotMet, {},
                             fmt::format("something stopped the fingers at {:.1f} mm", 1e3 * *width),
                             "Set \"expect\": \"any\" where that is no fault");
  }
  update_belief(parameters, outcome, context, diagnostics);
}

/// The same for a rehearsal, in which every grip finds its part.
/// @param pointer  of the operation in its file
void rehearse_grip(const FingerMotion& parameters, const std::string& pointer, Rehearsal& rehearsal,
                   Diagnostics& diagnostics) {
  const expression::MountedGripper& mounted = rehearsal.cell.grippers.find(parameters.gripper)->second;
  const device::GripperDescription& gripper = mounted.device->description();
  rehearsal.duration += gripper.stroke / parameters.speed.value_or(0.25 * gripper.speed_max);
  const Gripping gripping = gripping_of(parameters, rehearsal.q[mounted.arm]);
  rehearsal.told_masses.erase(parameters.gripper);
  const std::optional<collision::CellState> before =
      rehearsal.cell.shapes != nullptr ? std::optional(situation_of(rehearsal)) : std::nullopt;
  const auto left = leave_part(rehearsal.cell, gripping);
  if (!left) diagnostics.append(left.error(), pointer);
  const double width = parameters.width.value_or(parameters.opens ? gripper.stroke : 0.0);
  note_fingers(rehearsal, parameters.gripper, width, {});
  if (!parameters.opens && parameters.expect != GripParameters::Expect::kNothing) {
    const auto hold = take_part(rehearsal.cell, gripping);
    if (!hold) return diagnostics.append(hold.error(), pointer);
    note_fingers(rehearsal, parameters.gripper, width, hold->object);
    if (!parameters.part && !hold->object.empty()) rehearsal.one_of_many.insert(hold->object);
    const Diagnostics excess = parameters.part ? check_told_mass(rehearsal.cell, *hold) : Diagnostics();
    diagnostics.append(excess, pointer);
    if (parameters.part_mass > 0.0 && excess.empty())
      rehearsal.told_masses[parameters.gripper] = pointer + "/part_mass_kg";
  }
  if (before) check_fingers(rehearsal, parameters.gripper, *before, !parameters.opens, pointer, diagnostics);
  expression::expect_tool_settings(rehearsal.cell);
}

// -- As a command -----------------------------------------------------------------------------------------------------

class GripperCommand final : public OperationCommand {
 public:
  explicit GripperCommand(FingerMotion parameters) : parameters_(std::move(parameters)) {}

  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    const command::FingerParameters fingers = fingers_of(parameters_);
    MadeCommand made = on_actuator(command::gripper(build.cell, parameters_.gripper),
                                   parameters_.opens ? command::release(fingers) : command::grip(fingers));
    made.places = {{"/width", "/width_m"}, {"/speed", "/speed_m_s"}, {"/force", "/force_N"}};
    command::Command& gripped = made.command;
    const expression::State holding = expression::gripper_state(build.cell, parameters_.gripper, "holding");
    gripped.fails_if((made.action->state("overdue") || is_unexpected(holding)) && !gripped.cancelled());
    if (is_alone(build)) {
      // Nothing comes after it: what it shows when it has ended is what counts.
      gripped.observe(key + " holding", BooleanSensor(made.action->state("holding").node()));
      gripped.observe(key + " overdue", BooleanSensor(made.action->state("overdue").node()));
      gripped.observe(key + " width", made.action->value("width"));
      return made;
    }
    // Later commands may move on before anybody looks.
    const expression::State stands = (gripped.completed() || gripped.failed()) && !gripped.cancelled();
    gripped.observe(key + " stands", BooleanSensor(stands.node()));
    gripped.capture(key + " overdue", BooleanSensor(made.action->state("overdue").node()), stands);
    gripped.capture(key + " holding", holding, stands);
    gripped.capture(key + " width", expression::gripper_width(build.cell, parameters_.gripper), stands);
    gripped.capture(key + " q", expression::commanded_joints(build.cell, arm(build.cell)), stands);
    return made;
  }

  [[nodiscard]] bool is_called_by_type() const override { return true; }
  void check(const expression::Cell& cell, Diagnostics& diagnostics) const override {
    if (is_there(cell)) return;
    diagnostics.error(Code::kNotPossibleNow, pointer + "/gripper",
                      fmt::format("'{}' is coupled to no arm", parameters_.gripper), "Put \"couple\" before it");
  }
  [[nodiscard]] IntendedContact meant_touch() const override { return {.devices = {parameters_.gripper}}; }
  void rehearse(Rehearsal& rehearsal, Diagnostics& diagnostics) const override {
    rehearse_grip(parameters_, pointer, rehearsal, diagnostics);
  }

  void finish(const activity::RunView& ended, const std::string& key, bool cancelled, activity::Context& context,
              Diagnostics& diagnostics) const override {
    if (is_alone(ended) ? cancelled : !ended.was_true(key + " stands")) return;
    if (!is_there(context.cell)) return check(context.cell, diagnostics);  // its changer has lost it meanwhile
    GripOutcome outcome{.holding = ended.value<net::Boolean>(key + " holding"),
                        .timed_out = ended.value<net::Boolean>(key + " overdue").value_or(false),
                        .width = ended.value<net::Real>(key + " width"),
                        .q = {}};
    if (is_alone(ended)) outcome.q = position_of(*context.cell.arms.find(arm(context.cell))->second.device);
    if (const auto q = ended.value<net::JointArray>(key + " q")) outcome.q = q->map();
    Diagnostics own;
    note_grip(parameters_, outcome, context, own);
    diagnostics.append(own, pointer);
  }

 private:
  /// Null where the gripper does not answer.
  [[nodiscard]] expression::State is_unexpected(const expression::State& holding) const {
    if (parameters_.expect == GripParameters::Expect::kPart) return !holding;
    if (parameters_.expect == GripParameters::Expect::kNothing) return holding;
    return holding && !holding;
  }
  [[nodiscard]] const std::string& arm(const expression::Cell& cell) const {
    return cell.grippers.find(parameters_.gripper)->second.arm;
  }

  /// It is fixed to an arm, or coupled.
  [[nodiscard]] bool is_there(const expression::Cell& cell) const { return cell.arms.contains(arm(cell)); }

  FingerMotion parameters_;
};

/// What grip and release have in common.
template <class P>
ParameterTable<P> finger_parameters() {
  ParameterTable<P> table;
  table.name("gripper", NameOf::kGripper, &P::gripper, "Gripper that moves.")
      .number("width_m", "m", &P::width, kNotNegative, "Width to move to: 0 to close, the stroke to open.")
      .number("speed_m_s", "m/s", &P::speed, kPositive, "Speed of the fingers: a quarter of the fastest.")
      .number("force_N", "N", &P::force, kPositive, "Gripping force: half of the largest.")
      .number("timeout_s", "s", &P::timeout, kFingerTime,
              "The step fails if the fingers are not at rest by then: time for twice the stroke, and 1 s.");
  return table;
}

FingerMotion closing(const GripParameters& parameters) { return {parameters, false, {}}; }

FingerMotion opening(const ReleaseParameters& parameters) {
  return {{.gripper = parameters.gripper,
           .width = parameters.width,
           .speed = parameters.speed,
           .force = parameters.force,
           .timeout = parameters.timeout,
           .expect = GripParameters::Expect::kAny,
           .name = parameters.name,
           .pointer = parameters.pointer},
          true,
          parameters.onto};
}

}  // namespace

const ParameterTable<GripParameters>& grip_parameters() {
  using Expect = GripParameters::Expect;
  static const auto table = [] {
    const std::vector<std::pair<std::string, Expect>> words{
        {"part", Expect::kPart}, {"nothing", Expect::kNothing}, {"any", Expect::kAny}};
    return finger_parameters<GripParameters>()
        .choice("expect", &GripParameters::expect, words, "What has to be between the fingers at the end.")
        .name("part", NameOf::kObject, &GripParameters::part,
              "Object that is gripped: the free object between the fingers.")
        .number("part_mass_kg", "kg", &GripParameters::part_mass, kNotNegative,
                "Mass of the part, or this arm's share of it: checked against the object.");
  }();
  return table;
}

const ParameterTable<ReleaseParameters>& release_parameters() {
  static const auto table = [] {
    return finger_parameters<ReleaseParameters>().text(
        "onto", &ReleaseParameters::onto, "What the part stands on then: a frame, an object, a base; found by shapes.");
  }();
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

}  // namespace takt::operations
