#include "tests/core/kinematics/robots.h"

#include <cstdlib>
#include <iostream>
#include <vector>

#include <fmt/format.h>

namespace takt::kinematics::test {
namespace {

struct Row {
  std::string xyz, axis;
  double range_deg_low, range_deg_high, deg_per_s, effort, mass;
};

std::string body(double mass) {
  return fmt::format(
      "<inertial><origin xyz='0.01 0.02 0.1'/><mass value='{0}'/>"
      "<inertia ixx='{1}' iyy='{2}' izz='{3}' ixy='0.0001' ixz='0' iyz='-0.0002'/></inertial>",
      mass, mass * 0.011, mass * 0.012, mass * 0.004);
}

/// A serial arm from rows: base, link_1 .. link_n, flange.
std::string arm_urdf(const std::string& name, double base_mass, const std::vector<Row>& rows,
                     const std::string& flange_origin) {
  constexpr double kDegree = EIGEN_PI / 180.0;
  std::string text =
      fmt::format("<?xml version='1.0'?>\n<robot name='{}'>\n<link name='base'>{}</link>\n", name, body(base_mass));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const std::string parent = i == 0 ? "base" : fmt::format("link_{}", i);
    text += fmt::format(
        "<link name='link_{0}'>{1}</link>\n<joint name='joint_{0}' type='revolute'>\n  <parent link='{2}'/>"
        "<child link='link_{0}'/>\n  <origin {3}/><axis xyz='{4}'/>\n"
        "  <limit lower='{5:.17g}' upper='{6:.17g}' velocity='{7:.17g}' effort='{8}'/>\n</joint>\n",
        i + 1, body(row.mass), parent, row.xyz, row.axis, row.range_deg_low * kDegree, row.range_deg_high * kDegree,
        row.deg_per_s * kDegree, row.effort);
  }
  text += fmt::format(
      "<link name='flange'/>\n<joint name='flange_joint' type='fixed'><parent link='link_{}'/>"
      "<child link='flange'/><origin {}/></joint>\n</robot>\n",
      rows.size(), flange_origin);
  return text;
}

}  // namespace

std::string lwr_urdf() {
  return arm_urdf("lwr", 3.58,
                  {{"xyz='0 0 0.3105'", "0 0 1", -170, 170, 110, 176, 2.303},
                   {"xyz='0 0 0'", "0 -1 0", -120, 120, 110, 176, 2.303},
                   {"xyz='0 0 0.4'", "0 0 1", -170, 170, 128, 100, 2.303},
                   {"xyz='0 0 0'", "0 1 0", -120, 120, 128, 100, 2.303},
                   {"xyz='0 0 0.39'", "0 0 1", -170, 170, 204, 100, 1.601},
                   {"xyz='0 0 0'", "0 -1 0", -120, 120, 184, 38, 1.493},
                   {"xyz='0 0 0'", "0 0 1", -170, 170, 184, 38, 0.114}},
                  "xyz='0 0 0.078'");
}

std::string ur5_urdf() {
  return arm_urdf("ur5", 1.35,
                  {{"xyz='0 0 0.089159'", "0 0 1", -360, 360, 180, 150, 3.7},
                   {"xyz='0 0 0' rpy='1.5707963267948966 0 0'", "0 0 1", -360, 360, 180, 150, 8.393},
                   {"xyz='-0.425 0 0'", "0 0 1", -360, 360, 180, 150, 2.33},
                   {"xyz='-0.39225 0 0.10915'", "0 0 1", -360, 360, 180, 28, 1.219},
                   {"xyz='0 -0.09465 0' rpy='1.5707963267948966 0 0'", "0 0 1", -360, 360, 180, 28, 1.219},
                   {"xyz='0 0.0823 0' rpy='-1.5707963267948966 0 0'", "0 0 1", -360, 360, 180, 28, 0.1879}},
                  "xyz='0 0 0'");
}

std::string tx90_urdf() {
  return arm_urdf("tx90", 30.0,
                  {{"xyz='0 0 0.478'", "0 0 1", -180, 180, 400, 318, 25},
                   {"xyz='0.05 0 0'", "0 1 0", -130, 147.5, 400, 166, 20},
                   {"xyz='0 0.05 0.425'", "0 1 0", -145, 145, 430, 76, 18},
                   {"xyz='0 0 0'", "0 0 1", -270, 270, 540, 34, 12},
                   {"xyz='0 0 0.425'", "0 1 0", -115, 140, 475, 29, 5},
                   {"xyz='0 0 0.1'", "0 0 1", -270, 270, 760, 11, 1}},
                  "xyz='0 0 0'");
}

namespace {

/// Rows with the same limits for all: origin and axis say it all.
std::string skeleton(const std::string& name, const std::vector<std::pair<std::string, std::string>>& joints,
                     const std::string& flange, double range_deg = 180) {
  std::vector<Row> rows;
  for (const auto& [origin, axis] : joints) rows.push_back({origin, axis, -range_deg, range_deg, 180, 100, 3.0});
  return arm_urdf(name, 5.0, rows, flange);
}

}  // namespace

std::vector<ForeignArm> foreign_arms() {
  const std::string wrist = "spherical wrist, parallel elbow";
  std::vector<ForeignArm> arms;
  // Axis 2 set off from axis 1, elbow set off too, turns clockwise positive, all frames upright.
  arms.push_back({"kr",
                  skeleton("kr",
                           {{"xyz='0 0 0.4'", "0 0 -1"},
                            {"xyz='0.025 0 0'", "0 1 0"},
                            {"xyz='0.56 0 0'", "0 1 0"},
                            {"xyz='0 0 0.035'", "-1 0 0"},
                            {"xyz='0.515 0 0'", "0 1 0"},
                            {"xyz='0.08 0 0'", "-1 0 0"}},
                           "xyz='0 0 0' rpy='0 1.5707963267948966 0'"),
                  {},
                  wrist});
  // Right angles rounded to four digits, as many files have them.
  arms.push_back({"rounded",
                  skeleton("rounded",
                           {{"xyz='0 0 0.29'", "0 0 1"},
                            {"xyz='0 0 0' rpy='-1.5708 0 0'", "0 0 1"},
                            {"xyz='0 -0.27 0'", "0 0 1"},
                            {"xyz='0.07 0 0' rpy='0 1.5708 0'", "0 0 1"},
                            {"xyz='0 0 0.302' rpy='0 -1.5708 0'", "0 0 1"},
                            {"xyz='0.072 0 0' rpy='0 1.5708 0'", "0 0 1"}},
                           "xyz='0 0 0'"),
                  {},
                  wrist});
  // A UR with its base turned, the axes of the links turned over, and a fixed turn in every link.
  arms.push_back({"cobot",
                  skeleton("cobot",
                           {{"xyz='0 0 0.1273' rpy='0 0 2.2'", "0 0 1"},
                            {"xyz='0 0.22 0' rpy='0 1.5707963267948966 0'", "0 1 0"},
                            {"xyz='0 -0.17 0.612' rpy='0 0 0'", "0 -1 0"},
                            {"xyz='0 0 0.5723' rpy='0 1.5707963267948966 0'", "0 1 0"},
                            {"xyz='0 0.114 0'", "0 0 -1"},
                            {"xyz='0 0 0.1157'", "0 1 0"}},
                           "xyz='0 0.0922 0' rpy='0 0 1.5707963267948966'", 360),
                  {},
                  "three parallel axes"});
  // A crooked regional arm before a spherical wrist.
  arms.push_back({"crooked",
                  skeleton("crooked",
                           {{"xyz='0 0 0.3'", "0 0 1"},
                            {"xyz='0.1 0 0.1' rpy='0.9 0 0'", "0 0 1"},
                            {"xyz='0.3 0.05 0' rpy='0 0.7 0.3'", "0 0 1"},
                            {"xyz='0.1 0 0.2' rpy='0 1.2 0'", "0 0 1"},
                            {"xyz='0 0 0.3' rpy='1.1 0 0'", "0 0 1"},
                            {"xyz='0 0 0' rpy='-1.2 0 0'", "0 0 1"}},
                           "xyz='0 0 0.1'"),
                  {},
                  "spherical wrist"});
  const std::vector<std::pair<std::string, std::string>> seven = {
      {"xyz='0 0 0.333'", "0 0 1"},
      {"xyz='0 0 0' rpy='-1.5707963267948966 0 0'", "0 0 1"},
      {"xyz='0 -0.316 0' rpy='1.5707963267948966 0 0'", "0 0 1"},
      {"xyz='0.0825 0 0' rpy='1.5707963267948966 0 0'", "0 0 1"},
      {"xyz='-0.0825 0.384 0' rpy='-1.5707963267948966 0 0'", "0 0 1"},
      {"xyz='0 0 0' rpy='1.5707963267948966 0 0'", "0 0 1"},
      {"xyz='0.088 0 0' rpy='1.5707963267948966 0 0'", "0 0 1"}};
  // Seven axes with a spherical shoulder and a wrist set off: closed with the last joint held, from the other end.
  arms.push_back({"offset wrist, last held",
                  skeleton("seven", seven, "xyz='0 0 0.107'"),
                  {6},
                  "spherical wrist, meeting shoulder axes",
                  true});
  arms.push_back({"offset wrist, third held", skeleton("seven", seven, "xyz='0 0 0.107'"), {2}, ""});
  // Curved wrist: neighbours meet, but not all three in a point.
  arms.push_back({"curved wrist",
                  skeleton("curved",
                           {{"xyz='0 0 0.157' rpy='3.141592653589793 0 0'", "0 0 1"},
                            {"xyz='0 0.0016 -0.119' rpy='-1.5707963267948966 0 0'", "0 0 1"},
                            {"xyz='0 -0.41 0' rpy='3.141592653589793 0 0'", "0 0 1"},
                            {"xyz='0 0.207 -0.011' rpy='-1.5707963267948966 0 0'", "0 0 1"},
                            {"xyz='0 0 -0.104' rpy='1.0471975511965976 0 0'", "0 0 1"},
                            {"xyz='0 0 -0.104' rpy='1.0471975511965976 0 0'", "0 0 1"}},
                           "xyz='0 0 -0.16' rpy='3.141592653589793 0 0'"),
                  {},
                  ""});
  return arms;
}

RobotModel model_of(const std::string& urdf) {
  auto model = RobotModel::parse(urdf, ".");
  if (model) return *std::move(model);
  std::cerr << model.error().to_string() << std::endl;
  std::abort();
}

Chain chain_of(const std::string& urdf) {
  auto chain = Chain::create(model_of(urdf), "base", "flange");
  if (chain) return *std::move(chain);
  std::cerr << chain.error().to_string() << std::endl;
  std::abort();
}

Chain lwr() { return chain_of(lwr_urdf()); }

JointVector random_vector(Random& random, int size, double bound) {
  JointVector v(size);
  for (int i = 0; i < size; ++i) v[i] = random.uniform(-bound, bound);
  return v;
}

JointVector random_q(Random& random, const Chain& chain) {
  JointVector q(chain.joint_count());
  for (int i = 0; i < q.size(); ++i)
    q[i] = random.uniform(std::max(chain.lower()[i], -3.0), std::min(chain.upper()[i], 3.0));
  for (int i = 0; i < q.size(); ++i) {
    if (std::isfinite(chain.lower()[i])) q[i] = random.uniform(chain.lower()[i], chain.upper()[i]);
  }
  return q;
}

Eigen::Isometry3d random_pose(Random& random, double bound) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const auto number = [&] { return random.uniform(-1.0, 1.0); };
  X.linear() = Eigen::Quaterniond(number(), number(), number(), number()).normalized().toRotationMatrix();
  X.translation() = bound * Eigen::Vector3d(number(), number(), number());
  return X;
}

namespace {

Inertial random_body(Random& random) {
  const Eigen::Vector3d edge(random.uniform(0.05, 0.4), random.uniform(0.05, 0.4), random.uniform(0.05, 0.4));
  Inertial body{random.uniform(0.2, 8.0), random_pose(random, 0.2), Eigen::Matrix3d::Zero()};
  const Eigen::Vector3d square = edge.cwiseAbs2() * body.mass / 12.0;
  body.I_C.diagonal() << square.y() + square.z(), square.x() + square.z(), square.x() + square.y();
  return body;
}

}  // namespace

RobotModel random_model(Random& random, int movable_joints) {
  RobotModel model;
  model.name = "random";
  model.links.push_back({"l0", random_body(random), {}, {}});
  const auto hang = [&](const std::string& parent, const std::string& child, JointType type) {
    Joint joint;
    joint.name = "j_" + child;
    joint.type = type;
    joint.parent = parent;
    joint.child = child;
    joint.X_PJ = random_pose(random, 0.5);
    joint.axis = random_pose(random, 1.0).linear().col(0);
    if (random.unit() < 0.3) joint.axis = -Eigen::Vector3d::Unit(static_cast<Eigen::Index>(random.bits() % 3));
    joint.lower = -3.0;
    joint.upper = 3.0;
    joint.velocity = joint.effort = 1.0;
    model.joints.push_back(joint);
    Link link{child, {}, {}, {}};
    if (random.unit() < 0.8) link.inertial = random_body(random);
    model.links.push_back(link);
  };
  std::string last = "l0";
  for (int i = 1; i <= movable_joints; ++i) {
    if (random.unit() < 0.3) hang(last, fmt::format("side_{}", i), JointType::kFixed);
    if (random.unit() < 0.3) {
      const std::string between = fmt::format("fixed_{}", i);
      hang(last, between, JointType::kFixed);
      last = between;
    }
    const double kind = random.unit();
    const std::string next = fmt::format("l{}", i);
    hang(last, next, kind < 0.25 ? JointType::kPrismatic : kind < 0.4 ? JointType::kContinuous : JointType::kRevolute);
    last = next;
  }
  hang(last, "flange", JointType::kFixed);
  hang("flange", "beyond", JointType::kFixed);
  return model;
}

double pose_distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  // The sine of half the angle keeps its digits near zero, unlike the trace.
  const double half_sine = (a.linear() - b.linear()).norm() / std::sqrt(8.0);
  return std::max((a.translation() - b.translation()).norm(), 2.0 * std::asin(std::min(1.0, half_sine)));
}

}  // namespace takt::kinematics::test
