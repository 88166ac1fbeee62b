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

/// The first example that KUKA delivers with the interface. No strategy: KRL's stays.
namespace kuka_sample_words {
inline constexpr std::size_t kCommand = 0;      ///< integer, both ways
inline constexpr int kReady = 10, kLeave = -1;  ///< from remote: the quality suffices; to remote: the client is to end
inline constexpr std::size_t kEcho = 0;         ///< real, from remote: what came in kProbe
inline constexpr std::size_t kProbe = 1;        ///< real, to remote
}  // namespace kuka_sample_words

/// fri_start of the Warsaw University of Technology, and the FRI component of the TU Munich.
namespace rcprg_words {
inline constexpr std::uint16_t kRequest = 1 << 0;         ///< from remote; to remote: it is being served
inline constexpr std::size_t kCommand = 0, kCycle = 1;    ///< from remote; ms, of kReopen
inline constexpr int kStart = 1, kStop = 2, kReopen = 3;  ///< commands
inline constexpr int kStrategy = 30;                      ///< KRL's, always
}  // namespace rcprg_words

/// OpenKC.
namespace openkc_words {
inline constexpr std::uint16_t kRequest = 1 << 0;                    ///< from remote
inline constexpr std::size_t kStrategy = 1, kCommand = 15;           ///< from remote
inline constexpr std::size_t kCount = 13, kEcho = 14, kAnswer = 15;  ///< to remote
inline constexpr int kStart = 1, kStop = 2, kReset = 3, kSetCartesian = 4, kSetAxis = 5, kToCartesian = 6, kToAxis = 7,
                     kToGravity = 8, kToPosition = 9, kSetStrategy = 30;  ///< commands
inline constexpr int kDone = 100, kRefused = 101;                         ///< answers; the numbers are assumed
}  // namespace openkc_words

/// The robot control core of the University of Augsburg: strategy and tool are handed over value by value.
namespace isse_words {
inline constexpr std::uint16_t kRequest = 1 << 15;        ///< both ways
inline constexpr std::size_t kStep = 15, kStrategy = 14;  ///< integers; the step both ways
inline constexpr std::size_t kValue = 14;                 ///< real, of the steps after the first
inline constexpr int kSteps = 17;
/// Values by their step: mm and degrees A, B, C; kg; kg m^2.
inline constexpr int kTcp = 2, kMass = 8, kCentre = 9, kInertiaAxes = 12, kInertia = 15;
}  // namespace isse_words

}  // namespace takt::hw::fri
