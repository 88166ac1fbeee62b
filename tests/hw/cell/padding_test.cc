// Delays are padded among arms that one net drives together (row T3), and nobody loses a control mode by it.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_builder.h"
#include "cell/build/site_devices.h"
#include "cell/run/session.h"
#include "tests/cell/described.h"

namespace takt::cell::padding_test {
namespace {

using Json = nlohmann::json;

/// Two arms that look at each other, 1.4 m apart.
Json cell(const std::string& right, const Json& steps) {
  return {{"devices",
           {{"left", {{"model", "lwr4plus"}, {"at", {{"in", "world"}, {"position_m", {0, 0, 0.4}}}}}},
            {"right",
             {{"model", right}, {"at", {{"in", "world"}, {"position_m", {1.4, 0, 0.4}}, {"rpy_deg", {0, 0, 180}}}}}}}},
          {"program", {{"do", "sequence"}, {"steps", steps}}}};
}

const Json kSoftly = {{"do", "control_mode"}, {"arm", "left"}, {"mode", "cartesian_impedance"}};
const Json kTogether = {
    {"do", "lin"}, {"arm", "left"}, {"follower", "right"}, {"to", {{"by_m", {0, 0, 0.03}}}}, {"velocity_m_s", 0.05}};
Json alone(const std::string& arm) {
  return {{"do", "lin"}, {"arm", arm}, {"to", {{"by_m", {0, 0, 0.03}}}}, {"velocity_m_s", 0.05}};
}

std::unique_ptr<Session> session_of(const Json& scenario, const Site& site = {}) {
  Description description = test::parsed(scenario.dump());
  description.site = site;
  auto session = Session::create(std::move(description), test::models());
  EXPECT_TRUE(session) << session.error().to_string();
  return session ? std::move(*session) : nullptr;
}

Nanoseconds delay(const Session& session, const std::string& arm) {
  const device::BackendTiming timing = session.built().cell.arms.at(arm).device->timing();
  return timing.driver_delay + timing.dead_time;
}
std::size_t modes(const Session& session, const std::string& arm) {
  return session.built().cell.arms.at(arm).device->description().modes.modes.size();
}

Site with_a_slow_right_arm() {
  Site site;
  EXPECT_TRUE(bind(site, "right=slow:8ms").empty());
  return site;
}

TEST(Padding, AnArmThatDoesNotCooperateIsAsFastAsItIs) {
  const auto session = session_of(cell("ur5", Json::array({kSoftly, alone("left"), alone("right")})));
  ASSERT_TRUE(session);
  EXPECT_EQ(delay(*session, "left"), 0);
  EXPECT_EQ(delay(*session, "right"), 17 * kMillisecond);
  EXPECT_EQ(modes(*session, "left"), 3u);
  const RunReport report = session->run({});
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(Padding, ArmsThatMoveAsOneAreEquallyLateAndKeepTheirModes) {
  const auto session = session_of(cell("lwr4plus", Json::array({kTogether, kSoftly})), with_a_slow_right_arm());
  ASSERT_TRUE(session);
  EXPECT_GT(delay(*session, "right"), 0);
  EXPECT_EQ(delay(*session, "left"), delay(*session, "right"));
  EXPECT_EQ(modes(*session, "left"), 3u);
  EXPECT_EQ(modes(*session, "right"), 3u);
  const RunReport report = session->run({});
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_EQ(session->built().cell.arms.at("left").device->mode(), device::ControlMode::kCartesianImpedance);
  EXPECT_LE(report.site.skew, kMillisecond);
}

TEST(Padding, ACellForAProgramThatIsNotKnownIsPaddedAsAWhole) {
  const Json wait = {{"do", "wait"}, {"seconds", 1}};
  Diagnostics warnings;
  Description description = test::parsed(cell("ur5", Json::array({wait})).dump());
  const auto built = build_cell(description, test::models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  EXPECT_EQ(built->cell.arms.at("left").device->timing().driver_delay +
                built->cell.arms.at("left").device->timing().dead_time,
            17 * kMillisecond);
}

TEST(Padding, ASiteCanForbidIt) {
  Site site = with_a_slow_right_arm();
  site.pad_delays = false;
  const auto session = session_of(cell("lwr4plus", Json::array({kTogether})), site);
  ASSERT_TRUE(session);
  EXPECT_EQ(delay(*session, "left"), 0);
}

TEST(Padding, GroupsThatShareAnArmAreOne) {
  Json scenario = cell("lwr4plus", Json::array({kTogether}));
  scenario["devices"]["third"] = {{"model", "tx90"}, {"at", {{"in", "world"}, {"position_m", {0, 3, 0}}}}};
  Description description = test::parsed(scenario.dump());
  description.site.cooperating = ArmGroups{{"left", "right"}, {"right", "third"}};
  Diagnostics warnings;
  const auto built = build_cell(description, test::models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  for (const char* arm : {"left", "right", "third"}) {
    const auto timing = built->cell.arms.at(arm).device->timing();
    EXPECT_EQ(timing.driver_delay + timing.dead_time, 9 * kMillisecond) << arm;
  }
  EXPECT_FALSE(built->site->differ_in_delay(*description.site.cooperating));
}

}  // namespace
}  // namespace takt::cell::padding_test
