#include "core/operations/motion/motion.h"

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/motion/blend_limits.h"
#include "core/operations/command/command_step.h"
#include "core/operations/motion/motion_command.h"
#include "core/operations/motion/motion_step.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;
using Type = ParameterInfo::Type;
using Table = ParameterTable<MotionTask>;

ParameterInfo row(std::string key, Type type, std::string definition, std::string doc) {
  ParameterInfo info{.key = std::move(key), .type = type, .definition = std::move(definition)};
  info.doc = std::move(doc);
  return info;
}

/// The arm of the motion; null if the file names none that exists.
const expression::MountedArm* arm_of(const MotionTask& request, const expression::Cell& cell) {
  const auto found = cell.arms.find(request.arm);
  return found == cell.arms.end() ? nullptr : &found->second;
}

// -- Where it goes -------------------------------------------------------------------------------------------------

void add_goal(Table& table, const char* key, const char* doc, Goal& (*member)(MotionTask&)) {
  ParameterInfo info = row(key, Type::kObject, "goal", doc);
  info.fields = goal_fields();
  info.required = true;
  table.object(std::move(info), [member](const ParameterInfo& row, const ReadContext& from, MotionTask& request) {
    member(request) = read_goal(from.reader, arm_of(request, from.cell), row.key);
  });
}

const ParameterTable<MotionTask::About>& about_parameters() {
  using About = MotionTask::About;
  static const auto table = [] {
    ParameterTable<About> about;
    about.text("in", &About::in, "Frame of centre and axis.")
        .vector("position_m", "m", &About::centre, "Centre of the circle.")
        .required()
        .direction("axis", &About::axis, "Axis of the turn; any length but 0.")
        .number("angle_deg", "deg", &About::angle, {.low = -36000, .high = 36000}, "Angle of the turn.")
        .required();
    return about;
  }();
  return table;
}

/// An arc leads through a point to a goal, or about an axis.
void read_arc_goal(const ParameterInfo& row, const ReadContext& from, MotionTask& request) {
  if (from.reader.has("about")) return;
  Goal goal = read_goal(from.reader, arm_of(request, from.cell), row.key);
  (row.key == "via" ? request.via.emplace() : request.goal) = std::move(goal);
}

void read_orientation(const ParameterInfo& row, const ReadContext& from, MotionTask& request) {
  using motion::ArcOrientation;
  const bool about = from.reader.has("about");
  const auto choices = about ? std::vector<std::string>{"fixed", "tangential"} : row.choices;
  const std::string word = from.reader.choice(row.key, choices, choices.front());
  request.orientation = word == "goal"    ? ArcOrientation::kToGoal
                        : word == "fixed" ? ArcOrientation::kFixed
                                          : ArcOrientation::kTangential;
}

void add_arc(Table& table) {
  for (const auto& [key, doc] : {std::pair("to", "Goal at the end of the arc; not with 'about'."),
                                 {"via", "Via pose; its position counts. Not with 'about'."}}) {
    ParameterInfo info = row(key, Type::kObject, "goal", doc);
    info.fields = goal_fields();
    table.object(std::move(info), read_arc_goal);
  }
  table.part("about", "about", about_parameters(), &MotionTask::about,
             "Centre, axis and angle in place of 'to' and 'via'.");
  ParameterInfo orientation = row("orientation", Type::kChoice, "", "How the tool turns along the arc.");
  orientation.choices = {"goal", "fixed", "tangential"};
  orientation.fallback = "goal; with 'about' fixed";
  table.object(std::move(orientation), read_orientation);
  table.rule([](MotionTask& request, const ReadContext& from) {
    if (!request.about) return;
    for (const char* key : {"to", "via"}) {
      if (from.reader.has(key))
        from.reader.diagnostics().error(Code::kConflict, from.reader.at(key), fmt::format("'{}' and 'about'", key),
                                        "Remove one of them");
    }
  });
}

void read_through(const ParameterInfo& row, const ReadContext& from, MotionTask& request) {
  ObjectReader& reader = from.reader;
  const expression::MountedArm* arm = arm_of(request, from.cell);
  const Json* list = reader.array(row.key);
  if (!list) return;
  const std::string pointer = reader.at(row.key);
  std::size_t joints = 0;
  for (std::size_t i = 0; i < list->size(); ++i) {
    request.through.push_back(read_goal((*list)[i], pointer + pointer_segment(i), arm, reader.diagnostics()));
    joints += request.through.back().is_joints();
  }
  constexpr std::size_t kMost = 200;
  if (list->size() < 2 || list->size() > kMost) {
    reader.diagnostics().error(Code::kWrongSize, pointer, fmt::format("{} points", list->size()),
                               fmt::format("Give 2 to {}", kMost));
  }
  if (joints != 0 && joints != list->size()) {
    reader.diagnostics().error(Code::kConflict, pointer, "joint positions and poses in one spline",
                               "Use points of one kind");
  }
}

void add_through(Table& table) {
  ParameterInfo info = row("through", Type::kObject, "through", "Points of the spline: goals of one kind, 2 to 200.");
  info.fields = goal_fields();
  info.required = true;
  table.object(std::move(info), read_through);
}

void add_base_goal(Table& table) {
  ParameterInfo info = row("base_to", Type::kObject, "goal", "Where the base that carries the arm drives meanwhile.");
  info.fields = goal_fields();
  table.object(std::move(info), [](const ParameterInfo& row, const ReadContext& from, MotionTask& request) {
    if (from.reader.has(row.key)) request.base_goal = read_goal(from.reader, nullptr, row.key);
  });
}

/// Two devices on one clock.
void check_base_goal(MotionTask& request, const ReadContext& from) {
  if (!request.base_goal) return;
  const bool distance = request.blend.along_path.kind == motion::Blend::Kind::kDistance;
  const std::pair<const char*, bool> cannot[] = {{distance ? "blend_m" : "blend_fraction", request.blends()},
                                                 {"follower", !request.follower.empty()},
                                                 {"weave", request.weave.has_value()},
                                                 {"force_offset", request.force_offset.has_value()}};
  for (const auto& [key, given] : cannot) {
    if (given)
      from.reader.diagnostics().error(Code::kConflict, from.reader.at(key),
                                      fmt::format("a motion with a base has no '{}'", key),
                                      "Split it into two motions");
  }
}

// -- How it goes ---------------------------------------------------------------------------------------------------

void add_follower(Table& table) {
  ParameterInfo info = row("follower", Type::kName, "", "Second arm that moves as one with this one.");
  table.object(
      std::move(info),
      [](const ParameterInfo& row, const ReadContext& from, MotionTask& request) {
        if (from.reader.has(row.key)) request.follower = from.reader.choice(row.key, names_in(from.cell, NameOf::kArm));
      },
      [](const ParameterInfo& row, const MotionTask& request, ParameterWriter& to) {
        if (!request.follower.empty()) to.text(row.key, request.follower);
      });
}

void check_follower(MotionTask& request, const ReadContext& from) {
  if (request.follower.empty()) return;
  Diagnostics& diagnostics = from.reader.diagnostics();
  const std::string place = from.reader.at("follower");
  if (request.kind != PathKind::kLin && request.kind != PathKind::kCirc) {
    diagnostics.error(Code::kConflict, place, "two arms move as one only on the path of a frame", "Use lin or circ");
  } else if (request.follower == request.arm && !request.arm.empty()) {
    diagnostics.error(Code::kConflict, place, fmt::format("'{}' leads already", request.arm), "Name another arm");
  }
  if (request.compliance) check_springs_of_two(*request.compliance, from.reader.pointer(), diagnostics);
  if (request.has_overlay())
    diagnostics.error(Code::kConflict, place, "two arms as one with a weave or a force offset",
                      "Use one arm, or a plain motion");
}

void add_avoidance(Table& table) {
  table
      .number(
          "clearance_m", "m", [](MotionTask & p) -> auto& { return p.avoidance.clearance; }, {.low = 5e-4, .high = 0.1},
          "Distance kept beyond the margin of the cell, where start and goal allow it.")
      .integer(
          "seed", [](MotionTask & p) -> auto& { return p.avoidance.seed; }, {.low = 0, .high = 1e9},
          "Of all that is random in the search: the same seed finds the same path.")
      .number(
          "effort", "", [](MotionTask & p) -> auto& { return p.avoidance.effort; }, {.low = 0.01, .high = 100},
          "How long a path is looked for; 1: 100 000 postures.");
}

/// What two arms do to each other is felt by their own sensors.
void check_internal_force(const expression::Condition& condition, const expression::Cell& cell,
                          const std::string& place, const MotionTask& request, Diagnostics& diagnostics) {
  for (const expression::Condition& operand : condition.operands)
    check_internal_force(operand, cell, place, request, diagnostics);
  if (condition.kind != expression::Condition::Kind::kInternalForce) return;
  for (const std::string& name : {condition.device, condition.other}) {
    const std::string& arm = cell.sensors.find(name)->second.arm;
    if (arm.empty() || arm == request.arm || arm == request.follower) continue;
    diagnostics.error(Code::kConflict, place,
                      fmt::format("an internal force that '{}' feels, which is on '{}'", name, arm),
                      fmt::format("Name the sensors of '{}' and '{}'", request.arm, request.follower));
  }
}

void check_ends(MotionTask& request, const ReadContext& from) {
  if (from.reader.has("on_end") && !request.must_touch && !from.has("until"))
    from.reader.diagnostics().error(Code::kConflict, from.reader.at("on_end"), "'on_end' without 'until'",
                                    "Add 'until', or remove 'on_end'");
  if (request.follower.empty()) return;
  for (const auto& [key, condition] : {std::pair("until", &request.until), {"abort_if", &request.abort_if}}) {
    if (*condition && (*condition)->condition() != nullptr)
      check_internal_force(*(*condition)->condition(), from.cell, from.reader.at(key), request,
                           from.reader.diagnostics());
  }
}

void check_overlay(MotionTask& request, const ReadContext& from) {
  if (!request.has_overlay()) return;
  ObjectReader& reader = from.reader;
  request.acceleration = std::min(request.acceleration, command::kShareWithOverlay);
  if (request.force_offset) {
    const auto mounted = from.cell.sensors.find(request.force_offset->sensor);
    if (mounted != from.cell.sensors.end() && mounted->second.arm != request.arm)
      reader.diagnostics().error(Code::kConflict, reader.at("force_offset") + "/sensor",
                                 fmt::format("'{}' is not on '{}'", request.force_offset->sensor, request.arm),
                                 "Name a sensor on this arm");
  }
  if (request.weave && request.force_offset)
    reader.diagnostics().error(Code::kConflict, reader.at("force_offset"), "a weave and a force offset",
                               "Remove one of them");
  const bool moves_joints = request.kind == PathKind::kPtp || request.kind == PathKind::kMove ||
                            (!request.through.empty() && request.through.front().is_joints());
  if (!moves_joints) return;
  reader.diagnostics().error(
      Code::kConflict, reader.at(request.weave ? "weave" : "force_offset"),
      fmt::format("C8: {} moves joints, so there is no Cartesian path to {}",
                  request.through.empty() ? (request.kind == PathKind::kMove ? "move" : "PTP") : "a spline of joints",
                  request.weave ? "weave about" : "shift"),
      "Lay it over a Cartesian motion");
}

// -- How it goes on ------------------------------------------------------------------------------------------------

void add_blend(Table& table, const char* key, motion::Blend::Kind kind, const Range& range, const char* doc) {
  ParameterInfo info = row(key, Type::kNumber, "", doc);
  info.unit = kind == motion::Blend::Kind::kDistance ? "m" : "";
  info.range = range;
  table.object(
      std::move(info),
      [kind](const ParameterInfo& row, const ReadContext& from, MotionTask& request) {
        if (from.reader.has(row.key)) request.blend.along_path = {kind, from.reader.number(row.key, {}, row.range)};
      },
      [kind](const ParameterInfo& row, const MotionTask& request, ParameterWriter& to) {
        if (request.blend.along_path.kind == kind) to.number(row.key, request.blend.along_path.value);
      });
}

void check_blend(MotionTask& request, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  const bool distance = reader.has("blend_m"), fraction = reader.has("blend_fraction");
  if (distance && fraction)
    reader.diagnostics().error(Code::kConflict, reader.at("blend_fraction"), "a blend by distance and by fraction",
                               "Remove one of them");
  if ((distance || fraction) && request.until)
    reader.diagnostics().error(Code::kConflict, reader.at(distance ? "blend_m" : "blend_fraction"),
                               "a guarded motion is not blended", "Remove the blend or 'until'");
}

/// It was renamed.
void refuse_former_key(MotionTask&, const ReadContext& from) {
  if (from.reader.child("unless") == nullptr) return;
  from.reader.diagnostics().error(Code::kUnknownKey, from.reader.at("unless"), "'unless' is called 'abort_if' now",
                                  "Write 'abort_if'");
}

Table make_table(PathKind kind) {
  const Range share{.low = 0, .high = 1, .low_open = true};
  const std::vector<std::pair<std::string, bool>> solutions{{"nearest", false}, {"free", true}};
  const std::vector<std::pair<std::string, bool>> ends{{"fail", true}, {"continue", false}};
  Table table;
  table.name("arm", NameOf::kArm, &MotionTask::arm, "Arm or base that moves.").tool(&MotionTask::tool);
  if (kind == PathKind::kCirc) {
    add_arc(table);
  } else if (kind == PathKind::kSpline) {
    add_through(table);
  } else {
    add_goal(table, "to", "Goal of the motion.", [](MotionTask& request) -> Goal& { return request.goal; });
  }
  if (kind == PathKind::kLin) add_base_goal(table);
  table.number("speed", "", &MotionTask::velocity, share, "Share of the velocity limits.")
      .number("acceleration", "", &MotionTask::acceleration, share, "Share of the acceleration and jerk limits.");
  if (kind != PathKind::kPtp)
    table.number("velocity_m_s", "m/s", &MotionTask::linear_velocity, kPositive, "Speed of the tool centre point.");
  if (kind == PathKind::kMove) add_avoidance(table);
  if (kind == PathKind::kPtp)
    table.choice("solution", &MotionTask::free_solution, solutions,
                 "Of several joint configurations with the pose: the nearest, or the nearest whose path is free.");
  add_follower(table);
  const bool joints = kind == PathKind::kPtp || kind == PathKind::kMove;
  table.refused_if(joints || kind == PathKind::kSpline);
  table.compliance(&MotionTask::compliance)
      .part(
          "weave", "weave", weave_parameters(), [](MotionTask & p) -> auto& { return p.weave; },
          "Oscillation across the path.")
      .refused_if(joints)
      .part(
          "force_offset", "force_offset", force_offset_parameters(),
          [](MotionTask & p) -> auto& { return p.force_offset; }, "Shift of the path that holds a force.")
      .refused_if(joints)
      .condition("until", &MotionTask::until, "Guarded motion: brakes on its path when this becomes true.")
      .choice("on_end", &MotionTask::must_touch, ends, "Whether a guarded motion that reaches its goal fails.")
      .condition("abort_if", &MotionTask::abort_if, "Brakes on its path and fails when this becomes true.");
  add_blend(table, "blend_m", motion::Blend::Kind::kDistance, {.low = motion::kLeastBlend_m},
            "Distance from the goal at which the next motion takes over.");
  add_blend(table, "blend_fraction", motion::Blend::Kind::kFraction,
            {.low = motion::kLeastBlendShare, .high = motion::kMostBlendShare}, "The same as a share of the path.");
  table.rule([kind](MotionTask& request, const ReadContext&) { request.kind = kind; })
      .rule(refuse_former_key)
      .rule(check_follower)
      .rule(check_overlay)
      .rule(check_ends)
      .rule(check_blend)
      .rule(check_base_goal);
  return table;
}

}  // namespace

const ParameterTable<MotionTask>& motion_parameters(PathKind kind) {
  static const std::vector<Table> tables = [] {
    std::vector<Table> all;
    for (const PathKind one : {PathKind::kPtp, PathKind::kLin, PathKind::kCirc, PathKind::kSpline, PathKind::kMove})
      all.push_back(make_table(one));
    return all;
  }();
  return tables.at(static_cast<std::size_t>(kind));
}

MotionTask read_motion(PathKind kind, const OperationSource& source) {
  ObjectReader reader(source.json, source.pointer, source.diagnostics);
  MotionTask motion = motion_parameters(kind).read(reader, source.cell);
  constexpr std::string_view kNames[] = {"ptp", "lin", "circ", "spline", "move"};
  if (motion.name.empty()) motion.name = kNames[static_cast<std::size_t>(kind)];
  return motion;
}

namespace {

template <PathKind kind>
const std::vector<ParameterInfo>& motion_rows() {
  return motion_parameters(kind).list();
}

/// With "base_to" it is a motion of two devices, and a command as a step too.
template <PathKind kind>
std::unique_ptr<Step> read_motion_step(const OperationSource& source) {
  if (kind == PathKind::kLin && source.json.contains("base_to")) return step_of_command(source);
  return motion_step(read_motion(kind, source));
}

template <PathKind kind>
std::unique_ptr<OperationCommand> read_motion_command(const OperationSource& source) {
  return motion_command(read_motion(kind, source), source);
}

template <PathKind kind>
Operation motion_operation(std::string_view name, std::string_view doc) {
  return {.name = name,
          .doc = doc,
          .parameters = motion_rows<kind>,
          .read_step = read_motion_step<kind>,
          .read_command = read_motion_command<kind>,
          .is_motion = true};
}

}  // namespace

Operation ptp_operation() { return motion_operation<PathKind::kPtp>("ptp", "Moves all joints together to a goal."); }

Operation lin_operation() {
  return motion_operation<PathKind::kLin>(
      "lin",
      "Moves the tool centre point on a straight line; with 'base_to' the base that carries the arm drives meanwhile.");
}

Operation circ_operation() {
  return motion_operation<PathKind::kCirc>("circ", "Moves the tool centre point on a circle.");
}

Operation move_operation() {
  return motion_operation<PathKind::kMove>("move", "Moves all joints to a goal on a path around what is in the way.");
}

Operation spline_operation() { return motion_operation<PathKind::kSpline>("spline", "Moves smoothly through points."); }

}  // namespace takt::operations
