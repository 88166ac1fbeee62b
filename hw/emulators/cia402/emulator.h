#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/device/driver.h"
#include "hw/can/can_link.h"
#include "hw/emulators/cia402/node.h"

namespace takt::hw::cia402 {

/// How the emulated drives of an arm are set up.
struct EmulatorOptions {
  NodeId first_node = 1;  ///< of the first joint; the others follow
  int bridged = 3;        ///< as in DriveOptions
};

/// The drives of an arm on one bus, around an arm that takes set points each cycle. One thread. Realtime: cyclic but
/// for the constructor.
class Emulator final : public device::ControllerEmulator {
 public:
  Emulator(const device::DriverRequest& request, const EmulatorOptions& options, std::unique_ptr<CanLink> link,
           std::shared_ptr<device::ArmBackend> machine);

  void advance(Nanoseconds now) override;
  /// Brakes that the drives themselves closed open when a master switches the drives on again.
  void set_brakes(std::function<void()> /*close*/, std::function<void()> open) override { open_ = std::move(open); }
  [[nodiscard]] std::vector<std::string> news() override;

  // -- For who makes time go on in smaller steps (Twin).
  /// Reads the arm: once in each cycle of the arm.
  void look();
  /// Takes the frames that have come, and all that is due.
  void receive(Nanoseconds now);
  /// Tells the arm where to be now.
  void drive(Nanoseconds now);

  [[nodiscard]] Node& node(std::size_t joint) { return *nodes_[joint]; }
  [[nodiscard]] std::size_t joint_count() const { return nodes_.size(); }
  [[nodiscard]] CanLink& link() { return *link_; }

 private:
  void measure(Nanoseconds now);

  EmulatorOptions options_;
  std::unique_ptr<CanLink> link_;
  std::shared_ptr<device::ArmBackend> machine_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<DriveState> told_;
  device::ArmSample sample_;
  device::ArmSetPoint set_point_;
  bool has_sample_ = false, closed_ = false;  // closed_: brakes, by a drive
  std::function<void()> open_;
};

}  // namespace takt::hw::cia402
