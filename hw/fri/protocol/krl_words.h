#pragma once

#include <cstddef>

#include "hw/fri/protocol/packet.h"

/// The words that remote side and KRL program exchange, for each convention: indices count from 0, KRL's from 1.
namespace takt::hw::fri {

/// $STIFFNESS.STRATEGY of a control mode.
[[nodiscard]] constexpr int strategy_of(Control control) {
  if (control == Control::kJointImpedance) return 30;
  return control == Control::kCartesianImpedance ? 20 : 10;
}
/// @return kOther for a number that is no strategy
[[nodiscard]] constexpr Control control_of(int strategy) {
  switch (strategy) {
    case 10:
      return Control::kPosition;
    case 20:
      return Control::kCartesianImpedance;
    case 30:
      return Control::kJointImpedance;
    default:
      return Control::kOther;
  }
}

/// Our own: the state that is wanted, and a number that changes with each request, so that a program that fell back to
/// monitor state does not start by itself, and a lost datagram costs a cycle.
namespace takt_words {
inline constexpr std::size_t kWanted = 0;    ///< to KRL: 1 monitor, 2 command; from KRL: the state that it is in
inline constexpr std::size_t kStrategy = 1;  ///< both ways
inline constexpr std::size_t kRequest = 2;   ///< to KRL: number of the request; from KRL: the last one that was served
}  // namespace takt_words

/// FRIControl (Stanford's FRI library).
namespace fri_control_words {
inline constexpr std::size_t kStrategy = 14, kCommand = 15;
inline constexpr int kStart = 10, kStop = 20, kClose = 30, kCloseAlternative = 40;  ///< from remote
inline constexpr int kOpened = 10, kStarted = 20, kClosed = 30;                     ///< to remote
}  // namespace fri_control_words

/// lwr_hw of the Centro Piaggio, for ros_control.
namespace ros_control_words {
inline constexpr std::size_t kStrategy = 0, kCommand = 1;
inline constexpr int kStop = 0, kStart = 1;  ///< both ways
inline constexpr int kInitialised = 10;      ///< to remote, before the first command
}  // namespace ros_control_words

}  // namespace takt::hw::fri
