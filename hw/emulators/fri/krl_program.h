#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/device/backend.h"
#include "hw/fri/protocol/packet.h"

namespace takt::hw::fri {

/// What a KRL program can do and see of the interface, named as KRL names it. Values are KRL's own copies.
class KrlInterface {
 public:
  virtual ~KrlInterface() = default;
  virtual void fri_open() = 0;
  /// Asks for command state; fri_state() tells when it is there. It is given up after some seconds.
  virtual void fri_start(double safety_limits) = 0;
  virtual void fri_stop() = 0;
  virtual void fri_close() = 0;
  /// $STIFFNESS.STRATEGY: 10 position, 20 Cartesian impedance, 30 joint impedance; another one counts for nothing.
  /// Only in monitor state. @return false: it stays as it was
  virtual bool set_strategy(int strategy) = 0;
  /// $TOOL and $LOAD.
  virtual void set_tool(const device::ToolSetting& tool) = 0;

  [[nodiscard]] virtual State fri_state() const = 0;
  [[nodiscard]] virtual Quality fri_quality() const = 0;
  /// fri_start() was called and is neither done nor given up.
  [[nodiscard]] virtual bool starting() const = 0;
  [[nodiscard]] virtual const KrlValues& from_remote() const = 0;  ///< $FRI_FRM_...
  [[nodiscard]] virtual KrlValues& to_remote() = 0;                ///< $FRI_TO_...
};

/// A KRL program, as a script that is called every 12 ms, which is the controller's interpolation cycle. Another
/// program is another class. Realtime: cyclic, no allocation.
class KrlProgram {
 public:
  virtual ~KrlProgram() = default;
  virtual void poll(KrlInterface& krl) = 0;
};

/// By the name of its convention (docs/hardware.md, "The KRL program"). @return null: there is none. Realtime: setup.
[[nodiscard]] std::unique_ptr<KrlProgram> make_krl_program(std::string_view convention);
/// "takt", "fri_control", "ros_control", "kuka_sample", "rcprg", "openkc", "isse".
[[nodiscard]] const std::vector<std::string>& krl_conventions();

}  // namespace takt::hw::fri
