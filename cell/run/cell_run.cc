#include "cell/run/cell_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include <fmt/format.h>

#include "cell/build/command_tape.h"
#include "cell/build/site_devices.h"
#include "cell/file/degrees.h"
#include "sim/contact/contact_law.h"

namespace takt::cell {
namespace {

/// Number of the digest's block for the simulation's state; the core's own blocks have small numbers.
constexpr std::uint64_t kWorldBlock = 1u << 20;
constexpr Nanoseconds kWireConnectTime = 20 * kSecond;  // a controller's program has to start, too
constexpr Nanoseconds kConnectTime = 5 * kSecond;       // devices of 100 ms with a lossy wire need a tenth of it

}  // namespace

CellRun::CellRun(const Description& description, BuiltCell& built, Expectations expectations,
                 const std::vector<ScheduledFault>& faults, const RunOptions& options)
    : description_(description),
      built_(built),
      expectations_(expectations),
      options_(options),
      faults_(faults, built, description.seed, [this](auto kind, auto text) { note("fault", kind, text); }),
      site_watch_(built),
      contacts_(built),
      contact_log_(built),
      fault_watch_(built),
      start_(Clock::now()) {
  built_.world->set_profiling(options_.measure_times);
  for (const auto& expectation : expectations_) expectation->begin(variables_);
}

bool CellRun::open() {
  constexpr std::size_t kMostBlocks = 4096;
  if (options_.keep_blocks || options_.record_blocks) built_.core->digest().keep_blocks(kMostBlocks);
  if (!options_.video.empty()) {
    auto film = RunFilm::open(options_, description_, built_);
    if (film) {
      film_ = std::move(*film);
    } else {
      report_.diagnostics.append(film.error());
    }
  }
  // Last: from here on the file of that name is a new one, so nothing may be refused any more.
  if (!options_.record.empty() && !report_.diagnostics.has_errors()) {
    auto recorder = RunRecorder::open(options_.record, description_, built_, options_);
    if (recorder) {
      recorder_ = std::move(*recorder);
    } else {
      report_.diagnostics.append(recorder.error());
    }
  }
  if (options_.watchdog > 0 && !options_.realtime)
    watchdog_.emplace(*built_.core, rcc::Watchdog::Options{.limit = options_.watchdog, .grace = 0});
  return !report_.diagnostics.has_errors();
}

std::string CellRun::waiting_for() const {
  std::string waits = built_.site->waiting_for(built_.cell);
  return waits.empty() && faults_.latched() ? "emergency_stop" : waits;
}

CellRun::Connection CellRun::look_for_devices() {
  const std::string waits = waiting_for();
  if (waits.empty()) return starts_where_assumed() ? Connection::kThere : Connection::kFailed;
  if (built_.core->time() < (heard_from(waits) ? kWireConnectTime : kConnectTime)) return Connection::kWaiting;
  report_.diagnostics.error(Code::kDeviceFault, {},
                            fmt::format("device '{}' does not become ready{}", waits, why_waiting(waits)));
  return Connection::kFailed;
}

bool CellRun::connect(const std::function<bool()>& stopped) {
  begin_pace();
  while (!stopped()) {
    const Connection connection = look_for_devices();
    if (connection != Connection::kWaiting) return connection == Connection::kThere;
    if (!step({})) return false;
    if (built_.site->own_clock()) keep_pace(to_seconds(built_.core->time()));
  }
  return false;
}

/// A controller on a wire has sent something: its program may still be on the way to command state.
bool CellRun::heard_from(const std::string& device) const {
  return built_.site->on_own_clock(device) && built_.site->arm_drivers().contains(device) &&
         built_.cell.arms.at(device).device->has_sample();
}

std::string CellRun::why_waiting(const std::string& device) const {
  const std::string why = built_.site->why_waiting(device, built_.cell);
  return why.empty() ? why : ": " + why;
}

/// A program was planned from where the scenario says that the arms are. A simulation puts them there; a driver does
/// not.
bool CellRun::starts_where_assumed() {
  for (const auto& [name, driver] : built_.site->arm_drivers()) {
    const expression::MountedArm& arm = built_.cell.arms.at(name);
    const device::JointVector& q = arm.device->sample().q;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      if (std::abs(q[i] - arm.start[i]) <= arm.device->description().start_tolerance) continue;
      report_.diagnostics.error(
          Code::kConditionNotMet, "/devices" + pointer_segment(name) + "/start_deg",
          fmt::format("'{}' is not where the program assumes: joint {} is at {:.2f} deg, not at {:.2f}", name,
                      arm.device->description().joint_names[static_cast<std::size_t>(i)], q[i] / kDegree,
                      arm.start[i] / kDegree),
          "Move the arm there, or say in 'start_deg' where it is");
    }
  }
  return !report_.diagnostics.has_errors();
}

bool CellRun::step(const std::string& current) {
  before_cycle();
  built_.core->step();
  return after_cycle() && look_on(current);
}

void CellRun::before_cycle() { faults_.apply(built_.core->time()); }

bool CellRun::after_cycle() {
  built_.commands->end_cycle(built_.core->cycle() - 1, built_.core->time() - built_.core->period());
  if (!built_.world->step()) {
    diverged_ = true;
    report_.diagnostics.error(Code::kInternal, {}, built_.world->divergence());
    return false;
  }
  {
    const Stopwatch watch(options_.measure_times, report_.timing.digest);
    built_.core->digest().take(kWorldBlock, built_.world->state_bytes());
  }
  fault_watch_.hear(built_.core->events());
  site_watch_.watch();
  for (const auto& expectation : expectations_) expectation->watch(built_);
  if (recorder_) {
    const Stopwatch watch(options_.measure_times, report_.timing.recording);
    recorder_->add_cycle();
  }
  return !options_.after_cycle || options_.after_cycle(built_);
}

bool CellRun::look_on(const std::string& current) {
  tell_news();
  if (!look_at_contacts(current)) return false;
  if (!film_) return true;
  const Stopwatch watch(options_.measure_times, report_.timing.rendering);
  report_.diagnostics.append(film_->add_state(current, variables_.biases));
  return !report_.diagnostics.has_errors();
}

void CellRun::take_contacts() {
  const auto contacts = built_.world->take_contacts();
  contact_log_.look(contacts, [this](auto name, const auto& text) { note("contact", name, text); });
  if (film_) film_->touched(contacts);
  if (recorder_) recorder_->add_contacts(contacts, variables_.biases);
  const auto where = [this] { return where_ ? where_() : std::string(); };
  fault_watch_.look(contact_log_, where,
                    [this](auto source, auto name, const auto& text) { note(source, name, text); });
  contacts_.look(contacts, touching_);
}

bool CellRun::look_at_contacts(const std::string& current) {
  take_contacts();
  if (!contacts_.has_crashed()) return true;
  see_crash_through(current);
  const Diagnostics faults = contacts_.faults();
  for (const Diagnostic& fault : faults.list()) note("contact", "unexpected", fault.message);
  report_.diagnostics.append(faults);
  return false;
}

/// The motion goes on: no machine knows of a blow before its own bounds stop it, and the report is to say how hard it
/// was. In real time, and with drivers, the run ends at once.
void CellRun::see_crash_through(const std::string& current) {
  if (options_.realtime || built_.site->has_drivers()) return;
  while (!contacts_.is_over()) {
    before_cycle();
    built_.core->step();
    if (!after_cycle()) return;
    take_contacts();
    if (!film_) continue;
    report_.diagnostics.append(film_->add_state(current, variables_.biases));
    if (report_.diagnostics.has_errors()) return;
  }
}

bool CellRun::out_of_time(const std::string& current) {
  const double time = to_seconds(built_.core->time());
  if (time < description_.time_limit_s) return false;
  report_.diagnostics.error(Code::kTimeout, "/time_limit_s",
                            fmt::format("the program has not ended after {:g} s, in step '{}'", time, current));
  return true;
}

void CellRun::in_realtime(const RealtimeLoop::Report& report) {
  const auto lateness = [](const rcc::LatenessTimes& times) -> RealtimeReport::Lateness {
    return {times.quantile(0.5), times.quantile(0.99), times.quantile(0.999), times.worst()};
  };
  report_.realtime = {.realtime_scheduling = report.granted.realtime_scheduling,
                      .locked_memory = report.granted.locked_memory,
                      .processor = report.granted.processor,
                      .wakeups = lateness(report.wakeups),
                      .begins = lateness(report.begins),
                      .cycles_unseen = report.cycles_unseen};
  if (!report.granted.failure.empty()) report_.diagnostics.error(Code::kInternal, {}, report.granted.failure);
  if (report.events_lost > 0)
    report_.diagnostics.error(
        Code::kInternal, {}, fmt::format("the program looked too late for {} answers of the core", report.events_lost));
}

/// Whole cycles that the wall clock is ahead are overruns; they are not caught up, so that the cycles that follow are
/// not bunched. The simulated devices wait too, so nothing has to be stopped for it.
void CellRun::keep_pace(double time) {
  const auto due = start_ + std::chrono::duration<double>(time) + lost_;
  const std::chrono::nanoseconds period(built_.core->period());
  const auto late = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - due) / period;
  if (late <= 0) {
    const Nanoseconds machine = std::chrono::duration_cast<std::chrono::nanoseconds>(due.time_since_epoch()).count();
    const Nanoseconds later = built_.site->pace(built_.site->clock().at(machine));
    lost_ += std::chrono::nanoseconds(later);
    built_.site->clock().skip(later);
    return std::this_thread::sleep_until(due + std::chrono::nanoseconds(later));
  }
  built_.core->count_overruns(late);
  lost_ += late * period;
  built_.site->clock().skip((late * period).count());
}

/// The core's time is the machine's from now on.
void CellRun::begin_pace() {
  start_ = Clock::now() - std::chrono::nanoseconds(built_.core->time());
  lost_ = {};
  built_.site->clock().align(built_.core->time(), MonotonicClock::machine_time());
}

/// What happened to screws goes to the recording, and to whoever listens.
void CellRun::tell_of_screws() {
  const sim::ThreadLaw& threads = built_.world->threads();
  for (const sim::ThreadEvent& event : threads.events().subspan(screw_events_)) {
    const std::string text = fmt::format("'{}' {} in '{}'", threads.name_of_screw(event.screw), name_of(event.kind),
                                         threads.name_of_bore(event.bore));
    note("screw", name_of(event.kind), text);
    ++screw_events_;
  }
}

/// Once: a cell with so many shapes in a heap is no longer what its figures say.
void CellRun::tell_of_contacts() {
  const sim::ContactLaw& law = built_.world->contact_law();
  if (told_of_contacts_ || law.forgotten() == 0) return;
  told_of_contacts_ = true;
  note("contact", "forgotten",
       fmt::format("more than {} pairs of shapes touch: friction of the others is not remembered, and they creep",
                   law.capacity()));
}

/// What drivers have to say goes to the recording, and to whoever listens.
void CellRun::tell_news() {
  tell_of_screws();
  tell_of_contacts();
  constexpr std::int64_t kEvery = 100;  // cycles; in real time not each of them is looked at
  const std::int64_t due = built_.core->cycle() / kEvery;
  if (!built_.site->has_drivers() || due == news_told_) return;
  news_told_ = due;
  tell_of_drivers();
}

void CellRun::tell_of_drivers() {
  for (const std::string& line : built_.site->news()) note("driver", line.substr(0, line.find(':')), line);
}

void CellRun::pace(double planned_duration, const std::string& current) {
  constexpr std::int64_t kEvery = 16;  // cycles: the wall clock is not looked at in each
  const double time = to_seconds(built_.core->time());
  const bool own_clock = built_.site->own_clock();
  if (own_clock) keep_pace(time);
  if (built_.core->cycle() % kEvery != 0) return;
  if (options_.realtime && !own_clock) keep_pace(time);
  tell_progress(planned_duration, current);
}

void CellRun::tell_progress(double planned_duration, const std::string& current) {
  constexpr double kProgressEvery = 0.1;  // s
  if (!options_.progress || Stopwatch::seconds_since(last_progress_) <= kProgressEvery) return;
  last_progress_ = Clock::now();
  options_.progress(to_seconds(built_.core->time()), planned_duration, current);
}

void CellRun::note(std::string_view source, std::string_view name, std::string_view text) {
  LogEntry entry{.time = built_.core->time(),
                 .cycle = static_cast<std::uint64_t>(built_.core->cycle()),
                 .level = level_of(source, name),
                 .source = std::string(source),
                 .name = std::string(name),
                 .step = where_ ? where_() : std::string(),
                 .text = std::string(text)};
  follow_steps(entry);
  for (const auto& expectation : expectations_) expectation->happened(entry);
  if (recorder_) recorder_->add_event(entry);
  if (film_) report_.diagnostics.append(film_->happened(entry));
  if (options_.tell) options_.tell(entry);
  log_.add(std::move(entry));
}

/// Keeps the paths of the steps that run.
void CellRun::follow_steps(const LogEntry& entry) {
  if (entry.source != "program") return;
  const auto running = std::ranges::find(steps_running_, entry.step);
  if (entry.name == "begin") {
    steps_running_.push_back(entry.step);
  } else if ((entry.name == "end" || entry.name == "failed") && running != steps_running_.end()) {
    steps_running_.erase(running);
  } else {
    return;
  }
  for (const auto& expectation : expectations_) expectation->steps_run(steps_running_);
}

void CellRun::step_begun(std::string_view name) {
  steps_begun_.emplace_back(name);
  for (const auto& expectation : expectations_) expectation->step_begins(name);
}

void CellRun::close_recording() {
  if (!recorder_) return;
  const Clock::time_point begin = Clock::now();
  const record::RecorderStatus status = recorder_->close();
  report_.wall_time += Stopwatch::seconds_since(begin);
  if (report_.realtime) report_.realtime->cycles_not_recorded = static_cast<std::int64_t>(status.dropped_cycles);
  if (!status.error.empty())
    report_.diagnostics.error(Code::kFileNotWritable, {}, "the recording stopped: " + status.error);
  if (!status.removed) report_.products.push_back(options_.record.string());
}

/// The verdict, for a second more, in the film alone. What failed goes on meanwhile: everything brakes, and who watches
/// can read why. Nothing of it is in the report, which is made.
void CellRun::film_aftermath(Verdict verdict) {
  constexpr Nanoseconds kShown = kSecond;
  const auto wrong =
      std::ranges::find_if(report_.expectations, [](const auto& result) { return result.judged && !result.passed; });
  const bool broke_off = report_.diagnostics.has_errors();
  const bool known = !options_.video_failure.empty();
  if (!film_ || film_->is_over()) return;
  film_->judged(known ? Verdict::kFailed : verdict, report_.expectations);
  if (known) {
    film_->failed(options_.video_failure);
  } else if (!broke_off && wrong != report_.expectations.end()) {
    film_->failed(fmt::format("not held: {}: {}", wrong->name, wrong->measured));
  }
  const bool goes_on = known || verdict == Verdict::kFailed || verdict == Verdict::kError;
  const bool simulated = goes_on && !options_.realtime && !built_.site->has_drivers() && !diverged_;
  if (!simulated) return report_.diagnostics.append(film_->hold(kShown));
  built_.core->stop_all(net::Cause::Code::kAborted, "the run has ended");
  for (Nanoseconds end = built_.core->time() + kShown; built_.core->time() < end && !film_->is_over();) {
    built_.core->step();
    if (!built_.world->step()) break;
    film_->touched(built_.world->take_contacts());
    if (auto failed = film_->add_state({}, variables_.biases); failed.has_errors())
      return report_.diagnostics.append(failed);
  }
}

void CellRun::close_film() {
  if (!film_) return;
  const Clock::time_point begin = Clock::now();
  const auto film = film_->close();
  if (!film) {
    report_.diagnostics.append(with_option_names(film.error()));
    return;
  }
  report_.wall_time += Stopwatch::seconds_since(begin);
  report_.frames = film->frames;
  report_.timing.rendering += film->render_cpu_s;
  report_.products.push_back(options_.video.string());
}

/// Why it ended before its end, for the log, and what the machines said of it, for the report.
void CellRun::tell_end(bool interrupted) {
  if (interrupted) note("run", "interrupted", "");
  if (!report_.diagnostics.has_errors()) return;
  for (const Diagnostic& diagnostic : std::vector(report_.diagnostics.list()))
    if (diagnostic.severity == Severity::kError) note("run", "error", diagnostic.message);
  for (const std::string& fault : fault_watch_.told()) report_.diagnostics.note({}, fault);
}

/// A machine that has stopped by itself has not done what comes after it, though the program may not have noticed.
void CellRun::look_for_stops() {
  for (const auto& [name, arm] : built_.cell.arms) {
    if (!arm.device->has_sample() || arm.device->sample().fault == 0) continue;
    report_.diagnostics.error(
        Code::kDeviceFault, "/devices" + pointer_segment(name),
        fmt::format("'{}' has a fault at the end of the run: {}", name,
                    arm.device->fault_text(arm.device->sample().fault)),
        "Remove what stops it, or handle the fault in the program and reset the arm before its end");
  }
  const device::EmergencyStop* stop = built_.emergency_stop;
  if (stop != nullptr && stop->pressed() && !report_.diagnostics.has_errors())
    report_.diagnostics.error(Code::kDeviceFault, {}, "the emergency stop is pressed at the end of the run",
                              "Release and reset it before the program ends");
}

RunReport CellRun::finish(bool interrupted, const std::function<std::string()>& run_again) {
  if (built_.site->has_drivers()) tell_of_drivers();
  if (!interrupted && !repeats_commands_ && !report_.diagnostics.has_errors()) look_for_stops();
  tell_end(interrupted);
  report_.wall_time = Stopwatch::seconds_since(start_);
  report_.cycles = built_.core->cycle();
  report_.sim_time = to_seconds(built_.core->time());
  report_.digest = rcc::to_string(built_.core->digest().value());
  report_.estimates = variables_.estimates;
  report_.site = site_watch_.report();
  measure_core();
  const device::EmergencyStop* stop = built_.emergency_stop;
  if (stop != nullptr && stop->pressed() && report_.diagnostics.has_errors()) {
    report_.diagnostics.note(
        {}, fmt::format("the emergency stop of category {} is latched", static_cast<int>(stop->category())),
        "reset, or what comes before it");
  }
  const bool whole = !interrupted && !report_.diagnostics.has_errors();
  const bool held = judge(whole, run_again);
  record_verdicts();
  report_.log = log_.entries();
  report_.log_omitted = log_.omitted();
  if (recorder_ && !held) recorder_->keep();
  close_recording();
  const auto verdict = [&] {
    if (interrupted) return Verdict::kInterrupted;
    if (report_.diagnostics.has_errors()) return Verdict::kError;
    return held ? Verdict::kPassed : Verdict::kFailed;
  };
  film_aftermath(verdict());
  close_film();
  report_.verdict = verdict();
  report_.diagnostics.set_file(description_.file.string());
  return std::move(report_);
}

void CellRun::measure_core() {
  const rcc::Statistics& statistics = built_.core->statistics();
  const double digest =
      1e-9 * static_cast<double>(statistics.phase_ns[static_cast<std::size_t>(rcc::CyclePhase::kDigest)]);
  report_.timing.digest += digest;
  report_.timing.core = 1e-9 * static_cast<double>(statistics.total_ns) - digest;
  const sim::StepTimes times = built_.world->times();
  report_.core_ns_longest = static_cast<double>(statistics.max_ns);
  report_.overruns = statistics.overruns;
  report_.timing.physics = to_seconds(times.physics);
  report_.timing.controller = to_seconds(times.devices);
  if (statistics.measured_cycles > 0) {
    report_.core_ns_per_cycle = 1e9 * report_.timing.core / static_cast<double>(statistics.measured_cycles);
  }
}

/// Judges all expectations, also those of a run that was cut off: they say how far it came, and none has held.
bool CellRun::judge(bool whole, const std::function<std::string()>& run_again) {
  const Outcome outcome{built_,
                        variables_,
                        steps_begun_,
                        report_.sim_time,
                        report_.digest,
                        whole ? run_again : std::function<std::string()>(),
                        contact_log_.summaries(),
                        contact_log_.standing()};
  for (const auto& expectation : expectations_) {
    ExpectationResult result = expectation->judge(outcome);
    if (!whole && result.passed) {
      result.passed = result.judged = false;
      result.measured += "; the run was cut off";
    }
    report_.expectations.push_back(std::move(result));
  }
  return std::ranges::all_of(report_.expectations,
                             [=](const auto& result) { return result.passed || (whole && !result.judged); });
}

std::vector<ExpectationResult> CellRun::judge_now() const {
  const Outcome outcome{built_,
                        variables_,
                        steps_begun_,
                        to_seconds(built_.core->time()),
                        rcc::to_string(built_.core->digest().value()),
                        {},
                        contact_log_.summaries(),
                        contact_log_.standing()};
  std::vector<ExpectationResult> results;
  for (const auto& expectation : expectations_) results.push_back(expectation->judge(outcome));
  return results;
}

/// For the recording and the log of the report; on the terminal the report says it.
void CellRun::record_verdicts() {
  for (const ExpectationResult& result : report_.expectations) {
    const std::string_view name = result.passed ? "held" : result.judged ? "not held" : "not judged";
    LogEntry entry{.time = built_.core->time(),
                   .cycle = static_cast<std::uint64_t>(built_.core->cycle()),
                   .level = level_of(kExpectationSource, name),
                   .source = std::string(kExpectationSource),
                   .name = std::string(name),
                   .text = fmt::format("{}: {}", result.name, result.measured)};
    if (recorder_) recorder_->add_event(entry);
    log_.add(std::move(entry));
  }
}

std::unique_ptr<RealtimeLoop> realtime_loop(BuiltCell& built, const RunOptions& options) {
  SiteDevices& site = *built.site;
  RealtimeLoop::Options wanted{.processor = options.processor};
  // Simulated devices wait for a cycle that is late, so nothing has to be stopped for it.
  if (!site.has_drivers()) wanted.overrun_limit = std::numeric_limits<int>::max();
  if (!site.master_clock().empty()) wanted.pace = [&site](Nanoseconds due) { return site.pace(due); };
  return std::make_unique<RealtimeLoop>(*built.core, site.clock(), wanted);
}

}  // namespace takt::cell
