#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/rcc/control_core.h"

namespace takt::rcc {

/// Who may command the nets of a core from outside, and for how many cycles without a word. Once the holder has been
/// silent for longer, or has let go, what it started is cancelled (and comes to rest on its path), and what it has
/// loaded and not started is unloaded, so that no request and no rule that still waits can start it. That is decided in
/// the cycle and needs no other thread.
///
/// A fence is a number that grows with every grant: a command that carries an older one is recognised as that of a
/// former holder. Several may hold at one time; what each of them may command is decided by whoever grants.
class Lease {
 public:
  static constexpr std::size_t kNets = 256;    ///< of all holders and those before them that have not ended
  static constexpr std::size_t kHolders = 16;  ///< at one time
  explicit Lease(ControlCore& core) : core_(core) {}
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

  // -- Any thread, but grant() for one. Realtime: setup. -------------------------------------------------------------
  /// A new holder, in place of all that there are, whose nets come to rest.
  /// @param cycles  of silence that are allowed, 1 to 2^31 - 1; 0: any number, for a core that its client steps
  /// @return its fence, from 1 on
  std::uint32_t grant(std::int64_t cycles);
  /// The same beside the others. @return 0: there are kHolders already
  std::uint32_t grant_beside(std::int64_t cycles);
  /// Counts as a word of the holder. @return false: this is not, or no longer, the fence of a holder.
  bool renew(std::uint32_t fence);
  /// The holder lets go. @return as renew()
  bool release(std::uint32_t fence);
  /// All let go.
  void release_all();
  [[nodiscard]] bool holds(std::uint32_t fence) const { return place_of(fence) != nullptr; }
  /// The fence of the newest holder; 0: there is none.
  [[nodiscard]] std::uint32_t holder() const;
  /// The fence that a net was loaded with, its holder may be a former one; 0: nobody of this lease has loaded it.
  [[nodiscard]] std::uint32_t owner(NetId net) const;
  /// A net that this holder has loaded. @return false: it has kNets of them, none of which has ended
  bool add(NetId net, std::uint32_t fence);

  // -- After each cycle, on its thread. Realtime: cyclic, no allocation, O(kNets) while nets of former holders run. ---
  void after_cycle();

 private:
  /// The fence above, the net below; 0: free.
  using Owned = std::atomic<std::uint64_t>;
  struct Holder {
    std::atomic<std::uint32_t> fence = 0;  ///< 0: free
    std::atomic<std::int64_t> allowed = 0, renewed = 0;
  };
  [[nodiscard]] const Holder* place_of(std::uint32_t fence) const;
  [[nodiscard]] Holder* place_of(std::uint32_t fence) {
    return const_cast<Holder*>(std::as_const(*this).place_of(fence));
  }
  void let_go(Owned& owned);
  [[nodiscard]] bool over(NetId net) const;

  ControlCore& core_;
  std::array<Holder, kHolders> holders_;
  std::atomic<bool> former_ = false;  ///< nets of former holders may be there
  std::uint32_t last_fence_ = 0;
  std::array<Owned, kNets> owned_{};
};

}  // namespace takt::rcc
