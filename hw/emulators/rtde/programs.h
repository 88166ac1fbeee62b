#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "hw/emulators/rtde/events.h"
#include "hw/emulators/rtde/language.h"
#include "hw/rtde/modes.h"
#include "languages/urscript/machine.h"

namespace takt::hw::rtde {

/// The programs of an emulated controller: the one that runs, those that run beside it, and the one that is loaded. One
/// thread; what runs may ask for stop() and pause(), which take effect at the end of its frame.
class Programs {
 public:
  /// Threads of programs that run beside the main one have at least this number.
  static constexpr int kFirstSecondary = 1'000'000;

  /// What a watchdog does when its field was not written often enough.
  enum class WatchdogAction : std::uint8_t { kIgnore, kPause, kStop };

  /// @param library  of built-in functions, and @param events  outlive it
  /// @param released  called with each thread of a program that has ended, and with 0 when a program has
  Programs(const urscript::Library& library, EventLog& events, std::function<void(int thread)> released);

  [[nodiscard]] RuntimeState state() const { return state_; }
  [[nodiscard]] bool running() const { return main_ != nullptr; }
  /// Of the thread of the program that runs.
  [[nodiscard]] bool alive(int thread) const { return main_ != nullptr && main_->alive(thread); }
  /// The line that the program is at; 0 without one.
  [[nodiscard]] int line() const { return main_ != nullptr ? main_->line() : 0; }

  // -- Scripts -------------------------------------------------------------------------------------------------------
  /// A program in place of the one that runs, or, if it says `sec`, beside it. What does not compile is reported, and
  /// changes nothing. @return false then
  bool start(std::string_view text);

  // -- The program that is loaded
  // --------------------------------------------------------------------------------------
  /// Programs that load() finds, by path, and their scripts.
  std::map<std::string, std::string> installed;
  enum class Loading : std::uint8_t { kLoaded, kNotFound, kInvalid };
  /// In place of the one that was loaded, and that runs. What does not compile is reported, and changes nothing.
  Loading load(const std::string& path);
  [[nodiscard]] const std::string& loaded() const { return loaded_; }
  /// Starts it, or goes on with a paused program. @return false if it cannot.
  bool play();
  void pause();
  bool resume();
  void stop();

  // -- Watchdogs
  // -------------------------------------------------------------------------------------------------------
  /// @param field  number of an input field
  void set_watchdog(std::uint16_t field, Nanoseconds longest, WatchdogAction action);
  /// A client has written the field.
  void fed(std::uint16_t field);

  /// One frame of all that runs. @param may_run  false: safety or power forbids it; a program is paused then
  void run_frame(Nanoseconds now, bool may_run);

 private:
  struct Watchdog {
    std::uint16_t field = 0;
    Nanoseconds longest = 0, fed = 0;
    WatchdogAction action = WatchdogAction::kPause;
    bool barked = false;
  };

  void check_watchdogs();
  void run_main();
  void run_secondaries();
  void end_main();
  void report_end(const urscript::Machine& machine);
  [[nodiscard]] std::shared_ptr<const urscript::Program> compile(std::string_view text);
  void add_event(ControllerEvent event);
  void add_key(std::string_view title, const urscript::Machine& machine);

  const urscript::Library& library_;
  EventLog& events_;
  std::function<void(int)> released_;
  std::unique_ptr<urscript::Machine> main_;
  std::vector<std::unique_ptr<urscript::Machine>> secondaries_;
  std::vector<Watchdog> watchdogs_;
  RuntimeState state_ = RuntimeState::kStopped;
  std::string loaded_;
  Nanoseconds now_ = 0;
  bool in_frame_ = false, stop_asked_ = false;
};

}  // namespace takt::hw::rtde
