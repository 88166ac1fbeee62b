#include "core/motion/path.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::motion {
namespace {

using Json = nlohmann::ordered_json;

JointSample proportional(const JointVector& start, const JointVector& goal, const PathPoint& at) {
  const JointVector way = goal - start;
  JointSample sample{.q = start + at.s * way, .dq = at.ds * way, .ddq = at.dds * way};
  if (at.s >= 1.0) sample.q = goal;
  return sample;
}

/// Axis and angle of the short turn; at half a turn the axis is made unique.
void set_rotation(const Eigen::Quaterniond& R_start, const Eigen::Quaterniond& R_goal, CartesianLine& line) {
  Eigen::Quaterniond turn = (R_goal * R_start.conjugate()).normalized();
  // Below this, the sign of w is rounding: the turn is half a turn.
  constexpr double kHalfTurn = 1e-9;
  bool flip = turn.w() < 0.0;
  if (std::abs(turn.w()) < kHalfTurn) {
    const auto& v = turn.vec();
    const double leading = std::abs(v.x()) > kHalfTurn ? v.x() : std::abs(v.y()) > kHalfTurn ? v.y() : v.z();
    flip = leading < 0.0;
  }
  if (flip) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  // A turn below this is lost in the rounding of the poses themselves.
  constexpr double kNoTurn = 1e-13;
  if (sine < kNoTurn) return;
  line.axis = turn.vec() / sine;
  line.angle = 2.0 * std::atan2(sine, turn.w());
}

Json numbers(const auto& vector) {
  Json json = Json::array();
  for (int i = 0; i < static_cast<int>(vector.size()); ++i) json.push_back(vector[i]);
  return json;
}

JointVector joints(ObjectReader& reader, const std::string& key) {
  const auto values = reader.numbers(key, 0);
  if (values.size() > kinematics::kMaxJoints) {
    reader.findings().error(reader.at(key), fmt::format("{} joints", values.size()),
                            fmt::format("at most {}", kinematics::kMaxJoints));
    return {};
  }
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void check_same_size(ObjectReader& reader, const std::string& key, const JointVector& start, const JointVector& goal) {
  if (start.size() == goal.size()) return;
  reader.findings().error(reader.at(key), fmt::format("{} joints", goal.size()),
                          fmt::format("as many as at the start: {}", start.size()));
}

void check_unit(ObjectReader& reader, const std::string& key, double norm) {
  constexpr double kUnitTolerance = 1e-9;
  if (std::abs(norm - 1.0) <= kUnitTolerance) return;
  reader.findings().error(reader.at(key), fmt::format("'{}' has length {}", key, norm), "length 1");
}

Path read_joint_line(ObjectReader& reader) {
  JointLine line{.q_start = joints(reader, "start"), .q_goal = joints(reader, "goal")};
  check_same_size(reader, "goal", line.q_start, line.q_goal);
  return line;
}

Path read_cartesian_line(ObjectReader& reader) {
  CartesianLine line;
  const std::vector<double> start = reader.numbers("start", 7, std::vector<double>{0, 0, 0, 1, 0, 0, 0});
  line.p_start = {start[0], start[1], start[2]};
  line.R_start = Eigen::Quaterniond(start[3], start[4], start[5], start[6]);
  check_unit(reader, "start", line.R_start.norm());
  line.direction = reader.vector("direction", line.direction);
  check_unit(reader, "direction", line.direction.norm());
  line.length = reader.number("length_m", 0.0, kNotNegative);
  line.axis = reader.vector("axis", line.axis);
  check_unit(reader, "axis", line.axis.norm());
  line.angle = reader.number("angle_rad", 0.0, kNotNegative);
  if (reader.has("held_start")) line.held_start = joints(reader, "held_start");
  if (reader.has("held_goal")) line.held_goal = joints(reader, "held_goal");
  check_same_size(reader, "held_goal", line.held_start, line.held_goal);
  return line;
}

struct Kind {
  std::string name;
  Path (*read)(ObjectReader&);
};

const Kind kKinds[] = {{"joint_line", read_joint_line}, {"cartesian_line", read_cartesian_line}};

Json write(const JointLine& line) {
  return {{"kind", "joint_line"}, {"start", numbers(line.q_start)}, {"goal", numbers(line.q_goal)}};
}

Json write(const CartesianLine& line) {
  const Eigen::Vector3d& p = line.p_start;
  const Eigen::Quaterniond& R = line.R_start;
  return {{"kind", "cartesian_line"},
          {"start", {p.x(), p.y(), p.z(), R.w(), R.x(), R.y(), R.z()}},
          {"direction", numbers(line.direction)},
          {"length_m", line.length},
          {"axis", numbers(line.axis)},
          {"angle_rad", line.angle},
          {"held_start", numbers(line.held_start)},
          {"held_goal", numbers(line.held_goal)}};
}

}  // namespace

JointSample JointLine::sample(const PathPoint& at) const { return proportional(q_start, q_goal, at); }

CartesianLine CartesianLine::between(const Eigen::Isometry3d& X_BM_start, const Eigen::Isometry3d& X_BM_goal,
                                     const JointVector& held_start, const JointVector& held_goal) {
  CartesianLine line;
  line.p_start = X_BM_start.translation();
  line.R_start = Eigen::Quaterniond(X_BM_start.linear()).normalized();
  const Eigen::Vector3d way = X_BM_goal.translation() - line.p_start;
  // A way below this is lost in the rounding of the poses themselves.
  constexpr double kNoWay = 1e-13;
  if (way.norm() > kNoWay) {
    line.length = way.norm();
    line.direction = way / line.length;
  }
  set_rotation(line.R_start, Eigen::Quaterniond(X_BM_goal.linear()).normalized(), line);
  line.held_start = held_start;
  line.held_goal = held_goal;
  return line;
}

FrameSample CartesianLine::sample(const PathPoint& at) const {
  FrameSample sample;
  sample.X_BM.translation() = p_start + (at.s * length) * direction;
  sample.X_BM.linear() = (Eigen::AngleAxisd(at.s * angle, axis) * R_start).toRotationMatrix();
  sample.V_BM_B << (at.ds * length) * direction, (at.ds * angle) * axis;
  sample.A_BM_B << (at.dds * length) * direction, (at.dds * angle) * axis;
  return sample;
}

JointSample CartesianLine::held(const PathPoint& at) const { return proportional(held_start, held_goal, at); }

Json to_json(const Path& path) {
  return std::visit([](const auto& alternative) { return write(alternative); }, path);
}

Result<Path> path_from_json(const Json& json, const std::string& pointer) {
  Findings findings;
  ObjectReader reader(json, pointer, findings);
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.push_back(kind.name);
  const std::string name = reader.choice("kind", names);
  Path path;
  for (const Kind& kind : kKinds) {
    if (kind.name != name) continue;
    path = kind.read(reader);
    reader.finish();
  }
  if (findings.has_errors()) return std::unexpected(std::move(findings));
  return path;
}

}  // namespace takt::motion
