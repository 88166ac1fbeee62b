#include "core/operations/force/wipe.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/motion/blend_limits.h"
#include "core/operations/command/command_step.h"
#include "core/operations/motion/motion_plan.h"

namespace takt::operations {
namespace {

constexpr int kMostLanes = 100;

int lanes_of(const WipeParameters& wipe) { return 1 + static_cast<int>(std::ceil(wipe.width / wipe.pitch - 1e-9)); }

/// The ends of the lanes in the frame, each lane opposite to the one before; of a rectangle without a width one
/// lane.
std::vector<Eigen::Vector3d> ends_of_lanes(const WipeParameters& wipe) {
  std::vector<Eigen::Vector3d> ends;
  const int lanes = lanes_of(wipe);
  for (int i = 0; i < lanes; ++i) {
    const double y = lanes == 1 ? 0.0 : wipe.width * (static_cast<double>(i) / (lanes - 1) - 0.5);
    const double side = i % 2 == 0 ? -0.5 : 0.5;
    ends.push_back(wipe.centre + Eigen::Vector3d(side * wipe.length, y, 0.0));
    ends.push_back(wipe.centre + Eigen::Vector3d(-side * wipe.length, y, 0.0));
  }
  return ends;
}

/// One line after the other, blended at the corners as far as the pitch allows. What the path does along the force does
/// not count, so it stays at the height at which it begins.
Result<motion::SequencePlan> plan_lanes(const WipeParameters& wipe, const Pressing::Start& start) {
  const auto X_BI = start.cell.frames.pose(wipe.in, wipe.arm);
  if (!X_BI) return std::unexpected(X_BI.error());
  const Eigen::Vector3d p_start = start.X_BT.translation();
  std::vector<MotionTask> lines;
  for (const Eigen::Vector3d& end : ends_of_lanes(wipe)) {
    Eigen::Vector3d p_B = *X_BI * end;
    p_B -= start.direction_B * start.direction_B.dot(p_B - p_start);
    const Eigen::Vector3d before =
        lines.empty() ? p_start : Eigen::Vector3d(std::get<Goal::Pose>(lines.back().goal.value).X.translation());
    if ((p_B - before).norm() < 1e-6) continue;  // it is there already
    MotionTask line;
    line.kind = PathKind::kLin;
    line.name = wipe.name;
    line.pointer = wipe.pointer;
    line.arm = wipe.arm;
    line.linear_velocity = wipe.velocity;
    Goal::Pose pose{.in = wipe.arm, .X = start.X_BT, .keep_orientation = true};
    pose.X.translation() = p_B;
    line.goal = {pose};
    if (!lines.empty()) {
      const double corner = 0.4 * std::min((p_B - before).norm(), wipe.length);
      if (corner > motion::kLeastBlend_m) lines.back().blend = activity::BlendingCondition::at_distance(corner);
    }
    lines.push_back(std::move(line));
  }
  return plan_motions(lines, start.cell, start.q);
}

void check_lanes(const WipeParameters& wipe, const ReadContext& from) {
  if (!(wipe.pitch > 0.0) || lanes_of(wipe) <= kMostLanes) return;
  from.reader.diagnostics().error(Code::kTooLarge, from.reader.at("pitch_m"),
                                  fmt::format("{} lanes for this width", lanes_of(wipe)),
                                  fmt::format("Increase the pitch: at most {} lanes", kMostLanes));
}

}  // namespace

std::unique_ptr<OperationCommand> wipe_command(const WipeParameters& parameters) {
  Pressing pressing = pressing_of(parameters, "wipe");
  WipeParameters named = parameters;
  named.name = pressing.name;
  pressing.direction = -Eigen::Vector3d::UnitZ();
  pressing.in = parameters.in;
  pressing.path = [named](const Pressing::Start& start) { return plan_lanes(named, start); };
  pressing.path_key = "/length_m";
  return pressing_command(std::move(pressing));
}

const ParameterTable<WipeParameters>& wipe_parameters() {
  using P = WipeParameters;
  static const auto table = [] {
    ParameterTable<P> wipe;
    add_pressing_devices(wipe);
    wipe.text("in", &P::in, "Frame of the surface: the lanes are along its x, the force is against its z.")
        .required()
        .vector("centre_m", "m", &P::centre, "Centre of the rectangle in that frame.")
        .number("length_m", "m", &P::length, {.low = 0.001, .high = 5.0}, "Length of the lanes.")
        .number("width_m", "m", &P::width, {.low = 0.0, .high = 5.0}, "Extent of the rectangle across the lanes.")
        .number("pitch_m", "m", &P::pitch, {.low = 0.0005, .high = 1.0}, "Largest distance between neighbouring lanes.")
        .number("velocity_m_s", "m/s", &P::velocity, {.low = 0.0, .high = 1.0, .low_open = true},
                "Speed of the tool along the lanes.")
        .rule(check_lanes);
    add_pressing_force(wipe);
    return wipe;
  }();
  return table;
}

Operation wipe_operation() {
  return {.name = "wipe",
          .doc = "Follows a surface in lanes with a constant force.",
          .parameters = rows_of<wipe_parameters>,
          .read_step = step_of_command,
          .read_command = make_command<wipe_parameters, wipe_command>};
}

}  // namespace takt::operations
