#include "core/rcc/watch.h"

#include <cstring>
#include <utility>

namespace takt::rcc {

Watch::Watch(std::string name, net::ValueType type, const void* source, const WatchOptions& options)
    : name_(std::move(name)), type_(type), source_(static_cast<const std::byte*>(source)), every_(options.every) {
  size_ = net::visit_type(type, []<class T>(std::type_identity<T>) -> std::size_t {
    static_assert(sizeof(net::Slot<T>) <= kBytes);
    return sizeof(net::Slot<T>);
  });
  if (options.capacity > 0)
    ring_ = std::make_unique<boost::lockfree::spsc_queue<Sample>>(static_cast<std::size_t>(options.capacity));
}

void Watch::sample(std::int64_t cycle) {
  const int every = every_.load(std::memory_order_relaxed);
  if (every == 0 || cycle % every != 0) return;
  Sample& mine = places_[writers_];
  mine.cycle = cycle;
  std::memcpy(mine.bytes.data(), source_, size_);
  if (ring_ != nullptr && !ring_->push(mine)) dropped_.fetch_add(1, std::memory_order_relaxed);
  writers_ = between_.exchange(writers_ | kFresh, std::memory_order_acq_rel) & 3u;
}

WatchedValue Watch::value_of(const Sample& sample) const {
  return {.cycle = sample.cycle, .value = device::value_in(type_, sample.bytes.data())};
}

std::optional<WatchedValue> Watch::newest() {
  if ((between_.load(std::memory_order_relaxed) & kFresh) != 0)
    readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & 3u;
  if (places_[readers_].cycle < 0) return std::nullopt;
  return value_of(places_[readers_]);
}

std::size_t Watch::take(std::span<WatchedValue> values) {
  std::size_t count = 0;
  Sample sample;
  while (ring_ != nullptr && count < values.size() && ring_->pop(sample)) values[count++] = value_of(sample);
  return count;
}

}  // namespace takt::rcc
