// What the cycle pays for kinematics and dynamics of a seven-axis arm (the LWR 4+ of models/).
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/solutions.h"

namespace takt::kinematics {
namespace {

Chain load_arm() {
  const auto model = RobotModel::load("models/lwr4plus/lwr4plus.urdf");
  const auto chain =
      model ? Chain::create(*model, model->root().name, "flange") : Result<Chain>(std::unexpected(model.error()));
  if (chain) return *chain;
  std::fprintf(stderr, "run from the root of the repository\n%s", chain.error().to_string().c_str());
  std::exit(2);
}

const Chain& arm() {
  static const Chain chain = load_arm();
  return chain;
}

/// Smooth motion through good postures, as a cycle sees it: 1 kHz, up to about 1 rad/s per joint.
constexpr double kPeriod = 1e-3;
constexpr int kCycles = 4096;

struct Motion {
  std::vector<JointVector> q, dq, ddq;
};

const Motion& motion() {
  static const Motion made = [] {
    Motion m;
    const double home[] = {0.0, -0.52, 0.0, 1.57, 0.0, -1.05, 0.0};
    for (int k = 0; k < kCycles; ++k) {
      const double t = k * kPeriod;
      JointVector q(7), dq(7), ddq(7);
      for (int i = 0; i < 7; ++i) {
        const double w = 1.5 + 0.3 * i;
        q[i] = home[i] + 0.45 * std::sin(w * t + i);
        dq[i] = 0.45 * w * std::cos(w * t + i);
        ddq[i] = -0.45 * w * w * std::sin(w * t + i);
      }
      m.q.push_back(q);
      m.dq.push_back(dq);
      m.ddq.push_back(ddq);
    }
    return m;
  }();
  return made;
}

std::size_t next(std::size_t k) { return (k + 1) % kCycles; }

void forward(benchmark::State& state) {
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(arm().forward(motion().q[k]));
    k = next(k);
  }
}
BENCHMARK(forward);

void forward_and_jacobian(benchmark::State& state) {
  Eigen::Isometry3d X_BF;
  Jacobian J;
  std::size_t k = 0;
  for (auto _ : state) {
    arm().jacobian(motion().q[k], X_BF, J);
    benchmark::DoNotOptimize(J);
    k = next(k);
  }
}
BENCHMARK(forward_and_jacobian);

void inverse_dynamics(benchmark::State& state) {
  const Eigen::Vector3d gravity(0.0, 0.0, -9.81);
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(arm().inverse_dynamics(motion().q[k], motion().dq[k], motion().ddq[k], gravity));
    k = next(k);
  }
}
BENCHMARK(inverse_dynamics);

void mass_matrix(benchmark::State& state) {
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(arm().mass_matrix(motion().q[k]));
    k = next(k);
  }
}
BENCHMARK(mass_matrix);

/// Pose, dq and ddq in one call. Argument 0: seed = the last cycle's q; 1: extrapolated by its dq and ddq.
void cyclic_inverse(benchmark::State& state) {
  const auto inverse = InverseKinematics::create(arm());
  std::vector<InverseKinematics::Goal> goals;
  for (int k = 0; k < kCycles; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto& [q, dq, ddq] = std::tie(motion().q[i], motion().dq[i], motion().ddq[i]);
    InverseKinematics::Goal goal;
    Jacobian J;
    arm().jacobian(q, goal.X_BF, J);
    goal.V_BF_B = J * dq;
    goal.A_BF_B = J * ddq + arm().jacobian_dot_times_dq(q, dq);
    goal.held = inverse->held(q);
    goal.held_dq = inverse->held(dq);
    goal.held_ddq = inverse->held(ddq);
    goals.push_back(goal);
  }
  std::size_t k = 0;
  for (auto _ : state) {
    JointVector q = motion().q[k], dq = motion().dq[k], ddq = motion().ddq[k];
    if (state.range(0) == 1) q += kPeriod * dq + (0.5 * kPeriod * kPeriod) * ddq;
    k = next(k);
    if (k == 0) continue;
    if (inverse->solve_motion(goals[k], q, dq, ddq) != IkStatus::kOk) state.SkipWithError("not converged");
    benchmark::DoNotOptimize(ddq);
  }
}
BENCHMARK(cyclic_inverse)->Arg(0)->Arg(1);

/// All solutions of one pose after the other. Argument 0: the default grid of the third joint; 1: its value given.
void all_solutions(benchmark::State& state) {
  std::size_t k = 0;
  for (auto _ : state) {
    SolutionOptions options;
    options.reference = motion().q[k];
    if (state.range(0) == 1) options.held_values = {motion().q[k][2]};
    benchmark::DoNotOptimize(inverse_solutions(arm(), arm().forward(motion().q[k]), options));
    k = next(k);
  }
}
BENCHMARK(all_solutions)->Arg(0)->Arg(1);

void load_model(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(RobotModel::load("models/lwr4plus/lwr4plus.urdf"));
}
BENCHMARK(load_model);

void singularity_measure(benchmark::State& state) {
  const auto inverse = InverseKinematics::create(arm());
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(inverse->singularity_measure(motion().q[k]));
    k = next(k);
  }
}
BENCHMARK(singularity_measure);

}  // namespace
}  // namespace takt::kinematics

BENCHMARK_MAIN();
