// Two compliant arms with one bar that meets something in its way (docs/how-to/two-arms.md).
#include <algorithm>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/run/session.h"
#include "core/base/json.h"
#include "core/expression/condition_state.h"
#include "core/kinematics/chain.h"

namespace takt::cell::pair_springs_test {
namespace {

using Json = nlohmann::ordered_json;

/// The cell of the scenario carry until both hold the bar, with a block 10 mm above it, off its middle.
Json holding_the_bar() {
  Json scenario = read_json("scenarios/carry.json").value();
  scenario["objects"]["in the way"] = {
      {"shape", "box"}, {"size_m", {0.04, 0.08, 0.02}}, {"at", {{"in", "world"}, {"position_m", {0.8, -0.15, 0.86}}}}};
  Json& steps = scenario["program"]["steps"];
  steps.erase(steps.begin() + 4, steps.end());
  scenario["expectations"] =
      Json::array({{{"kind", "limits"}, {"arm", "left"}}, {{"kind", "limits"}, {"arm", "right"}}});
  for (const char* key : {"film", "cameras"}) scenario.erase(key);
  for (const char* arm : {"left", "right"})
    steps.push_back({{"do", "control_mode"}, {"arm", arm}, {"mode", "cartesian_impedance"}});
  return scenario;
}

Json up(double stiffness, double by, const std::string& name) {
  return {{"do", "lin"},
          {"name", name},
          {"arm", "left"},
          {"follower", "right"},
          {"to", {{"by_m", {0, 0, by}}}},
          {"velocity_m_s", 0.02},
          {"compliance", {{"mode", "cartesian_impedance"}, {"stiffness_N_m", stiffness}}}};
}

/// What the block is pushed with, and what the two do to each other, at the end, N; how far the set points moved to
/// each other; how the run ended.
struct Lifted {
  double force = 0.0, internal = 0.0, apart = 0.0;
  RunReport report;
};
Lifted lift(double stiffness) {
  Json scenario = holding_the_bar();
  scenario["program"]["steps"].push_back(up(stiffness, 0.005, "a little"));
  scenario["program"]["steps"].push_back(up(stiffness, 0.025, "against the block"));
  const auto description = parse_description(scenario.dump());
  EXPECT_TRUE(description) << description.error().to_string();
  static const device::ModelLibrary models({"models"});
  auto session = Session::create(*description, models);
  EXPECT_TRUE(session) << session.error().to_string();
  Lifted lifted;
  if (!session) return lifted;
  std::optional<std::size_t> watch;
  std::optional<expression::RealSensor> squeezed;
  std::optional<Eigen::Matrix4d> first;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    if (!watch) watch = built.world->watch_contact("bar", "in the way").value();
    if (!squeezed) squeezed = expression::internal_force(built.cell, "left wrist", "right wrist", {});
    constexpr double kMean = 0.01;  // over some 100 cycles: the sensors are noisy
    lifted.force += kMean * (built.world->contact(*watch).force - lifted.force);
    lifted.internal += kMean * (squeezed->now().value_or(0.0) - lifted.internal);
    const auto flange = [&](const char* name) -> Eigen::Isometry3d {
      const device::Arm& arm = *built.core->find_arm(name);
      return *built.cell.frames.pose(name) * arm.description().chain->forward(arm.set_point().q);
    };
    // From where both are on springs nothing but their common motion moves them.
    const bool together = built.core->find_arm("right")->mode() == device::ControlMode::kCartesianImpedance;
    if (!together) return true;
    const Eigen::Matrix4d X_LF = (flange("left").inverse() * flange("right")).matrix();
    if (!first) first = X_LF;
    lifted.apart = std::max(lifted.apart, (X_LF - *first).cwiseAbs().maxCoeff());
    return true;
  };
  lifted.report = (*session)->run(options);
  return lifted;
}

TEST(PairOnSprings, P5_SofterSpringsPushLessAgainstWhatIsInTheWayAndWhatIsSentAgrees) {
  const Lifted soft = lift(300), stiff = lift(5000);
  for (const Lifted* one : {&soft, &stiff}) {
    EXPECT_EQ(one->report.verdict, Verdict::kPassed) << one->report.diagnostics.to_string();
    EXPECT_LT(one->apart, 1e-9);
  }
  EXPECT_NEAR(soft.force, 2 * 300 * 0.02, 4.0) << "both springs, 20 mm beyond the block";
  EXPECT_GT(stiff.force, 2.5 * soft.force);
  EXPECT_GT(stiff.internal, 3.0 * soft.internal);
  RecordProperty("soft_mN", static_cast<int>(1e3 * soft.force));
  RecordProperty("stiff_mN", static_cast<int>(1e3 * stiff.force));
  RecordProperty("soft_internal_mN", static_cast<int>(1e3 * soft.internal));
  RecordProperty("stiff_internal_mN", static_cast<int>(1e3 * stiff.internal));
}

}  // namespace
}  // namespace takt::cell::pair_springs_test
