#pragma once

#include <cstdint>
#include <string_view>

#include "core/base/time.h"
#include "hw/fri/krl_handshake.h"

namespace takt::hw::fri {

/// Why the driver does not let the arm be moved (ArmSample::fault).
enum class Fault : std::uint32_t {
  kNone,
  kMonitor,      ///< monitor state: KRL has not started command state
  kFellBack,     ///< the controller went from command to monitor state by itself
  kDrivesOff,    ///< command state, but not all drives have power
  kRobotError,   ///< the controller reports errors of drives
  kCycle,        ///< the controller's cycle is another one than the site says
  kControl,      ///< it is in another control mode than was asked for
  kStopped,      ///< the core asked for brakes
  kNotStarted,   ///< KRL did not start in time
  kModeRefused,  ///< KRL did not start in the control mode that was asked for
  kTaskFrame     ///< a compliance in axes that the task frame of KRL does not have
};
/// What is wrong and what to do. Realtime: setup.
[[nodiscard]] std::string_view text_of(Fault fault);

/// Decides what the driver asks of KRL, and whether the arm may be moved: command state is asked for once, after that
/// only by reset(). One thread. Realtime: cyclic.
class Supervisor {
 public:
  static constexpr Nanoseconds kStartTime = 8 * kSecond;  ///< for KRL to start; a good connection needs 1 s

  /// @param cycle  of the interface, as the site says
  explicit Supervisor(Nanoseconds cycle) : cycle_(cycle) {}

  /// A datagram of the controller has come, `now` on any steady clock.
  void look(const Measurement& m, Nanoseconds now, const KrlHandshake& handshake);
  /// Somebody asks for command state again, after whatever happened.
  void reset(Nanoseconds now);
  /// The core wants brakes.
  void stop() { refuse(Fault::kStopped); }
  /// The arm must not be moved on; once.
  void refuse(Fault why);
  /// Begins to change the control mode, through monitor state.
  void change(Control control, Nanoseconds now);

  [[nodiscard]] const KrlRequest& request() const { return request_; }
  [[nodiscard]] bool changing() const { return phase_ == Phase::kLeaving || phase_ == Phase::kEntering; }
  /// Why the arm may not be moved; kNone: it may.
  [[nodiscard]] Fault fault(const Measurement& m) const;

 private:
  enum class Phase : std::uint8_t {
    kNew,       ///< no datagram yet
    kStarting,  ///< command state was asked for
    kRunning,   ///< it was there
    kLeaving,   ///< for another control mode: to monitor state
    kEntering,  ///< for another control mode: to command state
    kDone       ///< monitor state until reset()
  };
  void ask(State state, Control control);
  void end(Fault why);
  [[nodiscard]] bool wrong_cycle(const Measurement& m) const;
  [[nodiscard]] bool there(const Measurement& m) const {
    return m.state == State::kCommand && m.control == request_.control;
  }

  Nanoseconds cycle_;
  Phase phase_ = Phase::kNew;
  KrlRequest request_;
  Fault latched_ = Fault::kNone;
  Control next_control_ = Control::kPosition;
  Nanoseconds asked_ = 0;
};

}  // namespace takt::hw::fri
