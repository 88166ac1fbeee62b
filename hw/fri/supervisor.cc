#include "hw/fri/supervisor.h"

#include <cmath>

namespace takt::hw::fri {

std::string_view text_of(Fault fault) {
  switch (fault) {
    case Fault::kNone:
      return {};
    case Fault::kMonitor:
      return "FRI is in monitor state: the KRL program has not started command state";
    case Fault::kFellBack:
      return "the controller fell back to monitor state: read its message, then reset";
    case Fault::kDrivesOff:
      return "not all drives have power: check enabling switch, operating mode and emergency stops";
    case Fault::kRobotError:
      return "the controller reports errors of drives: read its messages";
    case Fault::kCycle:
      return "the controller's cycle is not that of the site: friOpen() and 'cycle_ms' must agree";
    case Fault::kControl:
      return "the arm is in another control mode than was asked for: check the strategy in the KRL program";
    case Fault::kStopped:
      return "stopped because brakes were asked for; reset to start again";
    case Fault::kNotStarted:
      return "the KRL program did not start command state in time: is it running, in the convention of the site?";
    case Fault::kModeRefused:
      return "the KRL program did not start the control mode that was asked for";
    case Fault::kTaskFrame:
      return "the stiffness is given in axes that the KRL program's task frame does not have: set 'task_frame' and "
             "$STIFFNESS.TASKFRAME";
  }
  return {};
}

void Supervisor::ask(State state, Control control) {
  request_.state = state;
  request_.control = control;
  ++request_.number;
}

void Supervisor::end(Fault why) {
  phase_ = Phase::kDone;
  latched_ = why;
  request_.state = State::kMonitor;
}

void Supervisor::reset(Nanoseconds now) {
  if (phase_ == Phase::kNew) return;  // starts anyway
  latched_ = Fault::kNone;
  phase_ = Phase::kStarting;
  asked_ = now;
  ask(State::kCommand, request_.control);
}

void Supervisor::refuse(Fault why) {
  if (phase_ == Phase::kDone) return;
  ask(State::kMonitor, request_.control);
  end(why);
}

void Supervisor::change(Control control, Nanoseconds now) {
  if (phase_ != Phase::kRunning || control == request_.control) return;
  phase_ = Phase::kLeaving;
  asked_ = now;
  ask(State::kMonitor, request_.control);
  next_control_ = control;
}

void Supervisor::look(const Measurement& m, Nanoseconds now, const KrlHandshake& handshake) {
  const bool late = now - asked_ > kStartTime;
  switch (phase_) {
    case Phase::kNew:
      request_.number = handshake.first_number(m) - 1;
      phase_ = Phase::kStarting;
      asked_ = now;
      return ask(State::kCommand, request_.control);
    case Phase::kStarting:
      if (there(m)) {
        phase_ = Phase::kRunning;
      } else if (late) {
        end(Fault::kNotStarted);
      }
      return;
    case Phase::kRunning:
      if (m.state != State::kCommand) end(Fault::kFellBack);
      return;
    case Phase::kLeaving:
      if (m.state == State::kMonitor) {
        phase_ = Phase::kEntering;
        ask(State::kCommand, next_control_);
      }
      [[fallthrough]];
    case Phase::kEntering:
      if (phase_ == Phase::kEntering && there(m)) phase_ = Phase::kRunning;
      if (changing() && late) end(Fault::kModeRefused);
      return;
    case Phase::kDone:
      return;
  }
}

bool Supervisor::wrong_cycle(const Measurement& m) const {
  return !(std::abs(m.measurement_period - to_seconds(cycle_)) < 0.01 * to_seconds(cycle_));
}

Fault Supervisor::fault(const Measurement& m) const {
  if (latched_ != Fault::kNone) return latched_;
  if (wrong_cycle(m)) return Fault::kCycle;
  if (m.error != 0) return Fault::kRobotError;
  if (m.state != State::kCommand) return Fault::kMonitor;
  if (!drives_on(m)) return Fault::kDrivesOff;
  return m.control == request_.control ? Fault::kNone : Fault::kControl;
}

}  // namespace takt::hw::fri
