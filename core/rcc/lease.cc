#include "core/rcc/lease.h"

namespace takt::rcc {
namespace {

constexpr unsigned kFenceBits = 32;

}  // namespace

std::uint32_t Lease::grant(std::int64_t cycles) {
  holder_.store(0);
  renewed_.store(core_.cycle());
  allowed_.store(cycles);
  holder_.store(++last_fence_);
  former_.store(true);
  return last_fence_;
}

bool Lease::renew(std::uint32_t fence) {
  if (fence == 0 || holder_.load() != fence) return false;
  renewed_.store(core_.cycle());
  return holder_.load() == fence;  // it may have lapsed in this very moment
}

bool Lease::release(std::uint32_t fence) {
  if (fence == 0 || !holder_.compare_exchange_strong(fence, 0)) return false;
  former_.store(true);
  return true;
}

bool Lease::over(NetId net) const {
  if (!core_.knows(net)) return true;
  const NetState state = core_.state(net);
  return state == NetState::kTerminated || state == NetState::kRejected;
}

bool Lease::add(NetId net, std::uint32_t fence) {
  const std::uint64_t wanted = std::uint64_t{fence} << kFenceBits | net;
  for (Owned& owned : owned_) {
    std::uint64_t old = owned.load();
    if (old != 0 && !over(static_cast<NetId>(old))) continue;
    if (!owned.compare_exchange_strong(old, wanted)) continue;
    if (holder_.load() != fence) former_.store(true);
    return true;
  }
  return false;
}

void Lease::let_go(Owned& owned) {
  std::uint64_t old = owned.load();
  if (old == 0 || static_cast<std::uint32_t>(old >> kFenceBits) == holder_.load()) return;
  const auto net = static_cast<NetId>(old);
  if (over(net)) {
    owned.compare_exchange_strong(old, 0);
    return;
  }
  // Again in the next cycle until it is over: a request that was under way may start it meanwhile.
  former_.store(true);
  const NetState state = core_.state(net);
  if (state == NetState::kRunning) {
    (void)core_.cancel(net);
  } else if (state == NetState::kReady) {
    (void)core_.unload(net);
  }
}

void Lease::after_cycle() {
  std::uint32_t holder = holder_.load();
  const std::int64_t allowed = allowed_.load();
  if (holder != 0 && allowed > 0 && core_.cycle() - renewed_.load() > allowed &&
      holder_.compare_exchange_strong(holder, 0))
    former_.store(true);
  if (!former_.exchange(false)) return;
  for (Owned& owned : owned_) let_go(owned);
}

}  // namespace takt::rcc
