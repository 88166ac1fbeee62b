#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "cell/file/fault_point.h"
#include "core/base/object_reader.h"
#include "core/base/time.h"
#include "core/device/backend.h"

namespace takt::cell {

/// Something that happens to the machines at one time, whatever the program does.
struct FaultEntry {
  enum class Kind {
    kStop,           ///< the arm stops by itself, as by a fault of its own
    kRelease,        ///< an operator forgets the fault and opens the brakes
    kEmergencyStop,  ///< the button is pressed: the core's latch, and the brakes of every arm by a circuit of their own
    kReset,          ///< the button is pulled, the latch reset, every arm released
    kPush,           ///< somebody pushes a body
    kSensor,         ///< the readings of a sensor or an input are wrong for a while
    kToolChanger,    ///< a tool changer has no air for a while, or its lock is open by itself
    kDevice          ///< the connection to an arm, a base or a gripper fails for a while, or its fingers are jammed
  };
  Kind kind = Kind::kStop;
  Nanoseconds at = 0;
  std::string arm;  ///< empty: all
  device::StopCategory category = device::StopCategory::kStopThenBrakes;
  /// Of an emergency stop of category 1: so long after it the circuit closes the brakes, whatever the core does.
  Nanoseconds brakes_after = kSecond;
  std::string body;                                 ///< of a push: "DEVICE/LINK" or "OBJECT"
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< at its centre of mass, in the world, N
  Nanoseconds duration = kSecond;                   ///< of a push, and of what is wrong for a while
  std::string device;                               ///< of wrong readings, of a connection: whose
  DeviceFault wrong;                                ///< and what
  std::string changer;                              ///< of a tool changer's fault
  bool opens = false;                               ///< the lock opens; else its air is gone
  std::string pointer;
};

/// The words of the file.
[[nodiscard]] const std::string& name_of(FaultEntry::Kind kind);
[[nodiscard]] const std::string& name_of(DeviceFault::Kind kind);

/// Reads the key "faults": diagnostics for what is wrong, the entries in the order of their times. Realtime: setup.
void read_faults(ObjectReader& reader, std::vector<FaultEntry>& faults);

}  // namespace takt::cell
