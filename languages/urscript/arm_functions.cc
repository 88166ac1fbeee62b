// When calls wait, whose motions they are, and what commands of the arm are made of.
#include "languages/urscript/arm_functions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "languages/urscript/poses.h"

namespace takt::languages::urscript {

void ArmFunctions::take(int thread) {
  if (owner_ != 0 && owner_ != thread && busy()) throw BadArgument{"another thread is already controlling the robot"};
  owner_ = thread;
}

void ArmFunctions::release(const std::vector<int>& threads) {
  if (owner_ == 0 || std::ranges::find(threads, owner_) == threads.end()) return;
  owner_ = 0;
  if (busy()) host_.stop();
}

Outcome ArmFunctions::ask(Act act) {
  Wait wait = [this, act = std::move(act)]() -> std::optional<Value> {
    try {
      return act();
    } catch (BadArgument& bad) {
      machine_->fail(std::move(bad.text));
      return Value();
    }
  };
  if (auto value = wait()) return *std::move(value);
  return wait;
}

Outcome ArmFunctions::at_rest(int thread, Act act) {
  return ask([this, thread, act = std::move(act), rested = false]() mutable -> std::optional<Value> {
    rested = rested || owner_ != thread || host_.settled();
    return rested ? act() : std::nullopt;
  });
}

/// At least a cycle. The time begins when the motions are over.
Outcome ArmFunctions::wait_for(int thread, double seconds, Value result) {
  return at_rest(
      thread,
      [this, seconds, result = std::move(result), end = std::optional<double>()]() mutable -> std::optional<Value> {
        if (!end) end = host_.now() + std::max(seconds, host_.cycle());
        if (host_.now() >= *end - 0.5 * host_.cycle()) return result;
        next_time_ = std::min(next_time_, *end);
        return std::nullopt;
      });
}

Outcome ArmFunctions::move(int thread, MotionCommand command) {
  if (freedrive_) throw BadArgument{"the arm is led by hand: end_freedrive_mode() comes first"};
  take(thread);
  command.at = at();
  command.force = force_;
  return ask([this, command = std::move(command), given = false]() mutable -> std::optional<Value> {
    // One that has a time begins at rest: how long it takes from within a blend is not known.
    if (!given && (command.time > 0.0 ? !host_.settled() : host_.unfinished() > kAdvance)) return std::nullopt;
    if (!given) {
      const bool blends = command.radius > 0.0;
      if (std::string problem = host_.move(command); !problem.empty()) throw BadArgument{std::move(problem)};
      given = true;
      if (blends) return Value();
    }
    if (!host_.settled()) return std::nullopt;
    // The force is held on where the arm stands.
    if (force_)
      (void)host_.last({.kind = LastingCommand::Kind::kForce, .X_FT = X_FT_, .force = *force_, .at = command.at});
    return Value();
  });
}

Outcome ArmFunctions::last(int thread, LastingCommand command, double seconds) {
  take(thread);
  command.at = at();
  command.X_FT = X_FT_;
  command.seconds = seconds;
  return at_rest(thread, [this, command, seconds, end = std::optional<double>()]() mutable -> std::optional<Value> {
    if (!end) {
      if (std::string problem = host_.last(command); !problem.empty()) throw BadArgument{std::move(problem)};
      if (seconds <= 0.0) return Value();
      end = host_.now() + seconds;
    }
    if (host_.now() >= *end - 0.5 * host_.cycle()) return Value();
    next_time_ = std::min(next_time_, *end);
    return std::nullopt;
  });
}

Outcome ArmFunctions::stop(int thread) {
  take(thread);
  host_.stop();
  return at_rest(thread, [] { return Value(); });
}

/// What lasts comes to rest, once the motions that the thread has given are over.
Outcome ArmFunctions::end_lasting(int thread) {
  take(thread);
  return at_rest(thread, [this, stopped = false]() mutable -> std::optional<Value> {
    if (!std::exchange(stopped, true) && host_.lasts()) host_.stop();
    return host_.settled() ? std::optional<Value>(Value()) : std::nullopt;
  });
}

Outcome ArmFunctions::write(int thread, Signal output, int number, double value) {
  const TextLocation place = at();
  return at_rest(thread, [this, output, number, value, place, written = false]() mutable -> std::optional<Value> {
    if (!std::exchange(written, true)) {
      // Beside what moves, or what lasts.
      const bool beside = host_.lasts() || !host_.settled();
      if (std::string problem = host_.write(output, number, value, beside, place); !problem.empty())
        throw BadArgument{std::move(problem)};
      if (beside) return Value();
    }
    return host_.settled() ? std::optional<Value>(Value()) : std::nullopt;
  });
}

Outcome ArmFunctions::read(int thread, Signal signal, int number) {
  return at_rest(thread, [this, signal, number]() -> std::optional<Value> {
    const auto value = host_.read(signal, number);
    if (!value) throw BadArgument{fmt::format("number {} is no signal of this cell", number)};
    const bool digital = signal == Signal::kDigitalIn || signal == Signal::kDigitalOut;
    return digital ? Value(*value != 0.0) : Value(*value);
  });
}

kinematics::JointVector ArmFunctions::joints(const Arguments& a, std::size_t i) const {
  return a.joints(i, static_cast<std::size_t>(host_.joints(false).size()));
}

/// The tool that a call names, or the one that is set.
Eigen::Isometry3d ArmFunctions::tool(const Arguments& a, std::size_t i) const {
  return a.none(i) || a[i].number() ? X_FT_ : to_isometry(a.pose(i));
}

MotionGoal ArmFunctions::goal(const Arguments& a, std::size_t i, bool may_be_joints) const {
  MotionGoal made;
  if (a[i].pose()) {
    made.X_BF = to_isometry(a.pose(i)) * X_FT_.inverse();
    if (!made.X_BF.matrix().allFinite()) throw BadArgument{fmt::format("argument {} is not finite", i + 1)};
    return made;
  }
  made.q = joints(a, i);
  if (may_be_joints) return made;
  made.X_BF = host_.flange(made.q);
  made.q.resize(0);
  return made;
}

MotionCommand ArmFunctions::command(const Arguments& a, MotionCommand::Kind kind, std::string_view word,
                                    std::size_t first) const {
  MotionCommand made{.kind = kind, .X_FT = X_FT_, .word = std::string(word), .at = {}};
  made.acceleration = a.real(first);
  made.velocity = a.real(first + 1);
  if (made.acceleration <= 0.0 || made.velocity <= 0.0) throw BadArgument{"velocity and acceleration must be above 0"};
  return made;
}

/// What of force_mode() an operation does: one axis along which the arm yields, with a force, in a frame that stands
/// still.
ForceCommand ArmFunctions::force(const Arguments& a) const {
  const Eigen::Isometry3d X_BTask = to_isometry(a.pose(0));
  const auto selection = a.numbers(1, 6), wrench = a.numbers(2, 6), limits = a.numbers(4, 6);
  if (a.integer(3, 1, 3) != 2) throw BadArgument{"only type 2 of force_mode(), a frame that stands still, has a match"};
  std::optional<std::size_t> axis;
  for (std::size_t i = 0; i < 6; ++i) {
    if (selection[i] == 0.0) continue;
    if (axis || i > 2) throw BadArgument{"the arm yields along one axis, and about none: select one of x, y, z"};
    axis = i;
  }
  if (!axis) throw BadArgument{"no axis is selected"};
  const double along = wrench[*axis];
  if (along == 0.0) throw BadArgument{"the force along the selected axis is 0: give one in N"};
  ForceCommand made;
  made.direction = X_BTask.linear().col(static_cast<Eigen::Index>(*axis)) * (along > 0.0 ? 1.0 : -1.0);
  made.force = std::abs(along);
  made.velocity = std::abs(limits[*axis]);
  if (made.velocity <= 0.0) throw BadArgument{"the limit along the selected axis, a speed, must be above 0"};
  return made;
}

}  // namespace takt::languages::urscript
