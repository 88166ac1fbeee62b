#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/device/description.h"
#include "hw/cia402/field_bus.h"
#include "hw/cia402/protocol/canopen.h"

namespace takt::hw::cia402 {

/// How the master of a CANopen bus is set up.
struct BusOptions {
  NodeId first_node = 1;                      ///< of the first joint; the others follow
  Nanoseconds cycle = 4 * kMillisecond;       ///< of SYNC: whole milliseconds
  Nanoseconds heartbeat = 50 * kMillisecond;  ///< of master and drives; who misses three is lost
};

/// Finds one drive, looks whether it is the right one, sets it up and starts it, by service data; then watches its
/// heartbeat, and begins anew when that is missing. It sends nothing itself: next() says what. One thread.
class DriveSetup {
 public:
  using Phase = FieldBus::Phase;

  DriveSetup(const device::ArmDescription& arm, std::size_t joint, const BusOptions& options);

  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] NodeId node() const { return node_; }
  /// "drive 3 (a3)".
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const DriveData& data() const { return data_; }

  /// What has to be sent now, if anything.
  [[nodiscard]] std::optional<CanFrame> next(Nanoseconds now);
  /// An answer of the drive.
  void take(const SdoMessage& answer, Nanoseconds now);
  /// A heartbeat of the drive.
  void hear(NmtState state, Nanoseconds now);
  /// What happened, for people; empty: nothing.
  [[nodiscard]] std::string take_line() { return std::exchange(line_, {}); }

 private:
  struct Transfer {
    ObjectId id;
    std::uint8_t size = 0;    ///< bytes to write; 0: to read
    std::uint32_t value = 0;  ///< to write
  };

  void search();
  void plan_transfers(const BusOptions& options);
  template <std::size_t N>
  void plan_message(std::uint16_t parameters, std::uint16_t mapping, std::uint32_t id,
                    const std::array<MappedObject, N>& objects);
  void write(const ObjectId& id, std::uint8_t size, std::uint32_t value) { transfers_.push_back({id, size, value}); }
  void look_at_drive();
  void refuse(std::string why);
  [[nodiscard]] std::uint32_t value(const ObjectId& id) const { return read_.at(id); }

  NodeId node_;
  std::string name_;
  BusOptions options_;
  double range_, acceleration_;  // of the joint: rad from 0, rad/s2
  Phase phase_ = Phase::kSearching;
  std::vector<Transfer> transfers_;
  std::size_t reads_ = 0;  // of the transfers, which come first
  std::size_t at_ = 0;
  bool asked_ = false;
  int tries_ = 0;
  Nanoseconds deadline_ = 0, heard_ = 0;
  std::map<ObjectId, std::uint32_t> read_;
  DriveData data_;
  std::string line_;
};

}  // namespace takt::hw::cia402
