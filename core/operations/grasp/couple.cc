#include "core/operations/grasp/couple.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/command/actions/device_action.h"
#include "core/expression/device_sensors.h"
#include "core/expression/tool_coupling.h"
#include "core/expression/tool_settings.h"
#include "core/operations/command/command_step.h"
#include "core/operations/command/operation_command.h"
#include "core/operations/grasp/held_part.h"

namespace takt::operations {
namespace {

using Eigen::Isometry3d;
using expression::BooleanSensor;
using expression::Cell;
using expression::MountedChanger;
namespace terminal = device::changer_terminal;

constexpr Range kLockTime{.low = 0.0, .high = 60.0, .low_open = true};

/// What a changer reported when its lock had moved.
struct LockOutcome {
  std::optional<bool> at_end, coupled;
  std::optional<double> number;
  kinematics::JointVector q;  ///< of its arm
};

std::string terminal_of(const std::string& changer, const char* which) { return changer + "/" + which; }

const MountedChanger& changer_in(const Cell& cell, const std::string& name) { return cell.changers.find(name)->second; }

Result<Isometry3d> coupling_face(const Cell& cell, const MountedChanger& changer, const kinematics::JointVector& q) {
  const auto X_WB = cell.frames.pose(changer.arm);
  if (!X_WB) return X_WB;
  return *X_WB * cell.arms.find(changer.arm)->second.device->description().chain->forward(q) * changer.X_FC;
}

// -- What is believed -------------------------------------------------------------------------------------------------

/// The tool side that a rehearsal couples: the one that is named, or the one that is there.
Result<std::string> side_to_couple(const Cell& cell, const CoupleParameters& parameters, const Isometry3d& X_WC) {
  const MountedChanger& changer = changer_in(cell, parameters.changer);
  const auto there = expression::side_at(cell, changer, X_WC);
  if (!parameters.tool) {
    if (there) return *there;
    return failure(Code::kConditionNotMet, "", fmt::format("no tool side is at '{}'", parameters.changer),
                   "Move to a tool side before, with this changer as \"tool\"");
  }
  const std::string wanted = expression::side_named(cell, *parameters.tool).value_or("");
  if (there == wanted) return wanted;
  const auto X_WS = cell.frames.pose(wanted);
  if (!X_WS) {
    Diagnostics lost;
    lost.append(X_WS.error(), "/tool");
    return std::unexpected(std::move(lost));
  }
  const Isometry3d X_CS = X_WC.inverse() * *X_WS;
  return failure(Code::kConditionNotMet, "/tool",
                 fmt::format("'{}' is {:.1f} mm and {:.1f} deg off '{}'", wanted, 1e3 * X_CS.translation().norm(),
                             180.0 / std::numbers::pi * Eigen::AngleAxisd(X_CS.linear()).angle(), parameters.changer),
                 fmt::format("Move it to within {:g} mm across, {:g} mm along its axis and {:g} deg; the size '{}'",
                             1e3 * changer.tolerance.offset, 1e3 * changer.tolerance.gap,
                             180.0 / std::numbers::pi * changer.tolerance.angle, changer.size));
}

/// What a tool of the tool side still holds; empty: nothing.
std::string held_by_tools(const Cell& cell, const std::string& side) {
  if (side.empty()) return {};
  for (const auto& [name, tool] : cell.tools)
    if (tool.side == side && cell.held.contains(name)) return name;
  return {};
}

/// What was to be coupled and what the changer says.
Diagnostics check_coupled(const Cell& cell, const CoupleParameters& parameters, const std::string& side) {
  Diagnostics diagnostics;
  const auto wanted = parameters.tool ? expression::side_named(cell, *parameters.tool) : std::nullopt;
  if (wanted && *wanted != side)
    diagnostics.error(Code::kConditionNotMet, "/tool", fmt::format("'{}' is coupled, not '{}'", side, *wanted),
                      "Put the tool sides in their places");
  return diagnostics;
}

/// What hangs on the arm then, tool sides with their tools, against what it may carry.
Diagnostics check_carried(const Cell& cell, const std::string& changer) {
  Diagnostics diagnostics;
  const std::string& name = changer_in(cell, changer).arm;
  const expression::MountedArm& arm = cell.arms.find(name)->second;
  const double most = arm.device->description().payload_max;
  const double carried = expression::tool_setting(cell, name).payload.mass;
  if (most > 0.0 && carried > most)
    diagnostics.error(
        Code::kLimitExceeded, "", fmt::format("'{}' carries {:.2f} kg then", name, carried),
        fmt::format("Keep it to at most {:g} kg: 'payload_max_kg' of '{}'", most, arm.device->description().model));
  return diagnostics;
}

std::string side_of_number(const Cell& cell, const MountedChanger& changer, double number) {
  for (const auto& [name, side] : cell.tool_sides)
    if (side.size == changer.size && side.number == std::lround(number)) return name;
  return {};
}

void note_coupled(const CoupleParameters& parameters, const LockOutcome& outcome, activity::Context& context,
                  Diagnostics& diagnostics) {
  const MountedChanger& changer = changer_in(context.cell, parameters.changer);
  const std::string side = outcome.number ? side_of_number(context.cell, changer, *outcome.number) : std::string();
  if (!outcome.coupled || (*outcome.coupled && side.empty()))
    return diagnostics.error(Code::kSensorSilent, "",
                             fmt::format("'{}' does not say which tool side it has coupled", parameters.changer),
                             "Check its sensors and their wiring");
  if (!*outcome.coupled)
    return diagnostics.error(Code::kConditionNotMet, "",
                             fmt::format("'{}' has locked without a tool side", parameters.changer),
                             "Put \"uncouple\" and a motion nearer to the tool side before it, or \"try\" around it");
  diagnostics.append(expression::couple(context.cell, parameters.changer, side));
  expression::tell_tool_settings(context.cell);
  context.event(parameters.changer, "coupled", side);
  diagnostics.append(check_coupled(context.cell, parameters, side));
  diagnostics.append(check_carried(context.cell, parameters.changer));
}

Diagnostics leave_tool(Cell& cell, const UncoupleParameters& parameters, const kinematics::JointVector& q) {
  const auto X_WC = coupling_face(cell, changer_in(cell, parameters.changer), q);
  if (!X_WC) return X_WC.error();
  const std::string onto = standing_frame(cell, parameters.onto.value_or(std::string(world::FrameGraph::kWorld)));
  Diagnostics placed;
  placed.append(expression::uncouple(cell, parameters.changer, *X_WC, onto), parameters.onto ? "/onto" : "");
  return placed;
}

void note_uncoupled(const UncoupleParameters& parameters, const LockOutcome& outcome, activity::Context& context,
                    Diagnostics& diagnostics) {
  const std::string side = expression::coupled_side(context.cell, parameters.changer);
  if (side.empty()) return;  // it was lost meanwhile
  diagnostics.append(leave_tool(context.cell, parameters, outcome.q));
  expression::tell_tool_settings(context.cell);
  context.event(parameters.changer, "uncoupled", side);
}

// -- As a command -----------------------------------------------------------------------------------------------------

/// Moves the lock and waits until it is there. What both operations have in common.
class LockCommand : public OperationCommand {
 public:
  LockCommand(std::string changer, bool locks, double timeout)
      : changer_(std::move(changer)), locks_(locks), timeout_(timeout) {}

  [[nodiscard]] bool is_called_by_type() const override { return true; }

  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    const command::Actuator lock = command::output(build.cell, terminal_of(changer_, terminal::kLock));
    const expression::State at_end =
        expression::digital_input(build.cell, terminal_of(changer_, locks_ ? terminal::kLocked : terminal::kUnlocked));
    command::RuntimeCommand move(name + " valve", lock, command::set_value(locks_));
    command::WaitCommand wait(name + " lock", at_end, timeout_);
    command::TransactionCommand both(name);
    both.add_started(move).add(wait).on_entered(move.completed(), start(wait));
    const auto coupled = expression::digital_input(build.cell, terminal_of(changer_, terminal::kCoupled));
    const auto number = expression::analog_input(build.cell, terminal_of(changer_, terminal::kToolNumber));
    // That the lock is not there in time makes its wait fail, and `both` with it.
    if (const auto wrong = wrong_side(build.cell, coupled, number)) both.fails_if(*wrong && !both.cancelled());
    if (is_alone(build)) {
      // Nothing comes after it: what it shows when it has ended is what counts.
      both.observe(key + " at end", BooleanSensor(at_end.node()));
      both.observe(key + " coupled", BooleanSensor(coupled.node()));
      both.observe(key + " number", number);
    } else {
      const expression::State over = wait.completed() || wait.timed_out();
      both.observe(key + " over", BooleanSensor(over.node()));
      both.capture(key + " at end", BooleanSensor(at_end.node()), over);
      both.capture(key + " coupled", BooleanSensor(coupled.node()), over);
      both.capture(key + " number", number, over);
      both.capture(key + " q", expression::commanded_joints(build.cell, arm(build.cell)), over);
    }
    return {.command = both, .actuator = lock};
  }

  void rehearse(Rehearsal& rehearsal, Diagnostics& diagnostics) const override {
    rehearsal.duration += changer_in(rehearsal.cell, changer_).lock_time;
    Diagnostics own;
    rehearse_belief(rehearsal, own);
    diagnostics.append(own, pointer);
    expression::expect_tool_settings(rehearsal.cell);
  }

  void finish(const activity::RunView& ended, const std::string& key, bool cancelled, activity::Context& context,
              Diagnostics& diagnostics) const override {
    if (!is_alone(ended) && !ended.was_true(key + " over")) return;
    LockOutcome outcome{.at_end = ended.value<net::Boolean>(key + " at end"),
                        .coupled = ended.value<net::Boolean>(key + " coupled"),
                        .number = ended.value<net::Real>(key + " number"),
                        .q = {}};
    // Whoever cancels it may find the lock at its end all the same.
    if (cancelled && !outcome.at_end.value_or(false)) return;
    if (is_alone(ended)) outcome.q = measured(context.cell);
    if (const auto q = ended.value<net::JointArray>(key + " q")) outcome.q = q->map();
    Diagnostics own;
    report(outcome, context, own);
    diagnostics.append(own, pointer);
  }

 protected:
  virtual void rehearse_belief(Rehearsal& rehearsal, Diagnostics& diagnostics) const = 0;
  virtual void note(const LockOutcome& outcome, activity::Context& context, Diagnostics& diagnostics) const = 0;
  /// Another tool side is coupled than was wanted, or none; nothing: it does not matter.
  [[nodiscard]] virtual std::optional<expression::State> wrong_side(const Cell&, const expression::State& coupled,
                                                                    const expression::RealSensor& number) const {
    (void)coupled;
    (void)number;
    return std::nullopt;
  }
  [[nodiscard]] const std::string& arm(const Cell& cell) const { return changer_in(cell, changer_).arm; }

 private:
  void report(const LockOutcome& outcome, activity::Context& context, Diagnostics& diagnostics) const {
    if (outcome.at_end.value_or(false)) return note(outcome, context, diagnostics);
    if (!outcome.at_end)
      return diagnostics.error(Code::kSensorSilent, "", fmt::format("'{}' did not answer", changer_),
                               "Check its power and its wiring");
    diagnostics.error(
        Code::kTimeout, "",
        fmt::format("the lock of '{}' did not {} within {:g} s", changer_, locks_ ? "close" : "open", timeout_),
        "Check its air");
  }
  [[nodiscard]] kinematics::JointVector measured(const Cell& cell) const {
    const device::Arm& device = *cell.arms.find(arm(cell))->second.device;
    return device.has_sample() ? device.sample().q : device.set_point().q;
  }

  std::string changer_;
  bool locks_;
  double timeout_;
};

class CoupleCommand final : public LockCommand {
 public:
  explicit CoupleCommand(CoupleParameters parameters)
      : LockCommand(parameters.changer, true, parameters.timeout), parameters_(std::move(parameters)) {}

  void check(const Cell& cell, Diagnostics& diagnostics) const override {
    const std::string side = expression::coupled_side(cell, parameters_.changer);
    if (side.empty()) return;
    diagnostics.error(Code::kConflict, pointer, fmt::format("'{}' has coupled '{}'", parameters_.changer, side),
                      "Put \"uncouple\" before it");
  }

 private:
  void rehearse_belief(Rehearsal& rehearsal, Diagnostics& diagnostics) const override {
    const auto X_WC = coupling_face(rehearsal.cell, changer_in(rehearsal.cell, parameters_.changer),
                                    rehearsal.q[arm(rehearsal.cell)]);
    if (!X_WC) return diagnostics.append(X_WC.error());
    const auto side = side_to_couple(rehearsal.cell, parameters_, *X_WC);
    if (!side) return diagnostics.append(side.error());
    diagnostics.append(expression::couple(rehearsal.cell, parameters_.changer, *side));
    diagnostics.append(check_carried(rehearsal.cell, parameters_.changer));
  }
  [[nodiscard]] std::optional<expression::State> wrong_side(const Cell& cell, const expression::State& coupled,
                                                            const expression::RealSensor& number) const override {
    const auto wanted = parameters_.tool ? expression::side_named(cell, *parameters_.tool) : std::nullopt;
    const auto side = wanted ? cell.tool_sides.find(*wanted) : cell.tool_sides.end();
    if (side == cell.tool_sides.end()) return !coupled;
    constexpr double kRounding = 0.5;
    return !coupled || !equals(number, static_cast<double>(side->second.number), kRounding);
  }
  void note(const LockOutcome& outcome, activity::Context& context, Diagnostics& diagnostics) const override {
    note_coupled(parameters_, outcome, context, diagnostics);
  }

  CoupleParameters parameters_;
};

class UncoupleCommand final : public LockCommand {
 public:
  explicit UncoupleCommand(UncoupleParameters parameters)
      : LockCommand(parameters.changer, false, parameters.timeout), parameters_(std::move(parameters)) {}

  /// An empty changer may be unlocked: that is how it becomes ready again.
  void check(const Cell& cell, Diagnostics& diagnostics) const override {
    const std::string holder = held_by_tools(cell, expression::coupled_side(cell, parameters_.changer));
    if (holder.empty()) return;
    diagnostics.error(Code::kConflict, pointer,
                      fmt::format("'{}' holds '{}'", holder, cell.held.find(holder)->second.object),
                      "Put \"release\" or \"detach\" before it");
  }

 private:
  void rehearse_belief(Rehearsal& rehearsal, Diagnostics& diagnostics) const override {
    if (expression::coupled_side(rehearsal.cell, parameters_.changer).empty()) return;
    diagnostics.append(leave_tool(rehearsal.cell, parameters_, rehearsal.q[arm(rehearsal.cell)]));
  }
  void note(const LockOutcome& outcome, activity::Context& context, Diagnostics& diagnostics) const override {
    note_uncoupled(parameters_, outcome, context, diagnostics);
  }

  UncoupleParameters parameters_;
};

void check_tool_side(CoupleParameters& parameters, const ReadContext& from) {
  if (!parameters.tool || expression::side_named(from.cell, *parameters.tool)) return;
  std::vector<std::string> names;
  for (const auto& [name, side] : from.cell.tool_sides) names.push_back(name);
  for (const auto& [name, tool] : from.cell.tools)
    if (!tool.side.empty()) names.push_back(name);
  from.reader.diagnostics().error(Code::kUnknownName, from.reader.at("tool"),
                                  fmt::format("there is no tool side, and no tool on one, '{}'", *parameters.tool),
                                  nearest_choice(*parameters.tool, names));
}

}  // namespace

const ParameterTable<CoupleParameters>& couple_parameters() {
  static const auto table = [] {
    ParameterTable<CoupleParameters> couple;
    couple.name("changer", NameOf::kToolChanger, &CoupleParameters::changer, "Tool changer that locks.")
        .text("tool", &CoupleParameters::tool, "Tool side, or a tool on it, that has to be coupled: whatever is there.")
        .number("timeout_s", "s", &CoupleParameters::timeout, kLockTime, "The step fails if the lock is open by then.")
        .rule(check_tool_side);
    return couple;
  }();
  return table;
}

const ParameterTable<UncoupleParameters>& uncouple_parameters() {
  static const auto table = [] {
    ParameterTable<UncoupleParameters> uncouple;
    uncouple.name("changer", NameOf::kToolChanger, &UncoupleParameters::changer, "Tool changer that unlocks.")
        .text("onto", &UncoupleParameters::onto, "Frame, object or base that the tool depends on then: the world.")
        .number("timeout_s", "s", &UncoupleParameters::timeout, kLockTime,
                "The step fails if the lock is closed by then.");
    return uncouple;
  }();
  return table;
}

std::unique_ptr<OperationCommand> couple_command(const CoupleParameters& parameters) {
  return std::make_unique<CoupleCommand>(parameters);
}

std::unique_ptr<OperationCommand> uncouple_command(const UncoupleParameters& parameters) {
  return std::make_unique<UncoupleCommand>(parameters);
}

Operation couple_operation() {
  return {.name = "couple",
          .doc = "Locks a tool changer: what it couples is a tool of its arm from then on.",
          .parameters = rows_of<couple_parameters>,
          .read_step = step_of_command,
          .read_command = make_command<couple_parameters, couple_command>};
}

Operation uncouple_operation() {
  return {.name = "uncouple",
          .doc = "Unlocks a tool changer: its tool stays where it is.",
          .parameters = rows_of<uncouple_parameters>,
          .read_step = step_of_command,
          .read_command = make_command<uncouple_parameters, uncouple_command>};
}

}  // namespace takt::operations
