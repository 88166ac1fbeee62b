#pragma once

#include <memory>

#include "core/device/description.h"
#include "hw/can/can_link.h"
#include "hw/cia402/drive_setup.h"
#include "hw/cia402/field_bus.h"

namespace takt::hw::cia402 {

/// The drives of an arm on CANopen: this side is master of the network, sends SYNC and a heartbeat, and watches the
/// heartbeats of the drives.
class CanopenBus final : public FieldBus {
 public:
  CanopenBus(const device::ArmDescription& arm, const BusOptions& options, std::unique_ptr<CanLink> link);

  void begin_cycle(Nanoseconds now) override;
  bool poll(Nanoseconds now) override;
  void send(std::span<const DriveOutputs> outputs) override;
  void wait(Nanoseconds timeout) override { (void)link_->wait(timeout); }
  [[nodiscard]] Phase phase() const override;
  [[nodiscard]] const DriveInputs& inputs(std::size_t joint) const override { return drives_[joint].inputs; }
  [[nodiscard]] const DriveData& data(std::size_t joint) const override { return drives_[joint].setup.data(); }
  [[nodiscard]] std::uint16_t error(std::size_t joint) const override { return drives_[joint].error; }
  [[nodiscard]] std::string refusal() const override { return refusal_; }
  [[nodiscard]] std::vector<std::string> lines() override;
  [[nodiscard]] CanCounts counts() const { return link_->counts(); }

 private:
  struct Drive {
    DriveSetup setup;
    DriveInputs inputs;
    unsigned fresh = 0;  // bits of the messages that came in this cycle
    std::uint16_t error = 0;
  };

  [[nodiscard]] Drive* drive_of(NodeId node);
  void take(const CanFrame& frame, Nanoseconds now);
  void take_inputs(const CanFrame& frame);
  void take_emergency(const CanFrame& frame);
  void take_heartbeat(const CanFrame& frame, Nanoseconds now);
  void meet_other_master();
  [[nodiscard]] bool complete() const;

  BusOptions options_;
  std::unique_ptr<CanLink> link_;
  std::vector<Drive> drives_;
  bool awaited_ = false;  // the inputs of this cycle were not all there yet
  bool other_master_ = false;
  Nanoseconds next_heartbeat_ = 0;
  std::vector<std::string> lines_;
  std::string refusal_;
};

}  // namespace takt::hw::cia402
