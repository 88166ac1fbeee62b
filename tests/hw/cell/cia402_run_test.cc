// Scenarios on a TX90 behind its driver, with the emulated drives in the process.
#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cell/build/site_devices.h"
#include "cell/run/session.h"
#include "hw/drivers.h"
#include "tests/cell/described.h"

namespace takt::cell::cia402_run_test {
namespace {

/// Down until something is felt, and back: the block is below the probe.
const std::string kTouchDown = R"({
  "devices": {
    "arm": {"model": "tx90", "at": {"in": "world"}},
    "wrist": {"model": "ft_gamma", "on": "arm"},
    "probe": {"model": "probe_ball", "on": "wrist"}
  },
  "objects": {
    "block": {"shape": "box", "size_m": [0.2, 0.2, 0.1], "fixed": true,
              "at": {"in": "world", "position_m": [0.7, 0, 0.05]}}
  },
  "program": {"do": "sequence", "steps": [
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.057]}, "speed": 0.5},
    {"do": "tare", "cycles": 200},
    {"do": "lin", "to": {"by_m": [0, 0, -0.03]}, "velocity_m_s": 0.001,
     "until": {"sensor": "wrist", "quantity": "force", "above_N": 5}},
    {"do": "lin", "to": {"by_m": [0.03, 0, 0.05]}, "speed": 0.5},
    {"do": "wait", "seconds": 0.2}
  ]}
})";

struct DrivenRun {
  RunReport report;
  std::vector<Eigen::VectorXd> q;  // of the plant, each cycle: samples come every fourth
};

std::unique_ptr<Session> session_of(const std::string& text, const std::vector<std::string>& backends) {
  hw::add_own_drivers();
  Description description = test::parsed(text);
  for (const std::string& backend : backends) {
    const Diagnostics diagnostics = cell::bind(description.site, backend);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  }
  auto session = Session::create(std::move(description), test::models());
  EXPECT_TRUE(session) << session.error().to_string();
  return session ? std::move(*session) : nullptr;
}

DrivenRun run(const std::string& text, const std::vector<std::string>& backends) {
  DrivenRun driven;
  const auto session = session_of(text, backends);
  if (!session) return driven;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    const auto& positions = built.world->positions();
    driven.q.emplace_back(Eigen::Map<const Eigen::VectorXd>(positions.data(), std::ssize(positions)));
    return true;
  };
  driven.report = session->run(options);
  return driven;
}

/// How far joint positions of one run, of each tenth cycle, are from the nearest ones of another.
double farthest(const DrivenRun& a, const DrivenRun& b) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.q.size(); k += 10) {
    double nearest = 10.0;
    for (const Eigen::VectorXd& other : b.q) nearest = std::min(nearest, (a.q[k] - other).lpNorm<Eigen::Infinity>());
    most = std::max(most, nearest);
  }
  return most;
}

TEST(Cia402Run, ATouchThroughTheDriverIsTheSimulatedOne) {
  const DrivenRun direct = run(kTouchDown, {}), driven = run(kTouchDown, {"arm=cia402"});
  ASSERT_EQ(direct.report.verdict, Verdict::kPassed) << direct.report.diagnostics.to_string();
  ASSERT_EQ(driven.report.verdict, Verdict::kPassed) << driven.report.diagnostics.to_string();
  EXPECT_LE(farthest(direct, driven), 1e-3) << "rad";
  EXPECT_LE(farthest(driven, direct), 1e-3) << "rad";
  EXPECT_EQ(driven.report.site.realities.at("arm"), device::BackendMode::kEmulated);
}

TEST(Cia402Run, TheSameSeedGivesTheSameDigest) {
  const std::vector<std::string> bad{"arm=cia402:virtual,jitter=0.2ms,loss=0.05%"};
  const DrivenRun a = run(kTouchDown, bad), b = run(kTouchDown, bad);
  ASSERT_EQ(a.report.verdict, Verdict::kPassed) << a.report.diagnostics.to_string();
  EXPECT_EQ(a.report.digest, b.report.digest);
}

TEST(Cia402Run, SettingsThatCannotBeAreRefused) {
  hw::add_own_drivers();
  for (const char* setting :
       {"arm=cia402:192.0.2", "arm=cia402:virtual,cycle=0.5ms", "arm=cia402:virtual,first_node=127",
        "arm=cia402:virtual,colour=red", "arm=cia402:virtual,heartbeat=5ms"}) {
    Site site;
    EXPECT_TRUE(cell::bind(site, setting).has_errors()) << setting;
  }
  Site site;
  EXPECT_TRUE(cell::bind(site, "arm=cia402:can0").empty());
  EXPECT_EQ(site.find("arm")->driver->reality(), device::BackendMode::kHardware);
  EXPECT_TRUE(site.find("arm")->own_clock());
  EXPECT_TRUE(cell::bind(site, "arm=cia402:127.0.0.1").empty());
  EXPECT_EQ(site.find("arm")->driver->reality(), device::BackendMode::kEmulated);
}

TEST(Cia402Run, NodesBeyondTheLastAreRefused) {
  hw::add_own_drivers();
  Description description = test::parsed(kTouchDown);
  EXPECT_TRUE(cell::bind(description.site, "arm=cia402:virtual,first_node=122").empty());
  const auto session = Session::create(std::move(description), test::models());
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().list().front().code, Code::kIncompatible);
}

constexpr const char* kThere = R"({"devices": {"arm": {"model": "lwr4plus"}}, "program": {"do": "sequence", "steps": [
    {"do": "ptp", "to": {"joints_deg": [20, 0, 0, 90, 0, -60, 0]}}]}})";

TEST(FirstMotions, HardwareBeginsAtAQuarterOfTheSpeedUnlessTheSiteSaysOtherwise) {
  const auto override_of = [](const std::vector<std::string>& backends, std::optional<double> said) {
    hw::add_own_drivers();
    Description description = test::parsed(kThere);
    for (const std::string& backend : backends) EXPECT_TRUE(cell::bind(description.site, backend).empty());
    description.site.speed_override = said;
    const auto session = Session::create(std::move(description), test::models());
    EXPECT_TRUE(session) << session.error().to_string();
    return session ? (*session)->built().site->speed_override() : 0.0;
  };
  EXPECT_EQ(override_of({}, {}), 1.0);
  EXPECT_EQ(override_of({"arm=fri"}, {}), 1.0) << "emulated";
  EXPECT_EQ(override_of({"arm=fri:192.0.2.1"}, {}), kFirstSpeed);
  EXPECT_EQ(override_of({"arm=fri:192.0.2.1"}, 1.0), 1.0);
  EXPECT_EQ(override_of({"arm=fri:192.0.2.1,emulated=true"}, {}), 1.0);
}

TEST(FirstMotions, TheShareCountsFromTheFirstMotionOn) {
  const auto duration = [](std::optional<double> said) {
    Description description = test::parsed(kThere);
    description.site.speed_override = said;
    const auto session = Session::create(std::move(description), test::models());
    return session ? (*session)->run({}).sim_time : 0.0;
  };
  const double whole = duration({});
  EXPECT_GT(duration(0.25), 3.0 * whole);
  EXPECT_EQ(duration(1.0), whole);
}

TEST(FirstMotions, AShareThatIsNoneIsRefused) {
  for (const char* text : {R"({"speed_override": 0, "devices": {}})", R"({"speed_override": 1.5, "devices": {}})",
                           R"({"speed_override": "slow", "devices": {}})"})
    EXPECT_FALSE(parse_site(text)) << text;
  const auto site = parse_site(R"({"speed_override": 0.5, "devices": {}})");
  ASSERT_TRUE(site) << site.error().to_string();
  EXPECT_EQ(site->speed_override, 0.5);
}

}  // namespace
}  // namespace takt::cell::cia402_run_test
