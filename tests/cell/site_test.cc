// Site files and --backend: what they say, what they refuse, and that the schema agrees.
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "cell/build/site_devices.h"
#include "cell/file/site.h"
#include "cell/run/session.h"
#include "tests/support/reports.h"

namespace takt::cell::site_test {
namespace {

using takt::test::Reports;
using testing::HasSubstr;

constexpr const char* kWhole = R"({
  "$schema": "../schemas/site.schema.json", "title": "Cell 3", "pad_delays": false, "master_clock": "left",
  "devices": {
    "left": {"backend": "slow", "cycle_ms": 4, "offset_ms": -3.5, "drift_ppm": -50, "transport_ms": 0.2,
             "jitter_ms": 0.7, "loss": 0.01, "repeat": 0.02, "reorder": 0.03, "answer_timeout_cycles": 5},
    "right": {"backend": "sim"},
    "wrist": {}
  }})";

TEST(Site, EveryKeyIsRead) {
  const auto site = parse_site(kWhole);
  ASSERT_TRUE(site) << site.error().to_string();
  EXPECT_FALSE(site->pad_delays);
  EXPECT_EQ(site->master_clock, "left");
  const Binding& left = *site->find("left");
  EXPECT_EQ(left.kind, "slow");
  EXPECT_EQ(left.slow.cycle, 4 * kMillisecond);
  EXPECT_EQ(left.slow.clock_offset, -3'500'000);
  EXPECT_DOUBLE_EQ(left.slow.drift, -50e-6);
  EXPECT_EQ(left.slow.wire.transport, 200'000);
  EXPECT_EQ(left.slow.wire.jitter, 700'000);
  EXPECT_EQ(left.slow.wire.loss, 0.01);
  EXPECT_EQ(left.slow.wire.repeat, 0.02);
  EXPECT_EQ(left.slow.wire.reorder, 0.03);
  EXPECT_EQ(left.slow.answer_timeout_cycles, 5);
  EXPECT_EQ(site->find("right")->kind, "sim");
  EXPECT_EQ(site->find("wrist")->kind, "sim");
  EXPECT_EQ(site->find("nobody"), nullptr);
}

TEST(Site, TheCommandLineSaysTheSameShorter) {
  Site site;
  const Diagnostics diagnostics = cell::bind(
      site, "arm=slow:8ms,offset=5ms,drift=-20ppm,jitter=0.5ms,transport=0.1ms,loss=1%,repeat=2%,reorder=3%,timeout=7");
  ASSERT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  const Binding& arm = *site.find("arm");
  EXPECT_EQ(arm.slow.cycle, 8 * kMillisecond);
  EXPECT_EQ(arm.slow.clock_offset, 5 * kMillisecond);
  EXPECT_DOUBLE_EQ(arm.slow.drift, -20e-6);
  EXPECT_EQ(arm.slow.wire.jitter, 500'000);
  EXPECT_DOUBLE_EQ(arm.slow.wire.loss, 0.01);
  EXPECT_DOUBLE_EQ(arm.slow.wire.reorder, 0.03);
  EXPECT_EQ(arm.slow.answer_timeout_cycles, 7);
  EXPECT_TRUE(cell::bind(site, "arm=sim").empty());
  EXPECT_EQ(site.find("arm")->kind, "sim") << "the last one counts";
  EXPECT_TRUE(cell::bind(site, "arm=slow").empty());
  EXPECT_EQ(site.find("arm")->slow.cycle, 0) << "that of the model";
}

TEST(Site, WhatIsWrongIsSaidWithWhatIsAllowed) {
  struct Case {
    const char* argument;
    Code code;
    std::vector<std::string> names;
  };
  for (const Case& c :
       {Case{"arm", Code::kInvalidValue, {"arm"}}, Case{"=slow", Code::kInvalidValue, {"=slow"}},
        Case{"arm=fri:192.0.2.1", Code::kUnknownName, {"fri"}}, Case{"arm=slow:8", Code::kInvalidValue, {"8", "ms"}},
        Case{"arm=slow:fast", Code::kInvalidValue, {"fast"}},
        Case{"arm=slow:8ms,drfit=1ppm", Code::kInvalidValue, {"drfit", "drift"}},
        Case{"arm=slow:0.5ms", Code::kOutOfRange, {"1", "100"}}, Case{"arm=slow:101ms", Code::kOutOfRange, {"100"}},
        Case{"arm=slow:8ms,loss=90%", Code::kOutOfRange, {"0.9"}},
        Case{"arm=sim:8ms", Code::kInvalidValue, {"sim", "8ms"}}, Case{"arm=slow:8ms,,", Code::kInvalidValue, {}},
        Case{"arm=slow:nanms", Code::kInvalidValue, {"nanms"}}}) {
    Site site;
    const Diagnostics diagnostics = cell::bind(site, c.argument);
    EXPECT_TRUE(diagnostics.has_errors()) << c.argument;
    EXPECT_THAT(diagnostics, takt::test::ReportsAnywhere(c.code, c.names)) << c.argument;
    EXPECT_TRUE(site.devices.empty()) << c.argument;
  }
}

TEST(Site, AFileIsRefusedWithAllThatIsWrong) {
  const auto site = parse_site(R"({"devices": {"arm": {"backend": "slwo"}, "b": {"backend": "slow", "drift_ppm": 1000},
                                   "c": {"backend": "sim", "cycle_ms": 8}}, "pad": true})");
  ASSERT_FALSE(site);
  const std::string text = site.error().to_string();
  for (const char* part : {"/devices/arm/backend", "slow", "/devices/b/drift_ppm", "/devices/c/cycle_ms", "/pad"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_FALSE(parse_site("{}"));
  EXPECT_FALSE(parse_site("[1]"));
  EXPECT_FALSE(parse_site("nonsense"));
  EXPECT_FALSE(read_site("no/such/file.json"));
}

TEST(Site, T4_LockStepAndAClockOfItsOwnAreRefusedTogether) {
  const std::vector<BackendKind> kinds{{"sim", false, ""}, {"wire", true, ""}};
  Site site;
  site.devices["left"].kind = "sim";
  site.devices["right"].kind = "wire";
  site.devices["right"].pointer = "/devices/right";
  const Diagnostics refused = check_clocks(site, /*realtime=*/false, kinds);
  ASSERT_EQ(refused.list().size(), 1u);
  EXPECT_THAT(refused, Reports(Code::kIncompatible, "/devices/right", {"right", "wire"}));
  EXPECT_TRUE(check_clocks(site, /*realtime=*/true, kinds).empty());
  for (const BackendKind& kind : backend_kinds()) EXPECT_FALSE(kind.own_clock) << "all run in lock-step so far";
}

std::string text_of(const std::string& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Site, TheSchemaAgreesWithTheReader) {
  valijson::Schema schema;
  const auto text = nlohmann::json::parse(text_of("schemas/site.schema.json"));
  valijson::SchemaParser(valijson::SchemaParser::kDraft7)
      .populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
  const auto agree = [&](const nlohmann::json& json) {
    const bool accepted =
        valijson::Validator().validate(schema, valijson::adapters::NlohmannJsonAdapter(json), nullptr);
    EXPECT_EQ(accepted, parse_site(json.dump()).has_value()) << json.dump();
    return accepted;
  };
  const auto whole = nlohmann::json::parse(kWhole);
  EXPECT_TRUE(agree(whole));
  // Each number of the slow device, too small and too large; each key misspelt; each type wrong.
  for (const auto& [key, value] : whole["devices"]["left"].items()) {
    for (const nlohmann::json& wrong : {nlohmann::json(-1e12), nlohmann::json(1e12), nlohmann::json("x"),
                                        nlohmann::json(nullptr), nlohmann::json::array()}) {
      nlohmann::json changed = whole;
      changed["devices"]["left"][key] = wrong;
      EXPECT_FALSE(agree(changed));
    }
    nlohmann::json changed = whole;
    changed["devices"]["left"].erase(key);
    changed["devices"]["left"][key + "_"] = value;
    EXPECT_FALSE(agree(changed));
  }
  for (const double cycle : {0.0, 0.5, 1.0, 100.0, 100.5}) {
    nlohmann::json changed = whole;
    changed["devices"]["left"]["cycle_ms"] = cycle;
    (void)agree(changed);
  }
  nlohmann::json changed = whole;
  changed.erase("devices");
  EXPECT_FALSE(agree(changed));
}

// -- In a run ---------------------------------------------------------------------------------------------------------

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

/// One arm, or two, that move by joints for about a second.
RunReport run(const std::string& devices, const std::vector<std::string>& backends, std::uint64_t seed = 1) {
  Site site;
  for (const std::string& backend : backends) {
    const Diagnostics diagnostics = cell::bind(site, backend);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  }
  auto description = parse_description(R"({"devices": {)" + devices + R"(}, "program": {"do": "sequence", "steps": [
        {"do": "lin", "arm": "a", "to": {"by_m": [0, 0, 0.05]}},
        {"do": "lin", "arm": "a", "to": {"by_m": [0, 0, -0.05]}}]}})",
                                       {}, seed);
  EXPECT_TRUE(description) << description.error().to_string();
  description->site = site;
  auto session = Session::create(std::move(*description), models());
  EXPECT_TRUE(session) << session.error().to_string();
  return (*session)->run({});
}

const std::string kOne = R"("a": {"model": "lwr4plus"})";
const std::string kTwo = kOne + R"(, "b": {"model": "ur5", "at": {"in": "world", "position_m": [1.5, 0, 0]}})";

TEST(SiteRun, T1_TheDelayIsTheDeclaredOne) {
  const RunReport report = run(kOne, {"a=slow:8ms"});
  ASSERT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  const DeviceTiming& arm = report.site.devices.at(0);
  const Nanoseconds declared = arm.declared.driver_delay + arm.declared.dead_time;
  EXPECT_EQ(declared, 17 * kMillisecond + 300'000) << "period, jitter, two cycles of the device";
  // What the estimate of the clock is off by: a share of the jitter, and the transport that nobody knows.
  EXPECT_NEAR(static_cast<double>(arm.delay_least), static_cast<double>(declared), 450'000.0);
  EXPECT_NEAR(static_cast<double>(arm.delay_most), static_cast<double>(declared), 450'000.0);
  EXPECT_LE(report.site.skew, 400'000);
  EXPECT_LE(arm.sample_age_most, arm.declared.sample_age);
  EXPECT_GT(arm.sample_age_most, 7 * kMillisecond);
  EXPECT_EQ(arm.dry, 0u);
}

// What is padded among arms that one net drives together: tests/hw/cell/padding_test.cc.
TEST(SiteRun, T3_ArmsThatNoNetDrivesTogetherAreNotPadded) {
  const RunReport alone = run(kTwo, {"b=slow:8ms,jitter=0ms,transport=0ms"});
  ASSERT_EQ(alone.verdict, Verdict::kPassed) << alone.diagnostics.to_string();
  const auto delay = [](const DeviceTiming& arm) { return arm.declared.driver_delay + arm.declared.dead_time; };
  EXPECT_EQ(delay(alone.site.devices.at(0)), 0);
  EXPECT_EQ(delay(alone.site.devices.at(1)), 17 * kMillisecond);
}

TEST(SiteRun, AModelsOwnCycleIsKept) {
  const RunReport report = run(R"("a": {"model": "tx90"})", {});
  ASSERT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_EQ(report.site.devices.at(0).declared.cycle, 4 * kMillisecond);
  EXPECT_EQ(report.site.devices.at(0).delay_least, 9 * kMillisecond);
  EXPECT_EQ(report.site.devices.at(0).delay_most, 9 * kMillisecond) << "an ideal clock: exactly";
  const RunReport direct = run(kOne, {});
  EXPECT_EQ(direct.site.devices.at(0).declared.cycle, 0) << "the LWR takes one each millisecond";
}

TEST(SiteRun, D4_TheSameSeedGivesTheSameRunAndEverySeedAnother) {
  const std::vector<std::string> backends{"a=slow:4ms,loss=1%,repeat=1%,reorder=1%"};
  const RunReport first = run(kOne, backends), second = run(kOne, backends), other = run(kOne, backends, 2);
  EXPECT_EQ(first.digest, second.digest);
  EXPECT_NE(first.digest, other.digest);
  EXPECT_GT(first.site.devices.at(0).lost, 0u);
  EXPECT_GT(first.site.devices.at(0).repeated, 0u);
}

TEST(SiteRun, DevicesThatAreNotThereOrCannotBeSlowAreErrors) {
  auto description = parse_description(R"({"devices": {)" + kOne + R"(, "probe": {"model": "probe_ball", "on": "a"}},
                                           "program": {"do": "sequence", "steps": []}})");
  ASSERT_TRUE(description) << description.error().to_string();
  ASSERT_TRUE(cell::bind(description->site, "arm=slow:8ms").empty());
  ASSERT_TRUE(cell::bind(description->site, "probe=slow:8ms").empty());
  const auto session = Session::create(std::move(*description), models());
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error(), Reports(Code::kUnknownName, "--backend", {"arm"}));
  EXPECT_THAT(session.error(), Reports(Code::kUnsupported, "--backend", {"probe", "tool"}));
}

}  // namespace
}  // namespace takt::cell::site_test
