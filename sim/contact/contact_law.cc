#include "sim/contact/contact_law.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <variant>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/contact/rest.h"

namespace takt::sim {
namespace {

/// Stiffness along a surface over that normal to it: 2 (1 - nu) / (2 - nu) for nu = 0.3.
/// Source: R. D. Mindlin, "Compliance of elastic bodies in contact", J. Appl. Mech. 16 (1949).
constexpr double kTangentialShare = 0.8;
/// While it slides, a contact's friction is a known force and needs no inertia of its own; this share of the mass in
/// contact keeps the equations regular. 64 points add a tenth of a thousandth; parts that are too light for the step
/// (screws of a few grams) need more.
constexpr double kSlidingMass = 1e-6;
constexpr double kLightSlidingMass = 0.01;
/// A point that friction brings to rest within so many steps is slowed down and never turned round.
constexpr double kStopSteps = 2.0;
/// The cone of a point is so much wider: the law limits the force itself, and the cone is only there for surfaces that
/// part within the step.
constexpr double kWideCone = 10.0;
/// Share of the spring's force that dampers may have in the load of a contact whose load is known before the step.
constexpr double kSteadyShare = 0.5;
/// Points of a contact that has a patch to share: with fewer, its limit is that of a point.
constexpr int kFewestShared = 3;
/// Inertia that the step adds over the mass in contact: the load of a lighter part is not known before the step.
constexpr double kHeaviestStep = 300.0;
/// Likewise, of a part that stands on shapes with a point or two each.
constexpr double kFeetStep = 10.0;
/// kg: lighter parts are damped well enough by their materials.
constexpr double kHeavy = 0.5;
/// rad of the period on the springs: a blow is over after half of one. What touches for longer lies there.
constexpr double kBlow = 3.2;
/// Ratio, of what lies. With less, a cube of 50 kg leans so far back and forth at 95 % of the limit that it slips.
constexpr double kLyingDamping = 2.0;
constexpr double kSharesRate = 1.0;
constexpr double kSharesTime = 0.2;        // s
constexpr std::size_t kMostPoints = 1024;  // of two shapes
constexpr double kLeastFriction = 1e-5;    // MuJoCo divides by it
constexpr double kLeastLever = 1e-5;       // m, likewise
// Of the spring against rolling: what an explicit step carries.
constexpr double kRollingStiffness = 0.1;  // of inertia over step squared
constexpr double kRollingDamping = 0.3;    // of inertia over step
constexpr double kLeastDeviation = 1e-10;  // m^2: points nearer than 10 um to each other cannot tell a twist

using MatrixMap = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
using VectorMap = Eigen::Map<const Eigen::Vector3d>;

constexpr int kFirstGeom = 32;             // where the first geom's number is in Memory::shapes
constexpr std::int64_t kGeoms = 0xffffff;  // numbers of geoms; above the first one's is that of the spring

std::int64_t shapes_of(const mjContact& contact) {
  return (static_cast<std::int64_t>(contact.geom[0]) << kFirstGeom) | static_cast<std::uint32_t>(contact.geom[1]);
}

/// Those of one spring of two shapes; `group` is below 128 (Solids::group).
std::int64_t spring_of(const mjContact& contact, int group) {
  return shapes_of(contact) | (static_cast<std::int64_t>(group) << 56);
}

/// The balls of a lip, which touch all at once.
std::size_t points_of_lip(const kinematics::Link& link) {
  const auto balls = std::ranges::count_if(link.collisions, [](const kinematics::Geometry& geometry) {
    return std::holds_alternative<kinematics::Sphere>(geometry.shape);
  });
  return balls > 1 ? static_cast<std::size_t>(balls) : 0;
}

bool matches(const ContactRule& rule, const ContactParameters& a, const ContactParameters& b) {
  const auto& [first, second] = rule.between;
  return (first == a.material && second == b.material) || (first == b.material && second == a.material);
}

}  // namespace

ContactPair combine(const ContactParameters& a, const ContactParameters& b, std::span<const ContactRule> rules) {
  ContactPair pair;
  if (a.own_stiffness || b.own_stiffness) {
    const bool first = a.own_stiffness && !(b.own_stiffness && b.stiffness < a.stiffness);
    pair.stiffness = first ? a.stiffness : b.stiffness;
    pair.damping = first ? a.damping : b.damping;
  } else {
    pair.stiffness = 1.0 / (1.0 / a.stiffness + 1.0 / b.stiffness);
    for (const ContactParameters* side : {&a, &b}) {
      const double share = pair.stiffness / side->stiffness;  // of the deflection
      pair.damping += side->damping * share * share;
    }
  }
  pair.friction = std::max(a.friction, b.friction);
  pair.torsion = std::max(a.torsion, b.torsion);
  pair.rolling = std::max(a.rolling, b.rolling);
  double oiled = std::max(a.oiled_friction, b.oiled_friction);
  for (const ContactRule& rule : rules) {
    if (!matches(rule, a, b)) continue;
    oiled = rule.oiled_friction.value_or(oiled);
    if (!a.own_stiffness && !b.own_stiffness) {
      pair.stiffness = rule.stiffness.value_or(pair.stiffness);
      pair.damping = rule.damping.value_or(pair.damping);
    }
    const auto follows = [](const ContactParameters& side) { return !side.own_friction || side.by_rules; };
    if (follows(a) && follows(b)) pair.friction = rule.friction.value_or(pair.friction);
  }
  if (a.oiled || b.oiled) pair.friction = std::min(pair.friction, oiled);
  return pair;
}

/// The contact points of two shapes in one step. Friction is of all of them together: they carry it by their shares of
/// the load, so that all reach their limits at once.
struct ContactLaw::Patch {
  const ContactPair* pair = nullptr;
  double stiffness = 0.0, damping = 0.0;  ///< of one point, normal
  double normal_damping = 0.0;            ///< of one point, with what the step adds
  double mass = 0.0;                      ///< kg, that the two bodies have against each other, about; a share of it
  double load = 0.0;                      ///< N, normal, of all points
  double friction_limit = 0.0;            ///< N, of all points
  double torsion = 0.0;                   ///< m
  double least = 0.0;                     ///< kg, that a sliding point adds
  bool steady = false;                    ///< most of the load is that of springs: it changes little in the step
  Eigen::Vector3d centre, normal;         ///< of the pressure, in the world
  Eigen::Vector3d stretch;                ///< m, in the world
  double twist = 0.0;                     ///< rad
  // Along the surface, of all points; damping and inertia with what the step adds.
  double along_stiffness = 0.0, along_damping = 0.0, along_inertia = 0.0;
};

ContactLaw::ContactLaw(const mjModel& model, const WorldDescription& description)
    : surface_of_(static_cast<std::size_t>(model.ngeom), 0) {
  std::vector<ContactParameters> known{ContactParameters{}};
  const auto number_of = [&](const ContactParameters& surface) {
    auto found = std::ranges::find(known, surface);
    if (found == known.end()) found = known.insert(known.end(), surface);
    return static_cast<int>(found - known.begin());
  };
  const auto set = [&](const std::string& body, int surface) {
    const int id = mj_name2id(&model, mjOBJ_BODY, body.c_str());
    if (id < 0) return;
    for (int i = 0; i < model.body_geomnum[id]; ++i)
      surface_of_[static_cast<std::size_t>(model.body_geomadr[id] + i)] = surface;
  };
  std::size_t memories = 8;
  for (const RobotDescription& robot : description.robots) {
    for (const auto& link : robot.model->links) {
      set(robot.name + "/" + link.name, number_of(robot.surface(link.name)));
      memories += points_of_lip(link);
    }
  }
  for (const ObjectDescription& object : description.objects) {
    set(object.name, number_of(object.contact));
    if (object.free) memories += 4 * object.shapes.size();
    for (const ObjectGeometry& part : object.shapes) memories += 6 * part.bores.size();
  }
  memories += 6 * description.grippers.size();
  surfaces_ = known.size();
  for (const auto& a : known) {
    for (const auto& b : known) pairs_.push_back(combine(a, b, description.contact_rules));
  }
  loads_.reserve(kMostPoints);
  before_.resize(memories);
  after_.resize(memories);
  for (int body = 0; body < static_cast<int>(model.nbody); ++body) {
    const int root = model.body_weldid[body];
    const bool free = root > 0 && model.body_dofnum[root] == 6 && model.tree_dofnum[model.body_treeid[root]] == 6;
    moved_.push_back(root != 0 && !free);
  }
  add_springs(model, description);
}

void ContactLaw::add_springs(const mjModel& model, const WorldDescription& description) {
  for (const RobotDescription& robot : description.robots) {
    for (const JointFigures& figures : robot.joints) {
      if (!figures.spring) continue;
      const std::string name = robot.name + "/" + figures.joint;
      const int joint = mj_name2id(&model, mjOBJ_JOINT, name.c_str());
      const double mobility = model.dof_invweight0[model.jnt_dofadr[joint]];
      springs_.push_back(
          {mj_name2id(&model, mjOBJ_EQUALITY, name.c_str()), *figures.spring, 1.0 / std::max(mjMINVAL, mobility)});
    }
  }
}

/// The equation of a contact's normal direction, on both sides.
void ContactLaw::set_springs(mjData& data) const {
  const double h = timestep_;
  for (int row = 0; row < data.ne; ++row) {
    const auto spring = std::ranges::find(springs_, data.efc_id[row], &Spring::equality);
    if (data.efc_type[row] != mjCNSTR_EQUALITY || spring == springs_.end()) continue;
    const auto& [stiffness, damping, preload] = spring->figures;
    const double inertia = h * (h * stiffness + damping);
    const double share = inertia / (inertia + spring->mass);
    const double force =
        -stiffness * data.efc_pos[row] - preload - (damping + share * h * stiffness) * data.efc_vel[row];
    data.efc_R[row] = 1.0 / inertia;
    data.efc_D[row] = inertia;
    data.efc_aref[row] = force / inertia;
  }
}

const ContactPair& ContactLaw::pair(int first, int second) const {
  const auto a = static_cast<std::size_t>(surface_of_[static_cast<std::size_t>(first)]);
  const auto b = static_cast<std::size_t>(surface_of_[static_cast<std::size_t>(second)]);
  return pairs_[a * surfaces_ + b];
}

const ContactLaw::Memory* ContactLaw::remembered(std::int64_t shapes) const {
  for (const Memory& memory : before_) {
    if (memory.shapes == shapes) return &memory;
    if (memory.shapes < 0) break;  // those that are used come first
  }
  return nullptr;
}

void ContactLaw::store(const Memory& memory) {
  if (used_ < after_.size())
    after_[used_++] = memory;
  else
    ++forgotten_;
}

void ContactLaw::prepare(const mjModel& model, mjData& data, const Solids& solids) {
  used_ = 0;
  timestep_ = model.opt.timestep;
  if (!springs_.empty()) set_springs(data);
  // The contact points of two shapes follow each other, and among them those that share a spring.
  int pair_end = 0;
  for (int begin = 0, end = 0; begin < data.ncon; begin = end) {
    const int group = solids.group(begin);
    const auto belongs = [&](int i) {
      return shapes_of(data.contact[i]) == shapes_of(data.contact[begin]) && solids.group(i) == group;
    };
    for (end = begin + 1; end < data.ncon && belongs(end);) ++end;
    if (begin >= pair_end) std::tie(pair_end, patches_of_pair_) = patches_from(model, data, solids, begin);
    if (data.contact[begin].geom[0] >= 0 && data.contact[begin].geom[1] >= 0)
      set_patch(model, data, solids, begin, end);
  }
  if (data.ntree_awake < static_cast<int>(model.ntree)) keep_resting(model, data);
  std::fill(after_.begin() + static_cast<std::ptrdiff_t>(used_), after_.end(), Memory{});
  std::swap(before_, after_);
}

/// The end of the contacts of the two bodies whose first one this is, and how many patches they are.
std::pair<int, int> ContactLaw::patches_from(const mjModel& model, const mjData& data, const Solids& solids,
                                             int begin) const {
  const auto bodies = [&](int i) {
    const auto body = [&](int geom) { return geom < 0 ? -1 : model.geom_bodyid[geom]; };
    return std::pair(body(data.contact[i].geom[0]), body(data.contact[i].geom[1]));
  };
  int end = begin + 1, patches = 1;
  for (; end < data.ncon && bodies(end) == bodies(begin); ++end) {
    const bool other =
        shapes_of(data.contact[end]) != shapes_of(data.contact[end - 1]) || solids.group(end) != solids.group(end - 1);
    patches += other ? 1 : 0;
  }
  return {end, patches};
}

/// What sleeps has no contacts, and its friction stays as it is.
void ContactLaw::keep_resting(const mjModel& model, const mjData& data) {
  for (const Memory& memory : before_) {
    if (memory.shapes < 0) break;
    const auto body = [&](int shift) { return model.geom_bodyid[(memory.shapes >> shift) & kGeoms]; };
    if (Rest::both_rest(model, data, body(kFirstGeom), body(0))) store(memory);
  }
}

/// What the points have together along the surface, and what the step adds to it.
void ContactLaw::set_along(Patch& patch, double stiffness, double damping) const {
  const double h = timestep_;
  const double inertia = h * (h * stiffness + damping), share = inertia / (inertia + patch.mass);
  patch.along_stiffness = kTangentialShare * stiffness;
  patch.along_damping = kTangentialShare * (damping + share * h * stiffness);
  patch.along_inertia = kTangentialShare * inertia * (1.0 + 2.0 * share);
}

/// Nothing that is driven, or hangs on what is, takes part.
bool ContactLaw::lies_free(int body, int other) const {
  return !moved_[static_cast<std::size_t>(body)] && !moved_[static_cast<std::size_t>(other)];
}

void ContactLaw::set_patch(const mjModel& model, mjData& data, const Solids& solids, int begin, int end) {
  const int group = solids.group(begin);
  double depth = 0.0, squares = 0.0, whole = 0.0;
  int points = 0;
  const auto depth_of = [&](const mjContact& contact) {
    return std::max(0.0, data.efc_margin[contact.efc_address] - data.efc_pos[contact.efc_address]);
  };
  for (int i = begin; i < end; ++i) {
    if (data.contact[i].efc_address < 0) continue;
    const double own = depth_of(data.contact[i]);
    depth += own;
    squares += own * own;
    whole += solids.weight(i);
    ++points;
  }
  if (points == 0) return;
  const mjContact& first = data.contact[begin];
  const double h = timestep_;
  Memory memory{.shapes = spring_of(first, group)};
  const Memory* old = remembered(memory.shapes);
  // A part that rocks would gain energy if its springs followed the shares of the points at once.
  const double shares_now = squares > 0.0 ? depth * depth / squares : points;
  const double before = old != nullptr ? old->shares : shares_now;
  const double fewer = (kSharesRate + (before - shares_now) / kSharesTime) * h;
  const double shares = std::max(shares_now, before - fewer);
  memory.shares = shares;
  Patch patch;
  patch.pair = &pair(first.geom[0], first.geom[1]);
  patch.torsion = patch.pair->torsion;
  const int body = model.body_weldid[model.geom_bodyid[first.geom[0]]];
  const int other = model.body_weldid[model.geom_bodyid[first.geom[1]]];
  const double mass = 1.0 / std::max(mjMINVAL, model.body_invweight0[2 * body] + model.body_invweight0[2 * other]);
  patch.mass = mass;
  const double stiffness = (whole > 0.0 ? whole : 1.0) * patch.pair->stiffness;
  const double damping = (whole > 0.0 ? whole : 1.0) * patch.pair->damping;
  set_along(patch, stiffness, damping);
  const bool light = patch.along_inertia > kHeaviestStep * mass;
  const bool heavy = mass > kHeavy && lies_free(body, other);
  const bool feet = heavy && patches_of_pair_ >= kFewestShared && patch.along_inertia < kFeetStep * mass;
  const bool shared = (points >= kFewestShared || feet) && !light;
  patch.least = (light ? kLightSlidingMass : kSlidingMass) * mass;
  if (shared) patch.mass = mass / patches_of_pair_;
  // What touches at the start of the world lies there.
  const double phase = old != nullptr ? old->phase : data.time > 0.0 ? 0.0 : 2.0 * kBlow;
  memory.phase = heavy ? std::min(phase + std::sqrt(stiffness / patch.mass) * h, 2.0 * kBlow) : 0.0;
  double normal = patch.pair->damping;
  if (heavy && shared) {
    // No damper along the surface stops more than there is in a step.
    const double along = 2.0 * kLyingDamping * std::sqrt(stiffness * patch.mass / kTangentialShare);
    set_along(patch, stiffness, std::max(damping, std::min(along, patch.mass / h)));
    const double lies = std::clamp(phase / kBlow - 1.0, 0.0, 1.0);
    normal = std::max(normal, lies * 2.0 * kLyingDamping * std::sqrt(stiffness * patch.mass));
  } else if (shared) {
    set_along(patch, stiffness, damping);
  }
  // What one point has of the stiffness.
  const auto scale_to = [&](int i) {
    const double own = solids.weight(i);
    const double share = own > 0.0 ? 1.0 / own : shares;
    patch.stiffness = patch.pair->stiffness / share;
    patch.damping = normal / share;
    const double added = h * (h * patch.stiffness + patch.damping);
    patch.normal_damping = patch.damping + added / (added + patch.mass) * h * patch.stiffness;
  };
  loads_.clear();
  double springs = 0.0;
  for (int i = begin; i < end; ++i) {
    const int row = data.contact[i].efc_address;
    double force = 0.0;
    if (row >= 0) {
      scale_to(i);
      const double spring = -patch.stiffness * (data.efc_pos[row] - data.efc_margin[row]);
      // Where the step adds much to a small mass, most of what dampers would do does not come about in it.
      const double added = shared ? h * (h * patch.stiffness + patch.damping) * points : 0.0;
      force = spring - patch.normal_damping * data.efc_vel[row] * patch.mass / (patch.mass + added);
      springs += spring;
    }
    loads_.push_back(force);
    patch.load += std::max(0.0, force);
  }
  patch.friction_limit = patch.pair->friction * patch.load;
  patch.steady = shared && std::abs(patch.load - springs) <= kSteadyShare * springs;

  patch.centre = patch.normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  const auto share_of = [&](int i) {
    return patch.load > 0.0 ? std::max(0.0, loads_[static_cast<std::size_t>(i - begin)]) / patch.load : 0.0;
  };
  const auto weight = [&](int i) { return patch.load > 0.0 ? share_of(i) : 1.0 / points; };
  const auto tangential = [&](const mjContact& contact) -> Eigen::Vector3d {
    if (contact.dim == 1) return Eigen::Vector3d::Zero();
    const double* v = data.efc_vel + contact.efc_address;
    return v[1] * VectorMap(contact.frame + 3) + v[2] * VectorMap(contact.frame + 6);
  };
  for (int i = begin; i < end; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0) continue;
    patch.centre += weight(i) * VectorMap(contact.pos);
    patch.normal += weight(i) * VectorMap(contact.frame);
    velocity += weight(i) * tangential(contact);
  }
  if (patch.normal.norm() > 1e-9) patch.normal.normalize();
  double deviation = 0.0, moment = 0.0;
  for (int i = begin; i < end; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0) continue;
    const Eigen::Vector3d arm = patch.normal.cross(VectorMap(contact.pos) - patch.centre);
    deviation += weight(i) * arm.squaredNorm();
    moment += weight(i) * arm.dot(tangential(contact));
  }
  double spin = deviation > kLeastDeviation ? moment / deviation : 0.0;
  if (deviation <= kLeastDeviation && first.dim > 3) spin = data.efc_vel[first.efc_address + 3];

  // Friction's spring moves with the surfaces.
  const int body1 = model.geom_bodyid[first.geom[0]], body2 = model.geom_bodyid[first.geom[1]];
  const MatrixMap R(data.xmat + 9 * body1), second(data.xmat + 9 * body2);
  const std::array<Eigen::Vector3d, 2> centre{R.transpose() * (patch.centre - VectorMap(data.xpos + 3 * body1)),
                                              second.transpose() * (patch.centre - VectorMap(data.xpos + 3 * body2))};
  patch.stretch = h * velocity;
  patch.twist = h * spin;
  if (old != nullptr) {
    patch.stretch += R * old->stretch;
    // What the twist stretches at the old centre is not what it stretches at the new one. Of two that slide on each
    // other, the pressure goes with one.
    if (deviation > kLeastDeviation) {
      const std::array<Eigen::Vector3d, 2> way{centre[0] - old->centre[0], centre[1] - old->centre[1]};
      const bool first_moves_less = way[0].squaredNorm() < way[1].squaredNorm();
      patch.stretch += old->twist * patch.normal.cross(first_moves_less ? Eigen::Vector3d(R * way[0])
                                                                        : Eigen::Vector3d(second * way[1]));
    }
    patch.twist += old->twist;
  }
  patch.stretch -= patch.normal * patch.normal.dot(patch.stretch);
  for (int i = begin; i < end; ++i) {
    if (data.contact[i].efc_address < 0) continue;
    scale_to(i);
    set_rows(model, data, patch, data.contact[i], share_of(i));
  }
  if (patch.pair->rolling > 0.0 && first.dim == 6) resist_rolling(model, data, patch, first, old, memory);
  // It is never stretched farther than friction can hold.
  const double longest = patch.friction_limit / patch.along_stiffness;
  if (const double length = patch.stretch.norm(); length > longest) patch.stretch *= longest / length;
  const double radius = std::max(std::sqrt(deviation), std::max(patch.torsion, 1e-6));
  patch.twist = std::clamp(patch.twist, -longest / radius, longest / radius);
  memory.stretch = R.transpose() * patch.stretch;
  memory.twist = patch.twist;
  memory.centre = centre;
  store(memory);
}

/// @param share  of this point in the load of all, 0 to 1
void ContactLaw::set_rows(const mjModel& model, mjData& data, const Patch& patch, mjContact& contact,
                          double share) const {
  const double h = timestep_;
  const int row = contact.efc_address;
  const auto set = [&](int i, double inertia, double force) {
    data.efc_R[row + i] = 1.0 / inertia;
    data.efc_D[row + i] = inertia;
    data.efc_aref[row + i] = force / inertia;
  };
  set(0, h * (h * patch.stiffness + patch.damping),
      -patch.stiffness * (data.efc_pos[row] - data.efc_margin[row]) - patch.normal_damping * data.efc_vel[row]);
  if (contact.dim == 1) return;

  const double friction = std::max(patch.pair->friction, kLeastFriction);
  const double limit = share * friction * patch.load;
  const double k = share * patch.along_stiffness, b = share * patch.along_damping;
  const VectorMap t1(contact.frame + 3), t2(contact.frame + 6);
  const Eigen::Vector2d velocity(data.efc_vel[row + 1], data.efc_vel[row + 2]);
  const Eigen::Vector3d stretch =
      patch.stretch + patch.twist * patch.normal.cross(VectorMap(contact.pos) - patch.centre);
  Eigen::Vector2d force = -k * Eigen::Vector2d(t1.dot(stretch), t2.dot(stretch)) - b * velocity;

  // A spring holds what needs less than the limit. What needs more slides: its force is known then, and needs no
  // inertia of its own but shortly before it comes to rest. The limit is one of all points, so their own cones are
  // wide. In an impact the load is not known before the step: there, what friction cannot bring to rest in it slides.
  const double speed = velocity.norm(), held = force.norm();
  const double least = patch.least, stops = h * patch.friction_limit;
  const bool beyond = held > limit || limit <= 0.0;
  const bool fast = speed * patch.mass > stops;
  const bool slides = patch.steady ? beyond && fast && speed * patch.mass > kStopSteps * stops &&
                                         speed > kStopSteps * stops * mobility(model, data, contact, velocity / speed)
                                   : fast;
  const double cone = patch.steady || slides ? kWideCone : 1.0;
  double inertia = std::max(least, share * patch.along_inertia);
  if (slides && patch.steady) {
    force = -limit / speed * velocity;
    inertia = least;
  } else if (beyond) {
    force *= held > 0.0 ? limit / held : 0.0;
  }
  const bool stopping = patch.steady ? beyond && !slides : slides;
  if (stopping && speed * inertia > h * limit) inertia = std::max(least, h * limit / speed);
  set(1, inertia, force[0]);
  set(2, inertia, force[1]);
  contact.friction[0] = contact.friction[1] = cone * friction;
  for (int i = 3; i < contact.dim; ++i) {
    // A lever: as stiff as the surface at the radius at which friction would give this torque. Rolling has its own.
    const double radius = i == 3 ? std::max(patch.torsion, kLeastLever) : kLeastLever;
    const double torque = i == 3 ? -(k * patch.twist + b * data.efc_vel[row + i]) * radius * radius : 0.0;
    set(i, inertia * radius * radius, std::clamp(torque, -radius * limit, radius * limit));
    contact.friction[i - 1] = cone * friction * radius;
  }
  contact.mu = contact.friction[0] * std::sqrt(data.efc_R[row + 1] / data.efc_R[row]);
}

/// A torque against rolling, of a spring that gives no more than it holds. It is explicit: what it is stretched by
/// moves a body by micrometres.
void ContactLaw::resist_rolling(const mjModel& model, mjData& data, const Patch& patch, const mjContact& contact,
                                const Memory* old, Memory& memory) const {
  const double h = timestep_;
  const int body = model.geom_bodyid[contact.geom[0]], other = model.geom_bodyid[contact.geom[1]];
  const auto mobility_of = [&](int one) { return model.body_invweight0[2 * model.body_weldid[one] + 1]; };
  const double inertia = 1.0 / std::max(mjMINVAL, mobility_of(body) + mobility_of(other));
  const double stiffness = kRollingStiffness * inertia / (h * h), damping = kRollingDamping * inertia / h;
  const double limit = patch.pair->rolling * patch.load;
  const VectorMap t1(contact.frame + 3), t2(contact.frame + 6);
  const double* rate = data.efc_vel + contact.efc_address;
  const Eigen::Vector3d spin = rate[4] * t1 + rate[5] * t2;
  const MatrixMap R(data.xmat + 9 * body);
  Eigen::Vector3d roll = h * spin;
  if (old != nullptr) roll += R * old->roll;
  roll -= patch.normal * patch.normal.dot(roll);
  if (const double length = roll.norm(); length * stiffness > limit) roll *= limit / (length * stiffness);
  memory.roll = R.transpose() * roll;
  Eigen::Vector3d torque = stiffness * roll + damping * spin;
  if (const double size = torque.norm(); size > limit) torque *= limit / size;
  // MuJoCo takes its bias off the other forces.
  const Eigen::Vector3d none = Eigen::Vector3d::Zero(), opposite = -torque;
  mj_applyFT(&model, &data, none.data(), torque.data(), contact.pos, other, data.qfrc_bias);
  mj_applyFT(&model, &data, none.data(), opposite.data(), contact.pos, body, data.qfrc_bias);
}

/// How fast a unit impulse along the surface makes the two points of a contact, 1/kg: those of free bodies exactly, as
/// they turn; of others as at the middle of their bodies.
double ContactLaw::mobility(const mjModel& model, const mjData& data, const mjContact& contact,
                            const Eigen::Vector2d& direction) const {
  const Eigen::Vector3d along =
      direction[0] * VectorMap(contact.frame + 3) + direction[1] * VectorMap(contact.frame + 6);
  double sum = 0.0;
  for (const int geom : contact.geom) {
    const int body = model.body_weldid[model.geom_bodyid[geom]];
    sum += model.body_invweight0[2 * body];
    if (model.body_dofnum[body] != 6 || !(model.body_mass[body] > 0.0)) continue;
    const Eigen::Vector3d arm = VectorMap(contact.pos) - VectorMap(data.xipos + 3 * body);
    const Eigen::Vector3d turn = MatrixMap(data.ximat + 9 * body).transpose() * arm.cross(along);
    for (int i = 0; i < 3; ++i) sum += turn[i] * turn[i] / std::max(mjMINVAL, model.body_inertia[3 * body + i]);
  }
  return sum;
}

void ContactLaw::stream(StateStream& state) {
  for (Memory& memory : before_) {
    state(memory.shapes);
    state.vector(memory.stretch);
    state(memory.twist);
    for (Eigen::Vector3d& centre : memory.centre) state.vector(centre);
    state.vector(memory.roll);
    state(memory.shares);
    state(memory.phase);
  }
}

}  // namespace takt::sim
