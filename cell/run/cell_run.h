#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cell/faults/faults.h"
#include "cell/file/description.h"
#include "cell/judge/contact_log.h"
#include "cell/judge/expectations.h"
#include "cell/judge/run_report.h"
#include "cell/run/contact_guard.h"
#include "cell/run/fault_watch.h"
#include "cell/run/realtime_loop.h"
#include "cell/run/run_film.h"
#include "cell/run/run_recorder.h"
#include "cell/run/stopwatch.h"
#include "core/operations/table/step.h"
#include "core/rcc/watchdog.h"

namespace takt::cell {

/// One run of a built cell, whoever drives it: a program tree (Session) or a program in C++ (app::Cell). It steps core
/// and world, lets the faults of the scenario happen, feeds what looks on (expectations, recording, film), keeps the
/// pace of the wall clock, and makes the report. Thread: the one that steps the core. Realtime: setup.
class CellRun {
 public:
  using Expectations = std::span<const std::unique_ptr<Expectation>>;

  /// All of them outlive the run.
  CellRun(const Description& description, BuiltCell& built, Expectations expectations,
          const std::vector<ScheduledFault>& faults, const RunOptions& options);

  /// Opens recording and film. @return false: it cannot be, and the report says why.
  [[nodiscard]] bool open();
  /// One cycle of core and world, and what looks on. @param current  name of what runs, for the film
  /// @return false if the run cannot go on; the report says why.
  [[nodiscard]] bool step(const std::string& current);
  /// The same in parts, for a core that somebody else steps (real time): faults that are due, after the core's cycle
  /// the world and what looks on, and whenever there is time for it what waits for others.
  void before_cycle();
  [[nodiscard]] bool after_cycle();
  [[nodiscard]] bool look_on(const std::string& current);
  /// A device that nobody hears yet; empty if all are there and nets may start.
  [[nodiscard]] std::string waiting_for() const;
  enum class Connection { kWaiting, kThere, kFailed };
  /// Whether all devices are there and stand where the program assumes. kFailed: the report says why.
  [[nodiscard]] Connection look_for_devices();
  /// Steps until all devices are there. @return false: one does not come, or `stopped` says so
  [[nodiscard]] bool connect(const std::function<bool()>& stopped);
  /// The scenario's time limit is over; the report says so.
  [[nodiscard]] bool out_of_time(const std::string& current);
  /// What became of a run whose core somebody else stepped.
  void in_realtime(const RealtimeLoop::Report& report);
  /// After each step: the wall clock, if asked for, and progress.
  void pace(double planned_duration, const std::string& current);
  /// Ten times a second of wall time.
  void tell_progress(double planned_duration, const std::string& current);
  /// Something that happened, for the log: recording, report, whoever listens.
  void note(std::string_view source, std::string_view name, std::string_view text);
  /// A named step of the program has begun.
  void step_begun(std::string_view name);

  /// What the expectations say now, of a run that goes on.
  [[nodiscard]] std::vector<ExpectationResult> judge_now() const;

  /// Closes recording and film, and judges. @param interrupted  somebody asked for an end from outside
  /// @param run_again  digest of a second run of the same program; may be empty
  [[nodiscard]] RunReport finish(bool interrupted, const std::function<std::string()>& run_again);

  /// The commands of a recording are carried out again: a fault at the end is one of the recorded run, and no program
  /// could have handled it.
  void repeat_commands() { repeats_commands_ = true; }

  /// Who knows what the steps in force mean to touch; without it nothing is meant.
  void ask_touching(ContactGuard::TouchingNow touching) { touching_ = std::move(touching); }
  /// Who knows in which step something happens: the path of the steps.
  void ask_where(std::function<std::string()> where) { where_ = std::move(where); }

  /// What the program knows: biases are shown in the film, estimates are judged.
  [[nodiscard]] activity::Variables& variables() { return variables_; }
  [[nodiscard]] RunReport& report() { return report_; }

 private:
  using Clock = Stopwatch::Clock;

  void begin_pace();
  void keep_pace(double time);
  void tell_news();
  void tell_of_drivers();
  void tell_of_screws();
  void tell_of_contacts();
  void take_contacts();
  [[nodiscard]] bool look_at_contacts(const std::string& current);
  void see_crash_through(const std::string& current);
  void follow_steps(const LogEntry& entry);
  void tell_end(bool interrupted);
  [[nodiscard]] bool heard_from(const std::string& device) const;
  [[nodiscard]] std::string why_waiting(const std::string& device) const;
  [[nodiscard]] bool starts_where_assumed();
  void close_recording();
  void film_aftermath(Verdict verdict);
  void close_film();
  void measure_core();
  void look_for_stops();
  [[nodiscard]] bool judge(bool whole, const std::function<std::string()>& run_again);
  void record_verdicts();

  const Description& description_;
  BuiltCell& built_;
  Expectations expectations_;
  const RunOptions& options_;
  activity::Variables variables_;
  Faults faults_;
  SiteWatch site_watch_;
  ContactGuard contacts_;
  ContactGuard::TouchingNow touching_;
  ContactLog contact_log_;
  FaultWatch fault_watch_;
  std::function<std::string()> where_;
  RunLog log_;
  std::unique_ptr<RunRecorder> recorder_;
  std::unique_ptr<RunFilm> film_;
  std::vector<std::string> steps_begun_;
  std::vector<std::string> steps_running_;  ///< their paths
  std::size_t screw_events_ = 0;            ///< that have been told
  std::int64_t news_told_ = 0;              ///< so often what drivers say was passed on
  bool told_of_contacts_ = false;           ///< that there are too many
  bool diverged_ = false;                   ///< the physics has no state to go on from
  bool repeats_commands_ = false;           ///< of a recording
  std::optional<rcc::Watchdog> watchdog_;   ///< of lock-step
  RunReport report_;
  Clock::time_point start_, last_progress_;
  std::chrono::nanoseconds lost_{0};  ///< that the run is behind the wall clock for good
};

/// The loop of a cell whose cycle runs beside its program, as the options of the run and the site want it.
[[nodiscard]] std::unique_ptr<RealtimeLoop> realtime_loop(BuiltCell& built, const RunOptions& options);

}  // namespace takt::cell
