#include "core/activity/force_request.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/motion_request.h"

namespace takt::activity {
namespace {

using kinematics::JointVector;

Result<Eigen::Vector3d> direction_in_base(const ForceRequest& request, const command::Cell& cell,
                                          const Eigen::Isometry3d& X_BT) {
  if (request.in == "tcp") return Eigen::Vector3d((X_BT.linear() * request.direction).normalized());
  const auto X_BI = cell.frames.pose(request.in, request.arm);
  if (!X_BI) return std::unexpected(X_BI.error());
  return Eigen::Vector3d((X_BI->linear() * request.direction).normalized());
}

/// The pattern as a spline of the tool centre point across the direction, from where it is.
Result<motion::SequencePlan> plan_pattern(const ForceRequest& request, const command::Cell& cell,
                                          const Eigen::Vector3d& direction_B, const Eigen::Isometry3d& X_BT,
                                          const JointVector& q) {
  const Eigen::Vector3d x = direction_B.unitOrthogonal();
  const Eigen::Vector3d y = direction_B.cross(x);
  MotionRequest motion;
  motion.kind = PathKind::kSpline;
  motion.name = request.name;
  motion.arm = request.arm;
  motion.pointer = request.pointer;
  motion.linear_velocity = request.pattern->velocity;
  for (const Eigen::Vector2d& point :
       search_points(request.pattern->kind, request.pattern->radius, request.pattern->pitch)) {
    Goal::Pose pose{.in = request.arm, .X = X_BT, .keep_orientation = true};
    pose.X.translation() += point.x() * x + point.y() * y;
    motion.through.push_back({pose});
  }
  return plan_motions({motion}, cell, q);
}

template <class Map>
std::string read_device(ObjectReader& reader, const char* key, const Map& devices) {
  std::vector<std::string> names;
  for (const auto& [name, device] : devices) names.push_back(name);
  return reader.choice(key, names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
}

ForceRequest read_request(ObjectReader& reader, const command::Cell& cell) {
  ForceRequest request;
  request.pointer = reader.pointer();
  request.name = reader.text("name", reader.text("do"));
  request.arm = read_device(reader, "arm", cell.arms);
  request.sensor = read_device(reader, "sensor", cell.sensors);
  const auto sensor = cell.sensors.find(request.sensor);
  if (sensor != cell.sensors.end() && sensor->second.arm != request.arm) {
    reader.findings().error(reader.at("sensor"), fmt::format("'{}' is not on '{}'", request.sensor, request.arm),
                            "a sensor on this arm");
  }
  request.direction = reader.vector("direction", request.direction);
  if (!(request.direction.norm() > 1e-9)) {
    reader.findings().error(reader.at("direction"), "a direction of no length", "a vector that is not zero");
    request.direction = Eigen::Vector3d::UnitZ();
  }
  request.in = reader.text("in", "tcp");
  request.force = reader.number("force_N", 10.0, {.low = 0.1, .high = 1000.0});
  request.approach = reader.number("approach_m_s", 0.002, {.low = 0.0, .high = 0.1, .low_open = true});
  request.travel = reader.number("travel_m", 0.05, {.low = 0.0, .high = 2.0, .low_open = true});
  if (const nlohmann::ordered_json* until = reader.object("until", false)) {
    auto condition = command::parse_condition(*until, reader.at("until"), cell);
    if (condition) {
      request.until = std::move(*condition);
    } else {
      reader.findings().append(condition.error());
    }
  }
  return request;
}

}  // namespace

Result<PreparedPress> prepare_press(const ForceRequest& request, const command::Cell& cell, const JointVector& q) {
  const Eigen::Isometry3d X_BT = tool_pose(cell.arms.find(request.arm)->second, q);
  const auto direction = direction_in_base(request, cell, X_BT);
  if (!direction) return std::unexpected(direction.error());
  PreparedPress prepared{.command = {.name = request.name,
                                     .arm = request.arm,
                                     .sensor = request.sensor,
                                     .direction_B = *direction,
                                     .force = request.force,
                                     .approach = request.approach,
                                     .travel = request.travel,
                                     .path = nullptr,
                                     .hold = request.hold,
                                     .drop = request.drop,
                                     .until = request.until},
                         .path = {}};
  if (!request.pattern) return prepared;
  auto path = plan_pattern(request, cell, *direction, X_BT, q);
  if (!path) return std::unexpected(path.error());
  prepared.path = std::make_shared<const motion::Motion>(std::move(path->motion));
  prepared.command.path = prepared.path.get();
  return prepared;
}

ForceRequest read_press(ObjectReader& reader, const command::Cell& cell, std::optional<double> hold) {
  ForceRequest request = read_request(reader, cell);
  request.hold = hold;
  if (reader.has("until")) request.hold.reset();
  if (reader.has("seconds")) request.hold = reader.number("seconds", {}, {.low = 0.0, .high = 3600.0});
  return request;
}

ForceRequest read_search(ObjectReader& reader, const command::Cell& cell) {
  ForceRequest request = read_request(reader, cell);
  ForceRequest::Pattern pattern;
  const bool zigzag = reader.choice("pattern", {"spiral", "zigzag"}, "spiral") == "zigzag";
  pattern.kind = zigzag ? SearchPattern::kZigzag : SearchPattern::kSpiral;
  pattern.radius = reader.number("radius_m", {}, {.low = 1e-4, .high = 1.0});
  pattern.pitch = reader.number("pitch_m", {}, {.low = 1e-5, .high = 1.0});
  pattern.velocity = reader.number("velocity_m_s", 0.01, {.low = 0.0, .high = 1.0, .low_open = true});
  if (reader.has("radius_m") && reader.has("pitch_m") && pattern.pitch > 0.0) {
    const std::size_t size = search_size(pattern.kind, pattern.radius, pattern.pitch);
    if (size > kMostSearchPoints) {
      reader.findings().error(reader.at("pitch_m"), fmt::format("{} points for this radius", size),
                              fmt::format("a wider pitch: at most {} points", kMostSearchPoints));
    }
  }
  if (reader.has("drop_m")) request.drop = reader.number("drop_m", {}, kPositive);
  if (!request.drop && !reader.has("until")) {
    reader.findings().error(reader.pointer(), "nothing says when something is found", "'drop_m' or 'until'");
  }
  request.must_find = reader.choice("on_end", {"fail", "continue"}, "fail") == "fail";
  request.pattern = pattern;
  return request;
}

}  // namespace takt::activity
