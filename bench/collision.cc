// Collisions: a pair, an arm among bodies, a motion of one arm and of two. docs/benchmarks.md has the figures.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "core/base/random.h"
#include "core/collision/body_pair.h"
#include "core/collision/cell_shapes.h"
#include "core/collision/motion_check.h"
#include "core/collision/narrow_phase.h"

namespace takt::collision {
namespace {

Eigen::Isometry3d shifted(double x, double y, double z) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << x, y, z;
  return X;
}

/// One or two arms with probes, 50 bodies in their reach, and the floor.
struct Cell {
  explicit Cell(int arms) {
    for (int i = 0; i < arms; ++i) {
      const std::string name = i == 0 ? "left" : "right";
      const auto arm = kinematics::RobotModel::load("models/lwr4plus/lwr4plus.urdf");
      const auto probe = kinematics::RobotModel::load("models/probe_ball/probe_ball.urdf");
      (void)scene.add_robot(name, *arm, -1, shifted(1.2 * i, 0, 0.75));
      (void)scene.add_robot(name + " probe", *probe, scene.find(name + "/" + arm->links.back().name),
                            Eigen::Isometry3d::Identity());
    }
    Random random(3);
    for (int i = 0; i < 50; ++i) {
      const double turn = random.uniform(-3.1, 3.1), radius = random.uniform(0.55, 0.9);
      const world::Object::Part part{.shape = world::Box{{0.08, 0.08, 0.08}}};
      scene.add_object("body " + std::to_string(i), {part}, -1,
                       shifted(radius * std::cos(turn), radius * std::sin(turn), random.uniform(0.0, 0.8)));
    }
    shapes.add_floor();
    scene.find_pairs_that_never_meet();
  }
  CellShapes shapes;
  Scene& scene = shapes.scene;
};

/// 2 s from posture to posture that meets nothing.
Trajectory motion_of(const Scene& scene) {
  const std::size_t joints = scene.joints().size();
  Trajectory motion{.duration = 2.0, .at = {}};
  for (std::size_t j = 0; j < joints; ++j) {
    motion.joints.push_back(static_cast<int>(j));
    motion.acceleration.push_back(6.0);
  }
  // From home, bent forward over the bodies, a swing of 70 degrees and back up a little.
  static constexpr double kHome[7] = {0.0, -0.5236, 0.0, 1.5708, 0.0, -1.0472, 0.0};
  motion.at = [joints](double time, std::vector<double>& q) {
    const double u = 0.5 * time, s = u * u * (3.0 - 2.0 * u);
    for (std::size_t j = 0; j < joints; ++j) q[j] = kHome[j % 7] + (j % 7 == 0 ? 1.2 : 0.15) * s;
  };
  return motion;
}

void pair_of_bodies(benchmark::State& state) {
  const Convex box = Convex::from(world::Box{{0.2, 0.1, 0.3}});
  const Convex rod = Convex::from(world::Cylinder{0.05, 0.2});
  Random random(1);
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 256; ++i) {
    Eigen::Isometry3d X = shifted(random.uniform(0.25, 0.5), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2));
    X.linear() = Eigen::AngleAxisd(random.uniform(-3, 3), Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    poses.push_back(X);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(separation(box, rod, poses[i++ % poses.size()], Eigen::Vector3d::UnitX(), 1e9));
  }
}
BENCHMARK(pair_of_bodies);

/// The smallest distance of the arm to all 50 bodies, in a cycle: the posture moves on by a step of a millisecond.
void arm_to_bodies(benchmark::State& state) {
  const Cell cell(1);
  const Scene& scene = cell.scene;
  std::vector<BodyPair> pairs;
  const int n = static_cast<int>(scene.bodies().size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      if (!scene.body(a).parts.empty() && (scene.body(b).owner.starts_with("body") || b == cell.shapes.floor) &&
          !scene.body(a).owner.starts_with("body"))
        pairs.emplace_back(scene, a, b);
  NearestPair nearest(scene, std::move(pairs));
  const Trajectory motion = motion_of(scene);
  State at = scene.start();
  Poses poses;
  scene.place(at, poses);
  const std::vector<int> order = [&] {
    std::vector<int> moved;
    const std::vector<bool> moves = scene.moved_by(at, motion.joints);
    for (const int body : scene.parents_first(at))
      if (moves[static_cast<std::size_t>(body)]) moved.push_back(body);
    return moved;
  }();
  double time = 0.0;
  for (auto _ : state) {
    time = time > 1.999 ? 0.0 : time + 1e-3;
    motion.at(time, at.q);
    scene.place_some(at, order, poses);
    benchmark::DoNotOptimize(nearest.distance(poses));
  }
}
BENCHMARK(arm_to_bodies);

void motion_check(benchmark::State& state) {
  const Cell cell(static_cast<int>(state.range(0)));
  const Trajectory motion = motion_of(cell.scene);
  std::size_t hits = 0;
  for (auto _ : state) hits += check_motion(cell.scene, cell.scene.start(), motion, {}).size();
  state.counters["hits"] = static_cast<double>(hits) / static_cast<double>(state.iterations());
}
BENCHMARK(motion_check)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace takt::collision

BENCHMARK_MAIN();
