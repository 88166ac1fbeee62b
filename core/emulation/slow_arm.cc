#include "core/emulation/slow_arm.h"

#include <algorithm>

namespace takt::emulation {

using device::ChangeClass;
using device::ControlMode;

namespace {

constexpr std::int64_t kShownCycles = 3;               // of the device: for a packet that is lost, and one that is late
constexpr Nanoseconds kSettling = 100 * kMillisecond;  // until the joints stand where the set points do

}  // namespace

SlowArm::SlowArm(const std::string& name, std::shared_ptr<device::ArmBackend> inner, const motion::JointLimits& limits,
                 const SlowOptions& options, Nanoseconds core_period, std::uint64_t seed, device::ControlModes modes)
    : inner_(std::move(inner)),
      options_(options),
      core_period_(core_period),
      modes_(std::move(modes)),
      device_clock_(options.clock()),
      agent_(limits, options.timing(core_period), core_clock_),
      controller_(limits, options.cycle, options.answer_timeout_cycles),
      to_core_(options.wire, seed, name + "/to core"),
      to_device_(options.wire, seed, name + "/to device"),
      device_cycle_(options.first_cycle()) {}

bool SlowArm::read(device::ArmSample& sample) {
  advance(++core_cycle_ * core_period_);
  const bool any = agent_.read(sample);
  // On the way to another mode it takes no set points, as was asked for: the arm is not lost.
  if (sample.changing_mode && sample.fault == 0) sample.ready = true;
  return any;
}

device::ControlModes SlowArm::delayed(const device::ControlModes& modes, const SlowOptions& options,
                                      Nanoseconds core_period) {
  device::ControlModes slow = modes;
  for (device::ModeChange& change : slow.changes) {
    // Position begins where a spring was pushed to: a step, for set points that are on their way.
    const bool step = change.change == ChangeClass::kSeamless && change.to == ControlMode::kPosition;
    if (step) change.change = ChangeClass::kAtStandstill;
    if (change.change != ChangeClass::kSeamless)
      change.duration += options.delay(core_period) + kShownCycles * options.cycle + kSettling;
  }
  return slow;
}

void SlowArm::change_mode(ControlMode mode) {
  const device::ModeChange* change = modes_.find(plant_.mode, mode);
  if (change == nullptr || change_ || plant_.changing_mode) return;
  if (change->change == ChangeClass::kSeamless && mode != ControlMode::kPosition) return inner_->change_mode(mode);
  // Before that what was sent earlier is on its way to the arm behind.
  const std::int64_t from = core_cycle_ + options_.delay(core_period_) / core_period_ + 1;
  change_ = Change{mode, from, from + kSettling / core_period_};
}

/// Asks until the arm behind stands and begins to change.
void SlowArm::continue_change() {
  if (!change_ || core_cycle_ < change_->from) return;
  if (change_->shown_until < 0) change_->shown_until = device_cycle_ + kShownCycles;
  if (plant_.mode == change_->to && !plant_.changing_mode) {
    if (device_cycle_ >= change_->shown_until) change_.reset();
  } else if (core_cycle_ > change_->end && !plant_.changing_mode) {
    change_.reset();
  } else if (!plant_.changing_mode) {
    inner_->change_mode(change_->to);
  }
}

/// All that happens up to now, in the order of time. The plant is known at the core's cycles only: what happens between
/// two of them sees the state of the earlier one.
void SlowArm::advance(Nanoseconds now) {
  looked_ = false;
  for (;;) {
    const Nanoseconds instant = device_clock_.to_core(device_cycle_ * options_.cycle);
    const Nanoseconds packet = to_core_.next_arrival(), answer = to_device_.next_arrival();
    const Nanoseconds next = std::min({instant, packet, answer});
    if (next > now) break;
    core_clock_.set(next);
    if (next == now) look_at_plant();
    if (next == answer) {
      take_answer();
    } else if (next == instant) {
      begin_device_cycle();
    } else {
      answer_packet();
    }
  }
  core_clock_.set(now);
  look_at_plant();
  tell_plant(now);
  hash_state();
}

void SlowArm::look_at_plant() {
  if (looked_) return;
  looked_ = true;
  const bool was_ready = has_plant_ && plant_.ready;
  const bool was_changing = changing();
  const ControlMode mode = plant_.mode;
  has_plant_ = inner_->read(plant_);
  continue_change();
  // What the drives do without set points the controller follows, so that it begins where they are.
  const bool stiffens = was_changing && plant_.mode != mode && plant_.mode == ControlMode::kPosition;
  if (has_plant_ && (!(was_ready && plant_.ready) || stiffens)) {
    controller_.stand(plant_.commanded.size() > 0 ? plant_.commanded : plant_.q);
  }
}

void SlowArm::begin_device_cycle() {
  const Nanoseconds instant = device_cycle_++ * options_.cycle;
  ++sequence_;
  if (!has_plant_) return;  // a device without a sample is silent
  controller_.begin_cycle(instant);
  measure_delay();
  device::ArmPacket packet{plant_, instant};
  packet.sample.sequence = sequence_;
  packet.sample.stamp = device_clock_.to_device(plant_.stamp);
  packet.sample.commanded = controller_.at(instant).q;
  packet.sample.changing_mode = changing();
  packet.sample.ready = ready() && !changing();
  if (controller_.timed_out() && packet.sample.fault == 0) packet.sample.fault = kAnswersMissing;
  to_core_.send(packet, core_clock_.now());
}

void SlowArm::answer_packet() {
  const auto answer = agent_.answer(to_core_.receive());
  if (!answer) return;
  const bool following = agent_.phase() == device::AgentReport::Phase::kFollowing;
  to_device_.send({*answer, following ? agent_.resampled_time() : -1}, core_clock_.now());
}

void SlowArm::take_answer() {
  const Sent sent = to_device_.receive();
  if (sent.answer.brake) inner_->brake();
  controller_.take(sent.answer, sent.resampled);
}

void SlowArm::measure_delay() {
  if (controller_.resampled() < 0) return;
  const Nanoseconds told_for = device_clock_.to_core(device_cycle_ * options_.cycle);  // the end of this cycle
  const Nanoseconds delay = told_for - controller_.resampled();
  report_.delay_least = std::min(report_.delay_least, delay);
  report_.delay_most = std::max(report_.delay_most, delay);
}

void SlowArm::tell_plant(Nanoseconds now) {
  if (!has_plant_ || !plant_.ready) return;
  const motion::JointSample state = controller_.at(device_clock_.to_device(now));
  inner_->write({.cycle = core_cycle_, .stamp = now, .q = state.q, .dq = state.dq, .ddq = state.ddq});
}

std::string SlowArm::fault_text(std::uint32_t fault) const {
  if (fault == kAnswersMissing) return "too many answers were missing: the controller stopped the arm";
  const std::string agents = device::ArmAgent::fault_text(fault);
  return agents.empty() ? inner_->fault_text(fault) : agents;
}

device::BackendTiming SlowArm::timing() const {
  const device::AgentTiming& agent = agent_.timing();
  return {.cycle = options_.cycle,
          .sample_age = options_.cycle + options_.wire.slowest() + core_period_,
          .driver_delay = agent.driver_delay(),
          .dead_time = agent.dead_time()};
}

SlowArmReport SlowArm::report() const {
  SlowArmReport report = report_;
  report.agent = agent_.report();
  report.missed_answers = controller_.missed();
  return report;
}

/// The set points on their way to the agent are in the digest of the core already.
void SlowArm::hash_state() {
  state_.begin();
  state_.add(device_cycle_);
  state_.add(sequence_);
  state_.add(to_core_.random().state());
  state_.add(to_device_.random().state());
  to_core_.for_each([this](const device::ArmPacket& packet, Nanoseconds arrival) {
    state_.add(arrival);
    state_.add(packet.sample.sequence);
    state_.add(packet.sample.q);
    state_.add(packet.sample.dq);
    state_.add(packet.sample.tau);
  });
  to_device_.for_each([this](const Sent& sent, Nanoseconds arrival) {
    state_.add(arrival);
    state_.add(sent.answer.instant);
    state_.add(sent.answer.state);
  });
  controller_.add_state(state_);
  state_.add(agent_.resampled_time());
  state_.add(static_cast<std::uint64_t>(agent_.phase()));
  state_.add(change_ ? std::uint64_t{1} + static_cast<std::uint64_t>(change_->to) : 0);
}

}  // namespace takt::emulation
