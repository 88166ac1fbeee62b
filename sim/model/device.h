#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/base/time.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// Writes state as 64-bit words into a buffer of fixed size, or reads it back in the same order, or only counts. One
/// function of a device serves all, so that the orders cannot differ. Realtime: cyclic.
class StateStream {
 public:
  enum class Mode { kCount, kWrite, kRead };
  /// @param words  as many as were counted; unused while counting
  StateStream(Mode mode, std::span<std::uint64_t> words) : mode_(mode), words_(words) {}

  void operator()(std::uint64_t& word) { copy(&word, 1); }
  void operator()(std::int64_t& value) { copy(&value, 1); }
  void operator()(double& value) { copy(&value, 1); }
  void operator()(bool& value) {
    std::uint64_t word = value ? 1 : 0;
    (*this)(word);
    value = word != 0;
  }
  /// Doubles that lie side by side: an Eigen matrix or a std::vector.
  template <class Values>
  void vector(Values& values) {
    copy(values.data(), static_cast<std::size_t>(values.size()));
  }
  [[nodiscard]] std::size_t position() const { return next_; }

 private:
  template <class T>
  void copy(T* values, std::size_t count) {
    static_assert(sizeof(T) == sizeof(std::uint64_t));
    if (mode_ != Mode::kCount && next_ + count <= words_.size() && count > 0) {
      if (mode_ == Mode::kWrite) {
        std::memcpy(words_.data() + next_, values, count * sizeof(T));
      } else {
        std::memcpy(values, words_.data() + next_, count * sizeof(T));
      }
    }
    next_ += count;
  }

  Mode mode_;
  std::span<std::uint64_t> words_;
  std::size_t next_ = 0;
};

/// One of the physics steps of a cycle.
struct Substep {
  int number = 0;          ///< from 0
  Nanoseconds length = 0;  ///< of this one
  double duration = 0.0;   ///< s, the same

  /// s, from the begin of the cycle to that of the step.
  [[nodiscard]] double begin() const { return number * duration; }
};

/// What the world calls of each device in it, in the order of the description.
/// Thread: the one that steps the world. Realtime: cyclic.
class SimDevice {
 public:
  virtual ~SimDevice() = default;
  /// Once, when the world is built: takes its start from the state of the plant. Realtime: setup.
  virtual void start(const mjData_& data) = 0;
  /// Before each physics step: computes from what can be measured and applies forces.
  virtual void actuate(mjData_& data, const Substep& step) = 0;
  /// At the end of a cycle, `now` being the new time; acceleration-level results are those of the last physics step.
  virtual void measure(const mjData_& data, Nanoseconds now) = 0;
  /// What it does to its machine keeps this where it is, and will until it is told something else: the machine may fall
  /// asleep (sim/contact/rest.h). Then actuate() applies nothing.
  [[nodiscard]] virtual bool stands() const { return false; }
  /// All that the device's future depends on.
  virtual void stream(StateStream& state) = 0;
  /// After a state was put back: what of it the plant keeps beside its own state. Realtime: setup.
  virtual void resume(mjData_& data) { (void)data; }
};

}  // namespace takt::sim
