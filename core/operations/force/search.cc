#include "core/operations/force/search.h"

#include <fmt/format.h>

#include "core/operations/command/command_step.h"
#include "core/operations/motion/motion_plan.h"

namespace takt::operations {
namespace {

/// The pattern as a spline of the tool centre point across the direction, from where it is.
Result<motion::SequencePlan> plan_pattern(const SearchParameters& search, const Pressing::Start& start) {
  const Eigen::Vector3d x = start.direction_B.unitOrthogonal();
  const Eigen::Vector3d y = start.direction_B.cross(x);
  MotionTask motion;
  motion.kind = PathKind::kSpline;
  motion.name = search.name;
  motion.arm = search.arm;
  motion.pointer = search.pointer;
  motion.linear_velocity = search.velocity;
  for (const Eigen::Vector2d& point : search_points(search.pattern, search.radius, search.pitch)) {
    Goal::Pose pose{.in = search.arm, .X = start.X_BT, .keep_orientation = true};
    pose.X.translation() += point.x() * x + point.y() * y;
    motion.through.push_back({pose});
  }
  return plan_motions({motion}, start.cell, start.q);
}

/// A pattern with too many points takes longer to plan than anybody waits; what is deeper than the tool may go cannot
/// be found.
void check_search(const SearchParameters& search, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  if (reader.has("radius_m") && reader.has("pitch_m") && search.pitch > 0.0) {
    const std::size_t size = search_size(search.pattern, search.radius, search.pitch);
    if (size > kMostSearchPoints) {
      reader.diagnostics().error(Code::kTooLarge, reader.at("pitch_m"), fmt::format("{} points for this radius", size),
                                 fmt::format("Increase the pitch: at most {} points", kMostSearchPoints));
    }
  }
  if (search.drop && search.depth && *search.depth <= *search.drop) {
    reader.diagnostics().error(Code::kConflict, reader.at("depth_max_m"),
                               fmt::format("{:g} m are not more than drop_m, {:g} m", *search.depth, *search.drop),
                               "Choose more than drop_m, so that something can be found");
  }
  if (!search.drop && !from.has("until")) {
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "no end condition is given",
                               "Give 'drop_m' or 'until'");
  }
}

}  // namespace

std::unique_ptr<OperationCommand> search_command(const SearchParameters& parameters) {
  Pressing pressing = pressing_of(parameters, "search");
  SearchParameters named = parameters;
  named.name = pressing.name;
  pressing.drop = parameters.drop;
  pressing.path = [named](const Pressing::Start& start) { return plan_pattern(named, start); };
  pressing.path_key = "/pattern";
  pressing.path_end_fails = parameters.must_find;
  return pressing_command(std::move(pressing));
}

const ParameterTable<SearchParameters>& search_parameters() {
  using P = SearchParameters;
  static const auto table = [] {
    const std::vector<std::pair<std::string, SearchPattern>> patterns{{"spiral", SearchPattern::kSpiral},
                                                                      {"zigzag", SearchPattern::kZigzag}};
    const std::vector<std::pair<std::string, bool>> ends{{"fail", true}, {"continue", false}};
    return pressing_parameters<P>()
        .choice("pattern", &P::pattern, patterns, "Path across the direction.")
        .number("radius_m", "m", &P::radius, {.low = 1e-4, .high = 1.0},
                "Radius of the spiral, half the side of the zigzag.")
        .required()
        .number("pitch_m", "m", &P::pitch, {.low = 1e-5, .high = 1.0}, "Distance between neighbouring turns or lanes.")
        .required()
        .number("velocity_m_s", "m/s", &P::velocity, {.low = 0.0, .high = 1.0, .low_open = true},
                "Speed along the pattern.")
        .number("drop_m", "m", &P::drop, kPositive, "Found: the tool is this much deeper than at contact.")
        .choice("on_end", &P::must_find, ends, "Whether a pattern that ends without a find fails the step.")
        .rule(check_search);
  }();
  return table;
}

Operation search_operation() {
  return {.name = "search",
          .doc = "Presses and follows a pattern until something is found.",
          .parameters = rows_of<search_parameters>,
          .read_step = step_of_command,
          .read_command = make_command<search_parameters, search_command>};
}

}  // namespace takt::operations
