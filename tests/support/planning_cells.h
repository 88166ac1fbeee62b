#pragma once

#include <algorithm>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/collision/motion_check.h"
#include "core/device/device_file.h"
#include "core/kinematics/solutions.h"
#include "core/planning/path_search.h"

/// Cells in which arms need a way around, with drawn starts and goals: for tests and benchmarks.
namespace takt::test {

using kinematics::JointVector;

/// An LWR 4+ with a gripper at the origin, and what stands around it.
class PlanningCell {
 public:
  enum class Kind { kShelf, kTwoArms, kContainer, kEmpty };

  /// Run from the root of the repository.
  explicit PlanningCell(Kind kind) : kind_(kind) {
    arm = device::read_arm("models/lwr4plus").value();
    add_arm("arm", Eigen::Isometry3d::Identity());
    if (kind == Kind::kShelf) add_shelf();
    if (kind == Kind::kTwoArms) add_neighbour();
    if (kind == Kind::kContainer) add_containers();
    box("table", {2.4, 2.4, 0.04}, {0.6, 0.0, -0.08});
    scene.find_pairs_that_never_meet();
    for (int j = 0; j < arm->chain->joint_count(); ++j) joints.push_back(j);
    state = scene.start();
  }

  [[nodiscard]] planning::FreeSpace free_space() const {
    return planning::FreeSpace(scene, state, joints,
                               {.lower = arm->limits.lower, .upper = arm->limits.upper, .rule = {}});
  }

  struct Task {
    JointVector start, goal;
  };
  /// Two postures between which the straight line is not free, each free, with at least clearance around them.
  [[nodiscard]] Task draw(Random& random) {
    for (int attempt = 0; attempt < 1000; ++attempt) {
      if (kind_ == Kind::kTwoArms) draw_neighbour(random);
      const auto start = posture(place(random, true), random), goal = posture(place(random, false), random);
      if (!start || !goal) continue;
      planning::FreeSpace space = free_space();
      if (!space.is_free_line(*start, *goal)) return {*start, *goal};
    }
    throw std::runtime_error("no task could be drawn in this cell");
  }
  [[nodiscard]] planning::Query query(const Task& task, std::uint64_t seed = 1) const {
    return {.start = task.start,
            .goals = {task.goal},
            .lower = arm->limits.lower,
            .upper = arm->limits.upper,
            .speed = arm->limits.velocity,
            .seed = seed};
  }

  collision::Scene scene;
  collision::State state;
  std::shared_ptr<const device::ArmDescription> arm;
  std::vector<int> joints;  ///< of the arm, in the scene

 private:
  static Eigen::Isometry3d at(const Eigen::Vector3d& p) { return Eigen::Isometry3d(Eigen::Translation3d(p)); }

  void add_arm(const std::string& name, const Eigen::Isometry3d& X_WB) {
    const auto links = kinematics::RobotModel::load("models/lwr4plus/lwr4plus.urdf").value();
    const auto gripper = kinematics::RobotModel::load("models/wsg50/wsg50.urdf").value();
    (void)scene.add_robot(name, links, -1, X_WB, {arm->home.data(), arm->home.data() + arm->home.size()});
    constexpr double kOpen[] = {0.03, 0.03};  // m
    (void)scene.add_robot(name + " gripper", gripper, scene.find(name + "/" + links.links.back().name),
                          Eigen::Isometry3d::Identity(), kOpen);
  }
  void box(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
    scene.add_object(name, {{.shape = world::Box{size}}}, -1, at(p));
  }

  /// Two columns and three rows of compartments, 0.44 m wide, 0.36 m high and 0.3 m deep, open towards the arm.
  void add_shelf() {
    for (int i = 0; i < 4; ++i) box("board " + std::to_string(i), {0.3, 0.92, 0.02}, {0.75, 0.0, 0.02 + 0.38 * i});
    for (int i = 0; i < 3; ++i) box("wall " + std::to_string(i), {0.3, 0.02, 1.14}, {0.75, 0.46 * (i - 1), 0.59});
    box("back", {0.02, 0.94, 1.16}, {0.91, 0.0, 0.59});
  }
  void add_neighbour() {
    Eigen::Isometry3d X = at({1.1, 0.0, 0.0});
    X.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    add_arm("neighbour", X);
    box("post", {0.06, 0.06, 0.6}, {0.55, 0.0, 0.24});
  }
  /// Two open boxes in front of the arm with a board between them.
  void add_containers() {
    for (const double y : {-0.3, 0.3}) {
      const std::string name = y < 0.0 ? "right" : "left";
      scene.add_object(name,
                       {{.shape = world::Box{{0.44, 0.34, 0.02}}, .X_OS = at({0.0, 0.0, 0.01})},
                        {.shape = world::Box{{0.02, 0.34, 0.25}}, .X_OS = at({0.21, 0.0, 0.125})},
                        {.shape = world::Box{{0.02, 0.34, 0.25}}, .X_OS = at({-0.21, 0.0, 0.125})},
                        {.shape = world::Box{{0.44, 0.02, 0.25}}, .X_OS = at({0.0, 0.16, 0.125})},
                        {.shape = world::Box{{0.44, 0.02, 0.25}}, .X_OS = at({0.0, -0.16, 0.125})}},
                       -1, at({0.5, y, -0.05}));
    }
    box("board", {0.3, 0.02, 0.3}, {0.55, 0.0, 0.1});
  }

  /// The neighbour reaches into the middle.
  void draw_neighbour(Random& random) {
    const auto own = static_cast<std::size_t>(arm->chain->joint_count());
    static constexpr double kReaching[] = {0.0, 0.6, 0.0, -1.2, 0.0, 0.7, 0.0};
    const auto first = static_cast<std::size_t>(
        std::ranges::find_if(scene.joints(), [](const auto& name) { return name.starts_with("neighbour/"); }) -
        scene.joints().begin());
    for (std::size_t j = 0; j < own; ++j) state.q[first + j] = kReaching[j] + random.uniform(-0.35, 0.35);
  }

  /// A pose of the gripper's fingertips. @param from  at the start of the motion
  [[nodiscard]] Eigen::Isometry3d place(Random& random, bool from) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    const double side = from ? 1.0 : -1.0;
    if (kind_ == Kind::kShelf) {
      // Fingers forward, in one compartment of each column.
      const int row = static_cast<int>(random.uniform(0.0, 3.0));
      X.translation() << random.uniform(0.66, 0.76), side * random.uniform(0.12, 0.34),
          0.22 + 0.38 * row + random.uniform(-0.08, 0.08);
      X.linear() = (Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitY()) *
                    Eigen::AngleAxisd(random.uniform(-0.3, 0.3), Eigen::Vector3d::UnitX()))
                       .toRotationMatrix();
      return X;
    }
    const bool container = kind_ == Kind::kContainer;
    X.translation() << random.uniform(0.42, 0.58),
        side * (container ? random.uniform(0.24, 0.36) : random.uniform(0.2, 0.4)),
        container ? random.uniform(0.03, 0.1) : random.uniform(0.1, 0.4);
    X.linear() = (Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
                  Eigen::AngleAxisd(random.uniform(-0.4, 0.4), Eigen::Vector3d::UnitZ()))
                     .toRotationMatrix();
    return X;
  }

  /// A free posture with the fingertips there, 2 mm further from everything than paths have to be.
  [[nodiscard]] std::optional<JointVector> posture(const Eigen::Isometry3d& X_WT, Random& random) const {
    constexpr double kFingertips = 0.1175;  // m: in front of the gripper's flange
    const Eigen::Isometry3d X_BF = X_WT * at({0.0, 0.0, -kFingertips});
    kinematics::SolutionOptions options;
    options.reference = arm->home;
    options.turns = false;
    for (Eigen::Index j = 0; j < options.reference.size(); ++j) options.reference[j] += random.uniform(-0.5, 0.5);
    options.most = 16;
    planning::FreeSpace space(scene, state, joints,
                              {.clearance = 6e-3, .lower = arm->limits.lower, .upper = arm->limits.upper, .rule = {}});
    for (const JointVector& q : kinematics::inverse_solutions(*arm->chain, X_BF, options))
      if (space.is_free(q)) return q;
    return std::nullopt;
  }

  Kind kind_;
};

}  // namespace takt::test
