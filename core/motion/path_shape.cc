#include "core/motion/path_shape.h"

#include <algorithm>
#include <cmath>

#include "core/motion/plan_checks.h"

namespace takt::motion {

std::size_t PathShape::cell_at(double s, std::size_t guess) const {
  std::size_t cell = std::min(guess, cells.size() - 1);
  while (cell > 0 && s < nodes[cells[cell].node].s) --cell;
  while (cell + 1 < cells.size() && s >= nodes[cells[cell].node + 1].s) ++cell;
  return cell;
}

void PathShape::add_cell() {
  const Node& a = nodes[nodes.size() - 2];
  const Node& b = nodes.back();
  const double h = b.s - a.s;
  const Components rise = b.first - a.first;
  cells.push_back({.node = nodes.size() - 2,
                   .limits = limits.size() - 1,
                   .width = h,
                   .linear = h * a.second,
                   .square = 3.0 * rise - h * (2.0 * a.second + b.second),
                   .cube = h * (a.second + b.second) - 2.0 * rise});
}

PathShape::Derivatives PathShape::derivatives(std::size_t cell, double s) const {
  const auto& [node, limits_of_cell, h, c1, c2, c3] = cells[cell];
  const Node& a = nodes[node];
  const double t = std::clamp((s - a.s) / h, 0.0, 1.0);
  return {.first = a.first + t * (c1 + t * (c2 + t * c3)),
          .second = (c1 + t * (2.0 * c2 + (3.0 * t) * c3)) / h,
          .third = (2.0 * c2 + (6.0 * t) * c3) / (h * h)};
}

Channels PathShape::channels(const Components& components) const {
  Channels result;
  channels(components, result);
  return result;
}

void PathShape::channels(const Components& components, Channels& result) const {
  result.resize(joint_count + 2);
  result.head(joint_count) = components.head(joint_count).abs();
  result[joint_count] = components.segment<3>(joint_count).matrix().norm();
  result[joint_count + 1] = components.segment<3>(joint_count + 3).matrix().norm();
}

namespace {

/// About as many instants as the shape has cells, so that no short piece is stepped over; a law of many segments is
/// made of the cells itself.
int parts_per_segment(const PathShape& shape, const TimeLaw& law) {
  constexpr std::size_t kFew = 16;
  constexpr std::size_t kMany = 64;
  if (law.segments().size() > kMany) return 1;
  return law.segments().size() > kFew ? 4 : std::max(kPartsPerSegment, static_cast<int>(shape.cells.size()));
}

}  // namespace

Loads loads_of(const PathShape& shape, const TimeLaw& law) { return *loads_if_shorter(shape, law, std::nullopt); }

std::optional<Loads> loads_if_shorter(const PathShape& shape, const TimeLaw& law, std::optional<double> duration) {
  Loads loads;
  std::size_t cell = 0;
  double tau = 0.0;
  std::size_t knot = 0;
  const int per_segment = parts_per_segment(shape, law);
  const std::vector<LawPoint> points = instants(law, per_segment);
  loads.instants.reserve(points.size());
  loads.stretch.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LawPoint& at = points[i];
    knot = i / static_cast<std::size_t>(per_segment + 1);
    const auto step = static_cast<double>(i % static_cast<std::size_t>(per_segment + 1)) / per_segment;
    const double segment = law.segments()[knot].duration_s;
    if (step == 0.0 && i > 0) tau += law.segments()[knot - 1].duration_s;
    cell = shape.cell_at(at.s, cell);
    const PathShape::Derivatives d = shape.derivatives(cell, at.s);
    const double v = at.ds;
    Loads::Instant& instant = loads.instants.emplace_back();
    instant.tau = tau + step * segment;
    instant.cell = cell;
    instant.at = at;
    shape.channels(d.first * v, instant.first);
    shape.channels(d.second * (v * v) + d.first * at.dds, instant.second);
    shape.channels(d.third * (v * v * v) + d.second * (3.0 * v * at.dds) + d.first * at.ddds, instant.third);
    const ShapeLimits& limits = shape.limits[shape.cells[cell].limits];
    const double needed = std::max({(instant.first / limits.velocity).maxCoeff(),
                                    std::sqrt((instant.second / limits.acceleration).maxCoeff()),
                                    std::cbrt((instant.third / limits.jerk).maxCoeff())});
    if (duration && law.duration() * needed >= *duration) return std::nullopt;
    loads.stretch.push_back(needed);
    loads.largest_stretch = std::max(loads.largest_stretch, needed);
  }
  return loads;
}

namespace {

/// What law and clock may take together, so that something is left for the clock.
constexpr double kMostOfVelocity = 0.9995, kMostOfAcceleration = 0.95, kMostOfJerk = 0.9;

}  // namespace

bool leaves_room(const PathShape& shape, const Loads& loads) {
  for (const Loads::Instant& load : loads.instants) {
    const ShapeLimits& limits = shape.limits[shape.cells[load.cell].limits];
    const double velocity = (load.first / limits.velocity).maxCoeff() * kLawShareOfVelocity;
    const double acceleration = (load.second / limits.hard_acceleration).maxCoeff();
    const double jerk = (load.third / limits.hard_jerk).maxCoeff();
    if (velocity > kMostOfVelocity || acceleration > kMostOfAcceleration || jerk > kMostOfJerk) return false;
  }
  return true;
}

ClockBounds clock_for(const PathShape& shape, const Loads& loads, double stretch) {
  ClockSearch search;
  const double k1 = 1.0 / stretch;
  const double k2 = k1 * k1;
  const double k3 = k2 * k1;
  for (const Loads::Instant& load : loads.instants) {
    const ShapeLimits& limits = shape.limits[shape.cells[load.cell].limits];
    for (Eigen::Index i = 0; i < load.first.size(); ++i) {
      search.add({.first_by_acceleration = k1 * load.first[i] / limits.hard_acceleration[i],
                  .second_by_acceleration = k2 * load.second[i] / limits.hard_acceleration[i],
                  .first_by_jerk = k1 * load.first[i] / limits.hard_jerk[i],
                  .second_by_jerk = k2 * load.second[i] / limits.hard_jerk[i],
                  .third_by_jerk = k3 * load.third[i] / limits.hard_jerk[i]});
    }
  }
  return search.bounds();
}

namespace {

/// All channels at one end of a cell.
void add_stop_loads(const PathShape& shape, const PathShape::Cell& cell, const PathShape::Derivatives& d,
                    std::vector<StopLoad>& loads) {
  const ShapeLimits& limits = shape.limits[cell.limits];
  const int n = shape.joint_count;
  for (int i = 0; i < n; ++i) {
    loads.push_back({.first = std::abs(d.first[i]),
                     .along = d.first[i] < 0.0 ? -d.second[i] : d.second[i],
                     .across = 0.0,
                     .third = std::abs(d.third[i]),
                     .acceleration = limits.hard_acceleration[i],
                     .jerk = limits.hard_jerk[i]});
  }
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d first = d.first.segment<3>(n + 3 * i), second = d.second.segment<3>(n + 3 * i);
    const double length = first.norm();
    const double along = length > 0.0 ? first.dot(second) / length : 0.0;
    loads.push_back({.first = length,
                     .along = along,
                     .across = std::sqrt(std::max(0.0, second.squaredNorm() - along * along)),
                     .third = d.third.segment<3>(n + 3 * i).matrix().norm(),
                     .acceleration = limits.hard_acceleration[n + i],
                     .jerk = limits.hard_jerk[n + i]});
  }
}

/// True if another piece begins or ends within kNearby of the cell.
bool near_joint(const PathShape& shape, std::size_t index) {
  constexpr double kNearby = 0.02;
  const double begin = shape.nodes[shape.cells[index].node].s, end = begin + shape.cells[index].width;
  const auto is_joint = [&shape](std::size_t i) { return shape.cells[i].node != shape.cells[i - 1].node + 1; };
  for (std::size_t i = index; i > 0 && shape.nodes[shape.cells[i].node].s > begin - kNearby; --i)
    if (is_joint(i)) return true;
  for (std::size_t i = index + 1; i < shape.cells.size() && shape.nodes[shape.cells[i].node].s < end + kNearby; ++i)
    if (is_joint(i)) return true;
  return false;
}

}  // namespace

StopTable stop_table_for(const PathShape& shape, const TimeLaw& law, double jerk_at_joints) {
  StopTable table;
  table.reserve(shape.cells.size());
  std::vector<StopLoad> loads;
  const FastestOf fastest(law);
  for (std::size_t i = 0; i < shape.cells.size(); ++i) {
    const PathShape::Cell& cell = shape.cells[i];
    const double s_begin = shape.nodes[cell.node].s, s_end = shape.nodes[cell.node + 1].s;
    loads.clear();
    add_stop_loads(shape, cell, shape.derivatives(i, s_begin), loads);
    add_stop_loads(shape, cell, shape.derivatives(i, s_end), loads);
    // Near to where pieces meet curvature may have another sign between two nodes.
    for (StopLoad& load : loads)
      if (jerk_at_joints > 0.0) load.along = -std::abs(load.along);
    table.push_back(stop_cell(loads, fastest.between(s_begin, s_end), s_end));
    if (jerk_at_joints > 0.0 && near_joint(shape, i)) {
      StopCell& last = table.back();
      last.jerk_by_cube = std::max(last.jerk_by_cube, jerk_at_joints * last.jerk);
    }
  }
  table.back().s_end = 1.0;
  return simplified(table);
}

}  // namespace takt::motion
