#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/time.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// Writes state as 64-bit words into a buffer, and reads it back in the same order. One function of a device serves
/// both ways, so that the orders cannot differ.
class StateStream {
 public:
  enum class Mode { kWrite, kRead };
  StateStream(Mode mode, std::vector<std::uint64_t>& words) : mode_(mode), words_(words) {}

  void operator()(std::uint64_t& word) {
    if (mode_ == Mode::kRead) {
      word = next_ < words_.size() ? words_[next_] : 0;
    } else if (next_ < words_.size()) {
      words_[next_] = word;
    } else {
      words_.push_back(word);
    }
    ++next_;
  }
  void operator()(std::int64_t& value) { convert(value); }
  void operator()(double& value) { convert(value); }
  void operator()(bool& value) {
    std::uint64_t word = value ? 1 : 0;
    (*this)(word);
    value = word != 0;
  }
  template <class Derived>
  void vector(Derived& values) {
    for (int i = 0; i < static_cast<int>(values.size()); ++i) (*this)(values[i]);
  }
  [[nodiscard]] std::size_t position() const { return next_; }

 private:
  template <class T>
  void convert(T& value) {
    auto word = std::bit_cast<std::uint64_t>(value);
    (*this)(word);
    value = std::bit_cast<T>(word);
  }

  Mode mode_;
  std::vector<std::uint64_t>& words_;
  std::size_t next_ = 0;
};

/// What the world calls of each device in it, in the order of the description.
/// Thread: the one that steps the world. Realtime: cyclic.
class SimDevice {
 public:
  virtual ~SimDevice() = default;
  /// Once, when the world is built: takes its start from the state of the plant. Realtime: setup.
  virtual void start(const mjData_& data) = 0;
  /// Before physics step number `substep` of a cycle: computes from what can be measured and applies forces.
  virtual void actuate(mjData_& data, int substep) = 0;
  /// At the end of a cycle, `now` being the new time; acceleration-level results are those of the last physics step.
  virtual void measure(const mjData_& data, Nanoseconds now) = 0;
  /// All that the device's future depends on.
  virtual void stream(StateStream& state) = 0;
};

}  // namespace takt::sim
