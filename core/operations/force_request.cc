#include "core/operations/force_request.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/kinematics/chain.h"
#include "core/operations/motion_request.h"

namespace takt::activity {
namespace {

using device::ControlMode;
using kinematics::JointVector;

/// From this share of the wanted force on there is contact; below a third of that there is none any more.
constexpr double kContactShare = 0.3, kReleaseShare = 1.0 / 3.0;
/// The integral acts slowly: it only takes away what the law leaves.
constexpr double kIntegralTime_s = 1.0;
/// Of the approach velocity: how fast the tool may follow a surface that gives way.
constexpr double kMostVelocity = 5.0;
constexpr double kMostAcceleration = 0.5;  ///< m/s^2

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

void check_sensor(ForceRequest& request, const ReadContext& from) {
  const auto sensor = from.cell.sensors.find(request.sensor);
  if (sensor == from.cell.sensors.end() || sensor->second.arm == request.arm) return;
  from.reader.diagnostics().error(Code::kConflict, from.reader.at("sensor"),
                                  fmt::format("'{}' is not on '{}'", request.sensor, request.arm),
                                  "a sensor on this arm");
}

/// What press and search have in common.
ParameterTable<ForceRequest> common_parameters() {
  ParameterTable<ForceRequest> table;
  table.name("arm", NameOf::kArm, &ForceRequest::arm, "Arm that presses.")
      .name("sensor", NameOf::kSensor, &ForceRequest::sensor, "Force/torque sensor on that arm.")
      .direction("direction", &ForceRequest::direction, "Direction of the motion and of the force; any length but 0.")
      .text("in", &ForceRequest::in, "Frame whose axes the direction is along; \"tcp\": those of the tool.")
      .number("force_N", "N", &ForceRequest::force, {.low = 0.1, .high = 1000.0}, "Force that the tool exerts.")
      .number("approach_m_s", "m/s", &ForceRequest::approach, {.low = 0.0, .high = 0.1, .low_open = true},
              "Speed until contact.")
      .number("travel_m", "m", &ForceRequest::travel, {.low = 0.0, .high = 2.0, .low_open = true},
              "Largest distance along the direction, from the start.")
      .condition("until", &ForceRequest::until, "Ends the operation when it becomes true.")
      .compliance(&ForceRequest::compliance)
      .rule(check_sensor);
  return table;
}

/// A pattern with too many points takes longer to plan than anybody waits.
void check_pattern(ForceRequest& request, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  const ForceRequest::Pattern& pattern = *request.pattern;
  if (reader.has("radius_m") && reader.has("pitch_m") && pattern.pitch > 0.0) {
    const std::size_t size = search_size(pattern.kind, pattern.radius, pattern.pitch);
    if (size > kMostSearchPoints) {
      reader.diagnostics().error(Code::kTooLarge, reader.at("pitch_m"), fmt::format("{} points for this radius", size),
                                 fmt::format("a wider pitch: at most {} points", kMostSearchPoints));
    }
  }
  if (!request.drop && !reader.has("until")) {
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "no end condition is given", "'drop_m' or 'until'");
  }
}

ForceRequest::Pattern& pattern_of(ForceRequest& request) {
  if (!request.pattern) request.pattern.emplace();
  return *request.pattern;
}

// -- Springs ---------------------------------------------------------------------------------------------------------

/// How the arm gives way while it presses.
device::Compliance springs_of(const ForceRequest& request, const device::Arm& arm) {
  return request.compliance ? springs_of(*request.compliance, arm.description()) : arm.compliance();
}

/// A force of the tool along a direction of the base as the axes of the springs have it: joints, or x, y, z.
JointVector as_springs_feel(const device::Compliance& springs, const command::MountedArm& arm,
                            const Eigen::Vector3d& direction_B, const JointVector& q) {
  Eigen::Isometry3d X_BF;
  kinematics::Jacobian J;
  arm.device->description().chain->jacobian(q, X_BF, J);
  if (springs.mode == ControlMode::kCartesianImpedance)
    return springs.in_tool_axes ? Eigen::Vector3d((X_BF.linear() * arm.X_FT.linear()).transpose() * direction_B)
                                : direction_B;
  kinematics::Vector6 at_flange;
  at_flange << direction_B, (X_BF.linear() * arm.X_FT.translation()).cross(direction_B);
  return J.transpose() * at_flange;
}

/// What springs do to a tool along a direction.
struct Softness {
  double by = 0.0;      ///< by how much the tool gives way to a force, m/N; infinite: nothing holds it
  double beside = 0.0;  ///< how far what the arm exerts beside the springs pushes it, m
};
Softness softness_along(const device::Compliance& springs, const JointVector& felt) {
  constexpr double kNone = 1e-9;
  Softness softness;
  for (Eigen::Index i = 0; i < felt.size(); ++i) {
    if (std::abs(felt[i]) < kNone) continue;
    softness.by += felt[i] * felt[i] / springs.stiffness[i];
    softness.beside += felt[i] * springs.feed_forward[i] / springs.stiffness[i];
  }
  return softness;
}

/// Springs that are bent by more than the tool may be sent never press with the force.
Result<std::optional<double>> softness_of(const ForceRequest& request, const command::MountedArm& arm,
                                          const Eigen::Vector3d& direction_B, const JointVector& q) {
  const device::Compliance springs = springs_of(request, *arm.device);
  if (springs.mode == ControlMode::kPosition) return std::nullopt;
  const Softness softness = softness_along(springs, as_springs_feel(springs, arm, direction_B, q));
  if (!std::isfinite(softness.by))
    return failure(Code::kRequires, "/force_N", "the tool has no stiffness along the direction",
                   "a stiffness above 0 there");
  const double bent = softness.by * request.force - softness.beside;
  if (bent <= request.travel) return std::optional(softness.by);
  return failure(Code::kLimitExceeded, "/travel_m",
                 fmt::format("{:g} N bend the springs by {:.4g} m, and the tool is sent by {:g} m at most",
                             request.force, bent, request.travel),
                 "a longer travel, stiffer springs along the direction, or a part of the force beside them");
}

}  // namespace

bool ForceRequest::needs_place() const {
  const bool own_springs = compliance && compliance->mode != ControlMode::kPosition;
  return pattern || in == "tcp" ||
         (own_springs && (compliance->mode == ControlMode::kJointImpedance || compliance->in_tool_axes));
}

Result<PreparedPress> prepare_press(const ForceRequest& request, const command::Cell& cell, const JointVector& q) {
  const command::MountedArm& arm = cell.arms.find(request.arm)->second;
  const Eigen::Isometry3d X_BT = tool_pose(arm, q);
  const auto direction = direction_in_base(request, cell, X_BT);
  if (!direction) return std::unexpected(direction.error());
  const auto softness = softness_of(request, arm, *direction, q);
  if (!softness) return std::unexpected(softness.error());
  command::PressWish wish{.force = {.force = request.force,
                                    .approach_velocity = request.approach,
                                    .contact_force = kContactShare * request.force,
                                    .release_share = kReleaseShare,
                                    // Takes the approach velocity away while the force builds up, whatever the surface
                                    // is like.
                                    .gain = request.approach / request.force,
                                    .integral_time = kIntegralTime_s,
                                    .velocity_max = kMostVelocity * request.approach,
                                    .acceleration_max = kMostAcceleration},
                          .travel = request.travel,
                          .sink = request.drop,
                          .clock = command::override_of(cell),
                          .softness = *softness};
  if (request.pattern) {
    auto path = plan_pattern(request, cell, *direction, X_BT, q);
    if (!path) return std::unexpected(path.error());
    wish.path = std::make_shared<const motion::Motion>(std::move(path->motion));
  }
  return PreparedPress{*direction, std::move(wish)};
}

const ParameterTable<ForceRequest>& press_parameters() {
  static const auto table = common_parameters().number(
      "seconds", "s", &ForceRequest::hold, {.low = 0.0, .high = 3600.0},
      "How long the force is held once it is reached; without 'until' 0.5 as a step, without end in a transaction.");
  return table;
}

const ParameterTable<ForceRequest>& search_parameters() {
  static const auto table = [] {
    const std::vector<std::pair<std::string, SearchPattern>> patterns{{"spiral", SearchPattern::kSpiral},
                                                                      {"zigzag", SearchPattern::kZigzag}};
    const std::vector<std::pair<std::string, bool>> ends{{"fail", true}, {"continue", false}};
    auto search = common_parameters();
    search
        .choice(
            "pattern", [](ForceRequest & p) -> auto& { return pattern_of(p).kind; }, patterns,
            "Path across the direction.")
        .number(
            "radius_m", "m", [](ForceRequest & p) -> auto& { return pattern_of(p).radius; }, {.low = 1e-4, .high = 1.0},
            "Radius of the spiral, half the side of the zigzag.")
        .required()
        .number(
            "pitch_m", "m", [](ForceRequest & p) -> auto& { return pattern_of(p).pitch; }, {.low = 1e-5, .high = 1.0},
            "Distance between neighbouring turns or lanes.")
        .required()
        .number(
            "velocity_m_s", "m/s", [](ForceRequest & p) -> auto& { return pattern_of(p).velocity; },
            {.low = 0.0, .high = 1.0, .low_open = true}, "Speed along the pattern.")
        .number("drop_m", "m", &ForceRequest::drop, kPositive, "Found: the tool is this much deeper than at contact.")
        .choice("on_end", &ForceRequest::must_find, ends, "Whether a pattern that ends without a find fails the step.")
        .rule(check_pattern);
    return search;
  }();
  return table;
}

ForceRequest read_press(ObjectReader& reader, const command::Cell& cell, std::optional<double> hold) {
  ForceRequest request = press_parameters().read(reader, cell);
  if (request.name.empty()) request.name = "press";
  if (!request.hold && !reader.has("until")) request.hold = hold;
  return request;
}

ForceRequest read_search(ObjectReader& reader, const command::Cell& cell) {
  ForceRequest request = search_parameters().read(reader, cell);
  if (request.name.empty()) request.name = "search";
  return request;
}

}  // namespace takt::activity
