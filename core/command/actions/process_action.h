#pragma once

#include "core/command/action.h"

/// A process that has to run where a path is followed: an arc, a jet of glue, a saw. Realtime: setup.
namespace takt::command {

struct ProcessParameters {
  double start_timeout = 1.0;  ///< s, within which the process has to run once it is wanted
  double finish_time = 0.0;    ///< s, that it goes on at rest at the end of the path, and after a cancel
  double overlap = 0.0;        ///< s of path time by which it starts again before where it went out
  int restarts = 0;            ///< how often it is started again where it goes out by itself
};

/// The motion, which is followed only while a process runs (primitive ProcessOnPath): it begins in the cycle in which
/// `running` holds. A pause is a break: the process goes out at once, the arm brakes on its path, and afterwards the
/// path is followed back by the overlap and the process started again. Any speed above 0 is the planned one: a process
/// speed is no matter of taste. Cancelled, the arm brakes on its path with the process on, which then goes on for the
/// finishing time.
/// Offers what the motion offers, and `process`: it is wanted, never null while the command runs; `not_started`: it did
/// not run in time; `lost`: it went out and was not to start again. Both end the motion, at rest, process off.
/// @param motion   a planned motion of one arm, with or without a weave
/// @param running  null: it does not
[[nodiscard]] Action while_process(const Action& motion, const expression::State& running,
                                   const ProcessParameters& parameters = {});

/// A digital output is what a state says until it is cancelled; null counts as false. (Cancelled, it keeps its last
/// value.)
[[nodiscard]] Action follow_state(const expression::State& state);

}  // namespace takt::command
