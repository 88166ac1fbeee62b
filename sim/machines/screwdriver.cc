#include "sim/machines/screwdriver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/contact/body_force.h"

namespace takt::sim {
namespace {

using Eigen::Vector3d;

constexpr double kSpeedGain = 200.0;     // 1/s: of the speed loop
constexpr double kIntegralGain = 100.0;  // 1/s: its integral part against the proportional one
constexpr double kClutchTime = 0.02;     // s at the torque of the clutch before it lets go
constexpr double kClutchSpeed = 0.2;     // rad/s: slower than this is stalled
constexpr double kAtLimit = 0.999;       // of the torque of the clutch
constexpr double kTurning = 0.05;        // rad/s
constexpr double kMagnetGap = 0.0005;    // m at which the magnet pulls with a quarter of its force, chosen
constexpr double kSensedGap = 0.0002;    // m: so near a screw is at the bit
constexpr double kSnapSpeed = 0.1;  // m/s: no faster does a screw snap to the bit; chosen, less than the film shows

Pose body_at(const mjData& data, int body) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Map<const Vector3d>(data.xpos + 3 * body);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.xmat + 9 * body);
  return X;
}

double to_resolution(double value, double step) { return step > 0.0 ? std::round(value / step) * step : value; }

SimOutputDescription wire_at(double initial) {
  SimOutputDescription wire;
  wire.initial = initial;
  return wire;
}

}  // namespace

Result<std::unique_ptr<SimDevice>> SimScrewdriver::make(const mjModel& model, const WorldDescription& description,
                                                        const std::string& robot,
                                                        const device::ScrewdriverDescription& driver) {
  const auto named = [&](mjtObj type, const std::string& name) {
    return mj_name2id(&model, type, (robot + "/" + name).c_str());
  };
  const int joint = named(mjOBJ_JOINT, driver.spindle);
  const int bit = named(mjOBJ_BODY, driver.bit);
  if (joint < 0 || bit < 0)
    return failure(Code::kUnknownName, "", fmt::format("no spindle '{}' or bit '{}'", driver.spindle, driver.bit));
  Plant plant{.position = model.jnt_qposadr[joint],
              .velocity = model.jnt_dofadr[joint],
              .bit = bit,
              .inertia = model.dof_M0[model.jnt_dofadr[joint]],
              .reach = reach_of(model, bit)};
  return std::unique_ptr<SimDevice>(
      new SimScrewdriver(driver, plant, sockets_of(model, description), description.seed, robot));
}

SimScrewdriver::SimScrewdriver(const device::ScrewdriverDescription& driver, Plant plant,
                               std::vector<ScrewSocket> screws, std::uint64_t seed, const std::string& name)
    : turn(wire_at(0.0)),
      reverse(wire_at(0.0)),
      speed(wire_at(driver.speed_max)),
      torque_limit(wire_at(driver.torque_max)),
      figures_(driver),
      plant_(plant),
      screws_(std::move(screws)),
      noise_(seed, name) {}

void SimScrewdriver::start(const mjData& data) { position_ = begin_ = data.qpos[plant_.position]; }

/// The edges of `turn`: a new tightening begins with angle and peak at zero.
void SimScrewdriver::start_or_stop() {
  const bool wanted = *turn.wire() >= 0.5;
  if (wanted == running_) return;
  running_ = wanted;
  integral_ = stalled_ = 0.0;
  let_go_ = false;
  if (!running_) return;
  begin_ = position_;
  peak_ = 0.0;
}

double SimScrewdriver::motor_torque(double rate, double duration) {
  const double most = std::clamp(*torque_limit.wire(), figures_.torque_min, figures_.torque_max);
  const double asked = std::clamp(*speed.wire(), figures_.speed_min, figures_.speed_max);
  const double wanted = !running_ || let_go_ ? 0.0 : *reverse.wire() >= 0.5 ? -asked : asked;
  reference_ += std::clamp(wanted - reference_, -figures_.acceleration * duration, figures_.acceleration * duration);
  const double gain = kSpeedGain * plant_.inertia, error = reference_ - rate;
  const double proportional = gain * error;
  const double next = integral_ + kIntegralGain * gain * error * duration;
  // The integral part stands still while the clutch limits the torque.
  if (std::abs(proportional + next) < most || proportional * next < 0.0) integral_ = std::clamp(next, -most, most);
  if (let_go_) integral_ = 0.0;
  return std::clamp(proportional + integral_, -most, most);
}

void SimScrewdriver::watch_clutch(double rate, double duration) {
  const double most = std::clamp(*torque_limit.wire(), figures_.torque_min, figures_.torque_max);
  const bool stalls = running_ && std::abs(applied_) >= kAtLimit * most && std::abs(rate) < kClutchSpeed;
  stalled_ = stalls ? stalled_ + duration : 0.0;
  if (stalled_ >= kClutchTime) let_go_ = true;
}

void SimScrewdriver::actuate(mjData& data, const Substep& step) {
  const double rate = data.qvel[plant_.velocity];
  position_ = data.qpos[plant_.position];
  start_or_stop();
  // What the last step's torque did not accelerate went into the bit.
  transmitted_ = applied_ - plant_.inertia * (rate - rate_before_) / step.duration;
  if (running_ && !let_go_) peak_ = std::max(peak_, std::abs(transmitted_));
  watch_clutch(rate, step.duration);
  applied_ = motor_torque(rate, step.duration);
  rate_before_ = rate;
  data.qfrc_applied[plant_.velocity] = applied_;
  hold_screw(data, step.duration);
}

/// On a screw that is still so far from the end of the bit. In contact it is the holding force; before, the magnet
/// makes the screw no faster than kSnapSpeed: a few grams would be through the bit within a step.
double SimScrewdriver::pull_at(double gap, double approach, double mass, double duration) const {
  if (gap <= 0.0) return figures_.holding_force;
  const double share = 1.0 / (1.0 + gap / kMagnetGap);
  return std::clamp(mass * (kSnapSpeed - approach) / duration, 0.0, figures_.holding_force * share * share);
}

/// The magnet in the bit: a pull along the axis, for the screw in whose socket the end of the bit is.
void SimScrewdriver::hold_screw(mjData& data, double duration) {
  if (figures_.holding_force <= 0.0) return;
  const std::int64_t before = std::exchange(pulled_, -1);
  const Pose X_WB = body_at(data, plant_.bit);
  const Vector3d end = X_WB * Vector3d(0, 0, plant_.reach);
  for (std::size_t i = 0; i < screws_.size() && pulled_ < 0; ++i) {
    const ScrewSocket& screw = screws_[i];
    const BitInSocket seen = look_into(screw, data, plant_.bit, plant_.reach);
    if (!seen.inside) continue;
    pulled_ = static_cast<std::int64_t>(i);
    const double approach = before == pulled_ ? (gap_ - seen.p_S.z()) / duration : 0.0;
    gap_ = seen.p_S.z();
    const Vector3d pull =
        pull_at(gap_, approach, screw.mass, duration) * (body_at(data, screw.body) * screw.X_OS).linear().col(2);
    add_force(data, screw.body, pull, end);
    add_force(data, plant_.bit, -pull, end);
  }
}

void SimScrewdriver::measure(const mjData& data, Nanoseconds now) {
  if (now % figures_.cycle != 0) return;
  const double rate = data.qvel[plant_.velocity];
  position_ = data.qpos[plant_.position];
  const double noise = figures_.torque_noise > 0.0 ? figures_.torque_noise * noise_.normal() : 0.0;
  clutch.take(let_go_ ? 1.0 : 0.0, now);
  turning.take(std::abs(rate) > kTurning ? 1.0 : 0.0, now);
  screw_present.take(pulled_ >= 0 && gap_ < kSensedGap ? 1.0 : 0.0, now);
  torque.take(to_resolution(transmitted_ + noise, figures_.torque_resolution), now);
  peak_torque.take(to_resolution(peak_, figures_.torque_resolution), now);
  angle.take(to_resolution(position_ - begin_, figures_.angle_resolution), now);
  measured_speed.take(rate, now);
}

void SimScrewdriver::stream(StateStream& state) {
  for (SimOutput* output : {&turn, &reverse, &speed, &torque_limit}) output->stream(state);
  for (SimGauge* gauge : {&clutch, &turning, &screw_present, &torque, &peak_torque, &angle, &measured_speed})
    gauge->stream_reading(state);
  for (double* value : {&reference_, &integral_, &applied_, &rate_before_, &transmitted_, &peak_, &begin_, &stalled_,
                        &position_, &gap_})
    state(*value);
  state(pulled_);
  for (bool* flag : {&running_, &let_go_}) state(*flag);
  std::uint64_t word = noise_.state();
  state(word);
  noise_ = Random(word);
}

}  // namespace takt::sim
