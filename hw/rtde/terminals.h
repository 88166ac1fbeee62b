#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "core/device/driver.h"
#include "core/emulation/state_hash.h"
#include "hw/io/image.h"
#include "hw/rtde/field.h"

/// The terminals of a UR controller as an I/O block: the n-th of a kind, in the order of the block's model, is the n-th
/// of the controller. Digital ones: 0 to 7 standard, 8 to 15 configurable, 16 and 17 of the tool. Analog ones:
/// standard.
namespace takt::hw::rtde {

inline constexpr std::size_t kDigitalTerminals = 18, kAnalogTerminals = 2;

/// What keeps a block from being the terminals of a controller; empty: nothing. Realtime: setup.
[[nodiscard]] std::string refuse_terminals(const device::IoDescription& io);

/// The channels of a block by kind. Realtime: setup to make, cyclic to read.
class TerminalMap {
 public:
  using Kind = device::IoChannel::Kind;

  /// @param io  of a block that refuse_terminals() accepts
  explicit TerminalMap(const device::IoDescription& io);
  [[nodiscard]] const std::vector<device::IoChannel>& of(Kind kind) const {
    return channels_[static_cast<std::size_t>(kind)];
  }
  /// Analog inputs: V or A of the controller in the channel's unit, and back.
  [[nodiscard]] static double in_unit(const device::IoChannel& channel, double volt_or_ampere);
  [[nodiscard]] static double volt_or_ampere(const device::IoChannel& channel, double value);
  /// Analog outputs: the share of 0 to 10 V, or of 4 to 20 mA, and back.
  [[nodiscard]] static double share_of(const device::IoChannel& channel, double value);
  [[nodiscard]] static double from_share(const device::IoChannel& channel, double share);
  [[nodiscard]] static bool is_voltage(const device::IoChannel& channel) { return channel.unit == "V"; }

 private:
  std::array<std::vector<device::IoChannel>, 4> channels_;
};

/// The block as core and driver share it. The functions of IoDriver are for the cycle, the others for the thread that
/// serves the wire. Outputs are written when the connection is there, and when they change; after a connection that
/// broke only when reset() was called since.
class TerminalBlock final : public device::IoDriver {
 public:
  /// @param fault_text  words for a fault of lose(); any thread
  TerminalBlock(const device::IoDescription& io, std::function<std::string(std::uint32_t)> fault_text);

  // -- The cycle -----------------------------------------------------------------------------------------------------
  [[nodiscard]] const device::IoTerminals& terminals() const override { return image_.terminals(); }
  [[nodiscard]] bool ready() const override { return image_.inputs().ready; }
  [[nodiscard]] std::string fault_text() const override;
  void reset() override { resets_.fetch_add(1); }

  // -- The wire ------------------------------------------------------------------------------------------------------
  /// Fields of one input recipe, for outputs(); empty: the block has no outputs.
  [[nodiscard]] const std::vector<std::string>& fields() const { return fields_; }
  /// What a package of the controller says. @param stamp  on the core's clock. Realtime: cyclic.
  void take(std::uint64_t digital, const std::array<double, kAnalogTerminals>& analog, Nanoseconds stamp);
  /// The connection is lost.
  void lose(std::uint32_t fault);
  /// Whether outputs have to be written; then outputs() are their fields. Realtime: cyclic.
  [[nodiscard]] bool take_outputs();
  [[nodiscard]] const std::vector<FieldValue>& outputs() const { return values_; }
  void add_to(emulation::StateHash& hash) const;

 private:
  void fill_outputs(const hw::OutputImage& wanted);

  TerminalMap map_;
  hw::CycleImage image_;
  std::function<std::string(std::uint32_t)> fault_text_;
  std::vector<std::string> fields_;
  std::vector<FieldValue> values_, told_;
  std::atomic<int> resets_ = 0;
  int resets_seen_ = 0;
  hw::InputImage inputs_;
  bool armed_ = true, written_ = false;
};

}  // namespace takt::hw::rtde
