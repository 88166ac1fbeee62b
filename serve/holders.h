#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/rcc/lease.h"
#include "core/rcc/rules.h"

namespace takt::serve {

/// Who commands which devices of a cell. Each holder has a lease with a fence of its own; the devices of two of them
/// never overlap. Any thread.
class Holders {
 public:
  using Devices = std::set<std::string, std::less<>>;
  struct Holding {
    std::uint32_t fence = 0;
    std::string client;
    std::optional<Devices> devices;  ///< nothing: all of the cell
  };
  using Log = std::function<void(const std::string& line)>;

  explicit Holders(rcc::ControlCore& core) : core_(core), lease_(core) {}

  /// Makes somebody the holder of devices. Whoever holds one of them loses all that is his, if that was asked for.
  /// @param cycles  of silence, 0: any number. @return the fence; or who is in the way
  [[nodiscard]] Result<std::uint32_t> take(const std::string& client, std::optional<Devices> devices,
                                           std::int64_t cycles, bool take_over, const Log& log);
  /// Those that have not lapsed, in the order of their fences.
  [[nodiscard]] std::vector<Holding> list() const;
  [[nodiscard]] std::optional<Holding> find(std::uint32_t fence) const;

  /// Why the holder may not start this net: it drives a device of somebody else, or it is not known yet what it drives.
  [[nodiscard]] Diagnostics check_start(std::uint32_t fence, rcc::NetId net) const;
  /// Why the holder may not touch this net in any other way: another holder has loaded it.
  [[nodiscard]] Diagnostics check_owner(std::uint32_t fence, rcc::NetId net) const;
  /// Both of a transaction.
  [[nodiscard]] Diagnostics check(std::uint32_t fence, const rcc::Transaction& transaction) const;
  /// Why the holder may not command this device itself.
  [[nodiscard]] Diagnostics check_device(std::uint32_t fence, const std::string& device) const;

  [[nodiscard]] rcc::Lease& lease() { return lease_; }

 private:
  void forget_ended() const;
  [[nodiscard]] std::string whose(std::string_view device) const;

  rcc::ControlCore& core_;
  rcc::Lease lease_;
  mutable std::mutex mutex_;
  mutable std::vector<Holding> holdings_;
};

}  // namespace takt::serve
