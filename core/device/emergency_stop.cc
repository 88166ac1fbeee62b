#include "core/device/emergency_stop.h"

#include <algorithm>

namespace takt::device {

namespace {

constexpr std::uint64_t kHealthy = 1, kReset = 2, kOneWrite = 1u << 8;
constexpr int kCategoryAt = 2, kOpenedAt = 4;
constexpr std::uint64_t kTwoBits = 3;
constexpr std::uint64_t kOpened = kTwoBits << kOpenedAt;

std::uint64_t bits_of(std::uint64_t word, int at) { return word >> at & kTwoBits; }

std::uint64_t with_bits(std::uint64_t word, int at, std::uint64_t bits) {
  return (word & ~(kTwoBits << at)) | bits << at;
}

StopCategory category_of(std::uint64_t word) { return static_cast<StopCategory>(bits_of(word, kCategoryAt)); }

/// Of an opening that is noted in the word.
StopCategory opened_with(std::uint64_t word) { return static_cast<StopCategory>(3 - bits_of(word, kOpenedAt)); }

/// While the chain is open: notes that it is, with the category that counts now, unless a stronger one is noted.
std::uint64_t note_opening(std::uint64_t word) {
  if ((word & kHealthy) != 0) return word;
  const std::uint64_t strength = 3 - bits_of(word, kCategoryAt);
  return with_bits(word, kOpenedAt, std::max(strength, bits_of(word, kOpenedAt)));
}

std::uint64_t with_category(std::uint64_t word, StopCategory category) {
  return with_bits(word, kCategoryAt, static_cast<std::uint64_t>(category));
}

}  // namespace

EmergencyStop::EmergencyStop(std::string name, Nanoseconds input_age_max)
    : Device(std::move(name)), input_(with_category(0, StopCategory::kStopThenBrakes)), input_age_max_(input_age_max) {}

template <class Change>
void EmergencyStop::write(Change change) {
  std::uint64_t word = input_.load(std::memory_order_relaxed);
  while (!input_.compare_exchange_weak(word, note_opening(change(word)) + kOneWrite, std::memory_order_acq_rel,
                                       std::memory_order_relaxed)) {
  }
}

void EmergencyStop::set_healthy(bool healthy) {
  write([healthy](std::uint64_t word) { return healthy ? word | kHealthy : word & ~kHealthy; });
}

void EmergencyStop::set_category(StopCategory category) {
  write([category](std::uint64_t word) { return with_category(word, category); });
}

void EmergencyStop::press(StopCategory category) {
  write([category](std::uint64_t word) { return with_category(word & ~kHealthy, category); });
}

void EmergencyStop::set_reset(bool pressed) {
  write([pressed](std::uint64_t word) { return pressed ? word | kReset : word & ~kReset; });
}

void EmergencyStop::beat() {
  write([](std::uint64_t word) { return word; });
}

void EmergencyStop::begin_cycle(std::int64_t /*cycle*/, Nanoseconds time) {
  // Reads all and forgets the opening, in one step: what is written after this is seen by the next cycle.
  const std::uint64_t word = input_.fetch_and(~kOpened, std::memory_order_acq_rel);
  const std::uint64_t writes = word / kOneWrite;
  if (writes != writes_before_) written_ = time;
  writes_before_ = writes;
  silent_ = input_age_max_ > 0 && time - written_ >= input_age_max_;

  const bool healthy = (word & kHealthy) != 0 && !silent_, reset = (word & kReset) != 0;
  const bool opened = (word & kOpened) != 0;
  const bool was_latched = latched_;
  if (reset && !reset_before_ && healthy_before_ && healthy && !opened) latched_ = false;
  if (!healthy || opened) latched_ = true;
  const StopCategory now = opened ? opened_with(word) : category_of(word);
  if (!latched_ || !was_latched || !was_open_) {
    category_ = now;
  } else if (!healthy || opened) {
    category_ = std::min(category_, now);
  }
  was_open_ = was_open_ || !latched_;
  reset_before_ = reset;
  healthy_before_ = healthy;
}

void EmergencyStop::add_state(StateWords& words) const {
  words.add(std::uint64_t{latched_} | std::uint64_t{silent_} << 1 | std::uint64_t{was_open_} << 2 |
            std::uint64_t{reset_before_} << 3 | std::uint64_t{healthy_before_} << 4 |
            static_cast<std::uint64_t>(category_) << 8);
}

}  // namespace takt::device
