#include "core/device/arm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/kinematics/chain.h"
#include "core/net/format_text.h"

namespace takt::device {

namespace {

/// Row N5: what a driver gives is finite and has the right size, or it is no sample.
bool usable(const ArmSample& sample, int joint_count) {
  return sample.q.size() == joint_count && sample.dq.size() == joint_count && sample.q.allFinite() &&
         sample.dq.allFinite() && sample.tau.allFinite() && sample.commanded.allFinite() &&
         sample.tau_external.allFinite() && (sample.commanded.size() == 0 || sample.commanded.size() == joint_count);
}

/// Cycles of a device after which a sample must show what was asked for a device cycle ago, its age included.
constexpr int kAnswerCycles = 5;

/// A machine has to be off for so long: one wrong sample stops nothing.
constexpr int kCyclesOff = 3;

/// Beside the declared delays: controllers smooth what they are told, and trail behind it.
constexpr Nanoseconds kTrailing = 100 * kMillisecond;

Nanoseconds following_window(const ArmDescription& description, const BackendTiming& timing) {
  return kTrailing + timing.driver_delay + timing.dead_time + std::max(timing.sample_age, description.sample_age_max);
}

/// Loads within 1 g and 0.1 mm are one.
std::optional<net::Text> tool_mismatch(const ToolSetting& was, const ToolSetting& wanted) {
  constexpr double kMass_kg = 1e-3, kWay_m = 1e-4;
  const double apart = (wanted.X_FT.translation() - was.X_FT.translation()).norm();
  if (std::abs(wanted.payload.mass - was.payload.mass) > kMass_kg)
    return net::format_text("begins with a load of {:.5g}, not {:.5g} kg", wanted.payload.mass, was.payload.mass);
  if (apart > kWay_m) return net::format_text("begins with another tool: {:.5g} m apart", apart);
  return std::nullopt;
}

}  // namespace

std::string_view name_of(Arm::Phase phase) {
  switch (phase) {
    case Arm::Phase::kNotReady:
      return "not ready";
    case Arm::Phase::kFrozen:
      return "frozen";
    case Arm::Phase::kFollowing:
      return "following";
    case Arm::Phase::kBraking:
      return "braking";
    case Arm::Phase::kChanging:
      return "changing mode";
  }
  return "";
}

Arm::Arm(std::string name, std::shared_ptr<const ArmDescription> description, std::shared_ptr<ArmBackend> backend,
         Nanoseconds period)
    : Actuator(std::move(name)),
      description_(std::move(description)),
      backend_(std::move(backend)),
      period_(period),
      guard_(description_->limits, to_seconds(period)),
      following_(description_->following_error, following_window(*description_, backend_->timing()), period),
      compliance_share_(static_cast<double>(period) / static_cast<double>(description_->impedance.ramp)) {}

void Arm::propose(const JointVector& q, const JointVector& dq, const JointVector& ddq) {
  proposal_.q = q;
  proposal_.dq = dq;
  proposal_.ddq = ddq;
  proposed_ = true;
  compliance_proposed_ = false;
}

void Arm::propose(const JointVector& q, const JointVector& dq, const JointVector& ddq, const Compliance& compliance) {
  propose(q, dq, ddq);
  proposed_compliance_ = compliance;
  compliance_proposed_ = true;
}

void Arm::begin_cycle(std::int64_t cycle, Nanoseconds time) {
  cycle_ = cycle;
  time_ = time;
  proposed_ = compliance_proposed_ = false;
  const bool failed = failed_before();
  has_sample_ = at_border([this] { return backend_->set_held(held_), backend_->read(sample_); }) && !failed &&
                usable(sample_, joint_count());
  sample_age_ = has_sample_ ? time - sample_.stamp : 0;
  if (sample_age_ > description_->sample_age_max) has_sample_ = false;
  // Somebody else changed the mode: what was sent is not what the device does. It is taken over anew.
  const bool other_mode = has_sample_ && cycle_ >= mode_due_ && sample_.mode != mode_;
  if (!ready()) {
    phase_ = Phase::kNotReady;
    following_.clear();
  } else if (phase_ == Phase::kChanging) {
    look_at_change();
  } else if (other_mode && phase_ != Phase::kNotReady) {
    phase_ = Phase::kNotReady;
  } else if (phase_ == Phase::kNotReady && !held_ && !sample_.changing_mode) {
    guard_.rest_at(start_positions());
    stand_in(sample_.mode);
    phase_ = Phase::kFrozen;
  }
}

void Arm::stand_in(ControlMode mode) {
  following_.clear();
  mode_ = mode;
  mode_due_ = 0;
  compliance_ = description_->impedance.standard(mode);
}

/// The device is there once the declared time is over and its samples say so; if they never do, it stays where it was.
void Arm::look_at_change() {
  const bool there = sample_.mode == target_mode_ && !sample_.changing_mode;
  if (there && mode_ != target_mode_) {
    // Whoever was pushed away from a spring's rest must not jump back to it: position begins where the arm is. That is
    // so from the first sample on that shows it, since set points are followed then.
    guard_.rest_at(target_mode_ == ControlMode::kPosition ? start_positions() : guard_.last().q);
    stand_in(target_mode_);
  }
  if (cycle_ < (there ? change_ends_ : mode_due_)) return;
  if (!there) stand_in(sample_.mode);
  phase_ = Phase::kFrozen;
}

void Arm::add_state(StateWords& words) const {
  words.add(std::uint64_t{has_sample_} | std::uint64_t{sample_.ready} << 1 | std::uint64_t{sample_.fault} << 32);
  words.add(static_cast<std::uint64_t>(phase_));
  if (has_sample_) {
    words.add(sample_.sequence);
    words.add(sample_.stamp);
    for (const auto* part : {&sample_.q, &sample_.dq, &sample_.tau, &sample_.commanded}) words.add(*part);
  }
  const ArmSetPoint& sent = set_point();
  for (const auto* part : {&sent.q, &sent.dq, &sent.ddq}) words.add(*part);
  words.add(static_cast<std::uint64_t>(mode_) | static_cast<std::uint64_t>(sample_.mode) << 8 |
            std::uint64_t{sample_.changing_mode} << 16 | std::uint64_t{sample_.braked} << 17 |
            std::uint64_t{compliance_.in_tool_axes} << 18);
  if (has_sample_) words.add(sample_.tau_external);
  if (mode_ == ControlMode::kPosition) return;
  for (const auto* part : {&compliance_.stiffness, &compliance_.damping_ratio, &compliance_.feed_forward})
    words.add(*part);
  words.add(compliance_.nullspace_stiffness);
  words.add(compliance_.nullspace_damping_ratio);
}

net::Text Arm::fault() const {
  if (ready() && sample_.mode != mode_) return net::format_text("{}: went into mode {}", name(), name_of(sample_.mode));
  if (exception()) return *exception();
  if (sample_.fault != 0) return net::format_text("{}: not ready, fault {}", name(), sample_.fault);
  if (sample_age_ > description_->sample_age_max)
    return net::format_text("{}: its newest sample is {} ms old", name(), sample_age_ / kMillisecond);
  return net::format_text("{}: {}", name(), has_sample_ ? "not ready" : "gives no sample that can be used");
}

std::optional<net::Text> Arm::refusal() const {
  const auto because = [this](std::string_view why) { return net::format_text("{}: {}", name(), why); };
  if (phase_ == Phase::kNotReady) return because("not ready");
  if (phase_ == Phase::kBraking) return because("is braking");
  if (phase_ == Phase::kChanging) return because("changes its control mode");
  if (at_rest() && mode_ == ControlMode::kPosition && away_from_set_point()) return because("is not where it was sent");
  return std::nullopt;
}

/// A slow device is on its way when the set points are at rest already; it is judged by what it is told at the time of
/// the sample. One that does not say that is told what was sent last. One that gives way may be anywhere.
bool Arm::away_from_set_point() const {
  const JointVector& told = sample_.commanded.size() > 0 ? sample_.commanded : guard_.last().q;
  for (int i = 0; i < joint_count(); ++i)
    if (std::abs(sample_.q[i] - told[i]) > description_->start_tolerance) return true;
  return false;
}

bool Arm::stands_by_itself() const {
  constexpr double kStanding = 0.01;  // rad/s or m/s: what encoders of arms that stand report
  return phase_ == Phase::kNotReady && has_sample_ && sample_.dq.cwiseAbs().maxCoeff() < kStanding;
}

StateAnswer Arm::answer(std::string_view wanted) const {
  using Kind = StateAnswer::Kind;
  const auto mode = wanted.empty() ? std::optional(mode_) : control_mode_of(wanted);
  const auto refused = [&](const net::Text& why) { return StateAnswer{Kind::kRefused, why}; };
  if (!mode) return refused(net::format_text("{}: there is no mode '{}'", name(), wanted));
  if (phase_ == Phase::kChanging)
    return *mode == target_mode_ || wanted.empty()
               ? StateAnswer{Kind::kLater, net::format_text("{}: changes its control mode", name())}
               : refused(net::format_text("{}: is going into mode {}", name(), name_of(target_mode_)));
  if (*mode == mode_) return {};
  const ModeChange* change = description_->modes.find(mode_, *mode);
  if (change == nullptr)
    return refused(net::format_text("{}: {} to {} is forbidden", name(), name_of(mode_), name_of(*mode)));
  if (change->change == ChangeClass::kOutsideNet)
    return refused(net::format_text("{}: {} to {} only outside a net", name(), name_of(mode_), name_of(*mode)));
  if (change->change == ChangeClass::kAtStandstill) {
    if (at_rest()) return {Kind::kLater, net::format_text("{}: changes its control mode", name())};
    return refused(net::format_text("{}: moves; mode {} at standstill only", name(), name_of(*mode)));
  }
  const bool jump = *mode == ControlMode::kPosition && !at_rest() && away_from_set_point();
  if (jump) return refused(net::format_text("{}: is away from its set point; no mode {}", name(), name_of(*mode)));
  return {Kind::kAtOnce, {}};
}

void Arm::enter(std::string_view wanted) {
  const auto mode = control_mode_of(wanted);
  if (!mode || *mode == mode_ || phase_ == Phase::kChanging) return;
  const ModeChange* change = description_->modes.find(mode_, *mode);
  if (change == nullptr) return;
  if (change->change == ChangeClass::kSeamless) {
    switch_to(*mode);
  } else if (phase_ == Phase::kFrozen) {
    change_mode(*mode);
  }  // else: a net has just let go of it, or still holds it
}

/// The last cycle of a net may be under way: what it proposed is still sent, the rest is of the new mode.
void Arm::switch_to(ControlMode mode) {
  const bool stiff = mode == ControlMode::kPosition;
  if (stiff && at_rest()) {
    guard_.rest_at(start_positions());
    proposed_ = false;
  }
  stand_in(mode);
  compliance_proposed_ = false;
  mode_due_ = cycle_ + kAnswerCycles * (1 + description_->cycle / period_);
  call_border([&] { backend_->change_mode(mode); });
}

std::optional<std::string> Arm::conflict(std::span<const std::string> wanted) const {
  for (const std::string& from : wanted) {
    for (const std::string& to : wanted) {
      const auto a = control_mode_of(from), b = control_mode_of(to);
      if (!a || !b || *a == *b) continue;
      const ModeChange* change = description_->modes.find(*a, *b);
      if (change != nullptr && change->change == ChangeClass::kSeamless) continue;
      return fmt::format("'{}' goes from mode {} to {}, which is {} there", name(), from, to,
                         change == nullptr ? "forbidden" : name_of(change->change));
    }
  }
  return std::nullopt;
}

std::optional<net::Text> Arm::refuse_change(ControlMode mode) const {
  if (phase_ == Phase::kChanging && mode == target_mode_) return std::nullopt;
  if (held_) return net::format_text("{}: a net holds it", name());
  if (phase_ != Phase::kFrozen) return net::format_text("{}: is {}", name(), name_of(phase_));
  if (mode == mode_ || description_->modes.find(mode_, mode) != nullptr) return std::nullopt;
  if (!description_->modes.has(mode)) return net::format_text("{}: has no mode {}", name(), name_of(mode));
  return net::format_text("{}: {} to {} is forbidden", name(), name_of(mode_), name_of(mode));
}

void Arm::change_mode(ControlMode mode) {
  const ModeChange* change = description_->modes.find(mode_, mode);
  if (phase_ != Phase::kFrozen || change == nullptr) return;
  target_mode_ = mode;
  change_ends_ = cycle_ + (change->duration + period_ - 1) / period_;
  mode_due_ = change_ends_ + kAnswerCycles * (1 + description_->cycle / period_);
  phase_ = Phase::kChanging;
  call_border([&] { backend_->change_mode(mode); });
}

Seam Arm::seam() const {
  const ArmSetPoint& last = proposed_ && phase_ == Phase::kFollowing ? proposal_ : guard_.last();
  return {.q = last.q, .dq = last.dq, .ddq = last.ddq, .mode = net::Text(name_of(mode_)), .tool = tool_};
}

bool Arm::will_rest() const {
  if (!proposed_ || phase_ != Phase::kFollowing) return at_rest();
  return Guard::rests(proposal_) && (compliance_proposed_ ? proposed_compliance_ : compliance_).neutral();
}

std::optional<net::Text> Arm::seam_mismatch(const Seam& end, const Seam& begin) const {
  if (begin.mode.size > 0 && end.mode.size > 0 && begin.mode.view() != end.mode.view()) {
    const auto from = control_mode_of(end.mode.view()), to = control_mode_of(begin.mode.view());
    const ModeChange* change = from && to ? description_->modes.find(*from, *to) : nullptr;
    if (change == nullptr || change->change != ChangeClass::kSeamless)
      return net::format_text("begins in mode {}, not {}", begin.mode.view(), end.mode.view());
  }
  if (begin.tool && end.tool) {
    if (const auto text = tool_mismatch(*end.tool, *begin.tool)) return text;
  }
  const double h = to_seconds(period_);
  double open = h * h * h;  // what a jerk of 1 does to a position in one period; then to a velocity, an acceleration
  double noise = Guard::kPositionNoise;
  constexpr std::array<std::string_view, 3> kUnits = {"rad", "rad/s", "rad/s2"};
  const std::array<std::pair<const JointVector*, const JointVector*>, 3> parts = {
      {{&end.q, &begin.q}, {&end.dq, &begin.dq}, {&end.ddq, &begin.ddq}}};
  for (std::size_t p = 0; p < parts.size(); ++p, open /= h, noise *= 2.0 / h) {
    const auto& [was, wanted] = parts[p];
    if (was->size() == 0 || wanted->size() == 0) continue;
    if (was->size() != wanted->size() || wanted->size() != joint_count())
      return net::format_text("begins with {} joints, not {}", wanted->size(), joint_count());
    for (int i = 0; i < joint_count(); ++i) {
      const double allowed = description_->limits.jerk[i] * open * (1.0 + Guard::kShare) + noise;
      if (std::abs((*wanted)[i] - (*was)[i]) <= allowed) continue;  // false for NaN
      return net::format_text("joint {}: begins at {:.5g}, not at {:.5g} {}",
                              description_->joint_names[static_cast<std::size_t>(i)], (*wanted)[i], (*was)[i],
                              kUnits[p]);
    }
  }
  return std::nullopt;
}

void Arm::hold() {
  held_ = true;
  releasing_ = false;
  started_ = false;
  if (phase_ == Phase::kFrozen) phase_ = Phase::kFollowing;
}

void Arm::release() {
  held_ = false;
  releasing_ = true;
}

void Arm::stop() {
  held_ = false;
  releasing_ = false;
  proposed_ = false;
  if (phase_ != Phase::kFollowing) return;
  const bool as_it_stays =
      mode_ == ControlMode::kPosition || compliance_ == stopped(compliance_, description_->impedance.range(mode_));
  if (at_rest() && as_it_stays) {
    freeze();
  } else {
    begin_braking();
  }
}

std::optional<Violation> Arm::find_violation() const {
  if (!proposed_) return at_rest() ? std::nullopt : std::optional(Violation{});
  if (!started_ && at_rest() && proposal_.q.size() == joint_count()) {
    for (int i = 0; i < joint_count(); ++i) {
      const double here = guard_.last().q[i];
      const bool away = std::abs(proposal_.q[i] - here) > description_->start_tolerance;
      if (away) return Violation{Violation::Rule::kStart, i, proposal_.q[i], here};
    }
  }
  return guard_.check(proposal_);
}

/// A net may change the mode by turns where that is seamless; what it sends beside the set point is guarded like that.
std::optional<net::Text> Arm::find_wrong_mode() const {
  if (!compliance_proposed_) return std::nullopt;
  const ControlMode mode = proposed_compliance_.mode;
  if (mode != mode_) {
    const ModeChange* change = description_->modes.find(mode_, mode);
    if (change == nullptr || change->change != ChangeClass::kSeamless)
      return net::format_text("{}: is in mode {}, not {}", name(), name_of(mode_), name_of(mode));
    if (mode == ControlMode::kPosition && away_from_set_point())
      return net::format_text("{}: is away from its set point; no mode {}", name(), name_of(mode));
  }
  if (mode == ControlMode::kPosition) return std::nullopt;
  const ComplianceRange& range = description_->impedance.range(mode);
  const Compliance& last = mode == mode_ ? compliance_ : range.standard;
  if (started_ && mode == mode_ && proposed_compliance_.in_tool_axes != compliance_.in_tool_axes)
    return net::format_text("{}: the axes of its compliance change", name());
  return find_fault(proposed_compliance_, last, range, compliance_share_);
}

/// Only stiff arms are where they are sent; one that gives way may be anywhere.
std::optional<net::Text> Arm::find_following_error() {
  const bool stiff = mode_ == ControlMode::kPosition && sample_.mode == ControlMode::kPosition && has_sample_;
  const auto error = stiff ? following_.check(sample_.q) : std::nullopt;
  cycles_off_ = error ? cycles_off_ + 1 : 0;
  if (cycles_off_ < kCyclesOff) return std::nullopt;
  const bool slides = description_->chain && description_->chain->is_prismatic(error->joint);
  return net::format_text("joint {}: does not follow, {:.3g} {} off its set points ({:.3g} at most)",
                          description_->joint_names[static_cast<std::size_t>(error->joint)], error->error,
                          slides ? "m" : "rad", following_.bound());
}

std::optional<net::Text> Arm::check() {
  if (phase_ != Phase::kFollowing) {
    cycles_off_ = 0;
    return std::nullopt;
  }
  std::optional<net::Text> trip = find_following_error();
  if (const auto violation = find_violation(); violation && !trip)
    trip = describe(*violation, description_->joint_names);
  if (!trip) trip = find_wrong_mode();
  if (trip) stop();
  return trip;
}

void Arm::hand_over() {
  switch (phase_) {
    case Phase::kNotReady:
      break;
    case Phase::kFollowing:
      follow();
      break;
    case Phase::kBraking:
      continue_braking();
      break;
    case Phase::kFrozen:
    case Phase::kChanging:
      send({guard_.last().q, guard_.last().dq, guard_.last().ddq});
      break;
  }
}

void Arm::follow() {
  if (proposed_) {
    started_ = true;
    if (compliance_proposed_ && proposed_compliance_.mode != mode_) {
      mode_ = proposed_compliance_.mode;
      mode_due_ = cycle_ + kAnswerCycles * (1 + description_->cycle / period_);
      call_border([this] { backend_->change_mode(mode_); });
    }
    if (compliance_proposed_) compliance_ = proposed_compliance_;
    send({proposal_.q, proposal_.dq, proposal_.ddq});
  } else {
    send({guard_.last().q, guard_.last().dq, guard_.last().ddq});
  }
  if (!std::exchange(releasing_, false)) return;
  if (at_rest()) {
    freeze();
  } else {
    begin_braking();
  }
}

void Arm::freeze() {
  phase_ = Phase::kFrozen;
  guard_.rest_at(guard_.last().q);
}

void Arm::begin_braking() {
  ramp_ = BrakeRamp({guard_.last().q, guard_.last().dq, guard_.last().ddq}, guard_.limits());
  brake_cycles_ = 0;
  phase_ = Phase::kBraking;
}

void Arm::continue_braking() {
  ++brake_cycles_;
  const double time = static_cast<double>(brake_cycles_) * to_seconds(period_);
  bool relaxed = true;
  if (mode_ != ControlMode::kPosition) {
    const ComplianceRange& range = description_->impedance.range(mode_);
    const Compliance target = stopped(compliance_, range);
    compliance_ = approach(compliance_, target, range, compliance_share_);
    relaxed = compliance_ == target;
  }
  send(ramp_.sample(time));
  if (time >= ramp_.duration() && relaxed) phase_ = Phase::kFrozen;
}

void Arm::send(const motion::JointSample& state) {
  const ArmSetPoint set_point{.cycle = cycle_, .stamp = time_, .q = state.q, .dq = state.dq, .ddq = state.ddq};
  guard_.sent(set_point);
  mode_ == ControlMode::kPosition ? following_.sent(state.q) : following_.clear();
  call_border([&] {
    if (mode_ != ControlMode::kPosition) backend_->write_compliance(compliance_);
    backend_->write(set_point);
  });
}

std::string Arm::fault_text() const { return fault_text(sample_.fault); }
std::string Arm::fault_text(std::uint32_t fault) const { return backend_->fault_text(fault); }

void Arm::brake() {
  call_border([this] { backend_->brake(); });
}

void Arm::set_tool(const ToolSetting& tool) {
  tool_ = tool;
  backend_->set_tool(tool);
}

}  // namespace takt::device
