#include "core/activity/scheduler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

#include <fmt/format.h>

#include "core/command/command_tree.h"

namespace takt::activity {
namespace {

using rcc::NetState;

/// Path time that a clock needs at most until its rate is steady: half the time from rest to full rate.
double way_to_steady(const motion::Motion& motion) {
  constexpr double kShare = 0.6;
  return kShare * motion::PathClock(motion.clock, motion.duration(), false).stop_time_bound();
}

/// CPU time of this thread: the work, whoever else is on the machine; for people, nothing is decided by it.
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// It brakes, or goes into another control mode.
bool is_busy(const device::Arm& arm) {
  return arm.phase() == device::Arm::Phase::kBraking || arm.phase() == device::Arm::Phase::kChanging;
}

bool is_waiting(RunState state) { return state == RunState::kQueued || state == RunState::kLoaded; }

}  // namespace

std::string_view name_of(RunState state) {
  static constexpr std::array<std::string_view, 6> kNames = {"queued",    "loaded",    "running",
                                                             "completed", "cancelled", "failed"};
  return kNames.at(static_cast<std::size_t>(state));
}

ActivityRun::~ActivityRun() {
  if (net_ != 0) (void)core_.unload(net_);
}

template <class T>
std::optional<T> ActivityRun::value(const std::string& observation) const {
  const auto found = observed_.find(observation);
  const rcc::NetHandle net = net_ != 0 ? core_.net(net_) : nullptr;
  if (found == observed_.end() || net == nullptr) return std::nullopt;
  const auto* slot = net->find<T>(found->second);
  return slot != nullptr && slot->null == 0 ? std::optional<T>(slot->value) : std::nullopt;
}
template std::optional<net::Boolean> ActivityRun::value(const std::string&) const;
template std::optional<net::Integer> ActivityRun::value(const std::string&) const;
template std::optional<net::Real> ActivityRun::value(const std::string&) const;
template std::optional<net::Vector> ActivityRun::value(const std::string&) const;
template std::optional<net::Frame> ActivityRun::value(const std::string&) const;
template std::optional<net::Wrench> ActivityRun::value(const std::string&) const;

void ActivityRun::watch_brakes(const std::vector<command::BrakePorts>& brakes) {
  const rcc::NetHandle handle = core_.net(net_);
  const net::CompiledNet& net = *handle;
  for (const command::BrakePorts& brake : brakes) {
    const Watched watched{.event = net.find<net::Boolean>(brake.event),
                          .rate = net.find<net::Real>(brake.clock + ".rate"),
                          .derivative = net.find<net::Real>(brake.clock + ".rate_derivative")};
    Reaction reaction{.activity = name(), .event = brake.name, .least = -1, .most = -1};
    for (const auto& line : net.report().reactions) {
      const bool from = std::ranges::find(brake.sources, line.source) != brake.sources.end();
      if (!from || !line.sink.starts_with(brake.fragment + "/") || !line.sink.ends_with(".q")) continue;
      reaction.least = reaction.least < 0 ? line.minimum_cycles : std::min(reaction.least, line.minimum_cycles);
      reaction.most = std::max(reaction.most, line.maximum_cycles);
    }
    if (!watched.event || !watched.rate || !watched.derivative || reaction.least < 0) continue;
    watched_.push_back(watched);
    reactions_.push_back(std::move(reaction));
  }
}

void ActivityRun::look_at_events() {
  const std::int64_t cycle = core_.cycle() - 1;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& watched = watched_[i];
    Reaction& reaction = reactions_[i];
    if (watched.rate->null) continue;  // its motion does not run
    const bool event = watched.event->null || watched.event->value;
    if (reaction.event_cycle < 0 && event) {
      reaction.event_cycle = cycle;
      watched.compared = watched.steady_before;
    }
    if (watched.compared && reaction.braking_cycle < 0 && watched.rate->value < watched.rate_before)
      reaction.braking_cycle = cycle;
    watched.rate_before = watched.rate->value;
    watched.steady_before = watched.rate->value > 0.0 && !watched.derivative->null && watched.derivative->value == 0.0;
  }
}

void ActivityRun::cancel() { wants_cancel_ = true; }

void ActivityRun::abort() {
  wants_cancel_ = true;
  if (state_ == RunState::kRunning) core_.abort(net_);
}

bool ActivityRun::shares_actuator(const ActivityRun& other) const {
  const auto own = model_->actuators(), others = other.model_->actuators();
  return std::ranges::find_first_of(own, others) != own.end();
}

const net::Slot<net::Real>* ActivityRun::clock_port(const command::SubjectPtr& command, const char* port) const {
  const auto fragment = fragments_.find(command.get());
  const rcc::NetHandle net = core_.net(net_);
  return fragment == fragments_.end() || net == nullptr ? nullptr
                                                        : net->find<net::Real>(fragment->second + "/clock." + port);
}

std::optional<std::size_t> ActivityRun::part() const {
  for (const PlannedPart& motion : prepared_.motions) {
    const auto* time = clock_port(motion.command, "time");
    if (time == nullptr || time->null != 0) continue;
    if (time->value < motion.begin) return std::nullopt;
    const auto passed = std::ranges::upper_bound(motion.handed_over, time->value);
    return static_cast<std::size_t>(passed - motion.handed_over.begin());
  }
  return std::nullopt;
}

RunPtr Scheduler::schedule(ActivityPtr model) {
  RunPtr run = std::make_shared<ActivityRun>(core_, std::move(model));
  run->asked_cycle_ = core_.cycle();
  run->due_cycle_ = core_.cycle() + options_.latency_cycles;
  runs_.push_back(run);
  return run;
}

void Scheduler::poll() {
  const std::vector<RunPtr> now = runs_;  // the list may change below
  for (const RunPtr& run : now) update(*run);
  for (const RunPtr& run : now)
    if (run->state_ == RunState::kQueued && !held_) try_begin(*run);
  for (const RunPtr& run : now) {
    if (held_ || run->state_ != RunState::kLoaded || run->change_ || core_.cycle() < run->due_cycle_) continue;
    if (!run->prepared_.modes.empty() && run->modes_before_.empty()) {
      begin_change(*run);
      continue;
    }
    if (run->rule_) post(*run);
  }
  for (const RunPtr& run : runs_) {
    if (run->over()) reactions_.insert(reactions_.end(), run->reactions_.begin(), run->reactions_.end());
  }
  std::erase_if(runs_, [](const RunPtr& run) { return run->over(); });
}

/// The queue of the core may be full of requests of others: then it is posted again in the next cycle.
void Scheduler::post(ActivityRun& run) {
  run.request_ = core_.post(*run.rule_);
  if (run.request_ != 0) return run.rule_.reset();
  if (run.queue_full_since_ < 0) run.queue_full_since_ = core_.cycle();
  if (core_.cycle() - run.queue_full_since_ < rcc::Rule::kPatience) return;
  Findings why;
  why.error("",
            fmt::format("'{}' was not started: the control core's queue of requests was full for {} cycles", run.name(),
                        rcc::Rule::kPatience),
            "fewer requests in one cycle");
  fail(run, std::move(why));
}

void Scheduler::cancel() {
  for (const RunPtr& run : runs_) run->cancel();
}

std::string Scheduler::current() const {
  std::string names;
  for (const RunPtr& run : runs_) {
    if (run->state() == RunState::kRunning) names += (names.empty() ? "" : " + ") + run->name();
  }
  return names;
}

void Scheduler::begin_change(ActivityRun& run) {
  run.change_.emplace(core_, run.prepared_.modes);
  run.modes_before_ = run.change_->before();
  if (!run.prepared_.command) run.state_ = RunState::kRunning;
}

/// When its arms stand: what failed brakes first.
void Scheduler::go_back(ActivityRun& run) {
  run.goes_back_ = true;
  run.rule_.reset();
  const bool brakes = std::ranges::any_of(run.modes_before_, [this](const auto& before) {
    const device::Arm* arm = core_.find_arm(before.first);
    return arm != nullptr && is_busy(*arm);
  });
  if (!brakes) run.change_.emplace(core_, run.modes_before_);
}

/// A change that has begun comes to its end, whoever cancels meanwhile.
void Scheduler::follow_change(ActivityRun& run) {
  if (!run.change_->poll(core_)) return;
  Findings findings = run.change_->findings();
  run.change_.reset();
  if (findings.has_errors()) return fail(run, std::move(findings));
  if (run.goes_back_ || !run.prepared_.command) return complete(run);
  if (!run.wants_cancel_) return;  // its net is started now
  if (run.prepared_.returns) return go_back(run);
  complete(run);
}

void Scheduler::complete(ActivityRun& run) {
  if (run.findings_.has_errors()) return end_failed(run);  // it has gone back after a failure
  const bool ran = run.net_ != 0 && core_.state(run.net_) == NetState::kTerminated;
  const bool cancelled = ran ? core_.status(run.net_).cause.code == net::Cause::Code::kCancelled : run.wants_cancel_;
  run.state_ = cancelled ? RunState::kCancelled : RunState::kCompleted;
  if (cancelled) give_up_followers(run);
}

void Scheduler::update(ActivityRun& run) {
  if (run.change_) return follow_change(run);
  if (run.goes_back_) return go_back(run);
  // Its start may have been carried out in the last cycle.
  const bool begun = run.net_ != 0 && core_.state(run.net_) > NetState::kReady;
  if (run.state_ == RunState::kQueued || (run.state_ == RunState::kLoaded && run.wants_cancel_ && !begun)) {
    if (!run.wants_cancel_) return;
    if (run.prepared_.returns && !run.modes_before_.empty()) return go_back(run);
    run.state_ = RunState::kCancelled;
    if (run.net_ != 0) (void)core_.unload(run.net_);
    return give_up_followers(run);
  }
  if (run.state_ == RunState::kLoaded) {
    for (const rcc::Event& event : core_.events()) {
      if (event.request != run.request_ || run.request_ == 0 || event.kind == rcc::Event::Kind::kState) continue;
      if (event.kind == rcc::Event::Kind::kRefused) {
        Findings why;
        why.error("", fmt::format("'{}' was not started: {}", run.name(), event.cause.text.view()), kAgain);
        return fail(run, std::move(why));
      }
      run.blended_ = !run.prepared_.taken_over.empty() && event.cause.text.size == 0;
    }
  }
  if (run.net_ == 0) return;
  const NetState state = core_.state(run.net_);
  if (is_active(state) || state == NetState::kTerminated) {
    run.state_ = RunState::kRunning;
    run.look_at_events();
  }
  if (run.wants_cancel_ && state == NetState::kRunning) core_.cancel(run.net_);
  if (state == NetState::kTerminated) finish(run);
}

void Scheduler::finish(ActivityRun& run) {
  const rcc::NetStatus status = core_.status(run.net_);
  if (!status.cause.in_order()) {
    Findings why;
    why.error("",
              fmt::format("'{}' was stopped in cycle {} ({}): {}", run.name(), status.last_cycle,
                          net::name_of(status.cause.code), status.cause.text.view()),
              kAgain);
    return fail(run, std::move(why));
  }
  if (run.prepared_.returns) return go_back(run);
  complete(run);
}

void Scheduler::fail(ActivityRun& run, Findings findings) {
  // Each place begins with the activity, as the paths of commands do.
  const std::string place = pointer_segment(run.name());
  for (Finding finding : findings.list()) {
    if (!finding.pointer.starts_with(place)) finding.pointer.insert(0, place);
    run.findings_.add(std::move(finding));
  }
  // An arm does not stay as soft as a failure has left it.
  const bool is_changed = run.prepared_.returns && !run.modes_before_.empty();
  if (is_changed && !run.goes_back_) return go_back(run);
  end_failed(run);
}

void Scheduler::end_failed(ActivityRun& run) {
  run.state_ = RunState::kFailed;
  if (run.net_ != 0) (void)core_.unload(run.net_);
  give_up_followers(run);
}

void Scheduler::give_up_followers(const ActivityRun& run) {
  bool behind = false;
  for (const RunPtr& other : runs_) {
    if (other.get() == &run) behind = true;
    if (!behind || other.get() == &run || !is_waiting(other->state_) || !other->shares_actuator(run)) continue;
    Findings why;
    why.error("",
              fmt::format("'{}' was given up: '{}' before it {}", other->name(), run.name(),
                          run.state_ == RunState::kCancelled ? "was cancelled" : "failed"),
              "nothing starts by itself after a stop: ask for it again");
    fail(*other, std::move(why));
  }
}

Scheduler::Predecessors Scheduler::predecessors_of(const ActivityRun& run) const {
  Predecessors before;
  for (const RunPtr& other : runs_) {
    if (other.get() == &run) break;
    if (other->over() || !other->shares_actuator(run)) continue;
    if (other->state_ == RunState::kRunning) before.running.push_back(other.get());
    before.wait = before.wait || is_waiting(other->state_);
    // Who changes control modes begins when all before have ended; its own end no net tells.
    if (other->state_ == RunState::kRunning)
      before.wait = before.wait || run.model_->begins_alone() || other->model_->begins_alone();
  }
  return before;
}

bool Scheduler::is_steady(const ActivityRun& run, const command::SubjectPtr& command) {
  const auto* rate = run.clock_port(command, "rate");
  const auto* change = run.clock_port(command, "rate_derivative");
  return rate != nullptr && change != nullptr && rate->value > 0.0 && change->value == 0.0;
}

bool Scheduler::is_as_planned(const ActivityRun& run, const command::SubjectPtr& command, double period) {
  constexpr double kRounding = 1e-6;  // of a cycle
  const double cycles = run.clock_port(command, "time")->value / period;
  return is_steady(run, command) && run.clock_port(command, "rate")->value == 1.0 &&
         std::abs(cycles - std::round(cycles)) < kRounding;
}

std::optional<Precedent::Leaving> Scheduler::leaving(const ActivityRun& run, const Forecast& forecast) const {
  const double period = to_seconds(core_.period());
  for (const auto& [command, motion] : forecast.last) {
    const auto* time = run.clock_port(command, "time");
    if (time == nullptr || time->null != 0) continue;
    double soonest = time->value / period + static_cast<double>(options_.latency_cycles + options_.margin_cycles);
    if (!is_steady(run, command)) soonest += way_to_steady(*motion.motion) / period;
    return Precedent::Leaving{.motion = motion,
                              .tau = std::ceil(soonest) * period,
                              .lead = static_cast<double>(options_.lead_cycles) * period,
                              .exact = is_as_planned(run, command, period)};
  }
  return std::nullopt;
}

std::optional<Precedent> Scheduler::precedent(const std::string& actuator, const Predecessors& before,
                                              bool& wait) const {
  for (ActivityRun* run : before.running) {
    const auto forecast = run->prepared_.forecasts.find(actuator);
    if (forecast == run->prepared_.forecasts.end()) continue;
    Precedent precedent{.at_end = forecast->second.after, .leaving = leaving(*run, forecast->second)};
    // It may be left, but has not come to the motion that may.
    wait = wait || (!forecast->second.last.empty() && !precedent.leaving);
    return precedent;
  }
  const auto arm = cell_.arms.find(actuator);
  if (arm == cell_.arms.end()) return Precedent{};
  const device::Arm& device = *arm->second.device;
  wait =
      wait || device.set_point().q.size() == 0 || !device.at_rest() || is_busy(device);  // no sample yet, or it brakes
  if (wait) return std::nullopt;
  Precedent precedent{.at_end = ActuatorState::at_rest(device.set_point().q), .leaving = std::nullopt};
  precedent.at_end.mode = name_of(device.mode());
  return precedent;
}

std::optional<Situation> Scheduler::situation_of(const ActivityRun& run, const Predecessors& before) const {
  Situation situation{.cell = cell_, .period = core_.period(), .precedents = {}};
  bool wait = false, all_leave = true;
  const auto own = run.model_->actuators();
  for (const std::string& actuator : own) {
    auto one = precedent(actuator, before, wait);
    if (wait || !one) return std::nullopt;
    // Where a predecessor leaves it nobody knows yet: it has to end first.
    if (cell_.arms.contains(actuator) && !one->at_end.rests()) return std::nullopt;
    situation.precedents[actuator] = std::move(*one);
  }
  for (const ActivityRun* other : before.running) {
    for (const std::string& actuator : other->model_->actuators()) {
      const auto found = situation.precedents.find(actuator);
      all_leave = all_leave && found != situation.precedents.end() && found->second.leaving.has_value();
    }
  }
  if (!all_leave) {
    for (auto& [name, one] : situation.precedents) one.leaving.reset();
  }
  // Without a seam only the end itself tells that the next may begin.
  const bool only_arms = std::ranges::all_of(own, [this](const auto& name) { return cell_.arms.contains(name); });
  if (!before.running.empty() && !only_arms) return std::nullopt;
  return situation;
}

void Scheduler::try_begin(ActivityRun& run) {
  const Predecessors before = predecessors_of(run);
  if (before.wait) return;
  auto situation = situation_of(run, before);
  if (!situation) return;
  const double begin = cpu_seconds();
  auto prepared = run.model_->prepare(*situation);
  const auto leaves = [](const auto& one) { return one.second.leaving.has_value(); };
  const auto wanted = static_cast<std::size_t>(std::ranges::count_if(situation->precedents, leaves));
  if (prepared && wanted > 0 && prepared->taken_over.size() != wanted) {
    // All or nothing: what cannot be taken over together is waited for.
    for (auto& [name, one] : situation->precedents) one.leaving.reset();
    prepared = run.model_->prepare(*situation);
  }
  if (!prepared) return fail(run, std::move(prepared.error()));
  run.prepared_ = std::move(*prepared);
  if (Findings wrong = agree_on_modes(run.prepared_, *situation); wrong.has_errors())
    return fail(run, std::move(wrong));
  run.preparation_.planning = cpu_seconds() - begin;
  load(run, before, *situation);
  run.preparation_.total = cpu_seconds() - begin;
}

void Scheduler::load(ActivityRun& run, const Predecessors& before, const Situation& situation) {
  run.state_ = RunState::kLoaded;
  if (!run.prepared_.command) return;  // nothing but a change of control modes
  auto mapped = command::map(*run.prepared_.command, core_.period());
  if (!mapped) return fail(run, std::move(mapped.error()));
  mapped->options.begins.clear();
  for (const auto& [device, ways] : run.prepared_.begins)
    for (const device::Seam& way : ways) mapped->options.begins.push_back({device, way});
  auto id = core_.load(mapped->net, mapped->options);
  if (!id) return fail(run, std::move(id.error()));
  run.net_ = *id;
  run.observed_ = std::move(mapped->observed);
  const command::CommandTree tree(*run.prepared_.command);
  for (int i = 0; i < tree.size(); ++i)
    run.fragments_[tree.at(i).node->subject.get()] = mapped->commands[static_cast<std::size_t>(i)].fragment;
  run.watch_brakes(mapped->brakes);
  auto rule = rule_for(run, before, situation);
  if (!rule) return fail(run, std::move(rule.error()));
  run.rule_ = *rule;
}

Result<rcc::Rule> Scheduler::rule_for(const ActivityRun& run, const Predecessors& before,
                                      const Situation& situation) const {
  rcc::Rule rule;
  rule.action.start = {run.net_};
  if (before.running.empty()) return rule;
  rule.otherwise.start = {run.net_};
  bool fits = true;
  const auto add = [&](const rcc::Term& term) { fits = rule.condition.add(term) && fits; };
  for (const ActivityRun* other : before.running) {
    if (run.prepared_.taken_over.empty()) {
      add(rcc::Term::state(other->net_, {NetState::kTerminated}));
      continue;
    }
    fits = rule.action.end.add(other->net_) && fits;
    for (const auto& [actuator, forecast] : other->prepared_.forecasts) {
      const auto& leaving = situation.precedents.find(actuator)->second.leaving;
      for (const auto& [command, motion] : forecast.last) {
        if (!leaving || motion.motion != leaving->motion.motion) continue;
        constexpr double kRounding = 1e-7;  // s
        add(rcc::Term::in_range(other->net_, other->clock_port(command, "time"), leaving->tau - kRounding,
                                leaving->tau + leaving->lead + kRounding));
        add(rcc::Term::in_range(other->net_, other->clock_port(command, "rate_derivative"), 0.0, 0.0));
      }
    }
  }
  if (fits) return rule;
  return failure(
      "",
      fmt::format("'{}' follows {} running activities at once; a rule of the control core ends at most {} nets "
                  "on at most {} conditions",
                  run.name(), before.running.size(), rcc::NetSet::kCapacity, rcc::Condition::kCapacity),
      "fewer activities before it that it has to wait for together");
}

}  // namespace takt::activity
