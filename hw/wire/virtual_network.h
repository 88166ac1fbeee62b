#pragma once

#include <cstdint>
#include <memory>

#include "core/base/clock.h"
#include "core/emulation/wire.h"
#include "hw/wire/network.h"

namespace takt::hw {

/// What a virtual wire does to what is sent over it, both ways.
struct VirtualFaults {
  /// Of datagrams. Streams take transport and jitter only, and keep their order.
  emulation::WireFaults wire;
  double corrupt = 0.0;   ///< share of datagrams in which one bit flips
  double truncate = 0.0;  ///< share of datagrams that lose bytes at their end
  /// Longest piece in which a stream arrives, bytes; pieces are drawn from 1 to this. 0: as sent.
  std::size_t stream_piece = 0;
};

/// Datagrams, of both directions. What random loss took is not counted.
struct VirtualCounts {
  std::uint64_t sent = 0;
  std::uint64_t dropped = 0;  ///< by lose_next()
  std::uint64_t cut = 0;      ///< while the cable was pulled
  std::uint64_t corrupted = 0, truncated = 0;
};

/// A wire within the process, on a clock that somebody else sets: what was sent at t arrives at t + transport + jitter,
/// and receive() gives it from the moment when the clock shows that. All hosts exist; 0 stands for 127.0.0.1. The same
/// seed and the same calls give the same arrivals, bit for bit. One thread uses the network and all of its links.
/// Realtime: cyclic, but for opening and for streams, which allocate.
class VirtualNetwork final : public Network {
 public:
  /// @param clock  its machine time; outlives the network
  VirtualNetwork(const Clock& clock, std::uint64_t seed, const VirtualFaults& faults = {});
  ~VirtualNetwork() override;

  [[nodiscard]] Result<std::unique_ptr<DatagramLink>> open_datagrams(const Endpoint& local) override;
  [[nodiscard]] Result<std::unique_ptr<StreamListener>> listen(const Endpoint& local) override;
  [[nodiscard]] Result<std::unique_ptr<StreamLink>> connect(const Endpoint& remote) override;

  /// From now on, for what is sent.
  void set_faults(const VirtualFaults& faults);
  /// A cable that is pulled: all datagrams are lost, streams stall, until it is plugged in again.
  void set_cut(bool cut);
  /// Loses the next `count` datagrams to a port, whatever the faults say.
  void lose_next(std::uint16_t port, int count);
  /// When the next datagram or piece of a stream arrives, on the machine's time; INT64_MAX if none is on its way.
  [[nodiscard]] Nanoseconds next_arrival() const;
  [[nodiscard]] const VirtualCounts& counts() const;

 private:
  class Hub;
  class Datagrams;
  class Listener;
  std::shared_ptr<Hub> hub_;
};

}  // namespace takt::hw
