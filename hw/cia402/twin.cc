#include "hw/cia402/twin.h"

#include <algorithm>

#include "hw/can/datagram_can.h"

namespace takt::hw::cia402 {
namespace {

constexpr Endpoint kDrives{kLoopback, kCanPort};

/// Nobody else is on this network.
std::unique_ptr<CanLink> open_can(VirtualNetwork& network, const Endpoint& local, const Endpoint& peer,
                                  const Clock& clock) {
  return std::make_unique<DatagramCan>(std::move(*network.open_datagrams(local)), peer, clock);
}

}  // namespace

Twin::Twin(const device::DriverRequest& request, const TwinOptions& options,
           std::shared_ptr<device::ArmBackend> machine)
    : TwinParts(request.seed, options.faults),
      Backend(request, options.client,
              std::make_unique<CanopenBus>(*request.description, options.bus, open_can(network, {}, kDrives, clock)),
              clock),
      machine_(machine),
      emulator_(request, options.emulator, open_can(network, kDrives, {}, clock), std::move(machine)) {
  bus_time_ = 2 * options.faults.wire.slowest();
}

bool Twin::read(device::ArmSample& sample) {
  advance(++core_cycle_ * core_period_);
  return client_.read(sample);
}

void Twin::pass_cycle_without_driver() {
  driver_lives_ = false;
  pass_cycle();
  driver_lives_ = true;
}

/// All that happens up to now, in the order of time. The arm is known at the core's cycles only.
void Twin::advance(Nanoseconds now) {
  bool looked = false;
  const auto look = [&] {
    if (!looked) emulator_.look();
    looked = true;
  };
  for (;;) {
    const Nanoseconds next = std::max(std::min(next_cycle_, network.next_arrival()), clock.now());
    if (next > now) break;
    clock.set(next);
    if (next == now) look();
    emulator_.receive(next);
    if (next_cycle_ <= next) {
      if (driver_lives_) client_.begin_cycle();
      next_cycle_ += cycle_;
    }
    if (driver_lives_) client_.poll();
    // A driver that does not run leaves what came where it is: time must go on all the same.
    if (!driver_lives_ && network.next_arrival() <= next) break;
  }
  clock.set(now);
  look();
  emulator_.receive(now);
  emulator_.drive(now);
  hash_state();
}

std::vector<std::string> Twin::news() {
  std::vector<std::string> lines = client_.news();
  for (std::string& line : emulator_.news()) lines.push_back("bus: " + std::move(line));
  return lines;
}

/// Set points on their way to the agent are in the digest of the core already.
void Twin::hash_state() {
  state_.begin();
  state_.add(next_cycle_);
  state_.add(network.next_arrival());
  state_.add(network.counts().sent);
  client_.add_state(state_);
  for (std::size_t i = 0; i < emulator_.joint_count(); ++i) {
    const AxisPoint told = emulator_.node(i).drive().at(clock.now());
    state_.add(told.q);
    state_.add(told.dq);
    state_.add(static_cast<std::uint64_t>(emulator_.node(i).drive().state()));
  }
}

}  // namespace takt::hw::cia402
