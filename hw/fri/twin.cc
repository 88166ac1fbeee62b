#include "hw/fri/twin.h"

#include <algorithm>

namespace takt::hw::fri {
namespace {

std::unique_ptr<DatagramLink> open(VirtualNetwork& network, const Endpoint& local) {
  // Nobody else is on this network.
  return std::move(*network.open_datagrams(local));
}

}  // namespace

Twin::Twin(const device::DriverRequest& request, const TwinOptions& options,
           std::shared_ptr<device::ArmBackend> machine)
    : TwinParts(request.seed, options.faults),
      Backend(request, options.client, open(network, {0, kRemote.port}), clock),
      request_(request),
      options_(options),
      machine_(std::move(machine)) {
  wire_time_ = options.faults.wire.slowest();
  make_emulator(options.clock_offset);
}

void Twin::make_emulator(Nanoseconds clock_offset) {
  emulator_ = std::make_unique<Emulator>(request_, options_.controller, open(network, {0, 0}), kRemote, machine_,
                                         emulation::DeviceClock(clock_offset, options_.drift));
  emulator_->set_tool(tool_);
  while (emulator_->next_cycle() < clock.now()) emulator_->skip_cycle();
}

void Twin::restart_controller() {
  emulator_.reset();
  make_emulator(options_.clock_offset / 2);
}

void Twin::inject(std::span<const std::byte> to_driver, std::span<const std::byte> to_controller) {
  client_.take(to_driver);
  emulator_->take(to_controller, clock.now());
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
    if (!looked) emulator_->look();
    looked = true;
  };
  for (;;) {
    const Nanoseconds cycle = emulator_->next_cycle(), arrival = network.next_arrival();
    const Nanoseconds next = std::max(std::min(cycle, arrival), clock.now());
    if (next > now) break;
    clock.set(next);
    if (next == now) look();
    emulator_->receive(next);
    driver_lives_ ? client_.serve() : client_.discard();
    if (emulator_->next_cycle() <= next) emulator_->begin_cycle();
  }
  clock.set(now);
  look();
  emulator_->drive(now);
  hash_state();
}

void Twin::set_tool(const device::ToolSetting& tool) {
  tool_ = tool;
  client_.set_tool(tool);
  emulator_->set_tool(tool);
  machine_->set_tool(tool);
}

std::string Twin::fault_text(std::uint32_t fault) const { return Client::fault_text(fault); }

std::vector<std::string> Twin::news() {
  std::vector<std::string> lines = client_.news();
  for (std::string& line : emulator_->news()) lines.push_back("controller: " + std::move(line));
  return lines;
}

/// Set points on their way to the agent are in the digest of the core already.
void Twin::hash_state() {
  const ClientReport& report = client_.report();
  state_.begin();
  state_.add(emulator_->next_cycle());
  state_.add(network.next_arrival());
  state_.add(network.counts().sent);
  state_.add(report.measurements);
  state_.add(report.old);
  state_.add(client_.commanded());
  state_.add(client_.agent().resampled_time());
  state_.add(emulator_->controller().at(emulator_->next_cycle()));
}

}  // namespace takt::hw::fri
