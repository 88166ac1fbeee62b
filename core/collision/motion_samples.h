#pragma once

#include <vector>

#include "core/collision/scene.h"
#include "core/collision/trajectory.h"

namespace takt::collision {

/// A motion at equally spaced times: poses of the bodies that move, and how far their points travel.
/// Thread: one at a time. Realtime: setup.
class MotionSamples {
 public:
  /// Scene and motion must outlive it.
  MotionSamples(const Scene& scene, const State& state, const Trajectory& motion);

  [[nodiscard]] int count() const { return count_; }  ///< of steps; there is one sample more
  [[nodiscard]] double step() const { return motion_.duration / count_; }
  [[nodiscard]] double time(int k) const { return k == count_ ? motion_.duration : k * step(); }
  [[nodiscard]] bool moves(int body) const { return row_of_[static_cast<std::size_t>(body)] >= 0; }

  /// Puts a body at a sample into the poses; what does not move is there already.
  void put(int body, int k) {
    const int row = row_of_[static_cast<std::size_t>(body)];
    if (row >= 0) poses_[static_cast<std::size_t>(body)] = sampled_[index(row, k)];
  }
  [[nodiscard]] const Poses& poses() const { return poses_; }
  [[nodiscard]] Eigen::Isometry3d pose(int body, int k) const {
    const int row = row_of_[static_cast<std::size_t>(body)];
    return row < 0 ? poses_[static_cast<std::size_t>(body)] : sampled_[index(row, k)];
  }
  /// No point of a body travels further than this from sample 0 to sample k: grows with k. m
  [[nodiscard]] double travel(int body, int k) const {
    const int row = row_of_[static_cast<std::size_t>(body)];
    return row < 0 ? 0.0 : travel_[index(row, k)];
  }
  /// Seen from another body no point of a body travels further than this from sample k to the next, m.
  [[nodiscard]] double travel_seen_from(int other, int body, int k) const;

  /// Puts all that moves to any time, for looks between samples.
  void put_all(double time, std::vector<double>& q);
  /// The same bound as travel(), for two poses of a body within the step after sample k that are `apart` s apart.
  [[nodiscard]] double between(int body, int k, const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                               double apart) const {
    return between(body, k, from, to, apart, 0.0);
  }
  [[nodiscard]] std::vector<double> q_at(double time) const;

 private:
  [[nodiscard]] std::size_t index(int row, int k) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(count_ + 1) + static_cast<std::size_t>(k);
  }
  [[nodiscard]] std::vector<double>& joints(int k) { return q_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const std::vector<double>& joints(int k) const { return q_[static_cast<std::size_t>(k)]; }

  /// Of points that are carried along by a body, so far outside of its ball, m.
  [[nodiscard]] double between(int body, int k, const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                               double apart, double beyond) const;
  /// Largest acceleration of any point of each body: joints that accelerate, and turns of what turns. Of the whole
  /// motion, or of each step where steps are long.
  void find_curvature();
  void add_curvature(const std::vector<double>& levers, const std::vector<double>& acceleration,
                     const std::vector<double>& fastest);
  /// By row and joint of the motion; see lever_of().
  [[nodiscard]] std::vector<double> find_levers() const;
  /// No joint is faster than the fastest of the chords and what it can gain between two samples.
  [[nodiscard]] std::vector<double> fastest_joints(int first_step, int last_step,
                                                   const std::vector<double>& acceleration) const;
  [[nodiscard]] int body_of(int joint) const;
  [[nodiscard]] int parent_of(int body) const;
  /// How far a point of a body can be from the axis of a joint below it, in any posture; negative: that joint does not
  /// move it.
  [[nodiscard]] double lever_of(int body, int joint) const;
  /// How far a sliding joint is out at most.
  [[nodiscard]] double range_of(int joint) const;
  void sample();

  const Scene& scene_;
  const Trajectory& motion_;
  State state_;
  std::vector<int> order_;   ///< bodies that move, parents first
  std::vector<int> row_of_;  ///< by body: where it is in order_; -1: it does not move
  int count_ = 1;
  std::vector<std::vector<double>> q_;  ///< of all joints, by sample
  Poses poses_;
  std::vector<Eigen::Isometry3d> sampled_;
  std::vector<double> travel_;
  /// Largest acceleration of a point, m/s^2.
  struct Bend {
    double inside = 0.0;  ///< of the body's ball
    double beyond = 0.0;  ///< more for each m that it is further away, 1/s^2
  };
  std::vector<Bend> bend_;  ///< by row, or by step and row
};

}  // namespace takt::collision
