// A seam with a weave through its corners, in the simulation: it never stops, the tool is where it is sent, and nobody
// who interrupts it anywhere breaks a limit. On all arms.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/run/interruptions.h"
#include "cell/run/session.h"
#include "core/kinematics/chain.h"

namespace takt::cell::weave_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSpeed = 0.06, kPeriod = 1e-3;  // m/s, s

class WeaveTest : public testing::TestWithParam<const char*> {
 protected:
  /// Three sides of a square: up and down beside the first two, nothing beside the third; away by the joints.
  static Json scenario() {
    Json json = Json::parse(
        R"({"devices": {"arm": {}},
        "faults": [{"at_s": 3600, "do": "emergency_stop"}], "program": {"do": "sequence", "steps": [
        {"do": "lin", "name": "to", "to": {"by_m": [0, 0, -0.03]}},
        {"do": "lin", "name": "one", "to": {"by_m": [0, 0.08, 0]}, "blend_m": 0.012},
        {"do": "lin", "name": "two", "to": {"by_m": [-0.06, 0, 0]}, "blend_m": 0.012},
        {"do": "lin", "name": "three", "to": {"by_m": [0, -0.08, 0]}, "blend_m": 0.012},
        {"do": "ptp", "name": "home", "to": "home", "speed": 0.3}]}})");
    json["devices"]["arm"]["model"] = GetParam();
    for (const int i : {1, 2, 3}) {
      Json& step = json["program"]["steps"][static_cast<std::size_t>(i)];
      step["velocity_m_s"] = kSpeed;
      // The home postures of the arms hold the tool's z axis along the world's.
      if (i < 3)
        step["weave"] = {{"amplitude_m", 0.0015}, {"frequency_Hz", 2}, {"direction", {0, 0, 1}}, {"ramp_s", 0.4}};
    }
    return json;
  }
  static std::unique_ptr<Session> session() {
    static const device::ModelLibrary models({"models"});
    auto description = parse_description(scenario().dump());
    EXPECT_TRUE(description) << description.error().to_string();
    auto session = Session::create(std::move(*description), models);
    EXPECT_TRUE(session) << session.error().to_string();
    return session ? std::move(*session) : nullptr;
  }
  static RunOptions options() {
    RunOptions options;
    options.repeat = options.measure_times = false;
    return options;
  }
};

TEST_P(WeaveTest, ItNeverStopsInACornerAndTheToolFollows) {
  const auto seam = session();
  ASSERT_TRUE(seam);
  struct Cycle {
    Eigen::Vector3d sent, measured;
  };
  std::vector<Cycle> cycles;
  RunOptions watched = options();
  watched.after_cycle = [&](BuiltCell& built) {
    const expression::MountedArm& arm = built.cell.arms.at("arm");
    if (arm.device->set_point().q.size() == 0) return true;
    const auto tool = [&](const device::JointVector& q) -> Eigen::Vector3d {
      return (arm.device->description().chain->forward(q) * arm.X_FT).translation();
    };
    cycles.push_back({tool(arm.device->set_point().q), tool(arm.device->sample().q)});
    return true;
  };
  const RunReport report = seam->run(watched);
  ASSERT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();

  // The seam is in the plane in which the arm is after its first step.
  const double plane = cycles.front().sent.z() - 0.03;
  const auto in_plane = [&](const Cycle& cycle) { return std::abs(cycle.sent.z() - plane) < 0.0016; };
  const auto begin = std::ranges::find_if(cycles, [&](const Cycle& cycle) {
    return in_plane(cycle) && (cycle.sent - cycles.front().sent).head<2>().norm() > 0.01;
  });
  auto end = begin;
  while (end != cycles.end() && in_plane(*end)) ++end;
  ASSERT_GT(end - begin, 2500);
  double slowest = 1e9, swing = 0.0, error = 0.0, jump = 0.0;
  constexpr int kSome = 24;  // arms are measured every 1, 2 or 8 cycles
  for (auto now = begin + kSome; now != end - 300; ++now) {
    const Eigen::Vector3d way = now->sent - (now - 1)->sent;
    slowest = std::min(slowest, way.head<2>().norm() / kPeriod);
    jump = std::max(jump, (now->measured - (now - kSome)->measured).norm() / (kSome * kPeriod));
    swing = std::max(swing, std::abs(now->measured.z() - plane));
    error = std::max(error, (now->measured - now->sent).norm());
  }
  EXPECT_GT(slowest, 0.7 * kSpeed) << "at the corners too";
  EXPECT_NEAR(swing, 0.0015, 4e-4);
  EXPECT_LT(jump, 1.6 * kSpeed) << "what the film shows has no leap";
  EXPECT_LT(error, 2e-3) << "the loops lag behind by some milliseconds";
}

// Rows L6, P2, S1.
TEST_P(WeaveTest, L6_P2_S1_InterruptedAnywhereItKeepsAllLimits) {
  const auto seam = session();
  ASSERT_TRUE(seam);
  constexpr std::int64_t kEvery = 10;
  Interruptions tries({.first = 600, .every = kEvery, .ways = [](std::int64_t point) {
                         const auto all = Interruptions::by_program(point);
                         return std::vector<Interruptions::Way>{
                             point % 4 == 3 ? Interruptions::Way::kStop1 : all[static_cast<std::size_t>(point % 3)]};
                       }});
  RunOptions interrupted = options();
  tries.attach(interrupted);
  const RunReport report = seam->run(interrupted);
  if (tries.in_child()) {
    if (report.verdict == Verdict::kError && tries.way() == Interruptions::Way::kCancel)
      tries.complain("a cancel became an error: " + report.diagnostics.to_string());
    tries.answer();
  }
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_GE(tries.tried(), 300);
  for (const std::string& failure : tries.failures()) ADD_FAILURE() << failure;
}

INSTANTIATE_TEST_SUITE_P(Arms, WeaveTest, testing::Values("lwr4plus", "ur5", "tx90"));

}  // namespace
}  // namespace takt::cell::weave_test
