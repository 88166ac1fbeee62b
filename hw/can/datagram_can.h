#pragma once

#include <array>
#include <memory>

#include "core/base/clock.h"
#include "hw/can/can_link.h"
#include "hw/wire/datagram_link.h"

namespace takt::hw {

/// A frame in a datagram: identifier (u32), size (u8), three bytes of 0, eight bytes of data (those beyond the size are
/// 0), CRC-32 of all before (u32). Little endian.
inline constexpr std::size_t kCanDatagramSize = 20;
inline constexpr std::uint16_t kCanPort = 20'402;  ///< of the drives' end, where nothing else is said
using CanDatagram = std::array<std::byte, kCanDatagramSize>;

/// Realtime: cyclic.
[[nodiscard]] CanDatagram encode(const CanFrame& frame);
/// @return nothing: another length, a wrong checksum, an identifier or a size that no frame has. Realtime: cyclic.
[[nodiscard]] std::optional<CanFrame> decode_can(std::span<const std::byte> datagram);

/// A bus with two ends, as datagrams: one frame each. What is damaged is dropped, as a CAN controller does.
class DatagramCan final : public CanLink {
 public:
  /// @param peer   the other end; port 0: whoever sends first, until it has been silent for a second
  /// @param clock  for that second; outlives the link
  DatagramCan(std::unique_ptr<DatagramLink> link, const Endpoint& peer, const Clock& clock);

  bool send(const CanFrame& frame) override;
  std::optional<CanFrame> receive() override;
  bool wait(Nanoseconds timeout) override { return link_->wait(timeout); }
  [[nodiscard]] CanCounts counts() const override { return counts_; }
  [[nodiscard]] Endpoint local() const { return link_->local(); }

 private:
  [[nodiscard]] bool is_stranger(const Endpoint& from);

  std::unique_ptr<DatagramLink> link_;
  Endpoint peer_;
  bool fixed_;
  const Clock& clock_;
  Nanoseconds heard_ = 0;  // machine time
  CanCounts counts_;
};

}  // namespace takt::hw
