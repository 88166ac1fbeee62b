#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace takt::hw::cia402 {

/// What a drive is told for a cycle of the bus.
struct DriveOutputs {
  std::uint16_t control = 0;
  std::int32_t target = 0;    ///< position at the end of the cycle, increments
  std::int32_t velocity = 0;  ///< there, increments/s
};
/// What a drive reports at the beginning of a cycle.
struct DriveInputs {
  std::uint16_t status = 0;
  std::int8_t mode = 0;       ///< of operation
  std::int32_t position = 0;  ///< increments
  std::int32_t velocity = 0;  ///< increments/s
  std::int16_t torque = 0;    ///< of the motor, thousandths of its rated torque
};
/// What a drive said of itself when it was set up.
struct DriveData {
  double increments_per_rad = 1.0;  ///< of the joint
  double torque_unit = 0.0;         ///< Nm of the joint in a thousandth; 0: not known
};

/// A field bus with the drives of an arm, one per joint, in mode CSP (CiA 402), as their master sees it. It finds the
/// drives, sets them up, and exchanges process data with all of them in each cycle. CANopen is one (CanopenBus); an
/// EtherCAT master with CoE fits as well. One thread. Realtime: cyclic while it runs; it allocates while it sets up.
class FieldBus {
 public:
  enum class Phase : std::uint8_t {
    kSearching,  ///< some drive has not answered, or is lost
    kSettingUp,
    kRunning,
    kRefused  ///< a drive is not what it must be: refusal() says why
  };

  virtual ~FieldBus() = default;
  /// A cycle begins at the time `now` of the machine: the drives take what was sent since the last one and report.
  virtual void begin_cycle(Nanoseconds now) = 0;
  /// Takes what has come. @return true once per cycle: when the inputs of all drives are there
  virtual bool poll(Nanoseconds now) = 0;
  /// For the next cycle, in the order of the joints.
  virtual void send(std::span<const DriveOutputs> outputs) = 0;
  /// Waits until poll() may have something to take, at most `timeout` ns.
  virtual void wait(Nanoseconds timeout) = 0;

  [[nodiscard]] virtual Phase phase() const = 0;
  [[nodiscard]] virtual const DriveInputs& inputs(std::size_t joint) const = 0;
  [[nodiscard]] virtual const DriveData& data(std::size_t joint) const = 0;
  /// The error code that a drive reported last and has not taken back; 0: none.
  [[nodiscard]] virtual std::uint16_t error(std::size_t joint) const = 0;
  /// Why it is in phase kRefused; empty: it is not. Realtime: setup.
  [[nodiscard]] virtual std::string refusal() const = 0;
  /// What happened since the last call, for people. Realtime: setup.
  [[nodiscard]] virtual std::vector<std::string> lines() = 0;
};

}  // namespace takt::hw::cia402
