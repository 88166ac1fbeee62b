#include "core/activity/force_step.h"

#include <optional>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/motion_request.h"
#include "core/activity/net_run.h"
#include "core/activity/search_pattern.h"
#include "core/base/object_reader.h"
#include "core/command/force_net.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

struct Pattern {
  SearchPattern kind = SearchPattern::kSpiral;
  double radius = 0.01, pitch = 0.001, velocity = 0.01;  ///< m, m, m/s
};

struct ForceRequest {
  std::string name, pointer, arm, sensor;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  std::string in;  ///< whose axes the direction is along
  double force = 10.0, approach = 0.002, travel = 0.05;
  std::optional<double> hold, drop;
  std::optional<command::Condition> until;
  std::optional<Pattern> pattern;
  bool must_find = true;
};

/// A command, and the plan that it refers to.
struct Prepared {
  command::PressCommand command;
  std::optional<motion::SequencePlan> path;
};

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

Result<Prepared> prepare(const ForceRequest& request, const command::Cell& cell, const JointVector& q) {
  const Eigen::Isometry3d X_BT = tool_pose(cell.arms.find(request.arm)->second, q);
  const auto direction = direction_in_base(request, cell, X_BT);
  if (!direction) return std::unexpected(direction.error());
  Prepared prepared{.command = {.name = request.name,
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
  prepared.path = std::move(*path);
  return prepared;
}

/// The plan must stay where it is while the net is made.
net::NetDescription net_of(const Prepared& prepared, const command::Cell& cell, const command::Biases& biases) {
  command::PressCommand command = prepared.command;
  command.path = prepared.path ? &prepared.path->motion : nullptr;
  return command::press_net(command, cell, biases);
}

class ForceRun final : public OneNetRun {
 public:
  explicit ForceRun(const ForceRequest& request) : request_(request) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    const JointVector& q = arm.device->set_point().q;
    if (q.size() == 0) return Progress::kRunning;
    const auto prepared = prepare(request_, context.cell, q);
    if (!prepared) {
      findings.append(prepared.error());
      return Progress::kFailed;
    }
    return load(context, net_of(*prepared, context.cell, context.variables.biases), findings);
  }

  Progress finish(Context& context, Findings& findings) override {
    using namespace command::press_ports;
    const bool found = was_true(kHeld) || was_true(kFound) || was_true(kUntil);
    if (found || was_true(kTouched)) note_touch(context);
    if (found) return Progress::kDone;
    if (was_true(kSilent)) {
      findings.error("/sensor", fmt::format("'{}' did not answer, so the arm stopped", request_.sensor),
                     "its power and its wires");
    } else if (was_true(kTooFar)) {
      findings.error("/travel_m", was_true(kTouched) ? "the travel was used up after the touch" : "nothing was touched",
                     "a longer travel, another beginning or direction");
    } else if (request_.must_find) {
      findings.error({}, "the pattern has come to its end and nothing was found",
                     "a larger radius, a smaller pitch, or \"on_end\": \"continue\"");
    }
    return findings.has_errors() ? Progress::kFailed : Progress::kDone;
  }

  /// Where the tool stands pressed counts as the touch of this arm.
  void note_touch(Context& context) const {
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    const auto X_WB = context.cell.frames.pose(request_.arm);
    if (!X_WB) return;
    const Eigen::Vector3d p_W = *X_WB * tool_pose(arm, arm.device->sample().q).translation();
    context.variables.touches[request_.arm] = {p_W, arm.ball_radius, context.core.cycle()};
    context.event(request_.arm, "touch", fmt::format("({:.5f}, {:.5f}, {:.5f}) m", p_W.x(), p_W.y(), p_W.z()));
  }

  const ForceRequest& request_;
};

class ForceStep final : public Step {
 public:
  explicit ForceStep(ForceRequest request) : request_(std::move(request)) {}

  /// Where the surface is shows only in the run: the arm is taken to stay where it begins.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    rehearsal.touched[request_.arm] = true;
    const auto prepared = prepare(request_, rehearsal.cell, rehearsal.q[request_.arm]);
    if (!prepared) {
      findings.append(prepared.error(), pointer);
      return;
    }
    rehearsal.duration += request_.hold.value_or(0.0);
    if (prepared->path) rehearsal.duration += prepared->path->motion.duration();
    rehearse_net(net_of(*prepared, rehearsal.cell, {}), rehearsal, pointer, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<ForceRun>(request_); }

 private:
  ForceRequest request_;
};

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
  if (const Json* until = reader.object("until", false)) {
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

std::unique_ptr<Step> parse_press(const Json& json, const std::string& pointer, const command::Cell& cell,
                                  Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  ForceRequest request = read_request(reader, cell);
  if (reader.has("seconds") || !reader.has("until")) {
    request.hold = reader.number("seconds", 0.5, {.low = 0.0, .high = 3600.0});
  }
  reader.finish();
  return std::make_unique<ForceStep>(std::move(request));
}

std::unique_ptr<Step> parse_search(const Json& json, const std::string& pointer, const command::Cell& cell,
                                   Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  ForceRequest request = read_request(reader, cell);
  Pattern pattern;
  const bool zigzag = reader.choice("pattern", {"spiral", "zigzag"}, "spiral") == "zigzag";
  pattern.kind = zigzag ? SearchPattern::kZigzag : SearchPattern::kSpiral;
  pattern.radius = reader.number("radius_m", {}, {.low = 1e-4, .high = 1.0});
  pattern.pitch = reader.number("pitch_m", {}, {.low = 1e-5, .high = 1.0});
  pattern.velocity = reader.number("velocity_m_s", 0.01, {.low = 0.0, .high = 1.0, .low_open = true});
  if (reader.has("radius_m") && reader.has("pitch_m") && pattern.pitch > 0.0) {
    const std::size_t size = search_size(pattern.kind, pattern.radius, pattern.pitch);
    if (size > kMostSearchPoints) {
      findings.error(reader.at("pitch_m"), fmt::format("{} points for this radius", size),
                     fmt::format("a wider pitch: at most {} points", kMostSearchPoints));
    }
  }
  if (reader.has("drop_m")) request.drop = reader.number("drop_m", {}, kPositive);
  if (!request.drop && !reader.has("until")) {
    findings.error(pointer, "nothing says when something is found", "'drop_m' or 'until'");
  }
  request.must_find = reader.choice("on_end", {"fail", "continue"}, "fail") == "fail";
  request.pattern = pattern;
  reader.finish();
  return std::make_unique<ForceStep>(std::move(request));
}

}  // namespace takt::activity
