#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cell/judge/contact_log.h"

namespace takt::cell {

/// Tells in words when an arm or a base reports a fault, or its guard refuses a set point: which, of which joint, after
/// which contact; and when the emergency stop latches. Thread: the program's. Realtime: setup.
class FaultWatch {
 public:
  using Where = std::function<std::string()>;
  using Note = std::function<void(std::string_view source, std::string_view name, const std::string& text)>;

  /// The cell must outlive it.
  explicit FaultWatch(const BuiltCell& built) : built_(built) {}

  /// After each cycle: what the core tells of it. Thread: the cycle's. Realtime: cyclic.
  void hear(std::span<const rcc::Event> events);
  /// After a cycle, or several. @param where  path of the steps that run; asked only when something is wrong
  void look(const ContactLog& contacts, const Where& where, const Note& note);
  /// What was told of arms so far, a sentence each: "arm: following error: joint a4 ...; 'probe/ball' pressed 'block'
  /// with 900.0 N at 3.210 s in 'reach in'".
  [[nodiscard]] const std::vector<std::string>& told() const { return told_; }

 private:
  struct Seen {
    std::uint32_t fault = 0;
    bool was_ready = false;  ///< in this run
  };
  void look_at(const std::string& name, const device::Arm& arm, const ContactLog& contacts, const Where& where,
               const Note& note);
  void tell_trips(const ContactLog& contacts, const Where& where, const Note& note);
  void tell(const std::string& name, std::string_view what, std::string text, const ContactLog& contacts,
            const Where& where, const Note& note);

  const BuiltCell& built_;
  std::map<std::string, Seen, std::less<>> arms_;  ///< by name, as seen last
  net::Text trip_;                                 ///< of a guard, the newest
  std::atomic<std::uint32_t> trips_{0};            ///< how many there were
  std::uint32_t trips_told_ = 0;
  bool latched_ = false;
  std::vector<std::string> told_;
};

}  // namespace takt::cell
