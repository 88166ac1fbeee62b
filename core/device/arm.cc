#include "core/device/arm.h"

#include <array>
#include <cmath>
#include <utility>

#include "core/net/format_text.h"

namespace takt::device {

namespace {

bool finite(const JointVector& v) {
  for (int i = 0; i < v.size(); ++i)
    if (!std::isfinite(v[i])) return false;
  return true;
}

/// Row N5: what a driver gives is finite and has the right size, or it is no sample.
bool usable(const ArmSample& sample, int joint_count) {
  return sample.q.size() == joint_count && sample.dq.size() == joint_count && finite(sample.q) && finite(sample.dq) &&
         finite(sample.tau) && finite(sample.commanded) &&
         (sample.commanded.size() == 0 || sample.commanded.size() == joint_count);
}

/// Loads within 1 g and 0.1 mm are one.
std::optional<net::Text> tool_misfit(const ToolSetting& was, const ToolSetting& wanted) {
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
  }
  return "";
}

Arm::Arm(std::string name, std::shared_ptr<const ArmDescription> description, std::shared_ptr<ArmBackend> backend,
         Nanoseconds period)
    : Actuator(std::move(name)),
      description_(std::move(description)),
      backend_(std::move(backend)),
      period_(period),
      guard_(description_->limits, to_seconds(period)) {}

void Arm::propose(const JointVector& q, const JointVector& dq, const JointVector& ddq) {
  proposal_.q = q;
  proposal_.dq = dq;
  proposal_.ddq = ddq;
  proposed_ = true;
}

void Arm::begin_cycle(std::int64_t cycle, Nanoseconds time) {
  cycle_ = cycle;
  time_ = time;
  proposed_ = false;
  has_sample_ = backend_->read(sample_) && usable(sample_, joint_count());
  sample_age_ = has_sample_ ? time - sample_.stamp : 0;
  if (sample_age_ > description_->sample_age_max) has_sample_ = false;
  if (!ready()) {
    phase_ = Phase::kNotReady;
  } else if (phase_ == Phase::kNotReady && !held_) {
    guard_.rest_at(sample_.commanded.size() > 0 ? sample_.commanded : sample_.q);
    phase_ = Phase::kFrozen;
  }
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
}

net::Text Arm::fault() const { return net::format_text("{}: not ready, fault {}", name(), sample_.fault); }

std::optional<net::Text> Arm::refusal() const {
  const auto because = [this](std::string_view why) { return net::format_text("{}: {}", name(), why); };
  if (phase_ == Phase::kNotReady) return because("not ready");
  if (phase_ == Phase::kBraking) return because("is braking");
  // A slow device is on its way when the set points are at rest already; it is judged by what it is told at the time of
  // the sample. One that does not say that is told what was sent last.
  const JointVector& told = sample_.commanded.size() > 0 ? sample_.commanded : guard_.last().q;
  for (int i = 0; i < joint_count(); ++i) {
    const double away = std::abs(sample_.q[i] - told[i]);
    if (at_rest() && away > description_->start_tolerance) return because("is not where it was sent");
  }
  return std::nullopt;
}

Seam Arm::seam() const {
  const ArmSetPoint& last = proposed_ && phase_ == Phase::kFollowing ? proposal_ : guard_.last();
  return {.q = last.q, .dq = last.dq, .ddq = last.ddq, .mode = net::Text("position"), .tool = tool_};
}

bool Arm::will_rest() const {
  return proposed_ && phase_ == Phase::kFollowing ? Guard::rests(proposal_) : guard_.at_rest();
}

std::optional<net::Text> Arm::misfit(const Seam& end, const Seam& begin) const {
  if (begin.mode.size > 0 && end.mode.size > 0 && begin.mode.view() != end.mode.view())
    return net::format_text("begins in mode {}, not {}", begin.mode.view(), end.mode.view());
  if (begin.tool && end.tool) {
    if (const auto text = tool_misfit(*end.tool, *begin.tool)) return text;
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
  if (at_rest()) {
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

std::optional<net::Text> Arm::check() {
  if (phase_ != Phase::kFollowing) return std::nullopt;
  const auto violation = find_violation();
  if (!violation) return std::nullopt;
  stop();
  return describe(*violation, description_->joint_names);
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
      send({guard_.last().q, guard_.last().dq, guard_.last().ddq});
      break;
  }
}

void Arm::follow() {
  if (proposed_) {
    started_ = true;
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
  send(ramp_.sample(time));
  if (time >= ramp_.duration()) phase_ = Phase::kFrozen;
}

void Arm::send(const motion::JointSample& state) {
  const ArmSetPoint set_point{.cycle = cycle_, .stamp = time_, .q = state.q, .dq = state.dq, .ddq = state.ddq};
  guard_.sent(set_point);
  backend_->write(set_point);
}

std::string Arm::fault_text() const { return backend_->fault_text(sample_.fault); }

void Arm::brake() { backend_->brake(); }

void Arm::set_tool(const ToolSetting& tool) {
  tool_ = tool;
  backend_->set_payload(tool.payload);
}

}  // namespace takt::device
