// The step "net": a net written by hand, from the first cycle to what its monitors showed last.
#include <cstdint>
#include <memory>
#include <vector>

#include "core/net/description.h"
#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

class NetStepTest : public test::ActivityTest {
 protected:
  void add(const std::string& name, const std::string& json) {
    auto net = net::net_from_json(test::Json::parse(json));
    ASSERT_TRUE(net) << net.error().to_string();
    fake.cell.nets[name] = std::make_shared<const net::NetDescription>(std::move(*net));
  }
  /// Ends after 20 cycles and shows how many there were.
  void add_counting() {
    add("counting", R"({"name": "counting", "primitives": [
      {"id": "count", "type": "CycleCounter", "parameters": {"counted": true, "reset": false}},
      {"id": "watch", "type": "Stopwatch", "parameters": {"running": true, "reset": false}},
      {"id": "late", "type": "GreaterThan", "parameters": {"b": 0.0195}},
      {"id": "end", "type": "Termination"},
      {"id": "counted", "type": "MonitorInteger"}],
    "links": [{"from": "watch.elapsed", "to": "late.a"}, {"from": "late.value", "to": "end.condition"},
      {"from": "count.count", "to": "counted.value"}]})");
  }
  /// Ends when it is cancelled, and only then.
  void add_patient() {
    add("patient", R"({"name": "patient", "primitives": [
      {"id": "cancel", "type": "Cancel"}, {"id": "end", "type": "Termination"}],
    "links": [{"from": "cancel.requested", "to": "end.condition"}]})");
  }
};

TEST_F(NetStepTest, ANetRunsToItsEndAndItsMonitorsAreKept) {
  add_counting();
  ASSERT_EQ(run(R"({"do": "net", "net": "counting"})"), Progress::kDone) << diagnostics.to_string();
  const int counted = std::stoi(variables.monitors["counting"]["counted"]);
  EXPECT_NEAR(counted, 20, 1);
  EXPECT_THAT(log, Contains("counting: counted " + std::to_string(counted)));
  EXPECT_LE(cycles, counted + latency + 3);
}

TEST_F(NetStepTest, MonitorsAreShownAtTheirRateWhileTheNetRuns) {
  add_counting();
  const program::Program program = good(R"({"do": "net", "net": "counting", "monitor_rate_Hz": 200})");
  std::vector<std::int64_t> shown;
  ASSERT_EQ(run(program,
                [&](int, program::ProgramRunner&) {
                  const auto of_net = variables.monitors.find("counting");
                  if (of_net == variables.monitors.end() || of_net->second.at("counted") == "null") return;
                  const std::int64_t now = std::stoll(of_net->second.at("counted"));
                  if (shown.empty() || shown.back() != now) shown.push_back(now);
                }),
            Progress::kDone)
      << diagnostics.to_string();
  ASSERT_GE(shown.size(), 3U) << "while it runs";
  for (std::size_t i = 1; i < shown.size(); ++i) EXPECT_EQ(shown[i] - shown[i - 1], 5) << "200 Hz of 1 kHz";
  EXPECT_THAT(wrong(R"({"do": "net", "net": "counting", "monitor_rate_Hz": 0})").list().front().pointer,
              "/program/monitor_rate_Hz");
}

TEST_F(NetStepTest, ACancelReachesTheNetWhenItIsDue) {
  add_patient();
  ASSERT_EQ(run(R"({"do": "net", "net": "patient", "cancel_after_s": 0.1})"), Progress::kDone)
      << diagnostics.to_string();
  EXPECT_NEAR(cycles, 100, 6);
}

TEST_F(NetStepTest, ANetThatOutstaysItsTimeIsAnErrorAndEnds) {
  add_patient();
  ASSERT_EQ(run(R"({"do": "net", "net": "patient", "within_s": 0.05})"), Progress::kFailed);
  EXPECT_THAT(pointers(diagnostics), ElementsAre("/program/within_s"));
  EXPECT_NEAR(cycles, 50, 6);
  fake.step();
  const auto ended = [](const rcc::Event& event) { return event.state == rcc::NetState::kTerminated; };
  EXPECT_TRUE(std::ranges::any_of(fake.core.events(), ended));
}

TEST_F(NetStepTest, TheNameOfANetIsChecked) {
  add_patient();
  const auto refusal = parse(R"({"do": "net", "net": "patent", "within_s": -1})");
  ASSERT_FALSE(refusal);
  EXPECT_THAT(pointers(refusal.error()), ElementsAre("/program/net", "/program/within_s"));
  EXPECT_THAT(refusal.error(), Reports(Code::kUnknownName, "/program/net", {"patient"}));
}

TEST_F(NetStepTest, RehearsalVerifiesTheNet) {
  add("wrong",
      R"({"name": "wrong", "primitives": [{"id": "robot", "type": "ArmState", "parameters": {"device": "amr"}}],
                   "links": []})");
  add_counting();
  const auto found = [this](const char* name) {
    return good(R"({"do": "net", "net": ")" + std::string(name) + "\"}")
        .rehearse(fake.cell, &fake.core.environment())
        .diagnostics;
  };
  EXPECT_THAT(pointers(found("counting")), IsEmpty());
  EXPECT_THAT(pointers(found("wrong")), Contains("/program/net"));
  EXPECT_THAT(found("wrong"), Reports(Code::kUnknownName, "/program/net", {"amr"}));
}

}  // namespace
}  // namespace takt::operations
