#include "app/cell.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include <fmt/format.h>

#include "app/cell_setup.h"
#include "app/remote/follower.h"
#include "cell/build/cell_builder.h"
#include "cell/file/data_folder.h"
#include "cell/file/operator.h"
#include "cell/run/cell_run.h"
#include "core/activity/command_activity.h"
#include "core/command/actions/online_action.h"
#include "core/command/actions/tare.h"
#include "core/device/channel.h"
#include "core/expression/believed_shapes.h"
#include "record/recorder.h"

namespace takt::app {
namespace {

using activity::ActivityError;

[[noreturn]] void refuse(Code code, std::string message, std::string hint) {
  Diagnostics why;
  why.error(code, "", std::move(message), std::move(hint));
  throw ActivityError(std::move(why));
}

/// The name, or that of the only one there is.
template <class Map>
std::string device_of(const Map& devices, const std::string& name, const char* kind) {
  std::vector<std::string> names;
  for (const auto& [one, device] : devices) names.push_back(one);
  if (name.empty() && names.size() == 1) return names.front();
  if (devices.contains(name)) return name;
  if (name.empty() && !names.empty())
    refuse(Code::kMissing, fmt::format("which {} of {}?", kind, names.size()), nearest_choice(name, names));
  refuse(Code::kUnknownName, fmt::format("the cell has no {} '{}'", kind, name), nearest_choice(name, names));
}

/// As it is named, beside the program, among the installed scenarios.
std::filesystem::path find_file(const std::filesystem::path& file) {
  std::error_code error;
  const auto beside = std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / file;
  const auto installed = cell::data_folder() / "scenarios" / file;
  for (const auto& place : {file, beside, installed})
    if (std::filesystem::exists(place, error)) return place;
  Diagnostics why;
  why.error(Code::kNotFound, "", "there is no such file",
            fmt::format("Check the path: there is no '{}' and no '{}' either", beside.string(), installed.string()));
  why.set_file(file.string());
  throw OpenError(std::move(why));
}

/// Models that are not there at all are told as that, not one by one only.
void explain_missing_data(Diagnostics& diagnostics) {
  const auto models = cell::data_folder() / "models";
  std::error_code error;
  if (std::filesystem::is_directory(models, error)) return;
  diagnostics.error(Code::kNotFound, "",
                    fmt::format("this install has no models: there is no folder '{}'", models.string()),
                    "Set TAKT_ROOT to the folder of models/ and scenarios/");
}

CellSetup setup_of(const CellOptions& options) {
  CellSetup setup;
  for (const auto& [pointer, value] : options.set) setup.open.overrides.push_back({pointer, value});
  setup.open.seed = options.seed;
  setup.run.video = options.video;
  setup.run.record = options.record;
  setup.run.camera = options.camera;
  setup.run.realtime = options.realtime;
  setup.core = options.core;
  setup.token = options.token;
  return setup;
}

}  // namespace

class Cell::Impl {
 public:
  Impl(const std::filesystem::path& file, const CellOptions& options, CellSetup setup)
      : quiet_(options.quiet), setup_(std::move(setup)), models_(library(options)), groups_(options.cooperating) {
    if (!setup_.core.empty()) reach();
    read(find_file(file));
    build();
    if (link_) follow();
    run_.emplace(description_, built_, expectations_, faults_, setup_.run);
    if (!run_->open()) throw OpenError(run_->report().diagnostics);
    activity::Runtime::Options wanted{
        .scheduler = {.latency_cycles = description_.program_latency_cycles, .checks_collisions = true},
        .variables = &run_->variables(),
        .event = [this](auto source, auto name, auto text) { run_->note(source, name, text); }};
    if (setup_.run.realtime) {
      realtime_ = cell::realtime_loop(built_, setup_.run);
      wanted.realtime = realtime_->support();
      wanted.scheduler.margin_cycles = activity::RealtimeSupport::kMargin;
    }
    if (follower_ != nullptr) {
      wanted.write_speed = [this](const std::string& channel, double value) {
        follower_->write_channel(channel, net::Real(value));
      };
      // The cycle does not wait for what is on the way either.
      if (served_.realtime) {
        wanted.realtime.events = &follower_->events();
        wanted.scheduler.margin_cycles = 2 * activity::RealtimeSupport::kMargin;
      }
    }
    if (setup_.run.before_step) wanted.before_activity = [this](const std::string& name) { ask(name); };
    runtime_.emplace(
        *built_.core, built_.cell, [this] { cycle(); }, wanted);
    operator_.emplace(description_.operator_script, *built_.core, built_.emergency_stop,
                      cell::OperatedProgram{.hold = [this](bool held) { runtime_->hold(held); },
                                            .cancel = [this] { runtime_->cancel(); }},
                      [this](auto name, auto text) { run_->note("operator", name, text); });
    run_->ask_touching([this] { return runtime_->touching(); });
    run_->ask_where([this] { return step_; });
    power_on();
  }

  ~Impl() {
    if (realtime_) (void)realtime_->stop();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  expression::Cell& cell() { return built_.cell; }
  rcc::ControlCore& core() { return *built_.core; }

  void write_channel(const std::string& name, const std::optional<device::ChannelValue>& value) {
    device::Channel& channel = *built_.cell.channels.at(device_of(built_.cell.channels, name, "channel"));
    const device::ChannelDescription& is = channel.description();
    if (is.writer == device::ChannelDescription::Writer::kNet)
      refuse(Code::kConflict, fmt::format("'{}' is written by nets", is.name),
             "Read it, or declare it without 'writer'");
    if (value && static_cast<net::ValueType>(value->index()) != is.type)
      refuse(Code::kWrongType, fmt::format("'{}' carries a {}", is.name, net::name_of(is.type)),
             "Write a value of that type");
    // In the follower the value arrives with the cycle in which the server has taken it.
    if (follower_ != nullptr) return follower_->write_channel(is.name, value);
    using Written = device::Channel::Written;
    Written written = Written::kBusy;
    while (written == Written::kBusy) written = value ? channel.write(*value) : channel.write_null();
  }
  activity::Runtime& runtime() { return *runtime_; }
  expression::Biases& biases() { return run_->variables().biases; }
  const std::string& title() const { return description_.title; }
  const Diagnostics& warnings() const { return warnings_; }

  void step(const std::string& name) {
    if (!step_.empty()) {
      run_->note("program", "end", step_);
      if (follower_ != nullptr) follower_->note("program", "end", step_);
    }
    step_ = name;
    run_->step_begun(name);
    operator_->step_begun(name);
    run_->note("program", "begin", name);
    if (follower_ != nullptr) {
      follower_->step_begun(name);
      follower_->note("program", "begin", name);
    }
  }

  void print(const std::string& line) {
    run_->report().lines.push_back(line);
    run_->note("program", "text", line);
    if (quiet_) return;
    fmt::print("{}\n", line);
    std::fflush(stdout);
  }

  void expect(cell::ExpectationResult result) { run_->report().expectations.push_back(std::move(result)); }

  cell::RunReport finish(const Diagnostics& why, const std::function<std::string()>& run_again) {
    cell::RunReport& report = run_->report();
    if (!broken_) report.diagnostics.append(why);  // else the report knows it already
    runtime_->drop_coroutines();
    if (why.has_errors()) runtime_->cancel();
    if (!broken_) settle();
    // What the operator broke off has failed for that reason alone.
    if (!operator_->broken_off().empty() && !report.diagnostics.has_errors())
      report.diagnostics.error(Code::kCancelled, {}, operator_->broken_off());
    const Diagnostics unawaited = runtime_->take_failures(/*given_up=*/!report.diagnostics.has_errors());
    if (operator_->broken_off().empty()) report.diagnostics.append(unawaited);
    if (realtime_) run_->in_realtime(realtime_->stop());
    report.reactions = runtime_->reactions();
    return follower_ != nullptr ? finish_there() : run_->finish(interrupted_, run_again);
  }

  bool broken() const { return broken_; }

  void beside(const std::function<void()>& work) {
    if (!realtime_) return work();
    realtime_->beside(work);
  }

 private:
  /// What is asked for begins when whoever goes through the program step by step says so.
  void ask(const std::string& activity) {
    if (!setup_.run.before_step) return;
    const std::string name = step_.empty() ? activity : step_ + ": " + activity;
    const cell::NextStep next{.name = name, .pointer = {}, .sim_time = to_seconds(built_.core->time()), .changed = {}};
    switch (setup_.run.before_step(next)) {
      case cell::StepAnswer::kNext:
        break;
      case cell::StepAnswer::kContinue:
        setup_.run.before_step = nullptr;
        break;
      case cell::StepAnswer::kCancel:
        interrupted_ = true;
        runtime_->cancel();
    }
  }

  /// The cell is in another process: which one?
  void reach() {
    Diagnostics wrong;
    const auto refuse_option = [&wrong](const char* name, bool given, const char* hint) {
      if (given) wrong.error(Code::kConflict, name, "the cell is in another process, which --core names", hint);
    };
    refuse_option("--video", !setup_.run.video.empty(),
                  "Ask the server for pictures, or run the program without --core");
    refuse_option("--record", !setup_.run.record.empty(), "Let the server record: PUT /v1/recording");
    refuse_option("--realtime", setup_.run.realtime, "Leave it out: the server decides");
    refuse_option("--seed", setup_.open.seed.has_value(), "Give it to takt serve");
    refuse_option("--site", !setup_.open.site.devices.empty(), "Give it to takt serve");
    if (wrong.has_errors()) throw OpenError(std::move(wrong));
    auto link = ServerLink::open({.url = setup_.core, .token = setup_.token});
    if (!link) throw OpenError(std::move(link.error()));
    link_ = std::move(*link);
    auto served = Follower::ask(*link_);
    if (!served) throw OpenError(std::move(served.error()));
    served_ = std::move(*served);
    setup_.open.seed = served_.seed;
  }

  void follow() {
    Diagnostics wrong;
    if (const std::string hash = record::content_hash(description_.text); hash != served_.hash)
      wrong.error(Code::kIncompatible, "--core",
                  fmt::format("the server has the cell of '{}' ({}), and this is '{}' ({})", served_.file, served_.hash,
                              description_.file.filename().string(), hash),
                  "Open the same file, with the same --set, on both sides");
    if (!description_.operator_script.empty())
      wrong.error(Code::kUnsupported, "/operator", "nobody carries out what the operator does while --core is used",
                  "Run the program without --core");
    if (wrong.has_errors()) refuse_cell(std::move(wrong));
    auto follower = std::make_unique<Follower>(*link_, built_, served_);
    follower_ = follower.get();
    (void)built_.core->add("follower", std::unique_ptr<net::Resource>(std::move(follower)));
    expectations_.clear();  // the server judges: it has the truth
    faults_.clear();
  }

  /// As finish() of a run here; what only the server knows comes from there.
  cell::RunReport finish_there() {
    const auto verdict = broken_ ? std::nullopt : follower_->judge();
    if (!broken_) follower_->leave();
    if (!verdict) run_->report().diagnostics.append(follower_->why_not());
    if (verdict) {
      auto& own = run_->report().expectations;
      own.insert(own.end(), verdict->expectations.begin(), verdict->expectations.end());
    }
    cell::RunReport report = run_->finish(interrupted_, {});
    if (!verdict) return report;
    report.digest = verdict->digest;
    report.cycles = verdict->cycles;
    return report;
  }

  static device::ModelLibrary library(const CellOptions& options) {
    std::vector<std::filesystem::path> folders = options.models;
    folders.push_back(cell::data_folder() / "models");
    return device::ModelLibrary(std::move(folders));
  }

  void read(const std::filesystem::path& file) {
    Diagnostics diagnostics;
    auto description =
        read_description(file, setup_.open.overrides, setup_.open.seed, diagnostics, cell::ReadFor::kCell);
    if (diagnostics.has_errors() && description) diagnostics.append(check_cell_names(*description, models_));
    diagnostics.set_file(file.string());
    if (diagnostics.has_errors() || !description) refuse_cell(std::move(diagnostics));
    description_ = std::move(*description);
    description_.site = setup_.open.site;
    description_.realtime = setup_.run.realtime;
    name_groups();
  }

  /// An arm that is named in no group is one by itself.
  void name_groups() {
    if (!groups_) return;
    std::vector<std::string> arms;
    for (const auto& [name, arm] : names_of_cell(description_, models_).arms) arms.push_back(name);
    Diagnostics diagnostics;
    cell::ArmGroups groups;
    for (const std::vector<std::string>& group : *groups_) {
      for (const std::string& name : group) {
        if (std::ranges::find(arms, name) != arms.end()) continue;
        diagnostics.error(Code::kUnknownName, {}, fmt::format("CellOptions::cooperating: there is no arm '{}'", name),
                          nearest_choice(name, arms));
      }
      groups.insert({group.begin(), group.end()});
    }
    diagnostics.set_file(description_.file.string());
    if (diagnostics.has_errors()) refuse_cell(std::move(diagnostics));
    for (const std::string& arm : arms) groups.insert({arm});
    description_.site.separate = cell::merged(groups);
    description_.site.cooperating = std::move(groups);
  }

  void build() {
    Diagnostics diagnostics;
    auto built = build_cell(description_, models_, setup_.open.measure_times, warnings_);
    if (built) {
      built_ = std::move(*built);
      // Nobody knows the steps of a program in C++ before it runs.
      auto expectations = make_expectations(description_.expectations, built_, std::nullopt);
      if (expectations) {
        expectations_ = std::move(*expectations);
      } else {
        diagnostics.append(expectations.error());
      }
      if (auto faults = cell::make_faults(description_.faults, built_)) {
        faults_ = std::move(*faults);
      } else {
        diagnostics.append(faults.error());
      }
      diagnostics.append(check_operator(description_.operator_script, *built_.core, std::nullopt));
    } else {
      diagnostics.append(built.error());
    }
    diagnostics.set_file(description_.file.string());
    warnings_.set_file(description_.file.string());
    if (diagnostics.has_errors()) refuse_cell(std::move(diagnostics));
  }

  [[noreturn]] static void refuse_cell(Diagnostics diagnostics) {
    explain_missing_data(diagnostics);
    throw OpenError(std::move(diagnostics));
  }

  /// Until every device is there and every arm has a set point to begin from.
  void power_on() {
    if (follower_ != nullptr) {
      if (Diagnostics wrong = follower_->begin(); wrong.has_errors()) throw OpenError(std::move(wrong));
      return operate();
    }
    const auto stopped = [this] { return interrupts() > 0 || run_->out_of_time(step_); };
    bool going = realtime_ ? connect_in_realtime(stopped) : run_->connect(stopped);
    const auto lacks = [](const auto& one) { return one.second.device->set_point().q.size() == 0; };
    while (going && std::ranges::any_of(built_.cell.arms, lacks)) going = !stopped() && one_cycle({});
    if (!going) throw OpenError(run_->report().diagnostics);
    operate();
  }

  bool connect_in_realtime(const std::function<bool()>& stopped) {
    run_->before_cycle();  // of the first one
    realtime_->start([this] {
      const bool going = run_->after_cycle();
      run_->before_cycle();  // of the next one
      return going;
    });
    while (!stopped() && one_cycle({})) {
      const auto connection = run_->look_for_devices();
      if (connection != cell::CellRun::Connection::kWaiting) return connection == cell::CellRun::Connection::kThere;
    }
    return false;
  }

  /// In real time at least one. @return false: the run cannot go on
  bool one_cycle(const std::string& current) {
    if (follower_ != nullptr) {
      follower_->touching(runtime_->touching());
      const bool going = follower_->next();
      if (!going) run_->report().diagnostics.append(follower_->why_not());
      return going && run_->look_on(current);
    }
    return realtime_ ? realtime_->next() && run_->look_on(current) : run_->step(current);
  }

  void operate() {
    operator_->before_cycle();
    if (setup_.run.operate) setup_.run.operate(*operator_);
  }

  int interrupts() const { return setup_.run.interrupt != nullptr ? setup_.run.interrupt->load() : 0; }
  std::string current() const { return step_.empty() ? runtime_->current() : step_; }

  void cycle() {
    if (broken_) throw ActivityError(run_->report().diagnostics);
    const bool going = one_cycle(current()) && !run_->out_of_time(current());
    broken_ = !going;
    if (!going) throw ActivityError(run_->report().diagnostics);
    if (follower_ != nullptr) {
      run_->tell_progress(0.0, current());
    } else if (realtime_) {
      realtime_->beside([this, now = current()] { run_->tell_progress(0.0, now); });
    } else {
      run_->pace(0.0, current());
    }
    look_at_interrupts();
    operate();
  }

  void look_at_interrupts() {
    const int count = interrupts();
    if (count >= 1 && !interrupted_) {
      interrupted_ = true;
      runtime_->cancel();
    }
    if (count >= 2) core().stop_all(net::Cause::Code::kAborted, "interrupted a second time");
  }

  /// Nothing runs and nothing moves without its program: what a run leaves behind is at rest and free.
  void settle() {
    constexpr Nanoseconds kLongest = 5 * kSecond;  // any arm comes to rest in less
    const Nanoseconds until = core().time() + kLongest;
    const auto clear = [](const auto& one) { return one.second.device->at_rest() && !one.second.device->held(); };
    try {
      while (core().time() < until && !(runtime_->idle() && std::ranges::all_of(built_.cell.arms, clear)))
        runtime_->step();
    } catch (const ActivityError& error) {
      if (!broken_) run_->report().diagnostics.append(error.diagnostics());
      return;
    }
    for (const auto& [name, arm] : built_.cell.arms) {
      if (clear(std::pair(name, arm))) continue;
      run_->report().diagnostics.error(
          Code::kNotPossibleNow, "",
          fmt::format("'{}' is {} when the program has ended", name, arm.device->held() ? "held" : "in motion"));
    }
  }

  bool quiet_;
  CellSetup setup_;
  device::ModelLibrary models_;
  CooperatingArms groups_;
  std::unique_ptr<ServerLink> link_;  ///< null: the cell is in this process. Outlives the core
  ServedCell served_;
  Follower* follower_ = nullptr;  ///< owned by the core; null likewise
  cell::Description description_;
  cell::BuiltCell built_;
  std::vector<std::unique_ptr<cell::Expectation>> expectations_;
  std::vector<cell::ScheduledFault> faults_;
  Diagnostics warnings_;
  std::optional<cell::CellRun> run_;
  std::unique_ptr<cell::RealtimeLoop> realtime_;  ///< null: lock-step
  std::optional<activity::Runtime> runtime_;
  std::optional<cell::Operator> operator_;
  std::string step_;
  bool interrupted_ = false, broken_ = false;
};

Cell::Cell(const std::filesystem::path& file, const CellOptions& options) : Cell(file, options, setup_of(options)) {}
Cell::Cell(const std::filesystem::path& file, const CellOptions& options, CellSetup setup)
    : impl_(std::make_unique<Impl>(file, options, std::move(setup))) {}
Cell::~Cell() = default;

app::Actuator Cell::arm(const std::string& name) { return {runtime(), device_of(model().arms, name, "arm")}; }
app::Frame Cell::frame(const std::string& name) { return {runtime(), name}; }
app::Actuator Cell::gripper(const std::string& name) {
  return {runtime(), device_of(model().grippers, name, "gripper")};
}

app::Actuator Cell::tool_changer(const std::string& name) {
  return {runtime(), device_of(model().changers, name, "tool changer")};
}
app::Actuator Cell::output(const std::string& name) {
  std::map<std::string, bool, std::less<>> outputs;  // digital and analog ones share one name space
  for (const auto& [one, device] : model().digital_outputs) outputs[one] = true;
  for (const auto& [one, device] : model().analog_outputs) outputs[one] = true;
  return {runtime(), device_of(outputs, name, "output")};
}

expression::WrenchSensor Cell::wrench(const std::string& sensor) {
  return contact_wrench(model(), device_of(model().sensors, sensor, "force/torque sensor"), impl_->biases());
}
expression::RealSensor Cell::force(const std::string& sensor) { return norm(expression::force(wrench(sensor))); }
expression::RealSensor Cell::pressing(const Eigen::Vector3d& direction_B, const std::string& sensor) {
  const std::string name = device_of(model().sensors, sensor, "force/torque sensor");
  return command::pressing_force(model(), name, direction_B, impl_->biases());
}
expression::State Cell::input(const std::string& name) {
  return expression::digital_input(model(), device_of(model().digital_inputs, name, "digital input"));
}
expression::RealSensor Cell::analog_input(const std::string& name) {
  return expression::analog_input(model(), device_of(model().analog_inputs, name, "analog input"));
}
void Cell::write_channel(const std::string& name, const std::optional<device::ChannelValue>& value) {
  impl_->write_channel(name, value);
}
expression::RealSensor Cell::distance(const std::vector<std::string>& side_a, const std::vector<std::string>& side_b) {
  expression::RealSensor sensor = smallest_distance(model(), side_a, side_b);
  if (const auto& fault = sensor.node()->fault) refuse(fault->code, fault->message, fault->hint);
  return sensor;
}
expression::State Cell::gripper_is(const std::string& state, const std::string& gripper) {
  const std::vector<std::string> states = {"moving", "holding", "lost", "open", "closed"};
  if (std::ranges::find(states, state) == states.end())
    refuse(Code::kUnknownName, fmt::format("a gripper is never '{}'", state), nearest_choice(state, states));
  return expression::gripper_state(model(), device_of(model().grippers, gripper, "gripper"), state);
}

activity::Activity Cell::as_activity(const command::Command& command) {
  return {runtime(), activity::command_activity(command)};
}

void Cell::tare(const std::string& sensor, std::int64_t cycles) {
  const std::string name = device_of(model().sensors, sensor, "force/torque sensor");
  const auto run = as_activity(command::tare_command(name, cycles, model())).execute();
  const auto bias = run->value<net::Wrench>("bias");
  if (!bias)
    refuse(Code::kSensorSilent, fmt::format("'{}' did not answer, so it was not tared", name),
           "Check its power and its wiring");
  runtime().biases()[name] = *bias;
}

void Cell::wait(double seconds) {
  const auto cycles = static_cast<std::int64_t>(std::ceil(seconds / to_seconds(core().period()) - 1e-9));
  const std::int64_t until = core().cycle() + cycles;
  runtime().run_until([this, until] { return core().cycle() >= until; });
}

void Cell::wait_for_all() {
  runtime().run_until([this] { return runtime().idle(); });
  if (Diagnostics failures = runtime().take_failures(); failures.has_errors()) throw ActivityError(std::move(failures));
}

bool Cell::wait_until(const expression::State& state, double timeout) {
  command::WaitCommand waiting("wait", state, timeout);
  waiting.observe("held", expression::BooleanSensor(state.node()));
  const auto run = as_activity(waiting).schedule();
  runtime().run_until([&run] { return run->over(); });
  if (run->failure() != activity::RunFailure::kAborted) require(run);
  return run->value<net::Boolean>("held").value_or(false);
}

void Cell::beside(const std::function<void()>& work) { impl_->beside(work); }

void Cell::step(const std::string& name) { impl_->step(name); }
void Cell::print(const std::string& line) { impl_->print(line); }
void Cell::expect(const std::string& name, bool passed, const std::string& measured) {
  impl_->expect({.name = name, .kind = "program", .passed = passed, .measured = measured});
}

cell::RunReport Cell::finish(const Diagnostics& why, const std::function<std::string()>& run_again) {
  Diagnostics all = why;
  try {
    if (!why.has_errors() && !impl_->broken()) wait_for_all();
  } catch (const activity::ProgramCancelled&) {
    // It was asked for; what ran has come to rest.
  } catch (const ActivityError& error) {
    all.append(error.diagnostics());
  }
  return impl_->finish(all, run_again);
}

activity::Runtime& Cell::runtime() { return impl_->runtime(); }
const expression::Cell& Cell::model() const { return impl_->cell(); }
rcc::ControlCore& Cell::core() { return impl_->core(); }
double Cell::time() { return to_seconds(core().time()); }
const std::string& Cell::title() const { return impl_->title(); }
const Diagnostics& Cell::warnings() const { return impl_->warnings(); }

}  // namespace takt::app
