#include "sim/machines/tool_changer.h"

#include <algorithm>
#include <array>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kCatch = 0.3;  ///< of the piston's way: here its balls come out, chosen

Pose pose_of_body(const mjData& data, int body) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Map<const Vector3d>(data.xpos + 3 * body);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.xmat + 9 * body);
  return X;
}

SimOutputDescription lock_wire(bool locked) {
  SimOutputDescription wire;
  wire.initial = locked ? 1.0 : 0.0;
  return wire;
}

int lock_in(const mjModel& model, const SimToolChangerDescription& changer, const SimToolSideDescription& side) {
  return mj_name2id(&model, mjOBJ_EQUALITY, lock_name(changer, side).c_str());
}

}  // namespace

std::string lock_name(const SimToolChangerDescription& changer, const SimToolSideDescription& side) {
  return changer.name + "/" + side.name;
}

SimToolChanger::SimToolChanger(const SimToolChangerDescription& description, const WorldDescription& world,
                               mjModel& model)
    : lock(lock_wire(!description.coupled.empty())),
      figures_(description),
      model_(model),
      body_(mj_name2id(&model, mjOBJ_BODY, description.body.c_str())) {
  for (const SimToolSideDescription& side : world.tool_sides) {
    if (side.size != figures_.size) continue;
    Side fits{.body = mj_name2id(&model, mjOBJ_BODY, side.body.c_str()),
              .lock = lock_in(model, figures_, side),
              .others = {},
              .number = side.number};
    for (const SimToolChangerDescription& other : world.tool_changers)
      if (other.name != figures_.name && other.size == side.size) fits.others.push_back(lock_in(model, other, side));
    if (side.name == figures_.coupled) side_ = static_cast<std::int64_t>(sides_.size());
    sides_.push_back(std::move(fits));
  }
  if (side_ != kNone) piston_ = 1.0;
}

Pose SimToolChanger::offset_of(const mjData& data, const Side& side) const {
  const Pose X_WC = pose_of_body(data, body_) * figures_.X_LC;
  return X_WC.inverse(Eigen::Isometry) * pose_of_body(data, side.body);
}

std::int64_t SimToolChanger::side_in_reach(const mjData& data) const {
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const bool taken = std::ranges::any_of(sides_[i].others, [&](int one) { return data.eq_active[one] != 0; });
    if (!taken && figures_.tolerance.holds(offset_of(data, sides_[i]))) return static_cast<std::int64_t>(i);
  }
  return kNone;
}

void SimToolChanger::move_piston(const mjData& data, double duration) {
  const double before = piston_;
  const double step = duration / figures_.lock_time;
  if (air_ && !broken_) piston_ = std::clamp(piston_ + (*lock.wire() >= 0.5 ? step : -step), 0.0, 1.0);
  if (before < kCatch && piston_ >= kCatch) {
    side_ = side_in_reach(data);
    if (side_ != kNone) X_CS_ = offset_of(data, caught());
  } else if (piston_ < kCatch) {
    side_ = kNone;
  }
  if (piston_ == 1.0) X_CS_ = Pose::Identity();  // drawn in: from here it only lets go
}

/// The pose that the lock holds goes from where the tool side was caught to the coupling face.
void SimToolChanger::draw_in() {
  const double left = (1.0 - piston_) / (1.0 - kCatch);
  const Quaterniond turn = Quaterniond::Identity().slerp(left, Quaterniond(X_CS_.linear()));
  const Pose X_LS = figures_.X_LC * Eigen::Translation3d(left * X_CS_.translation()) * turn;
  const Quaterniond r(X_LS.linear());
  const std::array<double, 4> quaternion = {r.w(), r.x(), r.y(), r.z()};
  double* data = model_.eq_data + mjNEQDATA * caught().lock;
  std::copy_n(X_LS.translation().data(), 3, data + 3);
  std::ranges::copy(quaternion, data + 6);
}

void SimToolChanger::set_locks(mjData& data) {
  for (std::size_t i = 0; i < sides_.size(); ++i)
    data.eq_active[sides_[i].lock] = static_cast<std::int64_t>(i) == side_ ? 1 : 0;
  if (side_ != kNone) draw_in();
}

void SimToolChanger::start(const mjData&) {}

void SimToolChanger::actuate(mjData& data, const Substep& step) {
  move_piston(data, step.duration);
  set_locks(data);
}

void SimToolChanger::measure(const mjData& data, Nanoseconds now) {
  if (now % figures_.period != 0) return;
  const bool holds = piston_ == 1.0 && side_ != kNone;
  locked.take(piston_ == 1.0 ? 1.0 : 0.0, now);
  unlocked.take(piston_ == 0.0 ? 1.0 : 0.0, now);
  ready_to_lock.take(side_in_reach(data) != kNone ? 1.0 : 0.0, now);
  coupled.take(holds ? 1.0 : 0.0, now);
  tool_number.take(holds ? caught().number : 0.0, now);
}

void SimToolChanger::stream(StateStream& state) {
  lock.stream(state);
  for (SimGauge* gauge : {&locked, &unlocked, &ready_to_lock, &coupled, &tool_number}) gauge->stream_reading(state);
  state(piston_);
  state(side_);
  state.vector(X_CS_.matrix());
}

void SimToolChanger::resume(mjData& data) { set_locks(data); }

}  // namespace takt::sim
