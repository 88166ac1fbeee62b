// A scenario whose gripper and I/O block are behind their drivers, with what they drive emulated in the process.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "hw/drivers.h"
#include "tests/cell/described.h"

namespace takt::cell::devices_run_test {
namespace {

Description pick() {
  auto description = read_description("scenarios/pick.json");
  EXPECT_TRUE(description) << description.error().to_string();
  return description ? std::move(*description) : Description{};
}

RunReport run(const std::vector<std::string>& backends) {
  hw::add_own_drivers();
  Description description = pick();
  for (const std::string& backend : backends) {
    const Diagnostics diagnostics = cell::bind(description.site, backend);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  }
  auto session = Session::create(std::move(description), test::models());
  EXPECT_TRUE(session) << session.error().to_string();
  return session ? (*session)->run({}) : RunReport{};
}

std::string not_met(const RunReport& report) {
  std::string text = report.diagnostics.to_string();
  for (const ExpectationResult& one : report.expectations)
    if (!one.passed) text += one.name + ": " + one.measured + "\n";
  return text;
}

/// The part is gripped, carried and set down; the beam sees it, the lamp burns; and all of it once more, to the bit.
TEST(DevicesRun, PickMeetsItsExpectationsThroughTheDriversOfGripperAndTerminals) {
  const RunReport driven = run({"gripper=wsg", "io=modbus:virtual,cycle=5ms"});
  EXPECT_EQ(driven.verdict, Verdict::kPassed) << not_met(driven);
  EXPECT_EQ(driven.site.realities.at("gripper"), device::BackendMode::kEmulated);
  EXPECT_EQ(driven.site.realities.at("io"), device::BackendMode::kEmulated);
  EXPECT_EQ(driven.site.realities.at("arm"), device::BackendMode::kSimulated);
}

TEST(DevicesRun, PickMeetsThemWithTheArmBehindItsDriverTooOverABadWire) {
  const RunReport driven = run({"arm=fri:virtual,loss=2%", "gripper=wsg:virtual,jitter=2ms,piece_bytes=5",
                                "io=modbus:virtual,cycle=5ms,jitter=1ms,piece_bytes=3"});
  EXPECT_EQ(driven.verdict, Verdict::kPassed) << not_met(driven);
}

TEST(DevicesRun, ADriverIsForItsKindOfDeviceOnly) {
  hw::add_own_drivers();
  for (const char* wrong : {"arm=wsg", "gripper=fri", "gripper=modbus", "io=wsg", "barrier=modbus"}) {
    Description description = pick();
    EXPECT_TRUE(cell::bind(description.site, wrong).empty());
    const auto session = Session::create(std::move(description), test::models());
    ASSERT_FALSE(session) << wrong;
    EXPECT_EQ(session.error().list().front().code, Code::kIncompatible) << wrong;
  }
}

TEST(DevicesRun, SettingsThatCannotBeAreRefused) {
  hw::add_own_drivers();
  for (const char* setting : {"gripper=wsg:192.0.2", "gripper=wsg:virtual,update=0.5ms",
                              "gripper=wsg:virtual,colour=red", "io=modbus:192.0.2", "io=modbus:virtual,unit=256",
                              "io=modbus:virtual,cycle=0ms", "io=modbus:virtual,analog_counts=0"}) {
    Site site;
    EXPECT_TRUE(cell::bind(site, setting).has_errors()) << setting;
  }
  Site site;
  EXPECT_TRUE(cell::bind(site, "gripper=wsg:192.0.2.1").empty());
  EXPECT_TRUE(cell::bind(site, "io=modbus:127.0.0.1:1502").empty());
  EXPECT_EQ(site.find("gripper")->driver->reality(), device::BackendMode::kHardware);
  EXPECT_EQ(site.find("io")->driver->reality(), device::BackendMode::kEmulated);
  EXPECT_TRUE(site.find("io")->own_clock());
  Description description = pick();
  EXPECT_TRUE(cell::bind(description.site, "io=modbus:virtual,digital_inputs=65530").empty());
  const auto session = Session::create(std::move(description), test::models());
  ASSERT_FALSE(session);
  EXPECT_NE(session.error().to_string().find("65535"), std::string::npos) << session.error().to_string();
}

}  // namespace
}  // namespace takt::cell::devices_run_test
