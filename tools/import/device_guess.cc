#include "tools/import/device_guess.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/joint_range.h"
#include "core/kinematics/posture.h"
#include "core/kinematics/solutions.h"

namespace takt::tools {
namespace {

using kinematics::Chain;
using kinematics::InverseKinematics;
using kinematics::JointVector;
using Json = nlohmann::ordered_json;

/// Of the arm's mass: enough for a gripper, and less than makers give (LWR 4+ 0.44, UR5 0.27, TX90 0.18).
constexpr double kPayloadShare = 0.1;
const Eigen::Vector3d kGravity(0.0, 0.0, -9.81);
constexpr int kPostures = 500;
constexpr double kMostAcceleration = 4.0;  // rad/s^2 or m/s^2
constexpr double kLeastAcceleration = 0.2;
constexpr double kArmature = 0.1;              // kg m^2
constexpr double kJerkPerAcceleration = 20.0;  // 1/s: full acceleration after 50 ms

double rounded(double value) {
  if (!(value > 0.0)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::round(value / unit) * unit;
}

JointVector random_posture(const Chain& chain, Random& random) {
  JointVector q(chain.joint_count());
  for (int i = 0; i < q.size(); ++i) {
    const kinematics::OneTurn turn = kinematics::one_turn(chain, i);
    q[i] = random.uniform(turn.low, turn.high);
  }
  return q;
}

/// Largest holding torque and inertia of each joint over many postures.
struct Loads {
  JointVector holding, inertia;
};

Loads loads_of(const Chain& chain) {
  const int n = chain.joint_count();
  Loads loads{JointVector::Zero(n), JointVector::Zero(n)};
  Random random(1, "loads");
  const JointVector rest = JointVector::Zero(n);
  for (int k = 0; k < kPostures; ++k) {
    const JointVector q = random_posture(chain, random);
    loads.holding = loads.holding.cwiseMax(chain.inverse_dynamics(q, rest, rest, kGravity).cwiseAbs());
    loads.inertia = loads.inertia.cwiseMax(JointVector(chain.mass_matrix(q).diagonal()));
  }
  return loads;
}

/// A pose near another one: moved by the vector (m, axes of the base) and turned about an axis of the flange (rad).
struct Excursion {
  Eigen::Vector3d by = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double angle = 0.0;
};

/// What an arm should be able to do from home: a hand's width and a good turn to all sides, and raising the hand until
/// it points ahead, also a little to the left and right.
std::vector<Excursion> excursions(double reach) {
  const double size = std::min(1.0, reach);
  std::vector<Excursion> list;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      list.push_back({0.12 * size * side * Eigen::Vector3d::Unit(axis)});
      list.push_back({Eigen::Vector3d::Zero(), Eigen::Vector3d::Unit(axis), 0.7 * side});
    }
  }
  for (const double side : {-1.0, 0.0, 1.0}) {
    list.push_back({size * Eigen::Vector3d(-0.05, 0.1 * side, 0.22), Eigen::Vector3d::UnitY(), -1.05});
  }
  return list;
}

/// The least of measure and distance to limits on the way to one of them, step by step on the same branch; 0 where it
/// is out of reach.
double room_on(const Excursion& excursion, const Chain& chain, const InverseKinematics& inverse,
               const JointVector& home) {
  constexpr int kSteps = 5;
  const Eigen::Isometry3d X = chain.forward(home);
  double least = 1.0;
  JointVector q = home;
  for (int step = 1; step <= kSteps; ++step) {
    const double share = static_cast<double>(step) / kSteps;
    Eigen::Isometry3d goal = X;
    goal.translation() += share * excursion.by;
    goal.linear() = X.linear() * Eigen::AngleAxisd(share * excursion.angle, excursion.axis);
    if (inverse.solve(goal, inverse.held(home), q) != kinematics::IkStatus::kOk) return 0.0;
    least = std::min({least, inverse.singularity_measure(q), 0.3 * kinematics::limit_distance(chain, q)});
    if (least <= 0.0) return 0.0;
  }
  return least;
}

/// How much room a posture leaves: the number of excursions that it can make with some room, then the least room. Work
/// ends where it cannot come to `wanted` any more.
double room(const Chain& chain, const InverseKinematics& inverse, const JointVector& home, double wanted) {
  constexpr double kEnough = 0.02;
  double least = std::min(inverse.singularity_measure(home), 0.3 * kinematics::limit_distance(chain, home));
  if (least < kEnough) return least;
  double made = 0.0;
  const std::vector<Excursion> all = excursions(chain.reach());
  double left = static_cast<double>(all.size());
  for (const Excursion& excursion : all) {
    if (made + left + 1.0 < wanted) break;
    left -= 1.0;
    const double here = room_on(excursion, chain, inverse, home);
    if (here < kEnough) continue;
    made += 1.0;
    least = std::min(least, here);
  }
  return made + least;
}

/// Elbow up where the geometry has a name for it, and nothing of the arm below its base: it stands on something.
bool stands_free(const kinematics::RobotModel& robot, const Chain& chain, const JointVector& q) {
  if (kinematics::posture(chain, q).elbow == "down") return false;
  std::map<std::string, Eigen::Isometry3d> X_B;
  X_B.emplace(robot.root().name, Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const kinematics::Joint& joint = robot.joints[i];
    Eigen::Isometry3d X = X_B.at(joint.parent) * joint.X_PJ;
    const auto found = std::ranges::find(chain.joint_names(), joint.name);
    if (found != chain.joint_names().end()) {
      const double at = q[found - chain.joint_names().begin()];
      if (joint.type == kinematics::JointType::kPrismatic) {
        X.translate(at * joint.axis);
      } else {
        X.rotate(Eigen::AngleAxisd(at, joint.axis));
      }
    }
    if (X.translation().z() < -0.02) return false;
    X_B.emplace(joint.child, X);
  }
  return true;
}

/// What costs the least reach to hold: joints that slide, from the base on (a rail, a lift), then as the elbow of a
/// seven-axis arm the third of those that turn.
std::vector<int> held_joints(const Chain& chain) {
  std::vector<int> held, turning;
  const int spare = std::max(0, chain.joint_count() - 6);
  for (int i = 0; i < chain.joint_count(); ++i) {
    if (chain.is_prismatic(i) && std::ssize(held) < spare) {
      held.push_back(i);
    } else {
      turning.push_back(i);
    }
  }
  while (std::ssize(held) < spare) {
    const std::size_t elbow = std::ssize(held) + 1 == spare ? 2 : 0;
    held.push_back(turning[elbow]);
    turning.erase(turning.begin() + static_cast<std::ptrdiff_t>(elbow));
  }
  return held;
}

Json list(const JointVector& values) {
  Json numbers = Json::array();
  for (const double value : values) numbers.push_back(std::round(value * 1e6) / 1e6 + 0.0);  // no -0
  return numbers;
}

JointVector accelerations(const Chain& chain, Draft& draft) {
  const Loads loads = loads_of(chain);
  const JointVector armature = armature_of(chain, draft);
  JointVector a(chain.joint_count());
  for (int i = 0; i < a.size(); ++i) {
    const double wanted = std::min(2.0 * chain.velocity_limit()[i], kMostAcceleration);
    const double spare = 0.8 * (chain.effort_limit()[i] - loads.holding[i]) / (loads.inertia[i] + armature[i]);
    a[i] = rounded(std::max(kLeastAcceleration, std::min(wanted, spare)));
    if (spare >= kLeastAcceleration) continue;
    draft.note(
        fmt::format("joint '{}' limit effort", chain.joint_names()[static_cast<std::size_t>(i)]),
        fmt::format("{:g}, kept", chain.effort_limit()[i]),
        fmt::format("WARNING: holding the arm takes up to {:.3g} {}: masses or torque limits of the file are wrong",
                    loads.holding[i], chain.is_prismatic(i) ? "N" : "Nm"));
  }
  return a;
}

std::string shown(const Json& value) { return value.dump(); }

}  // namespace

JointVector armature_of(const Chain& chain, const Draft& draft) {
  JointVector armature = JointVector::Constant(chain.joint_count(), kArmature);
  for (int i = 0; i < armature.size(); ++i) {
    const auto known = draft.extras.find(chain.joint_names()[static_cast<std::size_t>(i)]);
    if (known != draft.extras.end()) armature[i] = known->second.armature.value_or(kArmature);
  }
  return armature;
}

std::vector<double> guess_effort(const Chain& chain, const JointVector& armature) {
  const Loads loads = loads_of(chain);
  std::vector<double> effort;
  for (int i = 0; i < chain.joint_count(); ++i) {
    effort.push_back(rounded(10.0 + 2.0 * loads.holding[i] + 8.0 * (loads.inertia[i] + armature[i])));
  }
  return effort;
}

std::vector<Placeholder> placeholder_efforts(const Chain& chain) {
  constexpr double kPlaceholder = 1.0;  // Nm or N
  const Loads loads = loads_of(chain);
  std::vector<Placeholder> found;
  for (int i = 0; i < chain.joint_count(); ++i)
    if (chain.effort_limit()[i] <= kPlaceholder && chain.effort_limit()[i] < loads.holding[i])
      found.push_back({i, chain.effort_limit()[i], loads.holding[i]});
  return found;
}

namespace {

/// Of an arm with fewer than six joints, which cannot choose how its flange is turned: of many postures the one that
/// stands free, with the flange down and in front of the base where that can be, its x in the plane of the arm, and has
/// the most room.
JointVector home_of_few(const kinematics::RobotModel& robot, const Chain& chain, const InverseKinematics& inverse,
                        JointVector best) {
  Random random(1, "home");
  double most = 0.0;
  for (int k = 0; k < 4 * kPostures; ++k) {
    const JointVector q = k == 0 ? best : random_posture(chain, random);
    const Eigen::Isometry3d X_BF = chain.forward(q);
    const double down = std::max(0.0, -X_BF.linear()(2, 2));
    const Eigen::Vector2d across = X_BF.translation().head<2>();
    const double ahead = across.x() / std::max(across.norm(), 1e-3);
    const double straight = std::abs(X_BF.linear()(0, 0));
    const double free = stands_free(robot, chain, q) ? 100.0 : 0.0;
    const double here = room(chain, inverse, q, 0.0) + 3.0 * down + 5.0 * ahead + 5.0 * straight + free;
    if (here <= most * 1.001) continue;
    most = here;
    best = q;
  }
  return best;
}

}  // namespace

JointVector guess_home(const kinematics::RobotModel& robot, const Chain& chain) {
  JointVector best(chain.joint_count());
  for (int i = 0; i < best.size(); ++i) {
    const kinematics::OneTurn turn = kinematics::one_turn(chain, i);
    best[i] = 0.5 * (turn.low + turn.high);
  }
  const auto inverse = InverseKinematics::create(chain, held_joints(chain));
  if (!inverse) return best;
  if (chain.joint_count() < 6) return home_of_few(robot, chain, *inverse, best);
  kinematics::SolutionOptions options;
  options.turns = false;
  options.reference = best;
  if (chain.joint_count() == 7) {
    options.held_joint = held_joints(chain).front();
    options.held_values = {best[options.held_joint]};
  }
  double most = 0.0;
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  for (const double heading : {M_PI, 0.0, 0.5 * M_PI, -0.5 * M_PI}) {
    X_BF.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                    Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
    for (double x = 0.2; x <= 0.8; x += 0.06) {
      for (double z = 0.0; z <= 0.9; z += 0.06) {
        X_BF.translation() = chain.reach() * Eigen::Vector3d(x, 0.0, z);
        for (const JointVector& q : inverse_solutions(chain, X_BF, options)) {
          // Free and cramped before roomy and in the way.
          const double bonus = stands_free(robot, chain, q) ? 100.0 : 0.0;
          const double here = room(chain, *inverse, q, most - bonus) + bonus;
          // A clear gain is wanted, so that rounding does not choose.
          if (here <= most * 1.001) continue;
          most = here;
          best = q;
        }
      }
    }
  }
  return best;
}

namespace {

/// The home that the file has for all joints of the chain; nothing if it has none, or one that the joints cannot take.
std::optional<JointVector> home_of_file(const Chain& chain, Draft& draft) {
  if (draft.home.empty()) return std::nullopt;
  JointVector home(chain.joint_count());
  for (int i = 0; i < home.size(); ++i) {
    const std::string& joint = chain.joint_names()[static_cast<std::size_t>(i)];
    const auto known = draft.extras.find(joint);
    if (known == draft.extras.end() || !known->second.home) return std::nullopt;
    home[i] = *known->second.home;
    if (home[i] >= chain.lower()[i] && home[i] <= chain.upper()[i]) continue;
    draft.note(draft.home, "not used", fmt::format("joint '{}' is at {:g}, beyond its range", joint, home[i]));
    return std::nullopt;
  }
  return home;
}

std::string armature_why(const Chain& chain, const Draft& draft) {
  const auto known = std::ranges::count_if(chain.joint_names(), [&](const std::string& joint) {
    const auto found = draft.extras.find(joint);
    return found != draft.extras.end() && found->second.armature;
  });
  if (known == std::ssize(chain.joint_names())) return "of the file";
  return known > 0 ? fmt::format("of the file where it has one, else {:g}, a guess", kArmature) : "a guess";
}

}  // namespace

Json guess_device(const std::string& name, const kinematics::RobotModel& robot, const Chain& chain, Draft& draft) {
  const JointVector a = accelerations(chain, draft);
  const std::optional<JointVector> home = home_of_file(chain, draft);
  const auto n = static_cast<std::size_t>(chain.joint_count());
  Json held = Json::array();
  for (const int joint : held_joints(chain)) held.push_back(chain.joint_names()[static_cast<std::size_t>(joint)]);
  const Json limits = {{"acceleration_rad_s2", list(a)},
                       {"jerk_rad_s3", list(a * kJerkPerAcceleration)},
                       {"cartesian",
                        {{"linear_velocity_m_s", 0.5},
                         {"linear_acceleration_m_s2", 2.0},
                         {"linear_jerk_m_s3", 40.0},
                         {"angular_velocity_rad_s", 1.5},
                         {"angular_acceleration_rad_s2", 6.0},
                         {"angular_jerk_rad_s3", 120.0}}}};
  const Json gains = {{"natural_frequency_rad_s", std::vector<double>(n, 50.0)},
                      {"damping_ratio", std::vector<double>(n, 1.0)}};
  Json device = {{"kind", "arm"},
                 {"name", name},
                 {"title", draft.robot.text("name")},
                 {"urdf", name + ".urdf"},
                 {"base", draft.base},
                 {"flange", draft.flange},
                 {"home_rad", list(home ? *home : guess_home(robot, chain))},
                 {"held_joints", held},
                 {"start_tolerance_rad", 0.02},
                 {"payload_max_kg", rounded(std::max(0.5, kPayloadShare * chain.total_mass()))},
                 {"cycle_ms", 1},
                 {"limits", limits},
                 {"control", {{"modes", {"position"}}, {"mode_changes", Json::array()}, {"gains", gains}}},
                 {"armature_kg_m2", list(armature_of(chain, draft))},
                 {"sensors", {{"position", {{"resolution_rad", 1e-5}}}, {"velocity", {{"noise_sigma_rad_s", 1e-3}}}}}};
  const std::pair<const char*, std::string> guessed[] = {
      {"/home_rad", home ? draft.home : "flange down in front of the base, most room around"},
      {"/held_joints", "what an arm with more than six joints keeps still on a straight line"},
      {"/payload_max_kg", "a tenth of the arm's mass: makers give a sixth and more"},
      {"/cycle_ms", "a guess"},
      {"/limits/acceleration_rad_s2", "full speed after half a second, 4 at most, and what the torques allow"},
      {"/limits/jerk_rad_s3", "full acceleration after 50 ms"},
      {"/limits/cartesian/linear_velocity_m_s", "a guess"},
      {"/limits/cartesian/linear_acceleration_m_s2", "a guess"},
      {"/limits/cartesian/linear_jerk_m_s3", "a guess"},
      {"/limits/cartesian/angular_velocity_rad_s", "a guess"},
      {"/limits/cartesian/angular_acceleration_rad_s2", "a guess"},
      {"/limits/cartesian/angular_jerk_rad_s3", "a guess"},
      {"/control/gains/natural_frequency_rad_s", "a guess; of the simulated controller"},
      {"/control/gains/damping_ratio", "critically damped"},
      {"/armature_kg_m2", armature_why(chain, draft)},
      {"/sensors", "a guess"}};
  for (const auto& [pointer, why] : guessed) {
    draft.note(fmt::format("device.json {}", pointer), shown(device.at(Json::json_pointer(pointer))), why);
  }
  return device;
}

}  // namespace takt::tools
