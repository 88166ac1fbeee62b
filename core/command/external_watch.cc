#include "core/command/external_watch.h"

#include <array>
#include <utility>

namespace takt::command {
namespace {

/// Values that are kept for a program that looks late.
constexpr int kCapacity = 64;

}  // namespace

void ExternalWatch::detach() {
  for (External& external : externals_) core_->unwatch(external.watch);
  externals_.clear();
}

Diagnostics ExternalWatch::attach(rcc::ControlCore& core, rcc::NetId net, const std::vector<ExternalPort>& ports) {
  Diagnostics diagnostics;
  core_ = &core;
  for (const ExternalPort& port : ports) {
    auto watch = core.watch(net, port.port, {.every = 1, .capacity = kCapacity});
    if (!watch) {
      diagnostics.append(watch.error());
      continue;
    }
    externals_.push_back({.name = port.name, .handler = port.handler, .watch = std::move(*watch)});
  }
  return diagnostics;
}

void ExternalWatch::poll(const std::function<void(const ExternalEvent&)>& tell) {
  for (External& external : externals_) poll(external, tell);
}

/// What the ring holds has its cycle; where it was full, only the number is known.
void ExternalWatch::poll(External& external, const std::function<void(const ExternalEvent&)>& tell) {
  std::array<rcc::WatchedValue, kCapacity> values;
  const std::size_t taken = external.watch->take(values);
  for (std::size_t i = 0; i < taken; ++i) {
    if (values[i].value) report(external, std::get<net::Integer>(*values[i].value), values[i].cycle, tell);
  }
  const std::int64_t dropped = external.watch->dropped();
  if (std::exchange(external.dropped, dropped) == dropped) return;
  const auto newest = external.watch->newest();
  if (newest && newest->value) report(external, std::get<net::Integer>(*newest->value), std::nullopt, tell);
}

void ExternalWatch::report(External& external, std::int64_t count, std::optional<std::int64_t> cycle,
                           const std::function<void(const ExternalEvent&)>& tell) {
  while (external.seen < count) {
    ++external.seen;
    if (!cycle) ++times_lost_;
    const ExternalEvent event{.name = external.name, .count = external.seen, .cycle = cycle};
    if (tell) tell(event);
    if (external.handler) external.handler(event);
  }
}

}  // namespace takt::command
