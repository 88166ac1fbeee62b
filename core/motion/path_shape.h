#pragma once

#include <optional>
#include <vector>

#include "core/kinematics/types.h"
#include "core/motion/clock_bounds.h"
#include "core/motion/path_clock.h"
#include "core/motion/time_law.h"

namespace takt::motion {

/// One entry per bounded quantity of a path: the joints, then the length of the linear and of the angular vector of the
/// frame that moves.
using Channels = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kinematics::kMaxJoints + 2, 1>;
/// One entry per component: the joints, then the linear and the angular vector (three entries each).
using Components = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kinematics::kMaxJoints + 6, 1>;

/// Limits of the channels. A law may use the first three; law and clock together the other two.
struct ShapeLimits {
  Channels velocity, acceleration, jerk;
  Channels hard_acceleration, hard_jerk;
};

/// A path as the planner of time sees it: derivatives by s at nodes, cells between them, and what is allowed there.
/// Between nodes the first derivative is interpolated by cubics. Where pieces meet, a node stands twice.
struct PathShape {
  struct Node {
    double s;
    Components first;
    Components second;
  };
  /// From nodes[node] to nodes[node + 1], under limits[limits]. Made by add_cell().
  struct Cell {
    std::size_t node;
    std::size_t limits;
    double width;                     ///< in s
    Components linear, square, cube;  ///< of the first derivative by the share of the cell
  };
  struct Derivatives {
    Components first, second, third;
  };

  int joint_count = 0;
  std::vector<Node> nodes;
  std::vector<Cell> cells;
  std::vector<ShapeLimits> limits;

  /// The cell between the last two nodes, under the last limits.
  void add_cell();
  /// The cell that s lies in, looked for from `guess` on: cheap for a sequence of places.
  [[nodiscard]] std::size_t cell_at(double s, std::size_t guess) const;
  [[nodiscard]] Derivatives derivatives(std::size_t cell, double s) const;
  /// Joints one by one, vectors by their length.
  [[nodiscard]] Channels channels(const Components& components) const;
  void channels(const Components& components, Channels& result) const;
};

/// A law over a shape: what each channel does at enough instants.
struct Loads {
  struct Instant {
    double tau;
    std::size_t cell;
    LawPoint at;
    Channels first, second, third;  ///< by path time
  };
  std::vector<Instant> instants;
  /// By how much the law must be stretched at each instant so that every channel just keeps what a law may use (below
  /// 1: it could be shrunk).
  std::vector<double> stretch;
  double largest_stretch = 0.0;
};
[[nodiscard]] Loads loads_of(const PathShape& shape, const TimeLaw& law);
/// The same, given up as soon as the law, stretched by what it needs, cannot be shorter than `duration` (s; nothing:
/// never given up).
[[nodiscard]] std::optional<Loads> loads_if_shorter(const PathShape& shape, const TimeLaw& law,
                                                    std::optional<double> duration);

/// True if the law as it is keeps the limits of the shape with some room for a clock.
[[nodiscard]] bool leaves_room(const PathShape& shape, const Loads& loads);

/// The fastest clock under which law and clock keep all limits; `stretch` as applied to the law after loads_of().
/// Without stop table.
[[nodiscard]] ClockBounds clock_for(const PathShape& shape, const Loads& loads, double stretch);

/// What a stop may use on each cell of the shape under a law. @param jerk_at_joints  share of the jerk limits that the
/// law may take where pieces of the path meet, whatever the nodes show; 0 for a path of one piece
[[nodiscard]] StopTable stop_table_for(const PathShape& shape, const TimeLaw& law, double jerk_at_joints);

}  // namespace takt::motion
