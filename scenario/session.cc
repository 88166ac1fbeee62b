#include "scenario/session.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "scenario/faults.h"
#include "scenario/run_film.h"
#include "scenario/run_recorder.h"
#include "sim/render_shapes.h"

namespace takt::scenario {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Adds the wall time of its scope to a sum, if asked to measure.
class Stopwatch {
 public:
  Stopwatch(bool on, double& sum) : sum_(on ? &sum : nullptr) {
    if (sum_) start_ = Clock::now();
  }
  ~Stopwatch() {
    if (sum_) *sum_ += seconds_since(start_);
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double* sum_;
  Clock::time_point start_;
};

/// Number of the digest's block for the simulation's state; the core's own blocks have small numbers.
constexpr std::uint64_t kWorldBlock = 1u << 20;
constexpr Nanoseconds kConnectTime = 5 * kSecond;  // devices of 100 ms with a lossy wire need a tenth of it

/// Expectations about poses that no step of the program fits.
void check_estimates(const Description& description, const std::set<std::string, std::less<>>& estimates,
                     Findings& findings) {
  for (const ExpectationEntry& entry : description.expectations) {
    if (entry.kind != "estimate" || !entry.json.contains("estimate") || !entry.json["estimate"].is_string()) continue;
    const auto name = entry.json["estimate"].get<std::string>();
    if (estimates.contains(name)) continue;
    findings.error(entry.pointer + "/estimate", fmt::format("no step of the program fits '{}'", name),
                   nearest_choice(name, {estimates.begin(), estimates.end()}));
  }
}

/// Errors of form in the program of a cell that cannot be built.
Findings program_findings(const Description& description, const device::ModelLibrary& models) {
  if (!description.program.is_object()) return {};
  const auto program = activity::Program::parse(description.program, "/program", names_of_cell(description, models));
  return program ? Findings{} : program.error();
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPassed:
      return "passed";
    case Verdict::kFailed:
      return "failed";
    case Verdict::kRefused:
    case Verdict::kError:
      return "error";
    case Verdict::kInterrupted:
      return "interrupted";
  }
  return "error";
}

Result<std::unique_ptr<Session>> Session::open(const std::filesystem::path& file, const device::ModelLibrary& models,
                                               const OpenOptions& options) {
  Findings findings;
  auto description = read_description(file, options.overrides, options.seed, findings);
  if (description) description->site = options.site;
  if (!findings.has_errors()) return create(std::move(*description), models, options.measure_times);
  if (description) {
    findings.append(check_cell_names(*description, models));
    findings.append(program_findings(*description, models));
  }
  findings.set_file(file.string());
  return std::unexpected(std::move(findings));
}

Result<std::unique_ptr<Session>> Session::create(Description description, const device::ModelLibrary& models,
                                                 bool measure_times) {
  const std::string file = description.file.string();
  Findings warnings;
  const auto refuse = [&](Findings findings) {
    findings.set_file(file);
    return std::unexpected(std::move(findings));
  };
  auto built = build_cell(description, models, measure_times, warnings);
  if (!built) {
    built.error().append(program_findings(description, models));
    return refuse(std::move(built.error()));
  }
  auto program = activity::Program::parse(description.program, "/program", built->cell);
  if (!program) return refuse(std::move(program.error()));
  auto expectations = make_expectations(description.expectations, *built, *program);
  activity::Rehearsed rehearsed = program->rehearse(built->cell, &built->core->environment());
  Findings& findings = rehearsed.findings;
  if (!expectations) findings.append(expectations.error());
  check_estimates(description, rehearsed.estimates, findings);
  const auto names = program->names();
  for (std::size_t i = 0; i < description.film.cuts.size(); ++i) {
    const std::string& step = description.film.cuts[i].step;
    if (std::ranges::find(names, step) != names.end()) continue;
    findings.error(fmt::format("/film/cuts/{}/step", i), fmt::format("there is no step '{}'", step),
                   nearest_choice(step, names));
  }
  if (findings.has_errors()) return refuse(std::move(findings));
  if (built->triangles > sim::kTriangleBudget) {
    warnings.warning("", fmt::format("{} triangles in the scene", built->triangles),
                     fmt::format("at most {}, or the film is slower than its time", sim::kTriangleBudget));
  }
  warnings.append(findings);
  warnings.set_file(file);

  auto session = std::unique_ptr<Session>(new Session(std::move(description), std::move(*program), std::move(*built)));
  session->models_ = &models;
  session->expectations_ = std::move(*expectations);
  session->warnings_ = std::move(warnings);
  session->planned_duration_ = rehearsed.duration;
  return session;
}

Session::~Session() = default;

/// One run: the loop, what watches it, and the report that grows with it.
class Session::Run {
 public:
  Run(Session& session, const RunOptions& options)
      : session_(session),
        options_(options),
        context_{session.built_.cell, *session.built_.core, variables_, session.description_.program_latency_cycles,
                 [this](auto source, auto name, auto text) { note(source, name, text); }},
        runner_(session.program_, context_),
        faults_(session.description_.faults, session.built_),
        site_watch_(session.built_) {}

  RunReport execute() {
    start_ = Clock::now();
    session_.built_.world->set_profiling(options_.measure_times);
    if (!open_products()) {
      report_.verdict = Verdict::kRefused;
      return std::move(report_);
    }
    loop();
    close_products();
    finish();
    return std::move(report_);
  }

 private:
  bool open_products() {
    if (!options_.record.empty()) {
      auto recorder = RunRecorder::open(options_.record, session_.description_, session_.built_);
      if (recorder) {
        recorder_ = std::move(*recorder);
      } else {
        report_.findings.append(recorder.error());
      }
    }
    if (!options_.video.empty()) {
      auto film = RunFilm::open(options_, session_.description_, session_.built_);
      if (film) {
        film_ = std::move(*film);
      } else {
        report_.findings.append(film.error());
      }
    }
    return !report_.findings.has_errors();
  }

  void loop() {
    if (!connect()) return;
    while (!stopped()) {
      {
        const Stopwatch watch(options_.measure_times, report_.timing.program);
        if (runner_.advance() != activity::Progress::kRunning) break;
      }
      if (!step()) break;
      pace();
    }
  }

  /// Devices with a clock of their own take some cycles until their first samples are there.
  bool connect() {
    while (!stopped()) {
      const std::string waits = session_.built_.site->waiting_for(session_.built_.cell);
      if (waits.empty() && !faults_.latched()) return true;
      if (session_.built_.core->time() >= kConnectTime) {
        report_.findings.error({}, fmt::format("device '{}' does not become ready", waits));
        return false;
      }
      if (!step()) return false;
    }
    return false;
  }

  /// One cycle of core and world, and what looks on. @return false if the run cannot go on.
  bool step() {
    BuiltCell& built = session_.built_;
    faults_.apply([this](auto name, auto text) { note("fault", name, text); });
    built.core->step();
    if (!built.world->step()) {
      report_.findings.error({}, fmt::format("the physics diverged at {:.3f} s", to_seconds(built.world->time())));
      return false;
    }
    {
      const Stopwatch watch(options_.measure_times, report_.timing.digest);
      built.core->digest().take(kWorldBlock, built.world->state_bytes());
    }
    site_watch_.watch();
    for (auto& expectation : session_.expectations_) expectation->watch(built);
    return record_cycle();
  }

  bool record_cycle() {
    if (recorder_) {
      const Stopwatch watch(options_.measure_times, report_.timing.recording);
      recorder_->add_cycle();
    }
    if (!film_) return true;
    const Stopwatch watch(options_.measure_times, report_.timing.rendering);
    report_.findings.append(film_->add_cycle(runner_.current(), variables_.biases));
    return !report_.findings.has_errors();
  }

  /// Interrupts, and the time limit.
  bool stopped() {
    const int interrupts = options_.interrupt ? options_.interrupt->load() : 0;
    if (interrupts >= 1 && !cancelled_) {
      cancelled_ = true;
      runner_.cancel();
    }
    if (interrupts >= 2) return true;
    const double time = to_seconds(session_.built_.core->time());
    if (time < session_.description_.time_limit_s) return false;
    report_.findings.error(
        "/time_limit_s", fmt::format("the program has not ended after {:g} s, in step '{}'", time, runner_.current()));
    return true;
  }

  /// Waits for the wall clock. Whole cycles that it is ahead are overruns; they are not caught up, so that the cycles
  /// that follow are not bunched. The simulated devices wait too, so nothing has to be stopped for it.
  void keep_pace(double time) {
    const auto due = start_ + std::chrono::duration<double>(time) + lost_;
    const std::chrono::nanoseconds period(session_.built_.core->period());
    const auto late = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - due) / period;
    if (late <= 0) return std::this_thread::sleep_until(due);
    session_.built_.core->count_overruns(late);
    lost_ += late * period;
  }

  /// Once per 16 cycles: real time if asked for, and progress.
  void pace() {
    const std::int64_t cycle = session_.built_.core->cycle();
    if (cycle % 16 != 0) return;
    const double time = to_seconds(session_.built_.core->time());
    if (options_.realtime) keep_pace(time);
    if (options_.progress && seconds_since(last_progress_) > 0.1) {
      last_progress_ = Clock::now();
      options_.progress(time, session_.planned_duration_, runner_.current());
    }
  }

  void close_products() {
    if (recorder_) {
      const record::RecorderStatus status = recorder_->close();
      if (!status.error.empty()) report_.findings.error({}, "the recording stopped: " + status.error);
      report_.products.push_back(options_.record.string());
    }
    if (!film_) return;
    const auto film = film_->close();
    if (!film) {
      report_.findings.append(film.error());
      return;
    }
    report_.frames = film->frames;
    report_.timing.rendering += film->render_cpu_s;
    report_.products.push_back(options_.video.string());
  }

  void finish() {
    BuiltCell& built = session_.built_;
    report_.wall_time = seconds_since(start_);
    report_.cycles = built.core->cycle();
    report_.sim_time = to_seconds(built.core->time());
    report_.digest = rcc::to_string(built.core->digest().value());
    report_.estimates = variables_.estimates;
    report_.site = site_watch_.report();
    measure_core();
    report_.findings.append(runner_.findings());
    const bool held = judge();
    if (cancelled_) {
      report_.verdict = Verdict::kInterrupted;
    } else if (report_.findings.has_errors()) {
      report_.verdict = Verdict::kError;
    } else {
      report_.verdict = held ? Verdict::kPassed : Verdict::kFailed;
    }
    report_.findings.set_file(session_.description_.file.string());
  }

  void measure_core() {
    const rcc::Statistics& statistics = session_.built_.core->statistics();
    const double digest =
        1e-9 * static_cast<double>(statistics.phase_ns[static_cast<std::size_t>(rcc::CyclePhase::kDigest)]);
    report_.timing.digest += digest;
    report_.timing.core = 1e-9 * static_cast<double>(statistics.total_ns) - digest;
    const sim::StepTimes times = session_.built_.world->times();
    report_.core_ns_longest = static_cast<double>(statistics.max_ns);
    report_.overruns = statistics.overruns;
    report_.timing.physics = to_seconds(times.physics);
    report_.timing.controller = to_seconds(times.devices);
    if (statistics.measured_cycles > 0) {
      report_.core_ns_per_cycle = 1e9 * report_.timing.core / static_cast<double>(statistics.measured_cycles);
    }
  }

  /// Judges all expectations, also those of a run that broke off: they say how far it came.
  bool judge() {
    Outcome outcome{session_.built_, variables_, steps_begun_, report_.sim_time, report_.digest, {}};
    const bool whole = !cancelled_ && !report_.findings.has_errors();
    if (!session_.second_run_ && whole) outcome.run_again = [this] { return second_digest(); };
    bool all = true;
    for (const auto& expectation : session_.expectations_) {
      report_.expectations.push_back(expectation->judge(outcome));
      all = all && report_.expectations.back().passed;
    }
    return all;
  }

  std::string second_digest() const {
    auto again = Session::create(session_.description_, *session_.models_);
    if (!again) return again.error().to_string();
    (*again)->second_run_ = true;
    RunOptions quiet;
    quiet.measure_times = false;
    return (*again)->run(quiet).digest;
  }

  void note(std::string_view source, std::string_view name, std::string_view text) {
    if (source == "program" && name == "begin") steps_begun_.emplace_back(text);
    if (recorder_) recorder_->add_event(source, name, text);
  }

  Session& session_;
  const RunOptions& options_;
  activity::Variables variables_;
  activity::Context context_;
  activity::ProgramRunner runner_;
  Faults faults_;
  SiteWatch site_watch_;
  std::unique_ptr<RunRecorder> recorder_;
  std::unique_ptr<RunFilm> film_;
  std::vector<std::string> steps_begun_;
  RunReport report_;
  Clock::time_point start_, last_progress_;
  std::chrono::nanoseconds lost_{0};  // that the run is behind the wall clock for good
  bool cancelled_ = false;
};

std::vector<activity::RehearsedNet> Session::nets() const {
  std::vector<activity::RehearsedNet> nets;
  (void)program_.rehearse(built_.cell, nullptr, &nets);
  return nets;
}

RunReport Session::run(const RunOptions& options) { return Run(*this, options).execute(); }

}  // namespace takt::scenario
