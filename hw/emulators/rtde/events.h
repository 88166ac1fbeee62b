#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "core/base/time.h"

namespace takt::hw::rtde {

/// What a controller tells the clients of its primary interface beside its state.
struct ControllerEvent {
  enum class Kind : std::uint8_t {
    kText,              ///< text
    kKey,               ///< title, text: a program began or ended
    kError,             ///< code, argument, level, text
    kRuntimeException,  ///< line, column, text
    kSafetyMode         ///< argument: the new mode
  };
  Kind kind = Kind::kText;
  std::int32_t code = 0, argument = 0;
  std::int32_t level = 1;  ///< 1 information, 2 warning, 3 violation, 4 fault
  std::uint32_t line = 0, column = 0;
  std::string title, text;
  Nanoseconds time = 0;  ///< of the controller
};

/// The events of late, by numbers that only grow: each client asks for what came after the last one it has.
class EventLog {
 public:
  static constexpr std::size_t kKept = 256;

  void add(ControllerEvent event) {
    events_.push_back(std::move(event));
    if (events_.size() > kKept) events_.pop_front();
    ++end_;
  }
  /// Number of the next event.
  [[nodiscard]] std::uint64_t end() const { return end_; }
  /// The first number that is still known.
  [[nodiscard]] std::uint64_t begin() const { return end_ - events_.size(); }
  /// @param number  begin() <= number < end()
  [[nodiscard]] const ControllerEvent& operator[](std::uint64_t number) const { return events_[number - begin()]; }

 private:
  std::deque<ControllerEvent> events_;
  std::uint64_t end_ = 0;
};

}  // namespace takt::hw::rtde
