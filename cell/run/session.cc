#include "cell/run/session.h"

#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "cell/build/cell_builder.h"
#include "cell/build/command_tape.h"
#include "cell/build/site_devices.h"
#include "cell/file/operator.h"
#include "cell/judge/step_window.h"
#include "cell/run/cell_picture.h"
#include "cell/run/cell_run.h"
#include "cell/run/realtime_loop.h"
#include "core/net/compiled_net.h"

namespace takt::cell {
namespace {

/// Expectations about poses that no step of the program fits.
void check_estimates(const Description& description, const std::set<std::string, std::less<>>& estimates,
                     Diagnostics& diagnostics) {
  for (const ExpectationEntry& entry : description.expectations) {
    if (entry.kind != "estimate" || !entry.json.contains("estimate") || !entry.json["estimate"].is_string()) continue;
    const auto name = entry.json["estimate"].get<std::string>();
    if (estimates.contains(name)) continue;
    diagnostics.error(Code::kUnknownName, entry.pointer + "/estimate",
                      fmt::format("no step of the program fits '{}'", name),
                      nearest_choice(name, {estimates.begin(), estimates.end()}));
  }
}

/// Errors of form in the program of a cell that cannot be built.
Diagnostics program_diagnostics(const Description& description, const device::ModelLibrary& models) {
  if (!description.program.is_object()) return {};
  const auto program = program::Program::parse(description.program, "/program", names_of_cell(description, models),
                                               &description.programs);
  return program ? Diagnostics{} : program.error();
}

/// A cell, and the program as it was played through in it.
struct PreparedCell {
  BuiltCell built;
  std::vector<ScheduledFault> faults;
  program::Program program;
  program::Rehearsed rehearsed;
  ArmGroups cooperating;  ///< arms that one net of the program drives together
  Diagnostics warnings;
};

/// Wholes count by their parts.
ArmSet arms_of(const net::CompiledNet& net, const expression::Cell& cell) {
  ArmSet arms;
  for (const net::Resource* claim : net.claims()) {
    const auto* arm = dynamic_cast<const device::Arm*>(claim);
    if (arm != nullptr && cell.arms.contains(arm->name())) arms.insert(arm->name());
  }
  return arms;
}

ArmGroups cooperating_arms(const std::vector<operations::RehearsedNet>& nets, BuiltCell& built) {
  ArmGroups groups;
  for (const operations::RehearsedNet& rehearsed : nets) {
    const auto net = net::CompiledNet::compile(rehearsed.net, built.core->environment());
    if (!net) continue;  // the rehearsal has reported it
    ArmSet arms = arms_of(**net, built.cell);
    if (arms.size() > 1) groups.insert(std::move(arms));
  }
  return groups;
}

Result<PreparedCell> prepare_cell(const Description& description, const device::ModelLibrary& models,
                                  bool measure_times) {
  Diagnostics warnings;
  auto built = build_cell(description, models, measure_times, warnings);
  if (!built) {
    built.error().append(program_diagnostics(description, models));
    return std::unexpected(std::move(built.error()));
  }
  auto faults = make_faults(description.faults, *built);
  auto program = program::Program::parse(description.program, "/program", built->cell, &description.programs);
  if (!program) {
    Diagnostics diagnostics = std::move(program.error());
    if (!faults) diagnostics.append(faults.error());
    const auto expectations = make_expectations(description.expectations, *built, std::nullopt);
    if (!expectations) diagnostics.append(expectations.error());
    return std::unexpected(std::move(diagnostics));
  }
  std::vector<operations::RehearsedNet> nets;
  program::Rehearsed rehearsed =
      program->rehearse(built->cell, &built->core->environment(), built->site->may_pad() ? &nets : nullptr);
  if (!faults) rehearsed.diagnostics.append(faults.error());
  ArmGroups cooperating = cooperating_arms(nets, *built);
  return PreparedCell{std::move(*built),      faults ? std::move(*faults) : std::vector<ScheduledFault>{},
                      std::move(*program),    std::move(rehearsed),
                      std::move(cooperating), std::move(warnings)};
}

/// Which arms cooperate is known once the program has been played: if they are not equally late, the cell is built anew
/// with delays that are padded (row T3). No driver is connected for a trial.
Result<PreparedCell> prepare_padded_cell(Description& description, const device::ModelLibrary& models,
                                         bool measure_times) {
  Site& site = description.site;
  site.cooperating = ArmGroups{};
  site.connect = !site.has_drivers() || names_of_cell(description, models).arms.size() == 1;
  auto trial = prepare_cell(description, models, measure_times);
  if (!trial || trial->rehearsed.diagnostics.has_errors()) return trial;
  const bool padded = trial->built.site->differ_in_delay(trial->cooperating);
  if (site.connect && !padded) return trial;
  site.connect = true;
  site.cooperating = std::move(trial->cooperating);
  return prepare_cell(description, models, measure_times);
}

}  // namespace

Result<std::unique_ptr<Session>> Session::open(const std::filesystem::path& file, const device::ModelLibrary& library,
                                               const OpenOptions& options) {
  Diagnostics diagnostics;
  auto description = read_description(file, options.overrides, options.seed, diagnostics);
  if (description) {
    description->site = options.site;
    description->realtime = options.realtime;
    for (DeviceEntry& device : description->devices) device.may_fail = device.may_fail || options.all_may_fail;
    description->image = options.image;
  }
  if (!diagnostics.has_errors())
    return create(std::move(*description), library, options.measure_times, std::move(diagnostics));
  if (description) {
    const device::ModelLibrary models = library.beside(file);
    diagnostics.append(check_cell_names(*description, models));
    diagnostics.append(program_diagnostics(*description, models));
  }
  diagnostics.set_file(file.string());
  return std::unexpected(std::move(diagnostics));
}

Result<std::unique_ptr<Session>> Session::create(Description description, const device::ModelLibrary& library,
                                                 bool measure_times, Diagnostics read) {
  const std::string file = description.file.string();
  const device::ModelLibrary models = library.beside(description.file);
  const auto refuse = [&](Diagnostics diagnostics) {
    diagnostics.set_file(file);
    return std::unexpected(std::move(diagnostics));
  };
  auto prepared = prepare_padded_cell(description, models, measure_times);
  if (!prepared) return refuse(std::move(prepared.error()));
  auto& [built, faults, program, rehearsed, cooperating, warnings] = *prepared;
  auto expectations = make_expectations(description.expectations, built, program.names());
  Diagnostics& diagnostics = rehearsed.diagnostics;
  if (!description.image.empty()) {
    const auto* first = rehearsed.collisions.empty() ? nullptr : &rehearsed.collisions.front();
    if (const auto drawn = draw_cell(built, first, description.image); !drawn) diagnostics.append(drawn.error());
  }
  if (!expectations) diagnostics.append(expectations.error());
  diagnostics.append(check_operator(description.operator_script, *built.core, program.names()));
  check_estimates(description, rehearsed.estimates, diagnostics);
  const auto names = program.names();
  for (std::size_t i = 0; i < description.film.cuts.size(); ++i) {
    const std::string& step = description.film.cuts[i].step;
    for (const std::string_view part : unknown_parts(step, names))
      diagnostics.error(Code::kUnknownName, fmt::format("/film/cuts/{}/step", i),
                        fmt::format("there is no step '{}'", part), nearest_choice(std::string(part), names));
  }
  if (diagnostics.has_errors()) return refuse(std::move(diagnostics));
  read.append(warnings);
  read.append(diagnostics);
  read.set_file(file);

  auto session = std::unique_ptr<Session>(new Session(std::move(description), std::move(program), std::move(built)));
  session->models_ = library;
  session->expectations_ = std::move(*expectations);
  session->faults_ = std::move(faults);
  session->warnings_ = std::move(read);
  session->planned_duration_ = rehearsed.duration;
  session->meanwhile_ = std::move(rehearsed.meanwhile);
  return session;
}

Session::~Session() = default;

/// One run of the program tree: advances it between the cycles.
class Session::Run {
 public:
  Run(Session& session, const RunOptions& options)
      : session_(session),
        options_(options),
        run_(session.description_, session.built_, session.expectations_, session.faults_, options),
        realtime_(options.realtime ? realtime_loop(session.built_, options) : nullptr),
        context_{session.built_.cell,
                 *session.built_.core,
                 run_.variables(),
                 session.description_.program_latency_cycles,
                 [this](auto source, auto name, auto text) { note(source, name, text); },
                 realtime_ ? &realtime_->support() : nullptr},
        runner_(session.program_, context_),
        operator_(session.description_.operator_script, *session.built_.core, session.built_.emergency_stop,
                  {.hold = [this](bool held) { runner_.hold(held); }, .cancel = [this] { runner_.cancel(); }},
                  [this](auto name, auto text) { note("operator", name, text); }) {
    context_.meanwhile.spaces = session_.meanwhile_;
    run_.ask_touching([this] { return runner_.touching(); });
    run_.ask_where([this] { return runner_.path(); });
  }

  RunReport execute() {
    if (!options_.from.empty()) run_.report().diagnostics.append(runner_.enter(options_.from));
    if (!run_.open()) {
      run_.report().verdict = Verdict::kRefused;
      return std::move(run_.report());
    }
    if (options_.begun) options_.begun();
    loop();
    Diagnostics& diagnostics = run_.report().diagnostics;
    diagnostics.append(runner_.diagnostics());
    if (!operator_.broken_off().empty() && !diagnostics.has_errors())
      diagnostics.error(Code::kCancelled, {}, operator_.broken_off());
    // In real time nothing repeats to the bit: how many cycles a plan takes is the machine's affair.
    const bool repeat = options_.repeat && !session_.second_run_ && !options_.realtime;
    return run_.finish(cancelled_, repeat ? [this] { return second_digest(); } : std::function<std::string()>());
  }

 private:
  void loop() {
    if (realtime_) {
      run_.before_cycle();  // of the first one
      run_.in_realtime(
          realtime_->run({.after_cycle = [this] { return after_realtime_cycle(); },
                          .program = [this] { return look_between_cycles(); },
                          .outside = [this] { run_.tell_progress(session_.planned_duration_, current_); }}));
      return;
    }
    if (!run_.connect([this] { return stopped(); })) return;
    runner_.set_single_step(static_cast<bool>(options_.before_step));
    while (!stopped()) {
      if (!advance_program()) break;
      if (!run_.step(runner_.current())) break;
      run_.pace(session_.planned_duration_, runner_.current());
    }
  }

  bool after_realtime_cycle() {
    const bool going = run_.after_cycle();
    run_.before_cycle();  // of the next one
    return going;
  }

  /// In real time. @return false: it is over
  bool look_between_cycles() {
    if (stopped()) return false;
    if (!connected_) {
      const CellRun::Connection connection = run_.look_for_devices();
      if (connection == CellRun::Connection::kFailed) return false;
      connected_ = connection == CellRun::Connection::kThere;
    }
    if (connected_ && !advance_program()) return false;
    current_ = runner_.current();
    return run_.look_on(current_);
  }

  /// Between two cycles. @return false: it is over
  bool advance_program() {
    {
      const Stopwatch watch(options_.measure_times, run_.report().timing.program);
      operator_.before_cycle();
      if (options_.operate) options_.operate(operator_);
    }
    do {
      const Stopwatch watch(options_.measure_times, run_.report().timing.program);
      if (runner_.advance() != operations::Progress::kRunning) return false;
    } while (answered());
    return true;
  }

  /// In single steps: somebody decides about the step that would begin. @return false: none would
  bool answered() {
    if (runner_.asking().empty()) return false;
    const program::AskingStep& step = runner_.asking().front();
    NextStep next{step.name, step.pointer, to_seconds(session_.built_.core->time()), {}};
    auto known = runner_.variables();
    for (const auto& [place, variable] : known) {
      const auto before = known_.find(place);
      if (before != known_.end() && before->second == variable) continue;
      next.changed.push_back(fmt::format("{} = {}", variable.name, variable.value));
    }
    known_ = std::move(known);
    switch (options_.before_step(next)) {
      case StepAnswer::kNext:
        runner_.step();
        break;
      case StepAnswer::kContinue:
        runner_.set_single_step(false);
        break;
      case StepAnswer::kCancel:
        cancelled_ = true;
        runner_.cancel();
    }
    return true;
  }

  /// Interrupts, and the time limit.
  bool stopped() {
    const int interrupts = options_.interrupt ? options_.interrupt->load() : 0;
    if (interrupts >= 1 && !cancelled_) {
      cancelled_ = true;
      runner_.cancel();
    }
    return interrupts >= 2 || run_.out_of_time(runner_.current());
  }

  std::string second_digest() const {
    auto again = Session::create(session_.description_, session_.models_);
    if (!again) return again.error().to_string();
    (*again)->second_run_ = true;
    RunOptions quiet;
    quiet.measure_times = false;
    quiet.from = options_.from;
    return (*again)->run(quiet).digest;
  }

  void note(std::string_view source, std::string_view name, std::string_view text) {
    if (source == "program" && name == "begin") {
      run_.step_begun(text);
      operator_.step_begun(text);
    }
    run_.note(source, name, text);
  }

  Session& session_;
  const RunOptions& options_;
  CellRun run_;
  std::unique_ptr<RealtimeLoop> realtime_;  ///< null: lock-step
  activity::Context context_;
  program::ProgramRunner runner_;
  Operator operator_;
  bool cancelled_ = false;
  bool connected_ = false;                                      ///< in real time: all devices are there
  std::string current_;                                         ///< in real time: what runs, for who looks on
  std::map<std::string, program::ProgramRunner::Known> known_;  ///< variables when a step was asked for last
};

std::vector<operations::RehearsedNet> Session::nets() const {
  std::vector<operations::RehearsedNet> nets;
  (void)program_.rehearse(built_.cell, nullptr, &nets);
  return nets;
}

RunReport Session::run_commands(const record::Recording& recording, std::int64_t cycles, const RunOptions& options) {
  CellRun run(description_, built_, {}, faults_, options);
  run.repeat_commands();
  run.report().diagnostics.append(built_.commands->play(recording));
  if (run.report().diagnostics.has_errors() || !run.open()) {
    run.report().verdict = Verdict::kRefused;
    return std::move(run.report());
  }
  if (options.begun) options.begun();
  const auto interrupted = [&] { return options.interrupt && options.interrupt->load() > 0; };
  while (built_.core->cycle() < cycles && !interrupted()) {
    run.before_cycle();
    built_.core->step();
    if (!run.after_cycle()) break;
  }
  return run.finish(interrupted(), {});
}

RunReport Session::run(const RunOptions& options) { return Run(*this, options).execute(); }

}  // namespace takt::cell
