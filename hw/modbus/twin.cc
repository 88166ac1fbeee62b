#include "hw/modbus/twin.h"

#include <algorithm>
#include <utility>

namespace takt::hw::modbus {

Twin::Twin(const device::IoRequest& request, const TwinOptions& options, device::IoTerminals machine)
    : TwinParts(request.seed, options.faults),
      Backend(options.client, request, wire, clock, [this] { pass_cycle(); }),
      core_period_(request.core_period),
      remote_(options.client.remote),
      coupler_(options.coupler, request.description, wire, std::move(machine)) {}

void Twin::serve(Nanoseconds now) {
  coupler_.serve(now);
  if (!frozen) client_.poll();
}

/// All that happens up to now, in the order of time. The terminals are known at the core's cycles only.
void Twin::advance(Nanoseconds now) {
  for (;;) {
    const Nanoseconds arrival = wire.next_arrival(), due = client_.next_due();
    // What has arrived and was not taken has been offered already.
    Nanoseconds next = now;
    if (arrival > clock.now()) next = std::min(next, arrival);
    if (due > clock.now() && !frozen) next = std::min(next, due);
    if (next >= now) break;
    clock.set(next);
    serve(next);
  }
  clock.set(now);
  coupler_.serve(now);
  coupler_.look(now);
  if (!frozen) client_.poll();
  state_.begin();
  client_.add_state(state_);
  for (const std::uint16_t value : coupler_.coils()) state_.add(std::uint64_t{value});
  for (const std::uint16_t value : coupler_.holding_registers()) state_.add(std::uint64_t{value});
  state_.add(wire.next_arrival());
}

std::vector<std::string> Twin::news() {
  std::vector<std::string> lines = Backend::news();
  for (std::string& line : coupler_.news()) lines.push_back("coupler: " + std::move(line));
  return lines;
}

}  // namespace takt::hw::modbus
