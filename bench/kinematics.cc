// What the cycle pays for kinematics and dynamics of a seven-axis arm (the LWR 4+ of models/).
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/arm_angle.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/closed_form.h"
#include "core/kinematics/elimination.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/posture.h"
#include "core/kinematics/robot_model.h"
#include "core/kinematics/solutions.h"

namespace takt::kinematics {
namespace {

Chain load_arm(const std::string& name) {
  const auto model = RobotModel::load("models/" + name + "/" + name + ".urdf");
  const auto chain =
      model ? Chain::create(*model, model->root().name, "flange") : Result<Chain>(std::unexpected(model.error()));
  if (chain) return *chain;
  std::fprintf(stderr, "run from the root of the repository\n%s", chain.error().to_string().c_str());
  std::exit(2);
}

const Chain& arm() {
  static const Chain chain = load_arm("lwr4plus");
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

/// Random joints of an arm, away from singular postures.
std::vector<JointVector> postures(const Chain& chain) {
  Random random(3, "bench");
  const auto inverse = InverseKinematics::create(chain);
  std::vector<JointVector> all;
  while (all.size() < kCycles) {
    JointVector q(chain.joint_count());
    for (int i = 0; i < q.size(); ++i) q[i] = random.uniform(chain.lower()[i], chain.upper()[i]);
    if (inverse->singularity_measure(q) > 1e-2) all.push_back(q);
  }
  return all;
}

constexpr const char* kArms[] = {"ur5", "tx90", "lwr4plus"};

std::vector<int> held_of(const Chain& chain) {
  return chain.joint_count() == 7 ? std::vector<int>{2} : std::vector<int>{};
}

/// All branches of one pose after the other, in closed form, the arm recognised before. Argument: UR5, TX90, LWR (third
/// joint held).
void closed_form(benchmark::State& state) {
  const Chain chain = load_arm(kArms[state.range(0)]);
  const auto q = postures(chain);
  std::vector<Eigen::Isometry3d> X;
  std::vector<ClosedForm> forms;
  for (const JointVector& at : q) {
    X.push_back(chain.forward(at));
    forms.push_back(*ClosedForm::recognise(chain, at, held_of(chain)));
  }
  ClosedForm::Candidates found;
  std::size_t k = 0;
  long solutions = 0;
  for (auto _ : state) {
    forms[k].solve(X[k], found);
    benchmark::DoNotOptimize(found);
    solutions += found.count;
    k = next(k);
  }
  state.counters["solutions"] = static_cast<double>(solutions) / static_cast<double>(state.iterations());
}
BENCHMARK(closed_form)->Arg(0)->Arg(1)->Arg(2);

/// The same by inverse_solutions: recognised, solved, checked by forward kinematics, within limits, sorted.
void all_branches(benchmark::State& state) {
  const Chain chain = load_arm(kArms[state.range(0)]);
  const auto q = postures(chain);
  std::vector<Eigen::Isometry3d> X;
  for (const JointVector& at : q) X.push_back(chain.forward(at));
  std::size_t k = 0;
  SolutionOptions options;
  options.turns = false;
  for (auto _ : state) {
    options.reference = q[k];
    if (chain.joint_count() == 7) options.held_values.assign(1, q[k][2]);
    benchmark::DoNotOptimize(inverse_solutions(chain, X[k], options));
    k = next(k);
  }
}
BENCHMARK(all_branches)->Arg(0)->Arg(1)->Arg(2);

/// The LWR at a given arm angle.
void arm_angle(benchmark::State& state) {
  const auto angle = ArmAngle::recognise(arm());
  const auto q = postures(arm());
  std::vector<Eigen::Isometry3d> X;
  for (const JointVector& at : q) X.push_back(arm().forward(at));
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(angle->solve(X[k], 0.5));
    k = next(k);
  }
}
BENCHMARK(arm_angle);

/// One opening of the loop of six axes anywhere.
void elimination(benchmark::State& state) {
  Random random(4, "axes");
  const auto number = [&] { return random.uniform(-1.0, 1.0); };
  std::array<Line, 6> lines;
  for (Line& line : lines) {
    line.point << number(), number(), number();
    line.axis = Eigen::Vector3d(number(), number(), number()).normalized();
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (const Line& line : lines) {
    const Eigen::AngleAxisd turn(number(), line.axis);
    T = T * Eigen::Translation3d(line.point) * turn * Eigen::Translation3d(-line.point);
  }
  std::vector<std::array<double, 6>> found;
  for (auto _ : state) {
    found.clear();
    eliminate(lines, T, 0, found);
    benchmark::DoNotOptimize(found);
  }
}
BENCHMARK(elimination);

void name_of_posture(benchmark::State& state) {
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(posture(arm(), motion().q[k]));
    k = next(k);
  }
}
BENCHMARK(name_of_posture);

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
