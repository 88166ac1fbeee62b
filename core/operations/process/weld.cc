#include "core/operations/process/weld.h"

#include <algorithm>
#include <array>
#include <functional>
#include <initializer_list>
#include <utility>

#include <fmt/format.h>

#include "core/base/read_parts.h"
#include "core/command/actions/device_action.h"
#include "core/command/actions/motion_action.h"
#include "core/command/actions/online_action.h"
#include "core/command/actions/process_action.h"
#include "core/expression/device_sensors.h"
#include "core/expression/moving_frames.h"
#include "core/operations/command/command_step.h"
#include "core/operations/motion/motion_plan.h"

namespace takt::operations {
namespace {

using expression::BooleanSensor;
using expression::State;
using Effect = command::Effect::Kind;
using Planned = Result<command::PlannedMotion>;

constexpr const char* kEstablished = "established";
constexpr std::array<const char*, 3> kTorchOutputs = {"gas", "arc", "wire"};

// -- The path ---------------------------------------------------------------------------------------------------------

MotionTask line_task(const WeldParameters& weld, double velocity, const Eigen::Isometry3d& X_BT) {
  MotionTask task;
  task.kind = PathKind::kLin;
  task.name = weld.name;
  task.pointer = weld.pointer;
  task.arm = weld.arm;
  task.tool = weld.tool;
  task.linear_velocity = velocity;
  task.goal = {Goal::Pose{.in = weld.arm, .X = X_BT}};
  return task;
}

Eigen::Isometry3d back_along_torch(const Eigen::Isometry3d& X_BT, double distance) {
  Eigen::Isometry3d X = X_BT;
  X.translation() -= distance * X.linear().col(2);
  return X;
}

/// Over the beginning of the line, and down to it, without a stop between.
std::vector<MotionTask> approach_tasks(const WeldParameters& weld, const std::vector<TorchPose>& poses) {
  const Eigen::Isometry3d& X_BT = poses.front().X_BT;
  std::vector<MotionTask> tasks{line_task(weld, weld.approach_velocity, back_along_torch(X_BT, weld.retract)),
                                line_task(weld, weld.approach_velocity, X_BT)};
  tasks.front().blend = activity::BlendingCondition::at_distance(0.4 * weld.retract);
  return tasks;
}

std::vector<MotionTask> seam_tasks(const WeldParameters& weld, const std::vector<TorchPose>& poses) {
  std::vector<MotionTask> tasks;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    MotionTask task = line_task(weld, weld.travel, poses[i].X_BT);
    if (poses[i].p_via) {
      task.kind = PathKind::kCirc;
      Goal::Pose via{.in = weld.arm, .X = poses[i].X_BT};
      via.X.translation() = *poses[i].p_via;
      task.via = Goal{via};
    }
    if (i + 1 < poses.size() && weld.blend > 0.0) task.blend = activity::BlendingCondition::at_distance(weld.blend);
    if (weld.weave) {
      task.acceleration = command::kShareWithOverlay;
      task.weave = command::WeaveParameters{.amplitude = weld.weave->amplitude,
                                            .frequency = weld.weave->frequency,
                                            .direction_M = poses[i].across_T,
                                            .ramp = weld.weave->ramp};
    }
    tasks.push_back(std::move(task));
  }
  return tasks;
}

std::vector<MotionTask> retract_tasks(const WeldParameters& weld, const std::vector<TorchPose>& poses) {
  return {line_task(weld, weld.approach_velocity, back_along_torch(poses.back().X_BT, weld.retract))};
}

using Tasks = std::vector<MotionTask> (*)(const WeldParameters&, const std::vector<TorchPose>&);

/// Planned from where the arm is then, to where the line is then.
command::Action planned_motion(const WeldParameters& weld, Tasks tasks, const char* what, const BuildContext& build) {
  return command::planned_by(
      what, command::SetPointKind::kPath, [weld, tasks, what, build](const expression::Places& q_start) -> Planned {
        const expression::Cell cell = expression::cell_at(build.cell, q_start);
        const auto points = line_points(cell, weld.workpiece, weld.line, weld.arm);
        if (!points) return std::unexpected(points.error());
        auto plan = plan_motions(tasks(weld, torch_poses(*points, weld.angles)), cell, q_start.at(weld.arm));
        if (!plan) return std::unexpected(plan.error());
        build.notes.append(plan->notes);
        return command::PlannedMotion{.motion = std::make_shared<const motion::Motion>(std::move(plan->motion)),
                                      .X_FM = cell.arms.find(weld.arm)->second.X_FT,
                                      .handed_over = std::move(plan->handed_over),
                                      .name = what};
      });
}

// -- The commands -----------------------------------------------------------------------------------------------------

std::string signal_of(const WeldParameters& weld, const char* signal) { return weld.torch + "/" + signal; }

/// One command of the transaction.
class WeldPart : public OperationCommand {
 public:
  using Make = std::function<MadeCommand(const WeldPart& part, const BuildContext& build, const std::string& key)>;
  /// @param follows  the part whose action it needs; empty: none
  WeldPart(const WeldParameters& weld, const std::string& part, Make make, std::string follows = {})
      : weld_(weld), make_(std::move(make)), follows_(std::move(follows)) {
    name = part;
    pointer = weld.pointer;
  }
  [[nodiscard]] std::string follows() const override { return follows_; }
  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    return make_(*this, build, key);
  }
  [[nodiscard]] MadeCommand on(const command::Actuator& actuator, const command::Action& action) const {
    return on_actuator(actuator, action);
  }
  [[nodiscard]] MadeCommand on_arm(const BuildContext& build, const command::Action& action) const {
    return on_actuator(command::arm(build.cell, weld_.arm), action);
  }
  [[nodiscard]] MadeCommand set(const BuildContext& build, const char* signal, bool value) const {
    return on_actuator(command::output(build.cell, signal_of(weld_, signal)), command::set_value(value));
  }

 protected:
  const WeldParameters& weld() const { return weld_; }

 private:
  WeldParameters weld_;
  Make make_;
  std::string follows_;
};

/// The seam: the one that can fail.
class SeamPart final : public WeldPart {
 public:
  explicit SeamPart(const WeldParameters& weld) : WeldPart(weld, "seam", {}) {}

  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    const WeldParameters& own = weld();
    command::Action motion = planned_motion(own, seam_tasks, "seam", build);
    // Which weave a motion has is known once the line is.
    if (own.weave) motion = command::weave_each(motion, weaves(build.cell));
    const State burns = expression::digital_input(build.cell, signal_of(own, kEstablished));
    const command::Action seam = command::while_process(motion, burns,
                                                        {.start_timeout = own.ignition_timeout,
                                                         .finish_time = own.crater,
                                                         .overlap = own.overlap / own.travel,
                                                         .restarts = own.restarts});
    MadeCommand made = on_arm(build, seam);
    const State not_started = seam.state("not_started"), lost = seam.state("lost");
    made.command.fails_if((not_started || lost).once());
    const State silent = is_null(BooleanSensor(burns.node()));
    made.command.capture(key + " not started", BooleanSensor(silent.node()), not_started);
    made.command.capture(key + " lost", BooleanSensor(silent.node()), lost);
    made.command.capture(key + " lost at", seam.progress(), lost);
    return made;
  }

  void finish(const activity::RunView& ended, const std::string& key, bool, activity::Context&,
              Diagnostics& diagnostics) const override {
    const std::string torch = signal_of(weld(), kEstablished);
    if (const auto silent = ended.value<net::Boolean>(key + " not started")) {
      add(*silent, pointer + "/ignition_timeout_s",
          fmt::format("the arc did not burn within {:g} s", weld().ignition_timeout),
          "Check wire, gas and the earth clamp, or increase the timeout", diagnostics);
    }
    if (const auto silent = ended.value<net::Boolean>(key + " lost")) {
      add(*silent, pointer,
          fmt::format("the arc was lost at {:.0f} % of the line",
                      100.0 * ended.value<net::Real>(key + " lost at").value_or(0.0)),
          "Check stick-out and wire, or let it be lit again with 'restarts'", diagnostics);
    }
  }

 private:
  void add(bool silent, const std::string& where, const std::string& what, const char* hint,
           Diagnostics& diagnostics) const {
    if (!silent) return diagnostics.error(Code::kConditionNotMet, where, what, hint);
    diagnostics.error(Code::kSensorSilent, pointer + "/torch",
                      fmt::format("'{}' did not answer, so the arc was put out", signal_of(weld(), kEstablished)),
                      "Check its power and its wiring");
  }
  /// Of a line that is not there one for all, which is never used.
  [[nodiscard]] command::Weaves weaves(const expression::Cell& cell) const {
    const auto points = line_points(cell, weld().workpiece, weld().line, weld().arm);
    if (!points) return {std::nullopt};
    return weaves_of(seam_tasks(weld(), torch_poses(*points, weld().angles)));
  }
};

// -- What follows what ------------------------------------------------------------------------------------------------

StateParameters state_of_part(const char* which, const char* part) {
  StateParameters state;
  state.kind = StateParameters::Kind::kCommand;
  state.of = part;
  state.is = which;
  return state;
}
StateParameters completed(const char* part) { return state_of_part("completed", part); }
StateParameters cancelled(const char* part) { return state_of_part("cancelled", part); }
StateParameters negated(StateParameters state) {
  StateParameters result;
  result.kind = StateParameters::Kind::kNot;
  result.operands.push_back(std::move(state));
  return result;
}
StateParameters of_several(StateParameters::Kind kind, std::initializer_list<StateParameters> states) {
  StateParameters result;
  result.kind = kind;
  result.operands = states;
  return result;
}
StateParameters all_of(std::initializer_list<StateParameters> states) {
  return of_several(StateParameters::Kind::kAll, states);
}
/// It has come to its natural end.
StateParameters at_end(const char* part) { return all_of({completed(part), negated(cancelled(part))}); }

/// The commands of a seam as a transaction of operations. Who cancels the whole cancels the motion that runs; what
/// clean-up is goes on.
class Weld final : public OperationCommand {
 public:
  explicit Weld(const WeldParameters& weld) : OperationCommand(weld), weld_(weld) {
    transaction_ = std::make_unique<TransactionParameters>();
    transaction_->on_cancel = TransactionParameters::OnCancel::kForwardTo;
    transaction_->forward_to = {"approach", "preflow", "seam"};
    add_parts();
    add_handlers();
  }

  [[nodiscard]] MadeCommand make(const BuildContext&, const std::string&) const override {
    return {command::TransactionCommand(name)};
  }
  void check(const expression::Cell& cell, Diagnostics& diagnostics) const override {
    if (const auto points = line_points(cell, weld_.workpiece, weld_.line, weld_.arm); !points)
      diagnostics.append(points.error(), pointer);
  }
  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.duration += weld_.preflow + weld_.crater + weld_.postflow;
  }

 private:
  using Part = WeldPart;

  void add(const std::string& part, WeldPart::Make make, const std::string& follows = {}) {
    adopt(std::make_unique<WeldPart>(weld_, part, std::move(make), follows));
  }
  void add_motion(const char* part, Tasks tasks) {
    add(part, [tasks, part, weld = weld_](const Part& own, const BuildContext& build, const std::string&) {
      return own.on_arm(build, planned_motion(weld, tasks, part, build));
    });
  }
  void add_wait(const char* part, double seconds) {
    add(part, [seconds](const Part& own, const BuildContext&, const std::string&) {
      return MadeCommand{command::WaitCommand(own.name, seconds)};
    });
  }
  /// An output that is on while the seam wants its arc.
  void add_follower(const char* signal) {
    add(
        signal,
        [signal, weld = weld_](const Part& own, const BuildContext& build, const std::string&) {
          return own.on(command::output(build.cell, signal_of(weld, signal)),
                        command::follow_state(build.followed->state("process")));
        },
        "seam");
  }

  void add_parts() {
    add_motion("approach", approach_tasks);
    parts().front()->starts = true;
    add("gas on",
        [](const Part& own, const BuildContext& build, const std::string&) { return own.set(build, "gas", true); });
    add_wait("preflow", weld_.preflow);
    adopt(std::make_unique<SeamPart>(weld_));
    add_follower("arc");
    add_follower("wire");
    add_wait("postflow", weld_.postflow);
    add("gas off",
        [](const Part& own, const BuildContext& build, const std::string&) { return own.set(build, "gas", false); });
    add_motion("retract", retract_tasks);
    // Where a seam was left early is known in the run only: away from there by a velocity, for a time.
    add("withdraw", [weld = weld_](const Part& own, const BuildContext& build, const std::string&) {
      const net::Twist back{.linear = {0.0, 0.0, -weld.approach_velocity}, .angular = Eigen::Vector3d::Zero()};
      const expression::TwistSensor along(expression::apply(net::ValueType::kTwist, "ConstantTwist",
                                                            {{"value", expression::Term<net::Twist>(back).operand()}}));
      const State always(expression::apply(net::ValueType::kBoolean, "ConstantBoolean",
                                           {{"value", expression::Term<net::Boolean>(true).operand()}}));
      const expression::FrameSensor tool = expression::commanded_tool_pose(build.cell, weld.arm);
      return own.on_arm(build,
                        command::jog(expression::rotate(tool, along), always, {.linear_max = weld.approach_velocity}));
    });
    add_wait("withdrawal", weld_.retract / weld_.approach_velocity);
  }

  void when(const StateParameters& state, Effect effect, std::initializer_list<const char*> targets) {
    HandlerParameters handler;
    handler.pointer = weld_.pointer;
    handler.state = state;
    for (const char* target : targets) handler.effects.push_back({effect, target, weld_.pointer});
    handlers.push_back(std::move(handler));
  }

  void add_handlers() {
    const StateParameters failed = state_of_part("failed", "seam");
    const StateParameters left_early =
        of_several(StateParameters::Kind::kAny, {failed, all_of({completed("seam"), cancelled("seam")})});
    when(at_end("approach"), Effect::kStart, {"gas on", "preflow"});
    when(at_end("preflow"), Effect::kStart, {"seam", "arc", "wire"});
    when(cancelled("preflow"), Effect::kStart, {"gas off"});
    when(of_several(StateParameters::Kind::kAny, {completed("seam"), failed}), Effect::kCancel, {"arc", "wire"});
    when(at_end("seam"), Effect::kStart, {"postflow"});
    when(left_early, Effect::kStart, {"postflow"});
    when(completed("postflow"), Effect::kStart, {"gas off"});
    when(all_of({completed("postflow"), completed("seam"), negated(cancelled("seam"))}), Effect::kStart, {"retract"});
    // One of the two: who reads it sees that the planned one comes first.
    when(all_of({completed("postflow"), left_early, negated(state_of_part("started", "retract"))}), Effect::kStart,
         {"withdraw", "withdrawal"});
    when(completed("withdrawal"), Effect::kCancel, {"withdraw"});
  }

  WeldParameters weld_;
};

// -- Parameters -------------------------------------------------------------------------------------------------------

bool is_torch(const expression::Cell& cell, const std::string& name) {
  return cell.digital_inputs.contains(name + "/" + kEstablished) &&
         std::ranges::all_of(kTorchOutputs,
                             [&](const char* signal) { return cell.digital_outputs.contains(name + "/" + signal); });
}

void check_torch(WeldParameters& weld, const ReadContext& from) {
  std::vector<std::string> torches;
  for (const auto& [input, device] : from.cell.digital_inputs) {
    const std::string name = input.substr(0, input.find('/'));
    if (input == name + "/" + kEstablished && is_torch(from.cell, name)) torches.push_back(name);
  }
  if (weld.torch.empty() && torches.size() == 1) weld.torch = torches.front();
  if (is_torch(from.cell, weld.torch)) return;
  const bool given = !weld.torch.empty();
  from.reader.diagnostics().error(
      given ? Code::kUnknownName : Code::kMissing, from.reader.at("torch"),
      given ? fmt::format("'{}' is no torch", weld.torch) : fmt::format("one of {} torches", torches.size()),
      torches.empty() ? "Add a device with the outputs gas, arc, wire and the input established"
                      : nearest_choice(weld.torch, torches));
}

const ParameterTable<WeldWeave>& weld_weave_parameters() {
  static const auto table = [] {
    ParameterTable<WeldWeave> weave;
    weave
        .number("amplitude_m", "m", &WeldWeave::amplitude, {.low = 0.0, .high = 0.05, .low_open = true},
                "Largest distance from the line.")
        .required()
        .number("frequency_Hz", "Hz", &WeldWeave::frequency, {.low = 0.0, .high = 20.0, .low_open = true},
                "Oscillations in a second.")
        .required()
        .number("ramp_s", "s", &WeldWeave::ramp, {.low = 0.0, .high = 100.0, .low_open = true},
                "Time in which it grows at the start and fades at the end.");
    return weave;
  }();
  return table;
}

constexpr Range kProcessTime{.low = 0.0, .high = 60.0};
constexpr Range kTilt{.low = -60.0, .high = 60.0};

}  // namespace

const ParameterTable<WeldParameters>& weld_parameters() {
  using P = WeldParameters;
  static const auto table = [] {
    ParameterTable<P> weld;
    weld.name("arm", NameOf::kArm, &P::arm, "Arm that carries the torch.")
        .text("torch", &P::torch, "Device with the outputs gas, arc, wire and the input established.")
        .fallback("the only one of the cell")
        .name("workpiece", NameOf::kObject, &P::workpiece, "Object with lines.")
        .required()
        .text("line", &P::line, "Line of the workpiece.")
        .required()
        .number("travel_m_s", "m/s", &P::travel, {.low = 0.0, .high = 0.2, .low_open = true},
                "Speed along the line, which an override does not scale.")
        .number(
            "stick_out_m", "m", [](P & p) -> auto& { return p.angles.stick_out; }, {.low = 0.0, .high = 0.1},
            "Distance of the tool centre point from the line, along z of the tool.")
        .number(
            "travel_angle_deg", "deg", [](P & p) -> auto& { return p.angles.travel; }, kTilt,
            "Tilt in the direction of travel: above 0 the torch points ahead, below 0 back.")
        .number(
            "work_angle_deg", "deg", [](P & p) -> auto& { return p.angles.work; }, kTilt,
            "Tilt across the direction of travel.")
        .number(
            "rotation_deg", "deg", [](P & p) -> auto& { return p.angles.rotation; }, {.low = -360.0, .high = 360.0},
            "Turn about the axis of the torch; 0: x of the tool is along the beginning of the line.")
        .number("blend_m", "m", &P::blend, {.low = 0.0, .high = 0.1},
                "Distance from a corner at which the next part of the line begins; 0: the torch stops there.")
        .part("weave", "weld_weave", weld_weave_parameters(), &P::weave, "Swing across the line.")
        .number("preflow_s", "s", &P::preflow, kProcessTime, "Time of gas before the ignition.")
        .number("ignition_timeout_s", "s", &P::ignition_timeout, kProcessTime, "Within which the arc has to burn.")
        .number("crater_s", "s", &P::crater, kProcessTime, "Time of the arc at rest at the end.")
        .number("postflow_s", "s", &P::postflow, kProcessTime, "Time of gas after the arc.")
        .number("overlap_m", "m", &P::overlap, {.low = 0.0, .high = 0.1},
                "How far before the place where it went out the arc is lit again.")
        .integer("restarts", &P::restarts, {.low = 0, .high = 100},
                 "How often an arc that was lost is lit again before the step fails.")
        .number("approach_m_s", "m/s", &P::approach_velocity, {.low = 0.0, .high = 1.0, .low_open = true},
                "Speed to the line and away from it.")
        .number("retract_m", "m", &P::retract, {.low = 0.001, .high = 0.5},
                "Distance along the torch, before the line and after it.")
        .condition("abort_if", &P::abort_if, "Ends the seam in order and fails when this becomes true.")
        .tool(&P::tool)
        .rule(check_torch);
    return weld;
  }();
  return table;
}

std::unique_ptr<OperationCommand> weld_command(const WeldParameters& parameters) {
  WeldParameters named = parameters;
  if (named.name.empty()) named.name = "weld";
  return std::make_unique<Weld>(named);
}

Operation weld_operation() {
  return {.name = "weld",
          .doc = "Welds along a line of a workpiece: gas, ignition, seam, crater, gas, as one command.",
          .parameters = rows_of<weld_parameters>,
          .read_step = step_of_command,
          .read_command = make_command<weld_parameters, weld_command>};
}

}  // namespace takt::operations
