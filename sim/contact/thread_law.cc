#include "sim/contact/thread_law.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/contact/islands.h"
#include "sim/contact/spring_row.h"

namespace takt::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Stiffness of the flanks, chosen: far above what an arm or a clamp has, far below a real bolt's 1e8 N/m.
constexpr double kAxialStiffness = 2e7;  // N/m
constexpr double kSideStiffness = 5e6;   // N/m
constexpr double kDampingTime = 0.002;   // s, damping over stiffness, as that of steel
constexpr double kFrictionAngle = 0.05;  // rad, by which friction's spring gives before it slips
// When a screw is caught.
constexpr double kStartAngle = 0.05;  // rad to the right in the mouth: wobbling does not start a thread
constexpr double kOutOfMouth = 0.02;  // s out of the mouth, after which those turns no longer count
/// How far a screw may be off the axis and lean in the mouth of its thread.
struct Mouth {
  double off;   ///< pitches, of its tip
  double lean;  ///< times the lean at which a thread is crossed
};
constexpr Mouth kEnters = {.off = 0.5, .lean = 2.0};    // its turns begin to count
constexpr Mouth kRattles = {.off = 0.75, .lean = 3.0};  // and go on counting: under a bit it rattles
constexpr double kReleased = 0.1;                       // turns back beyond where it was caught
constexpr double kSeatedForce = 10.0;                   // N, pull of the thread for
constexpr double kSeatedTime = 0.02;                    // s
constexpr double kHeadUpright = 0.5;                    // cosine between the axis and what holds the head
constexpr double kCrossedRise = 10.0;                // run-down torques in a quarter turn of a crossed thread, chosen
constexpr double kFlankCosine = 0.8660254037844387;  // of half the flank angle, 30 degrees (ISO 68-1)
constexpr double kTurnOnce = 2.0 * std::numbers::pi;

using Jacobian = Eigen::Map<Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>;

Pose pose_at(const double* position, const double* matrix) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Map<const Vector3d>(position);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix);
  return X;
}

/// The lean at which half a pitch is missing on one side: the thread starts on the wrong flank.
double crossing_lean(const ThreadFigures& thread) { return std::atan(0.5 * thread.pitch / thread.major); }

}  // namespace

std::string_view name_of(ThreadEvent::Kind kind) {
  switch (kind) {
    case ThreadEvent::Kind::kCaught:
      return "caught";
    case ThreadEvent::Kind::kCrossed:
      return "crossed";
    case ThreadEvent::Kind::kSeated:
      return "seated";
    case ThreadEvent::Kind::kReleased:
      break;
  }
  return "released";
}

/// A screw seen from a bore.
struct ThreadLaw::RelativePose {
  Pose X_WB, X_BT;
  double angle = 0.0;      ///< rad, about the axis, -pi to pi
  double turn_rate = 0.0;  ///< rad/s, about the axis, against the bore

  [[nodiscard]] Vector3d tip() const { return X_BT.translation(); }
  [[nodiscard]] Vector2d lean() const { return {-X_BT.linear()(1, 2), X_BT.linear()(0, 2)}; }
};

ThreadLaw::Inertia ThreadLaw::inertia_of(const mjModel& model, int body) {
  return {.fixed = model.body_weldid[body] == 0,
          .mass = model.body_mass[body],
          .rotation = Eigen::Map<const Vector3d>(model.body_inertia + 3 * body).minCoeff()};
}

ThreadLaw::ThreadLaw(const mjModel& model, const WorldDescription& description, const Solids& solids)
    : drives_(model, description),
      jacobians_(12 * static_cast<std::size_t>(model.nv)),
      row_(static_cast<Eigen::Index>(model.nv)),
      applied_(6 * static_cast<std::size_t>(model.nbody)) {
  for (const ObjectDescription& object : description.objects) {
    const int body = mj_name2id(&model, mjOBJ_BODY, object.name.c_str());
    for (std::size_t i = 0; i < object.shapes.size(); ++i) {
      const int geom = mj_name2id(&model, mjOBJ_GEOM, solid_name(object.name, i).c_str());
      for (std::size_t k = 0; k < object.shapes[i].bores.size(); ++k) {
        const world::Bore& bore = object.shapes[i].bores[k];
        if (bore.thread.empty()) continue;
        const DrilledBore& figures = solids.find(geom)->bores[k];
        bores_.push_back({object.name, bore.thread, body, geom, figures, inertia_of(model, body)});
      }
    }
    if (!object.screw) continue;
    Screw screw;
    screw.name = object.name;
    screw.thread = object.screw->thread;
    screw.X_OT = object.screw->X_OT;
    screw.body = body;
    screw.shank = mj_name2id(&model, mjOBJ_GEOM, solid_name(object.name, object.screw->shank).c_str());
    screw.equality = mj_name2id(&model, mjOBJ_EQUALITY, object.name.c_str());
    screw.inertia = inertia_of(model, body);
    screws_.push_back(screw);
  }
}

ThreadLaw::RelativePose ThreadLaw::stand_of(const mjModel& model, const mjData& data, const Screw& screw,
                                            const ThreadedBore& bore) const {
  RelativePose stand;
  stand.X_WB = pose_at(data.geom_xpos + 3 * bore.geom, data.geom_xmat + 9 * bore.geom) * bore.figures.X_GB;
  const Pose X_WT = pose_at(data.xpos + 3 * screw.body, data.xmat + 9 * screw.body) * screw.X_OT;
  stand.X_BT = stand.X_WB.inverse(Eigen::Isometry) * X_WT;
  stand.angle = std::atan2(stand.X_BT.linear()(1, 0), stand.X_BT.linear()(0, 0));
  const auto spin = [&](int body) -> Vector3d {
    std::array<double, 6> velocity{};  // rotation first
    mj_objectVelocity(&model, &data, mjOBJ_BODY, body, velocity.data(), 0);
    return Eigen::Map<const Vector3d>(velocity.data());
  };
  stand.turn_rate = stand.X_WB.linear().col(2).dot(spin(screw.body) - spin(bore.body));
  return stand;
}

/// @param entered  it was in the mouth before
bool ThreadLaw::in_mouth(const Screw& screw, const ThreadedBore& bore, const RelativePose& stand, bool entered) {
  if (bore.size != screw.thread.size || stand.X_BT.linear()(2, 2) <= 0.0) return false;
  const Mouth& within = entered ? kRattles : kEnters;
  const Vector3d tip = stand.tip();
  const double pitch = screw.thread.pitch;
  return tip.head<2>().norm() <= within.off * pitch && tip.z() <= -bore.figures.chamfer + 0.5 * pitch &&
         tip.z() > -bore.figures.chamfer - 2.0 * pitch &&
         stand.lean().norm() <= within.lean * crossing_lean(screw.thread);
}

bool ThreadLaw::occupied(std::size_t bore) const {
  return std::ranges::any_of(screws_,
                             [&](const Screw& screw) { return screw.hold.bore == static_cast<std::int64_t>(bore); });
}

void ThreadLaw::take(std::size_t index, std::size_t bore, const RelativePose& stand, Nanoseconds now) {
  Screw& screw = screws_[index];
  screw.hold = {.bore = static_cast<std::int64_t>(bore),
                .crossed = stand.lean().norm() > crossing_lean(screw.thread),
                .seated = false,
                .angle = stand.angle,
                .begin = stand.angle,
                .height = stand.tip().z(),
                .off = stand.tip().head<2>(),
                .lean = stand.lean(),
                .twist = 0.0,
                .axial = 0.0,
                .side = 0.0,
                .pulled = 0.0};
  report(screw.hold.crossed ? ThreadEvent::Kind::kCrossed : ThreadEvent::Kind::kCaught, index, bore, now);
}

/// What MuJoCo has to know of it: the constraint's bodies; which shapes are one.
void ThreadLaw::apply(mjModel& model, mjData& data, Solids& solids, const Screw& screw) const {
  const bool held = screw.hold.bore >= 0;
  data.eq_active[screw.equality] = held ? 1 : 0;
  if (!held) return solids.part(screw.shank);
  const ThreadedBore& bore = bores_[static_cast<std::size_t>(screw.hold.bore)];
  model.eq_obj1id[screw.equality] = screw.body;
  model.eq_obj2id[screw.equality] = bore.body;
  solids.join(screw.shank, bore.geom);
}

bool ThreadLaw::watch(mjModel& model, mjData& data, Solids& solids, Nanoseconds now) {
  bool changed = drives_.watch(model, data);
  for (std::size_t i = 0; i < screws_.size(); ++i) {
    const bool other = screws_[i].hold.bore >= 0 ? update_hold(model, data, i, now) : try_engage(model, data, i, now);
    if (other) apply(model, data, solids, screws_[i]);
    changed = changed || other;
  }
  return changed;
}

/// Whether something holds it up in its thread: what lies under its head, or the bottom of the bore. A bit only pushes
/// it in.
bool ThreadLaw::rests(const mjModel& model, const mjData& data, const Screw& screw, const ThreadedBore& bore) const {
  const Vector3d out =
      (pose_at(data.geom_xpos + 3 * bore.geom, data.geom_xmat + 9 * bore.geom) * bore.figures.X_GB).linear().col(2);
  return std::ranges::any_of(std::span(data.contact, static_cast<std::size_t>(data.ncon)), [&](const auto& contact) {
    const auto is_screw = [&](int side) {
      return contact.geom[side] >= 0 && model.geom_bodyid[contact.geom[side]] == screw.body;
    };
    if (contact.efc_address < 0 || is_screw(0) == is_screw(1)) return false;
    const double along = out.dot(Eigen::Map<const Vector3d>(contact.frame));  // from the first to the second
    return (is_screw(1) ? along : -along) > kHeadUpright;
  });
}

/// Counts the turns of a screw that is held. @return true: it has been turned out
bool ThreadLaw::update_hold(const mjModel& model, const mjData& data, std::size_t index, Nanoseconds now) {
  Screw& screw = screws_[index];
  Hold& hold = screw.hold;
  const auto bore = static_cast<std::size_t>(hold.bore);
  const double angle = stand_of(model, data, screw, bores_[bore]).angle;
  hold.angle += std::remainder(angle - hold.angle, kTurnOnce);
  const bool pulls = !hold.seated && hold.axial < -kSeatedForce && rests(model, data, screw, bores_[bore]);
  hold.pulled = pulls ? hold.pulled + timestep_ : 0.0;
  if (!hold.seated && hold.pulled >= kSeatedTime) {
    hold.seated = true;
    report(ThreadEvent::Kind::kSeated, index, bore, now);
  }
  if (hold.angle - hold.begin <= kReleased * kTurnOnce) return false;
  hold = {};
  report(ThreadEvent::Kind::kReleased, index, bore, now);
  return true;
}

/// Counts how far a free screw has been turned to the right in a mouth, less what it has gone back since.
/// @return true: the thread has caught it
bool ThreadLaw::try_engage(const mjModel& model, const mjData& data, std::size_t index, Nanoseconds now) {
  Hold& hold = screws_[index].hold;
  for (std::size_t b = 0; b < bores_.size(); ++b) {
    if (bores_[b].size != screws_[index].thread.size || occupied(b)) continue;
    if (screws_[index].inertia.fixed && bores_[b].inertia.fixed) continue;
    const RelativePose stand = stand_of(model, data, screws_[index], bores_[b]);
    const auto mouth = static_cast<std::int64_t>(b);
    if (!in_mouth(screws_[index], bores_[b], stand, hold.mouth == mouth)) continue;
    hold.begun = std::max(0.0, (hold.mouth == mouth ? hold.begun : 0.0) - timestep_ * stand.turn_rate);
    hold.mouth = mouth;
    hold.outside = 0.0;
    if (hold.begun < kStartAngle) return false;
    take(index, b, stand, now);
    return true;
  }
  if (hold.mouth >= 0) hold.outside += timestep_;
  if (hold.outside >= kOutOfMouth) hold = {};
  return false;
}

double ThreadLaw::friction_limit(const Screw& screw) const {
  const ThreadFigures& thread = screw.thread;
  const Hold& hold = screw.hold;
  const double pressed = std::abs(hold.axial) / kFlankCosine + hold.side;
  const double flanks = thread.friction * pressed * 0.5 * thread.pitch_diameter;
  const double jam =
      hold.crossed ? kCrossedRise * thread.run_down * std::abs(hold.angle - hold.begin) / (0.25 * kTurnOnce) : 0.0;
  return thread.run_down + flanks + jam;
}

void ThreadLaw::set_rows(const mjModel& model, mjData& data, Screw& screw, int row) {
  const ThreadedBore& bore = bores_[static_cast<std::size_t>(screw.hold.bore)];
  const RelativePose stand = stand_of(model, data, screw, bore);
  const auto nv = static_cast<Eigen::Index>(model.nv);
  const Vector3d tip_W = stand.X_WB * stand.tip();
  const auto scratch = [&](std::size_t i) { return jacobians_.data() + 3 * i * static_cast<std::size_t>(nv); };
  mj_jac(&model, &data, scratch(0), scratch(1), tip_W.data(), screw.body);
  mj_jac(&model, &data, scratch(2), scratch(3), tip_W.data(), bore.body);
  Jacobian shift(scratch(0), 3, nv), turn(scratch(1), 3, nv);
  shift -= Jacobian(scratch(2), 3, nv);
  turn -= Jacobian(scratch(3), 3, nv);
  const Eigen::Matrix3d& R = stand.X_WB.linear();
  const double lead = screw.thread.pitch / kTurnOnce;

  // A straight screw centres itself in its first turn; a crossed one stays as it was caught.
  const Hold& hold = screw.hold;
  const double turned = hold.begin - hold.angle;
  const double stays = hold.crossed ? 1.0 : std::clamp(1.0 - turned / kTurnOnce, 0.0, 1.0);
  const Vector2d off = stand.tip().head<2>() - stays * hold.off;
  const Vector2d lean = stand.lean() - stays * hold.lean;
  const double helix = stand.tip().z() - hold.height - lead * (hold.angle - hold.begin);
  const double engaged = std::clamp(-stand.tip().z() - bore.figures.chamfer, screw.thread.pitch, bore.figures.length);
  const double lever = 0.5 * engaged;

  const auto set_row = [&](int i, const auto& jacobian) {
    row_.noalias() = jacobian;
    set_jacobian(model, data, row + i, {row_.data(), static_cast<std::size_t>(nv)});
  };
  const auto hold_at = [&](int i, double error, double stiffness, double inertia) {
    set_spring(model, data, row + i, {stiffness, kDampingTime * stiffness, inertia}, error);
  };
  for (int i = 0; i < 2; ++i) {
    set_row(i, R.col(i).transpose() * shift);
    set_row(3 + i, R.col(i).transpose() * turn);
  }
  set_row(2, R.col(2).transpose() * shift - lead * R.col(2).transpose() * turn);
  set_row(5, R.col(2).transpose() * turn);
  const auto& [fixed, mass, rotation] = screw.inertia.fixed ? bore.inertia : screw.inertia;
  const double along_helix = 1.0 / (1.0 / mass + lead * lead / rotation);
  const double upright = kSideStiffness * lever * lever;
  for (int i = 0; i < 2; ++i) {
    hold_at(i, off[i], kSideStiffness, mass);
    hold_at(3 + i, lean[i], upright, rotation);
  }
  hold_at(2, helix, kAxialStiffness, along_helix);

  // Friction: a spring that is never stretched farther than it holds. It is soft, as its row adds an inertia that goes
  // with its stiffness.
  const double h = timestep_;
  const double limit = friction_limit(screw), stiffness = limit / kFrictionAngle, damping = h * stiffness;
  set_spring(model, data, row + 5, {stiffness, damping, rotation}, 0.0);
  const double rate = data.efc_vel[row + 5];
  screw.hold.twist = std::clamp(screw.hold.twist + h * rate, -kFrictionAngle, kFrictionAngle);
  const double torque = std::clamp(-stiffness * screw.hold.twist - damping * rate, -limit, limit);
  data.efc_aref[row + 5] = torque * data.efc_R[row + 5];
}

void ThreadLaw::prepare(const mjModel& model, mjData& data) {
  for (Screw& screw : screws_) {
    const int row = screw.hold.bore >= 0 ? row_of_equality(data, screw.equality) : -1;
    if (row >= 0) set_rows(model, data, screw, row);
  }
  drives_.prepare(model, data);
}

void ThreadLaw::finish_step(mjModel& model, mjData& data) {
  timestep_ = model.opt.timestep;
  prepare(model, data);
  copy_rows_to_islands(model, data);
  mj_fwdActuation(&model, &data);
  mj_fwdAcceleration(&model, &data);
  mj_fwdConstraint(&model, &data);
  remember_forces(data);
  sense(model, data);
  mj_checkAcc(&model, &data);
  if (model.opt.integrator == mjINT_EULER) {
    mj_Euler(&model, &data);
  } else {
    mj_implicit(&model, &data);
  }
}

void ThreadLaw::remember_forces(const mjData& data) {
  for (Screw& screw : screws_) {
    const int row = screw.hold.bore >= 0 ? row_of_equality(data, screw.equality) : -1;
    if (row < 0) continue;
    screw.hold.axial = data.efc_force[row + 2];
    screw.hold.side = std::hypot(data.efc_force[row], data.efc_force[row + 1]);
  }
}

/// Sensors count what welds exert, in axes that are not those of these rows. In their place, forces are applied to the
/// bodies while the sensors are computed.
void ThreadLaw::sense(const mjModel& model, mjData& data) {
  std::copy_n(data.xfrc_applied, applied_.size(), applied_.begin());
  for (const Screw& screw : screws_) {
    const int row = screw.hold.bore >= 0 ? row_of_equality(data, screw.equality) : -1;
    if (row < 0) continue;
    const ThreadedBore& bore = bores_[static_cast<std::size_t>(screw.hold.bore)];
    const Pose X_WB = pose_at(data.geom_xpos + 3 * bore.geom, data.geom_xmat + 9 * bore.geom) * bore.figures.X_GB;
    const Vector3d tip = pose_at(data.xpos + 3 * screw.body, data.xmat + 9 * screw.body) * screw.X_OT.translation();
    const Vector3d force = Eigen::Map<const Vector3d>(data.efc_force + row);
    Vector3d torque = Eigen::Map<const Vector3d>(data.efc_force + row + 3);
    torque.z() -= screw.thread.pitch / kTurnOnce * force.z();
    take_weld(data, row, screw.body, bore.body, {X_WB.linear() * force, X_WB.linear() * torque, tip});
  }
  drives_.sense(data);
  data.flg_rnepost = 0;  // forces in joints are those of the step before
  mj_sensorAcc(&model, &data);
  std::ranges::copy(applied_, data.xfrc_applied);
}

void ThreadLaw::resume(mjModel& model, mjData& data, Solids& solids) {
  for (const Screw& screw : screws_) apply(model, data, solids, screw);
  drives_.resume(model, data);
}

void ThreadLaw::stream(StateStream& state) {
  for (Screw& screw : screws_) {
    Hold& hold = screw.hold;
    for (std::int64_t* bore : {&hold.bore, &hold.mouth}) state(*bore);
    for (bool* flag : {&hold.crossed, &hold.seated}) state(*flag);
    for (double* value : {&hold.angle, &hold.begin, &hold.height, &hold.twist, &hold.axial, &hold.side, &hold.pulled,
                          &hold.begun, &hold.outside})
      state(*value);
    state.vector(hold.off);
    state.vector(hold.lean);
  }
  drives_.stream(state);
}

std::vector<std::string> ThreadLaw::screw_names() const {
  std::vector<std::string> names;
  for (const Screw& screw : screws_) names.push_back(screw.name);
  return names;
}

ThreadEvent::Kind ThreadLaw::state_of(std::size_t screw) const {
  using Kind = ThreadEvent::Kind;
  const Hold& hold = screws_[screw].hold;
  if (hold.bore < 0) return Kind::kReleased;
  if (hold.crossed) return Kind::kCrossed;
  return hold.seated ? Kind::kSeated : Kind::kCaught;
}

double ThreadLaw::turned(std::size_t screw) const {
  const Hold& hold = screws_[screw].hold;
  return hold.bore < 0 ? 0.0 : hold.begin - hold.angle;
}

void ThreadLaw::report(ThreadEvent::Kind kind, std::size_t screw, std::size_t bore, Nanoseconds now) {
  if (event_count_ == kEvents) return;
  events_[event_count_] = {kind, now, screw, bore};
  std::atomic_ref(event_count_).store(event_count_ + 1, std::memory_order_release);
}

std::span<const ThreadEvent> ThreadLaw::events() const {
  auto& count = const_cast<std::size_t&>(event_count_);  // atomic_ref reads only objects that could be written
  return {events_.data(), std::atomic_ref(count).load(std::memory_order_acquire)};
}

}  // namespace takt::sim
