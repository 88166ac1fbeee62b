#include "core/operations/process/weld_line.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/read_parts.h"
#include "core/expression/moving_frames.h"

namespace takt::operations {
namespace {

using Eigen::Vector3d;

constexpr double kShortest_m = 1e-6;

std::string frame_of_point(const std::string& workpiece, const std::string& line, std::size_t number) {
  return fmt::format("{}/{}/{}", workpiece, line, number);
}

/// The lines that a workpiece has: LINE of WORKPIECE/LINE/1.
std::vector<std::string> line_names(const std::vector<std::string>& frames, const std::string& workpiece) {
  std::vector<std::string> lines;
  for (const std::string& frame : frames) {
    if (!frame.starts_with(workpiece + "/") || !frame.ends_with("/1")) continue;
    const std::size_t begin = workpiece.size() + 1;
    if (frame.size() > begin + 2) lines.push_back(frame.substr(begin, frame.size() - begin - 2));
  }
  return lines;
}

Vector3d across(const Vector3d& inward, const Vector3d& travel) {
  const Vector3d side = inward.cross(travel);
  return side.norm() > kShortest_m ? Vector3d(side.normalized()) : inward.unitOrthogonal();
}

/// The direction of the way between two points: of an arc, the tangent at the given end.
Vector3d tangent(const LinePoint& from, const LinePoint& to, bool at_end) {
  const Vector3d chord = to.position - from.position;
  if (!to.via) return chord.normalized();
  // The tangent at an end of an arc, mirrored at the chord, leads to the point between.
  const Vector3d a = *to.via - from.position, b = to.position - *to.via;
  const Vector3d normal = a.cross(b);
  if (normal.norm() < kShortest_m * kShortest_m) return chord.normalized();
  const double angle = std::atan2(normal.norm(), a.dot(b));  // half of the arc
  return Eigen::AngleAxisd(at_end ? angle : -angle, normal.normalized()) * chord.normalized();
}

/// The mean of two directions.
Vector3d middle(const Vector3d& a, const Vector3d& b) {
  const Vector3d sum = a + b;
  return sum.norm() > kShortest_m ? Vector3d(sum.normalized()) : b;
}

Vector3d torch_axis(const Vector3d& inward, const Vector3d& travel, const TorchAngles& angles) {
  const Vector3d side = across(inward, travel), ahead = side.cross(inward);
  const Vector3d tilted = std::cos(angles.travel) * inward + std::sin(angles.travel) * ahead;
  return Eigen::AngleAxisd(angles.work, ahead) * tilted;
}

}  // namespace

Result<std::vector<LinePoint>> line_points(const expression::Cell& cell, const std::string& workpiece,
                                           const std::string& line, const std::string& arm) {
  const std::vector<std::string> names = cell.frames.names();
  const auto exists = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
  std::vector<LinePoint> points;
  for (std::size_t number = 1; exists(frame_of_point(workpiece, line, number)); ++number) {
    const std::string name = frame_of_point(workpiece, line, number);
    if (expression::moves(cell.frames, name, arm))
      return failure(Code::kUnsupported, "/workpiece", fmt::format("'{}' moves against '{}'", workpiece, arm),
                     "Let the workpiece rest while it is welded");
    const auto X_BP = cell.frames.pose(name, arm);
    if (!X_BP) return std::unexpected(X_BP.error());
    LinePoint point{.position = X_BP->translation(), .inward = X_BP->linear().col(2), .along = X_BP->linear().col(0)};
    if (exists(name + "/via")) {
      const auto X_BV = cell.frames.pose(name + "/via", arm);
      if (!X_BV) return std::unexpected(X_BV.error());
      point.via = X_BV->translation();
    }
    points.push_back(point);
  }
  if (points.size() >= 2) return points;
  const auto lines = line_names(names, workpiece);
  return failure(Code::kUnknownName, "/line", fmt::format("'{}' has no line '{}'", workpiece, line),
                 lines.empty() ? "Give the object 'lines'" : nearest_choice(line, lines));
}

std::vector<TorchPose> torch_poses(const std::vector<LinePoint>& points, const TorchAngles& angles) {
  std::vector<TorchPose> poses;
  Vector3d x_B = Eigen::AngleAxisd(angles.rotation, points.front().inward) * points.front().along;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LinePoint& point = points[i];
    const Vector3d in = i > 0 ? tangent(points[i - 1], point, true) : tangent(point, points[1], false);
    const Vector3d out = i + 1 < points.size() ? tangent(point, points[i + 1], false) : in;
    const Vector3d z_B = torch_axis(point.inward, middle(in, out), angles);
    x_B = x_B - z_B.dot(x_B) * z_B;
    x_B = x_B.norm() > kShortest_m ? Vector3d(x_B.normalized()) : z_B.unitOrthogonal();
    TorchPose pose;
    pose.X_BT.linear() << x_B, z_B.cross(x_B), z_B;
    pose.X_BT.translation() = point.position - angles.stick_out * z_B;
    // The tool turns evenly from the pose before to this one.
    if (point.via && i > 0) pose.p_via = *point.via - angles.stick_out * middle(poses.back().X_BT.linear().col(2), z_B);
    pose.across_T = pose.X_BT.linear().transpose() * across(z_B, in);
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace takt::operations
