#include "hw/wsg/twin.h"

#include <utility>

#include "hw/wire/virtual_stream.h"

namespace takt::hw::wsg {

Twin::Twin(const device::GripperRequest& request, const TwinOptions& options,
           std::shared_ptr<device::GripperBackend> machine)
    : TwinParts(request.seed, options.faults),
      Backend(options.client, request, wire, clock),
      core_period_(request.core_period),
      remote_(options.client.remote),
      emulator_(options.emulator, request.description, wire, std::move(machine)) {}

bool Twin::read(device::GripperSample& sample) {
  pass_cycle();
  return client_.read(sample);
}

void Twin::serve() {
  emulator_.serve();
  if (!frozen) client_.poll();
}

/// All that happens up to now, in the order of time. The machine is known at the core's cycles only.
void Twin::advance(Nanoseconds now) {
  for (;;) {
    const Nanoseconds next = wire.next_arrival();
    // What has arrived and was not taken has been offered already.
    if (next <= clock.now() || next >= now) break;
    clock.set(next);
    serve();
  }
  clock.set(now);
  emulator_.look();
  emulator_.serve();
  emulator_.update(now);
  if (!frozen) client_.poll();
  state_.begin();
  client_.add_state(state_);
  state_.add(std::uint64_t{emulator_.flags()} | static_cast<std::uint64_t>(emulator_.grasp_state()) << 32);
  state_.add(emulator_.set_point().sequence);
  state_.add(wire.next_arrival());
}

std::vector<std::string> Twin::news() {
  std::vector<std::string> lines = Backend::news();
  for (std::string& line : emulator_.news()) lines.push_back("gripper: " + std::move(line));
  return lines;
}

}  // namespace takt::hw::wsg
