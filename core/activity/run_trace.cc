#include "core/activity/run_trace.h"

#include <algorithm>
#include <cstring>

#include "core/device/channel.h"

namespace takt::activity {
namespace {

constexpr std::size_t kAlign = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

std::size_t aligned(std::size_t bytes) { return (bytes + kAlign - 1) / kAlign * kAlign; }

}  // namespace

void RunTrace::attach(const net::CompiledNet& net, const std::vector<command::TracedPort>& ports) {
  net_ = &net;
  for (const command::TracedPort& wanted : ports) {
    if (ports_.size() == kMostPorts) break;
    const auto port = std::ranges::find(net.ports(), wanted.port, &net::CompiledNet::Port::name);
    if (port == net.ports().end()) continue;
    ports_.push_back({wanted.name, port->type, port->offset, port->size, row_bytes_});
    row_bytes_ += aligned(port->size);
  }
  rows_.resize(kCycles * row_bytes_);
}

void RunTrace::note(std::int64_t cycle) {
  if (count_ > 0 && noted_[(count_ - 1) % kCycles] == cycle) return;
  const std::size_t row = count_++ % kCycles;
  noted_[row] = cycle;
  std::byte* to = rows_.data() + row * row_bytes_;
  for (const Port& port : ports_) std::memcpy(to + port.at, net_->slots().data() + port.offset, port.size);
}

std::vector<TracedCycle> RunTrace::cycles() const {
  std::vector<TracedCycle> all;
  for (std::size_t i = count_ < kCycles ? 0 : count_ - kCycles; i < count_; ++i) {
    TracedCycle& one = all.emplace_back(TracedCycle{.cycle = noted_[i % kCycles], .values = {}});
    for (const Port& port : ports_) {
      const auto value = device::value_in(port.type, rows_.data() + (i % kCycles) * row_bytes_ + port.at);
      one.values.emplace_back(port.name, value ? device::to_text(*value) : "null");
    }
  }
  return all;
}

}  // namespace takt::activity
