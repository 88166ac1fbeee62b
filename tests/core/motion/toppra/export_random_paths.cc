// Random blended sequences, and motions that take a running one over, as tables of joint positions, with the limits
// that a law may use and the durations that our planner finds: with jerk lifted, and with it. One JSON text on stdout,
// for compare.py.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>

#include <nlohmann/json.hpp>

#include "core/motion/plan_checks.h"
#include "tests/core/motion/motion_runs.h"
#include "tests/core/motion/random_paths.h"

namespace takt::motion::test {
namespace {

using Json = nlohmann::ordered_json;

/// Both ends of each piece, and places evenly between them.
std::vector<double> places(const Path& path) {
  std::vector<double> s{0.0};
  const auto* composite = std::get_if<CompositePath>(&path);
  const std::size_t count = composite ? composite->pieces.size() : 1;
  constexpr int kPerPiece = 60;
  for (std::size_t k = 0; k < count; ++k) {
    const double begin = composite ? composite->pieces[k].s_begin : 0.0;
    const double end = composite ? composite->pieces[k].s_end : 1.0;
    for (int i = 1; i <= kPerPiece; ++i) s.push_back(i == kPerPiece ? end : begin + (end - begin) * i / kPerPiece);
  }
  return s;
}

/// @return null if the arm cannot do it, or does not blend all of it.
Json export_case(Random& random, const std::string& urdf) {
  RandomArm arm(urdf, random);
  // The other tool knows joint limits only.
  arm.cartesian = {1e3, 1e5, 1e10, 1e3, 1e5, 1e10};
  const JointVector q0 = arm.good_q(random);
  std::vector<LegMaker> makers;
  const auto count = 1 + random.bits() % 4;
  for (std::size_t k = 0; k < count; ++k) {
    makers.push_back(random_leg(random, arm, 0.25, {Blend::Kind::kFraction, random.uniform(0.1, 0.5)}));
  }
  const auto with_jerk = plan_sequence(arm.model(), q0, makers);
  const double ramp =
      (arm.limits.acceleration * kLawShareOfAcceleration).cwiseQuotient(arm.limits.jerk * kLawShareOfJerk).maxCoeff();
  const JointVector jerk = arm.limits.jerk;
  arm.limits.jerk *= 1e4;
  const auto lifted = plan_sequence(arm.model(), q0, makers);
  if (!with_jerk || !lifted || !with_jerk->notes.empty() || !lifted->notes.empty()) return nullptr;
  if (lifted->motion.duration() < 0.05) return nullptr;
  Json table = Json::array();
  const std::vector<double> s = places(lifted->motion.path);
  for (const JointVector& q : joints_along(arm, lifted->motion, s)) table.push_back(as_list(q));
  return {{"s", s},
          {"q", std::move(table)},
          {"velocity", as_list(arm.limits.velocity * kLawShareOfVelocity)},
          {"acceleration", as_list(arm.limits.acceleration * kLawShareOfAcceleration)},
          {"jerk", as_list(jerk * kLawShareOfJerk)},
          {"longest_ramp", ramp},
          {"motions", count},
          {"begin_rate", 0.0},
          {"lifted", lifted->motion.duration()},
          {"with_jerk", with_jerk->motion.duration()}};
}

/// Leaves a motion at a random time for another one.
Result<SequencePlan> relay(const RandomArm& arm, const JointVector& q0, double share, const LegMaker& first,
                           const LegMaker& second, const Blend& blend) {
  const auto before = plan_sequence(arm.model(), q0, {first});
  if (!before) return std::unexpected(before.error());
  const double tau = share * before->motion.duration();
  return plan_take_over(arm.model(), {.motion = before->motion, .tau = tau, .lead = 1e-3, .blend = blend}, {second});
}

/// @return null if the arm cannot do it.
Json export_relay(Random& random, const std::string& urdf) {
  RandomArm arm(urdf, random);
  arm.cartesian = {1e3, 1e5, 1e10, 1e3, 1e5, 1e10};
  const JointVector q0 = arm.good_q(random);
  const LegMaker first = random_leg(random, arm, 0.25, {}), second = random_leg(random, arm, 0.25, {});
  const double share = random.uniform(0.1, 0.5);
  const Blend blend{Blend::Kind::kFraction, random.uniform(0.1, 0.4)};
  arm.limits.jerk *= 1e4;
  const auto lifted = relay(arm, q0, share, first, second, blend);
  if (!lifted || lifted->motion.duration() < 0.05) return nullptr;
  Json table = Json::array();
  const std::vector<double> s = places(lifted->motion.path);
  for (const JointVector& q : joints_along(arm, lifted->motion, s)) table.push_back(as_list(q));
  return {{"s", s},
          {"q", std::move(table)},
          {"velocity", as_list(arm.limits.velocity * kLawShareOfVelocity)},
          {"acceleration", as_list(arm.limits.acceleration * kLawShareOfAcceleration)},
          {"motions", 2},
          {"begin_rate", lifted->motion.law.begin().ds},
          {"lifted", lifted->motion.duration()}};
}

}  // namespace
}  // namespace takt::motion::test

int main(int argc, char** argv) {
  using namespace takt::motion::test;
  namespace robots = takt::kinematics::test;
  const long wanted = argc > 1 ? std::atol(argv[1]) : 20;
  takt::Random random(static_cast<std::uint64_t>(argc > 2 ? std::atol(argv[2]) : 5));
  const std::string urdfs[] = {robots::lwr_urdf(), robots::ur5_urdf(), robots::tx90_urdf()};
  Json cases = Json::array();
  for (std::size_t i = 0; static_cast<long>(cases.size()) < wanted && i < 1000; ++i) {
    const bool from_rest = static_cast<long>(cases.size()) < wanted / 2;
    Json one = from_rest ? export_case(random, urdfs[i % 3]) : export_relay(random, urdfs[i % 3]);
    if (!one.is_null()) cases.push_back(std::move(one));
  }
  std::cout << cases.dump() << '\n';
}
