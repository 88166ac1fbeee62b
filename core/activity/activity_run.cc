#include "core/activity/activity_run.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/command/command_tree.h"
#include "core/expression/comparison.h"

namespace takt::activity {
namespace {

constexpr const char *kAborted = " abort_if", *kAbortUnknown = " abort_if unknown", *kCompared = " compares ";

/// "/0", "/1/0"
bool is_part(std::string_view text) {
  return text.starts_with('/') && std::ranges::all_of(text, [](char c) { return c == '/' || (c >= '0' && c <= '9'); });
}

}  // namespace

/// What was made one motion, or is a composition of one, has no parts.
RunView ActivityRun::inside(const std::string& part) const {
  const bool has_parts =
      std::ranges::any_of(observed_, [](const auto& one) { return one.first.ends_with(kPartStarted); });
  return has_parts ? RunView(*this, part) : RunView(*this);
}

RunState RunView::state() const {
  if (is_whole()) return run_.state();
  if (!was_true(kPartStarted)) return RunState::kQueued;
  if (was_true(kPartFailed)) return RunState::kFailed;
  // A guarded motion or a press cancels itself where it comes to its end.
  if (was_true(kPartCancelled) && run_.state() == RunState::kCancelled) return RunState::kCancelled;
  if (was_true(kPartCompleted)) return RunState::kCompleted;
  return run_.over() ? RunState::kFailed : RunState::kRunning;
}

RunFailure RunView::failure() const {
  if (is_whole()) return run_.failure();
  return was_true(kPartFailed)          ? RunFailure::kAborted
         : state() == RunState::kFailed ? run_.failure()
                                        : RunFailure::kNone;
}

bool RunView::may_have_failed() const {
  if (!is_whole()) return was_true(kPartFailed);
  const net::Cause cause = run_.cause();
  return cause.in_order() && cause.code != net::Cause::Code::kCancelled;
}

RunView RunView::narrowed_to(const std::string& observation) const {
  return is_whole() ? inside(run_.only_part_with(observation)) : *this;
}

ActivityRun::~ActivityRun() { unload(); }

void ActivityRun::unload() {
  externals_.detach();
  if (net_ == 0) return;
  unloaded_ = compiled_net();
  (void)core_.unload(net_);
}

void ActivityRun::forget_net() {
  unload();
  net_ = 0;
  unloaded_ = nullptr;
  observed_.clear();
  clocks_.clear();
  reactions_ = {};
  trace_ = {};
}

rcc::NetStatus ActivityRun::status() const {
  if (status_) return *status_;
  return net_ != 0 ? core_.status(net_) : rcc::NetStatus{};
}

Diagnostics ActivityRun::diagnostics_inside() const {
  const std::string own = pointer_segment(name());
  Diagnostics inside;
  for (Diagnostic diagnostic : diagnostics_.list()) {
    if (diagnostic.pointer.starts_with(own)) diagnostic.pointer.erase(0, own.size());
    inside.add(std::move(diagnostic));
  }
  return inside;
}

std::string ActivityRun::only_part_with(const std::string& observation) const {
  std::string only;
  const bool names_a_part = observation.size() > 1 && is_part(std::string_view(observation).substr(0, 2));
  if (names_a_part || observed_.contains(observation)) return only;
  for (const auto& [name, port] : observed_) {
    if (name.size() <= observation.size() || !name.ends_with(observation)) continue;
    std::string part = name.substr(0, name.size() - observation.size());
    if (part.ends_with(' ')) part.pop_back();
    if (!is_part(part)) continue;
    if (!only.empty()) return {};
    only = std::move(part);
  }
  return only;
}

const std::string* ActivityRun::port_of(const std::string& observation) const {
  const std::string part = only_part_with(observation);
  const auto found = observed_.find(command::scoped_name(part, observation));
  return found == observed_.end() ? nullptr : &found->second;
}

std::vector<std::string> ActivityRun::observed_after(const std::string& begin) const {
  std::vector<std::string> rest;
  for (const auto& [name, port] : observed_)
    if (name.starts_with(begin)) rest.push_back(name.substr(begin.size()));
  return rest;
}

template <class T>
std::optional<T> ActivityRun::value(const std::string& observation) const {
  const std::string* port = port_of(observation);
  const rcc::NetHandle net = compiled_net();
  if (port == nullptr || net == nullptr) return std::nullopt;
  const auto* slot = net->find<T>(*port);
  return slot != nullptr && slot->null == 0 ? std::optional<T>(slot->value) : std::nullopt;
}
template std::optional<net::Boolean> ActivityRun::value(const std::string&) const;
template std::optional<net::Integer> ActivityRun::value(const std::string&) const;
template std::optional<net::Real> ActivityRun::value(const std::string&) const;
template std::optional<net::Vector> ActivityRun::value(const std::string&) const;
template std::optional<net::Frame> ActivityRun::value(const std::string&) const;
template std::optional<net::Twist> ActivityRun::value(const std::string&) const;
template std::optional<net::Wrench> ActivityRun::value(const std::string&) const;
template std::optional<net::JointArray> ActivityRun::value(const std::string&) const;

bool ActivityRun::was_true(const std::string& observation) const {
  return value<net::Boolean>(observation).value_or(false);
}

void ActivityRun::abort() {
  wants_cancel_ = true;
  if (carrier_ != nullptr) return carrier_->abort();
  if (state_ == RunState::kRunning && net_ != 0) core_.abort(net_);
}

bool ActivityRun::shares_actuator(const ActivityRun& other) const {
  const auto own = model_->actuators(), others = other.model_->actuators();
  return std::ranges::find_first_of(own, others) != own.end();
}

const ActivityRun::Clock* ActivityRun::clock_of(const expression::SubjectPtr& command) const {
  const auto clock = clocks_.find(command.get());
  return clock == clocks_.end() ? nullptr : &clock->second;
}

bool ActivityRun::is_before(const HandOver& hand_over) const {
  if (first_cycle() < 0 || core_.cycle() <= first_cycle()) return true;  // not evaluated yet
  const Clock* clock = clock_of(hand_over.command);
  return clock != nullptr && clock->runs() && clock->time->value < hand_over.time;
}

bool ActivityRun::carries() const {
  return blended_ && state_ == RunState::kRunning &&
         std::ranges::any_of(planned_.taken_over, [this](const auto& one) { return is_before(one.second); });
}

bool ActivityRun::carries(const ActivityRun& other) const {
  const auto others = other.model_->actuators();
  return !over() && std::ranges::any_of(others, [this](const std::string& name) {
    const auto hand_over = planned_.taken_over.find(name);
    return hand_over != planned_.taken_over.end() && is_before(hand_over->second);
  });
}

std::optional<std::size_t> ActivityRun::part() const {
  for (const PlannedPart& motion : planned_.motions) {
    const Clock* clock = clock_of(motion.command);
    if (clock == nullptr || !clock->runs()) continue;
    if (clock->time->value < motion.begin) return std::nullopt;
    const auto passed = std::ranges::upper_bound(motion.handed_over, clock->time->value);
    return static_cast<std::size_t>(passed - motion.handed_over.begin());
  }
  return std::nullopt;
}

Diagnostics ActivityRun::attach(command::MappedCommand mapped) {
  const rcc::NetHandle handle = core_.net(net_);
  const net::CompiledNet& net = *handle;
  if (planned_.command) {
    const command::CommandTree tree(*planned_.command);
    for (int i = 0; i < tree.size(); ++i) {
      const auto& clock = mapped.commands[static_cast<std::size_t>(i)].clock;
      if (!clock) continue;
      clocks_[tree.at(i).node->subject.get()] = {.time = net.find<net::Real>(clock->time),
                                                 .rate = net.find<net::Real>(clock->rate),
                                                 .rate_derivative = net.find<net::Real>(clock->rate_derivative)};
    }
  }
  reactions_.attach(name(), net, mapped.brakes);
  trace_.attach(net, mapped.traced);
  observed_ = std::move(mapped.observed);
  return externals_.attach(core_, net_, mapped.externals);
}

void ActivityRun::after_cycle() {
  const std::int64_t cycle = core_.cycle() - 1;
  reactions_.look(cycle);
  trace_.note(cycle);
}

expression::State not_allowed(const expression::State& state, const command::Command& command) {
  const expression::State silent = is_null(expression::BooleanSensor(state.node()));
  return ((state || silent) && command.active()).once();
}

expression::State not_touched(const expression::State& until, bool must_touch, const command::Command& command) {
  const expression::State touched = (until && command.active()).once();
  const expression::State silent = (is_null(expression::BooleanSensor(until.node())) && command.active()).once();
  return !touched && (must_touch ? silent || !command.cancelled() : silent);
}

void add_abort(command::Command& command, const expression::State& state, const std::string& key) {
  const expression::BooleanSensor holds(state.node()), unknown(is_null(holds).node());
  command.on_entered(state, cancel(command));
  command.fails_if(not_allowed(state, command));
  command.capture(key + kAborted, holds, state);
  command.capture(key + kAbortUnknown, unknown, expression::State(unknown.node()));
  capture_compared(command, state, key + kAborted);
}

void capture_compared(command::Command& command, const expression::State& state, const std::string& key) {
  for (const auto& [quantity, text] : expression::comparisons_of(state))
    command.capture(key + kCompared + text, quantity, state);
}

std::string compared_text(const RunView& run, const std::string& key) {
  std::string all;
  const RunView part = run.narrowed_to(key);
  for (const std::string& text : part.observed_after(key + kCompared)) {
    const auto value = part.value<net::Real>(key + kCompared + text);
    if (value) all += fmt::format("{}{}: {:.4g}", all.empty() ? "" : ", ", text, *value);
  }
  return all;
}

Diagnostics abort_diagnostics(const RunView& run, const std::string& key) {
  Diagnostics diagnostics;
  const bool silent = run.was_true(key + kAbortUnknown);
  if (silent || run.was_true(key + kAborted))
    add_abort_diagnostic(silent, compared_text(run, key + kAborted), "/abort_if", diagnostics);
  return diagnostics;
}

void add_abort_diagnostic(bool silent, const std::string& compared, std::string pointer, Diagnostics& diagnostics) {
  if (silent)
    return diagnostics.error(Code::kSensorSilent, std::move(pointer),
                             "a sensor in `abort_if` did not answer, so it was stopped",
                             "Check the sensor's power and wiring");
  diagnostics.error(Code::kAbortCondition, std::move(pointer),
                    fmt::format("`abort_if` became true{}, so it was stopped",
                                compared.empty() ? "" : fmt::format(" ({})", compared)),
                    "Remove the cause and ask for it again");
}

}  // namespace takt::activity
