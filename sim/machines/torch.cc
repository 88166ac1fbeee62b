#include "sim/machines/torch.h"

#include <numbers>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

SimOutputDescription shut() {
  SimOutputDescription wire;
  wire.initial = 0.0;
  return wire;
}

Eigen::Isometry3d body_in_world(const mjData& data, int body) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(data.xpos + 3 * body);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.xmat + 9 * body);
  return X;
}

}  // namespace

SimTorch::SimTorch(const device::TorchDescription& torch, const mjModel& model, int body, const Eigen::Isometry3d& X_LT)
    : gas(shut()), arc(shut()), wire(shut()), figures_(torch), model_(model), body_(body), X_LT_(X_LT) {}

double SimTorch::deposit_rate() const {
  return std::numbers::pi / 4.0 * figures_.wire_diameter * figures_.wire_diameter * figures_.wire_speed;
}

void SimTorch::find_metal(const mjData& data) {
  const Eigen::Isometry3d X_WT = body_in_world(data, body_) * X_LT_;
  const Eigen::Vector3d from = X_WT.translation(), along = X_WT.linear().col(2);
  int geom = -1;
  // Written by mj_ray: only its scratch memory.
  auto& scratch = const_cast<mjData&>(data);
  spot_.distance = mj_ray(&model_, &scratch, from.data(), along.data(), nullptr, 1, body_, &geom, nullptr);
  spot_.body = geom < 0 ? -1 : model_.geom_bodyid[geom];
  if (spot_.body < 0) return;
  spot_.p_B = body_in_world(data, spot_.body).inverse() * (from + spot_.distance * along);
}

void SimTorch::change_arc(double duration) {
  const bool wanted = *arc.wire() >= 0.5;
  const bool in_range = spot_.body >= 0 && spot_.distance >= figures_.stick_out_min &&
                        spot_.distance <= figures_.stick_out_max && fault_ != Fault::kLost;
  missing_ = in_range ? 0.0 : missing_ + duration;
  if (!wanted || (burns_ && missing_ > figures_.extinction)) burns_ = false;
  const bool lights = wanted && in_range && !burns_ && fault_ == Fault::kNone;
  waited_ = lights ? waited_ + duration : 0.0;
  if (lights && waited_ >= figures_.ignition) burns_ = true;
}

void SimTorch::measure(const mjData& data, Nanoseconds now) {
  find_metal(data);
  change_arc(to_seconds(now - last_));
  last_ = now;
  spot_.burns = burns_;
  spot_.gas = *gas.wire() >= 0.5;
  spot_.wire = *wire.wire() >= 0.5;
  if (now % figures_.cycle == 0) established.take(burns_ ? 1.0 : 0.0, now);
}

void SimTorch::stream(StateStream& state) {
  for (SimOutput* output : {&gas, &arc, &wire}) output->stream(state);
  established.stream_reading(state);
  state(waited_);
  state(missing_);
  state(burns_);
  state(last_);
  std::int64_t body = spot_.body;
  state(body);
  spot_.body = static_cast<int>(body);
  state.vector(spot_.p_B);
  state(spot_.distance);
  for (bool* level : {&spot_.burns, &spot_.gas, &spot_.wire}) state(*level);
}

}  // namespace takt::sim
