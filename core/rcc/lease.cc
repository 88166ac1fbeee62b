#include "core/rcc/lease.h"

#include <algorithm>

namespace takt::rcc {
namespace {

constexpr unsigned kFenceBits = 32;

}  // namespace

const Lease::Holder* Lease::place_of(std::uint32_t fence) const {
  if (fence == 0) return nullptr;
  for (const Holder& holder : holders_)
    if (holder.fence.load() == fence) return &holder;
  return nullptr;
}

std::uint32_t Lease::holder() const {
  std::uint32_t newest = 0;
  for (const Holder& holder : holders_) newest = std::max(newest, holder.fence.load());
  return newest;
}

std::uint32_t Lease::grant(std::int64_t cycles) {
  release_all();
  return grant_beside(cycles);
}

std::uint32_t Lease::grant_beside(std::int64_t cycles) {
  for (Holder& holder : holders_) {
    if (holder.fence.load() != 0) continue;
    holder.renewed.store(core_.cycle());
    holder.allowed.store(cycles);
    holder.fence.store(++last_fence_);
    former_.store(true);
    return last_fence_;
  }
  return 0;
}

bool Lease::renew(std::uint32_t fence) {
  Holder* holder = place_of(fence);
  if (holder == nullptr) return false;
  holder->renewed.store(core_.cycle());
  return holder->fence.load() == fence;  // it may have lapsed in this very moment
}

bool Lease::release(std::uint32_t fence) {
  Holder* holder = place_of(fence);
  if (holder == nullptr || !holder->fence.compare_exchange_strong(fence, 0)) return false;
  former_.store(true);
  return true;
}

void Lease::release_all() {
  for (Holder& holder : holders_) holder.fence.store(0);
  former_.store(true);
}

std::uint32_t Lease::owner(NetId net) const {
  for (const Owned& owned : owned_)
    if (const std::uint64_t one = owned.load(); static_cast<NetId>(one) == net)
      return static_cast<std::uint32_t>(one >> kFenceBits);
  return 0;
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
    if (!holds(fence)) former_.store(true);
    return true;
  }
  return false;
}

void Lease::let_go(Owned& owned) {
  std::uint64_t old = owned.load();
  if (old == 0 || holds(static_cast<std::uint32_t>(old >> kFenceBits))) return;
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
  for (Holder& holder : holders_) {
    std::uint32_t fence = holder.fence.load();
    const std::int64_t allowed = holder.allowed.load();
    const bool silent = fence != 0 && allowed > 0 && core_.cycle() - holder.renewed.load() > allowed;
    if (silent && holder.fence.compare_exchange_strong(fence, 0)) former_.store(true);
  }
  if (!former_.exchange(false)) return;
  for (Owned& owned : owned_) let_go(owned);
}

}  // namespace takt::rcc
