// Scenarios on an arm behind a driver, with the emulated controller in the process: the simulated run again, later by
// the delay, and the same bits for the same seed.
#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "cell/run/session.h"
#include "core/base/json.h"
#include "hw/drivers.h"
#include "tests/support/reports.h"
#include "tests/support/scratch_folder.h"

namespace takt::cell {
namespace {

using takt::test::Names;
using takt::test::Reports;

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

/// An arm with a force sensor over a block: there, down until it is felt, and back.
const std::string kTouch = R"({
  "devices": {
    "arm": {"model": "lwr4plus", "at": {"in": "world"}},
    "wrist": {"model": "ft_gamma", "on": "arm"},
    "probe": {"model": "probe_ball", "on": "wrist"}
  },
  "objects": {
    "block": {"shape": "box", "size_m": [0.2, 0.2, 0.1], "fixed": true,
              "at": {"in": "world", "position_m": [0.56, 0, 0.05]}}
  },
  "program": {"do": "sequence", "steps": [
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.065]}, "speed": 0.5},
    {"do": "tare", "cycles": 200},
    {"do": "lin", "to": {"by_m": [0, 0, -0.03]}, "velocity_m_s": 0.005,
     "until": {"sensor": "wrist", "quantity": "force", "above_N": 5}},
    {"do": "lin", "to": {"by_m": [0.03, 0, 0.05]}, "speed": 0.5},
    {"do": "wait", "seconds": 0.2}
  ]}
})";

struct Driven {
  RunReport report;
  std::vector<device::JointVector> q;  // of the plant, each cycle
};

Driven run(const std::string& text, const std::vector<std::string>& backends, std::uint64_t seed = 1) {
  hw::add_own_drivers();
  Site site;
  for (const std::string& backend : backends) {
    const Diagnostics diagnostics = cell::bind(site, backend);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
  }
  auto description = parse_description(text, {}, seed);
  EXPECT_TRUE(description) << description.error().to_string();
  description->site = site;
  auto session = Session::create(std::move(*description), models());
  EXPECT_TRUE(session) << session.error().to_string();
  Driven driven;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    driven.q.push_back(built.cell.arms.at("arm").device->sample().q);
    return true;
  };
  driven.report = (*session)->run(options);
  return driven;
}

/// Largest distance of a trajectory's points from another one's, which may be later or earlier by `open` cycles: what a
/// guarded motion's end is late by, all that follows it is, too.
double apart(const std::vector<device::JointVector>& a, const std::vector<device::JointVector>& b, std::int64_t open) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    double nearest = 10.0;
    for (std::int64_t shift = -open; shift <= open; ++shift) {
      const std::int64_t at =
          std::clamp<std::int64_t>(static_cast<std::int64_t>(k) + shift, 0, static_cast<std::int64_t>(b.size()) - 1);
      nearest = std::min(nearest, (a[k] - b[static_cast<std::size_t>(at)]).cwiseAbs().maxCoeff());
    }
    most = std::max(most, nearest);
  }
  return most;
}

/// In which cycle the arm has first left its start.
std::int64_t first_motion(const std::vector<device::JointVector>& q) {
  const auto begin = std::ranges::find_if(q, [](const auto& one) { return one.size() > 0; });
  const auto moved = std::ranges::find_if(begin, q.end(),
                                          [&](const auto& one) { return (one - *begin).cwiseAbs().maxCoeff() > 1e-3; });
  return moved - q.begin();
}

TEST(FriRun, ATouchThroughTheDriverIsTheSimulatedOne) {
  const Driven direct = run(kTouch, {}), fri = run(kTouch, {"arm=fri"});
  ASSERT_EQ(direct.report.verdict, Verdict::kPassed) << direct.report.diagnostics.to_string();
  ASSERT_EQ(fri.report.verdict, Verdict::kPassed) << fri.report.diagnostics.to_string();
  EXPECT_GT(first_motion(fri.q) - first_motion(direct.q), 70) << "KRL has to start first";
  const auto moving = [](const std::vector<device::JointVector>& q) {
    return std::vector<device::JointVector>(q.begin() + first_motion(q) - 10, q.end());
  };
  EXPECT_LE(apart(moving(direct.q), moving(fri.q), 12), 1e-3) << "rad";
  EXPECT_EQ(fri.report.site.realities.at("arm"), device::BackendMode::kEmulated);
  EXPECT_EQ(fri.report.site.realities.at("wrist"), device::BackendMode::kSimulated);
  EXPECT_THAT(to_text(fri.report, "touch"), Names("arm EMULATED", "probe SIM", "wrist SIM"));
}

TEST(FriRun, TheSameSeedGivesTheSameDigestOverABadWire) {
  const std::vector<std::string> bad{"arm=fri:virtual,loss=5%,jitter=0.2ms,repeat=2%,drift=80ppm"};
  const Driven a = run(kTouch, bad), b = run(kTouch, bad), c = run(kTouch, bad, 2);
  ASSERT_EQ(a.report.verdict, Verdict::kPassed) << a.report.diagnostics.to_string();
  EXPECT_EQ(a.report.digest, b.report.digest);
  EXPECT_NE(a.report.digest, c.report.digest);
}

/// Of the device, in the report of a run.
DeviceTiming timing_of(const Driven& driven, std::string_view device) {
  const auto& devices = driven.report.site.devices;
  const auto found = std::ranges::find(devices, device, &DeviceTiming::device);
  EXPECT_NE(found, devices.end()) << device;
  return found == devices.end() ? DeviceTiming{} : *found;
}

TEST(FriRun, TheReportCountsWhatTheWireDidToSamples) {
  const Driven good = run(kTouch, {"arm=fri"}), bad = run(kTouch, {"arm=fri:virtual,loss=5%,repeat=2%,drift=80ppm"});
  EXPECT_EQ(timing_of(good, "arm").lost, 0u);
  EXPECT_EQ(timing_of(good, "arm").repeated, 0u);
  const DeviceTiming arm = timing_of(bad, "arm");
  EXPECT_GT(arm.lost, 10u);
  EXPECT_GT(arm.repeated, 3u);
  EXPECT_NEAR(arm.drift_ppm, 80.0, 40.0);
  EXPECT_EQ(timing_of(bad, "wrist").lost, 0u) << "simulated";
}

TEST(FriRun, StatesOnTheWayUpAreNoErrors) {
  const Driven fri = run(kTouch, {"arm=fri"});
  ASSERT_EQ(fri.report.verdict, Verdict::kPassed) << fri.report.diagnostics.to_string();
  for (const LogEntry& entry : fri.report.log) {
    EXPECT_LT(entry.level, LogLevel::kWarning) << to_text(entry);
    EXPECT_NE(entry.name, "recovered") << "there was no fault";
  }
  EXPECT_TRUE(std::ranges::any_of(fri.report.log, [](const LogEntry& entry) { return entry.name == "starting"; }));
}

TEST(FriRun, AnArmOfSixJointsAndADeviceThatIsNoArmAreRefused) {
  hw::add_own_drivers();
  Site site;
  EXPECT_TRUE(cell::bind(site, "arm=fri").empty());
  EXPECT_TRUE(cell::bind(site, "wrist=fri").empty());
  auto description =
      parse_description(R"({"devices": {"arm": {"model": "ur5"}, "wrist": {"model": "ft_gamma", "on": "arm"}},
                                           "program": {"do": "wait", "seconds": 1}})",
                        {}, 1);
  ASSERT_TRUE(description) << description.error().to_string();
  description->site = site;
  const auto session = Session::create(std::move(*description), models());
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error(), Reports(Code::kIncompatible, "--backend", {"arm", "fri", "ur5", "7", "6"}));
  EXPECT_THAT(session.error(), Reports(Code::kIncompatible, "--backend", {"wrist", "fri", "force_torque_sensor"}));
}

TEST(FriRun, AnArmThatIsElsewhereIsNotStarted) {
  std::string text = R"({"devices": {"arm": {"model": "lwr4plus"}}, "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": "home"}]}})";
  hw::add_own_drivers();
  Site site;
  EXPECT_TRUE(cell::bind(site, "arm=fri").empty());
  auto description = parse_description(text, {}, 1);
  ASSERT_TRUE(description);
  description->site = site;
  auto session = Session::create(std::move(*description), models());
  ASSERT_TRUE(session);
  // As if somebody had moved the robot: the program was planned from elsewhere.
  const_cast<BuiltCell&>((*session)->built()).cell.arms.at("arm").start[3] += 0.1;
  const RunReport report = (*session)->run({});
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kConditionNotMet, "/devices/arm/start_deg", {"arm", "a3"}));
}

TEST(FriSite, AddressesAndKeysOfTheCommandLineAreThoseOfASiteFile) {
  hw::add_own_drivers();
  Site site;
  EXPECT_TRUE(bind(site, "arm=fri:192.0.2.1:4000,krl=ros_control,cycle=2ms,margin=1.5ms").empty());
  const Binding* robot = site.find("arm");
  ASSERT_TRUE(robot && robot->driver);
  EXPECT_TRUE(robot->own_clock());
  EXPECT_EQ(robot->driver->reality(), device::BackendMode::kHardware);
  EXPECT_EQ(check_clocks(site, false).list().size(), 1u) << "row T4";
  EXPECT_TRUE(bind(site, "arm=fri:127.0.0.1").empty());
  EXPECT_EQ(site.find("arm")->driver->reality(), device::BackendMode::kEmulated);
  EXPECT_TRUE(bind(site, "arm=fri:192.0.2.1,emulated=true").empty());
  EXPECT_EQ(site.find("arm")->driver->reality(), device::BackendMode::kEmulated);
  EXPECT_TRUE(bind(site, "arm=fri").empty());
  EXPECT_FALSE(site.find("arm")->own_clock());
  EXPECT_TRUE(check_clocks(site, false).empty());
  EXPECT_THAT(bind(site, "arm=fri:robot"), Reports(Code::kInvalidValue, "--backend/address", {"robot"}));
  EXPECT_THAT(bind(site, "arm=fri:virtual,krl=rust"), Reports(Code::kUnknownName, "--backend/krl", {"rust"}));
  EXPECT_THAT(bind(site, "arm=fri:virtual,cycle=0.5ms"), Reports(Code::kOutOfRange, "--backend/cycle_ms", {"0.5"}));
  EXPECT_THAT(bind(site, "arm=fri:virtual,colour=red"), Reports(Code::kUnknownKey, "--backend/colour", {"colour"}));
}

TEST(RtdeSite, WhatIsInstalledOnAnEmulatedControllerIsCheckedWhenItIsRead) {
  hw::add_own_drivers();
  Site site;
  const takt::test::ScratchFolder folder("programs");
  const std::string programs =
      "arm=rtde:127.0.0.2,series=e,remote_control=false,external_control=127.0.0.1:50010,programs=";
  EXPECT_THAT(cell::bind(site, programs + folder.path().string()),
              Reports(Code::kNotFound, "--backend/programs", {".script"}));
  std::ofstream(folder / "wave.script") << "def wave():\nend\n";
  EXPECT_TRUE(cell::bind(site, programs + folder.path().string()).empty());
  EXPECT_THAT(cell::bind(site, programs + "/nowhere"),
              Reports(Code::kFileNotReadable, "--backend/programs", {"/nowhere"}));
  EXPECT_THAT(cell::bind(site, "arm=rtde:virtual,remote_control=false"),
              Reports(Code::kIncompatible, "--backend/remote_control", {"CB3"}));
  EXPECT_THAT(cell::bind(site, "arm=rtde:virtual,external_control=robot"),
              Reports(Code::kInvalidValue, "--backend/external_control", {"robot"}));
}

/// The schema of site files, and whether it and the reader are of one opinion about a device.
class SiteSchema {
 public:
  SiteSchema() {
    hw::add_own_drivers();
    const auto read = read_json("schemas/site.schema.json");
    EXPECT_TRUE(read);
    const nlohmann::json text = *read;
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema_);
  }
  bool agree(const nlohmann::json& device) {
    const nlohmann::json json{{"devices", {{"arm", device}}}};
    const bool accepted =
        valijson::Validator().validate(schema_, valijson::adapters::NlohmannJsonAdapter(json), nullptr);
    EXPECT_EQ(accepted, parse_site(json.dump()).has_value()) << json.dump();
    return accepted;
  }
  /// Each key with values of other types and out of range, and by another name.
  void spoil_each_key_of(const nlohmann::json& whole) {
    EXPECT_TRUE(agree(whole));
    for (const auto& [key, value] : whole.items()) {
      for (const nlohmann::json& wrong :
           {nlohmann::json(-1e12), nlohmann::json(1e12), nlohmann::json(nullptr), nlohmann::json::array()}) {
        nlohmann::json changed = whole;
        changed[key] = wrong;
        EXPECT_FALSE(agree(changed)) << key;
      }
      nlohmann::json changed = whole;
      changed.erase(key);
      changed[key + "_"] = value;
      EXPECT_FALSE(agree(changed)) << key;
    }
  }

 private:
  valijson::Schema schema_;
};

TEST(SiteSchema, KnowsEveryKindOfBackEnd) {
  SiteSchema schema;
  for (const BackendKind& kind : backend_kinds()) {
    nlohmann::json device{{"backend", kind.name}};
    if (kind.name == kTerminals) device["of"] = "arm";
    EXPECT_TRUE(schema.agree(device)) << kind.name;
  }
}

TEST(SiteSchema, AgreesWithTheReaderOfEachDriver) {
  SiteSchema schema;
  const takt::test::ScratchFolder programs("programs");
  std::ofstream(programs / "wave.script") << "def wave():\nend\n";
  schema.spoil_each_key_of({{"backend", "fri"},
                            {"address", "192.0.2.1:49938"},
                            {"emulated", false},
                            {"cycle_ms", 4},
                            {"krl", "fri_control"},
                            {"task_frame", "tool"},
                            {"margin_ms", 2.5},
                            {"bridged_cycles", 10},
                            {"offset_ms", 5},
                            {"drift_ppm", -3},
                            {"transport_ms", 0.1},
                            {"jitter_ms", 0.2},
                            {"loss", 0.1},
                            {"repeat", 0.1},
                            {"reorder", 0.1},
                            {"corrupt", 0.1},
                            {"truncate", 0.1}});
  schema.spoil_each_key_of({{"backend", "rtde"},
                            {"address", "192.0.2.1"},
                            {"emulated", false},
                            {"series", "e"},
                            {"robot", "UR5e"},
                            {"registers", "lower"},
                            {"lookahead_s", 0.05},
                            {"gain", 500},
                            {"power_on", true},
                            {"remote_control", false},
                            {"external_control", "192.0.2.2:50010"},
                            {"programs", programs.path().string()},
                            {"margin_ms", 2.5},
                            {"transport_ms", 0.2},
                            {"jitter_ms", 0.2}});
  schema.spoil_each_key_of({{"backend", "cia402"},
                            {"address", "can0"},
                            {"emulated", false},
                            {"cycle_ms", 4},
                            {"first_node", 3},
                            {"heartbeat_ms", 20},
                            {"margin_ms", 2.5},
                            {"bridged_cycles", 2},
                            {"transport_ms", 0.1},
                            {"jitter_ms", 0.1},
                            {"loss", 0.1}});
  schema.spoil_each_key_of({{"backend", "wsg"},
                            {"address", "192.0.2.1:1000"},
                            {"emulated", false},
                            {"update_ms", 10},
                            {"home", true},
                            {"referenced", false},
                            {"transport_ms", 0.2},
                            {"jitter_ms", 0.2},
                            {"piece_bytes", 5}});
  schema.spoil_each_key_of({{"backend", "modbus"},
                            {"address", "192.0.2.1:502"},
                            {"emulated", false},
                            {"cycle_ms", 10},
                            {"digital_inputs", 0},
                            {"digital_outputs", 512},
                            {"analog_inputs", 4},
                            {"analog_outputs", 2048},
                            {"analog_counts", 4095},
                            {"unit", 2},
                            {"timeout_ms", 100},
                            {"watchdog_ms", 500},
                            {"transport_ms", 0.2},
                            {"jitter_ms", 0.2},
                            {"piece_bytes", 5}});
  schema.spoil_each_key_of({{"backend", "terminals"}, {"of", "arm"}});
}

}  // namespace
}  // namespace takt::cell
