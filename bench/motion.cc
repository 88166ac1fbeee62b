// What planning costs before a start, and what following a plan costs in the cycle (the LWR 4+ of models/).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/inverse.h"
#include "core/motion/leg.h"
#include "core/motion/path_clock.h"
#include "core/motion/planner.h"

namespace takt::motion {
namespace {

using kinematics::Chain;
using kinematics::InverseKinematics;
using kinematics::RobotModel;

constexpr double kPeriod = 1e-3;

template <class T>
T value_or_exit(Result<T> result) {
  if (result) return *std::move(result);
  std::fprintf(stderr, "run from the root of the repository\n%s", result.error().to_string().c_str());
  std::exit(2);
}

struct Arm {
  RobotModel model = value_or_exit(RobotModel::load("models/lwr4plus/lwr4plus.urdf"));
  Chain chain = value_or_exit(Chain::create(model, model.root().name, "flange"));
  InverseKinematics inverse = value_or_exit(InverseKinematics::create(chain));
  JointLimits limits{.lower = chain.lower(),
                     .upper = chain.upper(),
                     .velocity = chain.velocity_limit(),
                     .acceleration = JointVector::Constant(7, 8.0),
                     .jerk = JointVector::Constant(7, 160.0)};
  CartesianLimits cartesian;
  JointVector home = JointVector::Zero(7);
};

const Arm& arm() {
  static const Arm made = [] {
    Arm a;
    a.home << 0.0, -0.5236, 0.0, 1.5708, 0.0, -1.0472, 0.0;
    return a;
  }();
  return made;
}

JointVector goal_near_home(Random& random, double size) {
  JointVector q = arm().home;
  for (int i = 0; i < q.size(); ++i) q[i] += random.uniform(-size, size);
  return q;
}

/// Wall time of each call, told as percentiles beside the mean.
class Percentiles {
 public:
  template <class F>
  void time(F call) {
    const auto begin = std::chrono::steady_clock::now();
    call();
    const auto end = std::chrono::steady_clock::now();
    microseconds_.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
  }
  void tell(benchmark::State& state) {
    std::ranges::sort(microseconds_);
    const auto at = [&](double share) {
      return microseconds_[static_cast<std::size_t>(share * static_cast<double>(microseconds_.size() - 1))];
    };
    state.counters["p50_us"] = at(0.5);
    state.counters["p99_us"] = at(0.99);
  }

 private:
  std::vector<double> microseconds_;
};

void ptp(benchmark::State& state) {
  Random random(1);
  Percentiles times;
  for (auto _ : state) {
    times.time([&] {
      benchmark::DoNotOptimize(plan_ptp(arm().chain, arm().limits, arm().home, goal_near_home(random, 0.7)));
    });
  }
  times.tell(state);
}

void lin(benchmark::State& state) {
  Random random(2);
  Percentiles times;
  long refused = 0;
  for (auto _ : state) {
    const auto X_goal = arm().chain.forward(goal_near_home(random, 0.25));
    times.time([&] {
      const auto motion = plan_lin(arm().chain, arm().inverse, arm().limits, arm().cartesian, arm().home, X_goal);
      refused += !motion;
      benchmark::DoNotOptimize(motion);
    });
  }
  times.tell(state);
  state.counters["refused"] = benchmark::Counter(static_cast<double>(refused), benchmark::Counter::kAvgIterations);
}

/// Four motions blended into one: PTP, LIN, an arc, LIN.
void blended_sequence(benchmark::State& state) {
  const ArmModel model{arm().chain, &arm().inverse, arm().limits, arm().cartesian};
  const Blend blend{Blend::Kind::kDistance, 0.03};
  const auto shifted = [](const JointVector& q, double x, double y, double z) -> Eigen::Isometry3d {
    return Eigen::Translation3d(x, y, z) * arm().chain.forward(q);
  };
  const auto blended = [&](Result<Leg> leg) {
    if (leg) leg->blend = blend;
    return leg;
  };
  const std::vector<LegMaker> makers = {
      [&](const JointVector& q) { return blended(ptp_leg(model, q, q + JointVector::Constant(7, 0.2))); },
      [&](const JointVector& q) { return blended(lin_leg(model, q, shifted(q, 0, 0, -0.15))); },
      [&](const JointVector& q) {
        return blended(
            circ_leg(model, q,
                     ArcThrough{.p_via = shifted(q, 0.05, 0.05, 0).translation(), .X_BM_goal = shifted(q, 0, 0.1, 0)}));
      },
      [&](const JointVector& q) { return blended(lin_leg(model, q, shifted(q, 0, 0, 0.1))); }};
  long refused = 0;
  for (auto _ : state) {
    const auto plan = plan_sequence(model, arm().home, makers);
    refused += !plan || !plan->notes.empty();
    benchmark::DoNotOptimize(plan);
  }
  state.counters["refused"] = benchmark::Counter(static_cast<double>(refused), benchmark::Counter::kAvgIterations);
}

/// 5 mm/s over 50 mm: the approach of a probe.
void lin_slow(benchmark::State& state) {
  const Eigen::Isometry3d X_goal = Eigen::Translation3d(0, 0, -0.05) * arm().chain.forward(arm().home);
  for (auto _ : state) {
    benchmark::DoNotOptimize(plan_lin(arm().chain, arm().inverse, arm().limits, arm().cartesian, arm().home, X_goal, {},
                                      {.linear_velocity = 0.005}));
  }
}

void clock_update(benchmark::State& state) {
  PathClock clock({.acceleration_max = 5.0, .jerk_max = 30.0}, 1e9, true);
  clock.reset({.tau = 5e8});
  long k = 0;
  double target = 1.0;
  for (auto _ : state) {
    if (++k % 300 == 0) target = static_cast<double>(k / 300 % 5) * 0.5 - 1.0;
    benchmark::DoNotOptimize(clock.update(target, kPeriod));
  }
}

void law_at(benchmark::State& state) {
  const TimeLaw law = TimeLaw::rest_to_rest({.velocity = 1.0, .acceleration = 4.0, .jerk = 40.0});
  double tau = 0.0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(law.at(tau));
    tau = tau < law.duration() ? tau + kPeriod : 0.0;
  }
}

void cartesian_line_sample(benchmark::State& state) {
  const auto line =
      CartesianLine::between(arm().chain.forward(arm().home), arm().chain.forward(JointVector::Constant(7, 0.3)));
  double s = 0.0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(line.sample({.s = s, .ds = 1.0, .dds = 1.0}));
    s = s < 1.0 ? s + 1e-3 : 0.0;
  }
}

BENCHMARK(ptp)->Unit(benchmark::kMicrosecond);
BENCHMARK(lin)->Unit(benchmark::kMicrosecond);
BENCHMARK(lin_slow)->Unit(benchmark::kMicrosecond);
BENCHMARK(blended_sequence)->Unit(benchmark::kMicrosecond);
BENCHMARK(clock_update);
BENCHMARK(law_at);
BENCHMARK(cartesian_line_sample);

}  // namespace
}  // namespace takt::motion

BENCHMARK_MAIN();
