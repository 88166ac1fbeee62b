#include "serve/holders.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/device/device.h"

namespace takt::serve {
namespace {

bool overlap(const std::optional<Holders::Devices>& one, const std::optional<Holders::Devices>& other) {
  if (!one || !other) return true;
  return std::ranges::any_of(*one, [&other](const std::string& device) { return other->contains(device); });
}

std::string text_of(const std::optional<Holders::Devices>& devices) {
  return devices ? fmt::format("{}", fmt::join(*devices, ", ")) : "all devices";
}

}  // namespace

void Holders::forget_ended() const {
  std::erase_if(holdings_, [this](const Holding& one) { return !lease_.holds(one.fence); });
}

Result<std::uint32_t> Holders::take(const std::string& client, std::optional<Devices> devices, std::int64_t cycles,
                                    bool take_over, const Log& log) {
  const std::lock_guard lock(mutex_);
  forget_ended();
  Diagnostics in_the_way;
  std::vector<Holding> former;
  for (const Holding& one : holdings_)
    if (overlap(one.devices, devices)) former.push_back(one);
  for (const Holding& one : former)
    if (!take_over)
      in_the_way.error(Code::kConflict, "/take_over",
                       fmt::format("'{}' holds {}, fence {}", one.client, text_of(one.devices), one.fence),
                       "Wait, or send take_over: true");
  if (in_the_way.has_errors()) return std::unexpected(std::move(in_the_way));
  for (const Holding& one : former) (void)lease_.release(one.fence);
  const std::uint32_t fence = lease_.grant_beside(cycles);
  if (fence == 0)
    return failure(Code::kTooLarge, "/devices", fmt::format("{} clients hold devices already", rcc::Lease::kHolders),
                   "Wait until one lets go, or take over its devices");
  for (const Holding& one : former)
    log(fmt::format("'{}' has lost the lease of {}, fence {}, to '{}', fence {}", one.client, text_of(one.devices),
                    one.fence, client, fence));
  log(fmt::format("'{}' has the lease of {}, fence {}", client, text_of(devices), fence));
  forget_ended();
  holdings_.push_back({.fence = fence, .client = client, .devices = std::move(devices)});
  return fence;
}

std::vector<Holders::Holding> Holders::list() const {
  const std::lock_guard lock(mutex_);
  forget_ended();
  return holdings_;
}

std::optional<Holders::Holding> Holders::find(std::uint32_t fence) const {
  const auto all = list();
  const auto found = std::ranges::find(all, fence, &Holding::fence);
  return found == all.end() ? std::nullopt : std::optional(*found);
}

std::string Holders::whose(std::string_view device) const {
  for (const Holding& one : list())
    if (one.devices && one.devices->contains(device)) return fmt::format("'{}' holds it", one.client);
  return "nobody holds it";
}

Diagnostics Holders::check_device(std::uint32_t fence, const std::string& device) const {
  Diagnostics wrong;
  const auto own = find(fence);
  if (own && own->devices && !own->devices->contains(device))
    wrong.error(Code::kConflict, "Takt-Fence",
                fmt::format("lease {} does not have '{}': {}", fence, device, whose(device)),
                "Take the lease of all devices that are needed");
  return wrong;
}

Diagnostics Holders::check_start(std::uint32_t fence, rcc::NetId net) const {
  Diagnostics wrong = check_owner(fence, net);
  const auto own = find(fence);
  if (!own || !own->devices || !core_.knows(net)) return wrong;
  const rcc::NetHandle compiled = core_.net(net);
  if (compiled == nullptr) {
    wrong.error(Code::kNotKnownYet, "", fmt::format("it is not known yet what net {} drives", net),
                "Wait until it is Ready");
    return wrong;
  }
  for (const net::Resource* claim : compiled->claims())
    if (const auto* device = dynamic_cast<const device::Actuator*>(claim); device != nullptr)
      wrong.append(check_device(fence, device->name()));
  return wrong;
}

Diagnostics Holders::check_owner(std::uint32_t fence, rcc::NetId net) const {
  Diagnostics wrong;
  const std::uint32_t owner = lease_.owner(net);
  if (owner == 0 || owner == fence || !lease_.holds(owner)) return wrong;
  const auto other = find(owner);
  wrong.error(Code::kConflict, "Takt-Fence",
              fmt::format("net {} belongs to '{}', fence {}", net, other ? other->client : "", owner),
              "Use nets that were loaded with this fence");
  return wrong;
}

Diagnostics Holders::check(std::uint32_t fence, const rcc::Transaction& transaction) const {
  Diagnostics wrong;
  for (const rcc::NetId net : transaction.start) wrong.append(check_start(fence, net));
  for (const rcc::NetSet* set : {&transaction.abort, &transaction.cancel, &transaction.end})
    for (const rcc::NetId net : *set) wrong.append(check_owner(fence, net));
  return wrong;
}

}  // namespace takt::serve
