#include "sim/machines/conveyor.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/contact/body_force.h"

namespace takt::sim {
namespace {

using Eigen::Vector3d;

/// 1/s: both poles of what follows the counts of the encoder.
constexpr double kFollowRate = 40.0;
/// Cycles from a sample of the encoder to when an arm moves by it: one until the core reads it, one until the arm does.
constexpr double kAhead = 2.0;
/// m/s: the belt moves.
constexpr double kMoves = 1e-3;
/// Cosine between the belt and what lies on it: what touches its ends is not taken along.
constexpr double kFlat = 0.7;
/// N: wakes what sleeps, and moves nothing.
constexpr double kTouch = 1e-12;

SimOutputDescription begins_with(double value) {
  SimOutputDescription wire;
  wire.initial = value;
  return wire;
}

}  // namespace

Result<std::unique_ptr<SimDevice>> SimConveyor::make(const mjModel& model, const std::string& robot,
                                                     const device::ConveyorDescription& conveyor, std::uint64_t seed) {
  const int body = mj_name2id(&model, mjOBJ_BODY, (robot + "/" + conveyor.belt_link).c_str());
  if (body < 0) return failure(Code::kUnknownName, "", fmt::format("no belt '{}'", conveyor.belt_link));
  return std::unique_ptr<SimDevice>(new SimConveyor(model, body, conveyor, seed, robot));
}

SimConveyor::SimConveyor(const mjModel& model, int body, const device::ConveyorDescription& conveyor,
                         std::uint64_t seed, const std::string& name)
    : run(begins_with(0.0)),
      speed(begins_with(conveyor.speed)),
      figures_(conveyor),
      model_(model),
      body_(body),
      noise_(seed, name + "/encoder"),
      carries_(static_cast<std::size_t>(model.nbody), 0) {}

void SimConveyor::start(const mjData&) {}

void SimConveyor::change_speed(double duration) {
  const double wanted = *run.wire() >= 0.5 ? *speed.wire() : 0.0;
  const double step = figures_.acceleration * duration, before = velocity_;
  velocity_ = std::clamp(wanted, velocity_ - step, velocity_ + step);
  travel_ += 0.5 * (before + velocity_) * duration;
}

/// Rows of a contact are its normal and two directions along the surface, of the second body against the first.
void SimConveyor::move_surfaces(mjData& data) {
  const Vector3d along(data.xmat[9 * body_], data.xmat[9 * body_ + 3], data.xmat[9 * body_ + 6]);
  const Vector3d up(data.xmat[9 * body_ + 2], data.xmat[9 * body_ + 5], data.xmat[9 * body_ + 8]);
  for (std::size_t body = 0; body < carries_.size(); ++body)
    if (data.body_awake[body] != mjS_ASLEEP) carries_[body] = 0;
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0 || contact.dim < 3 || contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    const int first = model_.geom_bodyid[contact.geom[0]], second = model_.geom_bodyid[contact.geom[1]];
    if (first != body_ && second != body_) continue;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(contact.frame);
    if (std::abs(axes.row(0).dot(up)) < kFlat) continue;
    carries_[static_cast<std::size_t>(first == body_ ? second : first)] = 1;
    const double way = first == body_ ? -velocity_ : velocity_;
    for (int k = 1; k < 3; ++k) data.efc_vel[contact.efc_address + k] += way * axes.row(k).dot(along);
  }
}

void SimConveyor::wake_parts(mjData& data) const {
  for (std::size_t body = 0; body < carries_.size(); ++body) {
    if (carries_[body] == 0 || data.body_awake[body] != mjS_ASLEEP) continue;
    add_wrench(data, static_cast<int>(body), {0.0, 0.0, -kTouch}, Vector3d::Zero());
  }
}

void SimConveyor::actuate(mjData& data, const Substep& step) {
  change_speed(step.duration);
  move_surfaces(data);
  if (velocity_ != 0.0) wake_parts(data);
}

/// What follows the counts has no error while the speed stays.
void SimConveyor::read_encoder() {
  const double seen = travel_ + figures_.noise * noise_.normal(), step = figures_.resolution;
  count_ = step > 0.0 ? std::round(seen / step) * step : seen;
  const double h = to_seconds(figures_.cycle), gain = std::min(1.0, kFollowRate * h);
  believed_ += h * rate_;
  const double missing = count_ - believed_;
  believed_ += 2.0 * gain * missing;
  rate_ += gain * gain / h * missing;
}

void SimConveyor::measure(const mjData&, Nanoseconds now) {
  if (now % figures_.cycle != 0) return;
  read_encoder();
  position.take(count_, now);
  running.take(std::abs(velocity_) > kMoves ? 1.0 : 0.0, now);
  if (pose_ == nullptr) return;
  const double x = believed_ + kAhead * to_seconds(figures_.cycle) * rate_;
  (void)pose_->write(net::Frame(figures_.X_MB * Eigen::Translation3d(x, 0.0, 0.0)));
}

void SimConveyor::stream(StateStream& state) {
  for (SimOutput* output : {&run, &speed}) output->stream(state);
  for (SimGauge* gauge : {&running, &position}) gauge->stream_reading(state);
  for (double* value : {&velocity_, &travel_, &count_, &believed_, &rate_}) state(*value);
  for (std::int64_t& carries : carries_) state(carries);
  std::uint64_t drawn = noise_.state();
  state(drawn);
  noise_ = Random(drawn);
}

}  // namespace takt::sim
