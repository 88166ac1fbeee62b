// Runs beside the wall clock, and runs that are stuck. No time is judged here: machines are shared.
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::cell::realtime_run_test {
namespace {

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

/// Never returns from its second update.
class HangsForTest final : public net::Primitive {
 public:
  explicit HangsForTest(net::Setup&) {}
  void update(const net::Cycle& cycle) override {
    while (cycle.index_in_net >= 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
};
TAKT_PRIMITIVE(HangsForTest, "test", "Never returns from its second update.");

/// An arm that goes there and back, in blends and with a branch between, and waits.
constexpr const char* kThereAndBack = R"({
  "devices": {"arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]}},
  "program": {"do": "sequence", "steps": [
    {"do": "ptp", "name": "there", "to": {"joints_deg": [8, -30, 0, 90, 0, -60, 0]}, "blend_fraction": 0.3},
    {"do": "ptp", "to": {"joints_deg": [8, -25, 0, 90, 0, -60, 0]}},
    {"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "velocity_m_s": 0.2},
    {"do": "wait", "seconds": 0.05},
    {"do": "ptp", "name": "back", "to": {"joints_deg": [0, -30, 0, 90, 0, -60, 0]}}]},
  "expectations": [{"kind": "limits"}, {"kind": "step", "step": "back"}]
})";

std::unique_ptr<Session> session_of(const std::string& text) {
  auto description = parse_description(text);
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return nullptr;
  }
  auto session = Session::create(std::move(*description), models());
  if (!session) ADD_FAILURE() << session.error().to_string();
  return session ? std::move(*session) : nullptr;
}

TEST(RealtimeRun, APassedRunEndsWhereTheOneInLockStepEnds) {
  RunOptions options;
  const auto in_lock_step = session_of(kThereAndBack), in_realtime = session_of(kThereAndBack);
  ASSERT_TRUE(in_lock_step && in_realtime);
  const RunReport before = in_lock_step->run(options);
  options.realtime = true;
  int told = 0;
  options.progress = [&told](double, double, const std::string&) { ++told; };
  const RunReport report = in_realtime->run(options);
  ASSERT_EQ(before.verdict, Verdict::kPassed) << before.diagnostics.to_string();
  ASSERT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_FALSE(before.realtime.has_value());
  ASSERT_TRUE(report.realtime.has_value());
  EXPECT_GE(report.realtime->begins.worst, report.realtime->wakeups.p50);
  EXPECT_GE(report.wall_time, report.sim_time) << "never faster than the wall clock";
  EXPECT_GT(told, 1);
  const auto q = [](const Session& session) { return session.built().cell.arms.at("arm").device->set_point().q; };
  EXPECT_LT((q(*in_lock_step) - q(*in_realtime)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(RealtimeRun, ATimeLimitEndsIt) {
  auto description = parse_description(kThereAndBack);
  ASSERT_TRUE(description);
  description->time_limit_s = 0.2;
  auto session = Session::create(std::move(*description), models());
  ASSERT_TRUE(session) << session.error().to_string();
  RunOptions options;
  options.realtime = true;
  const RunReport report = (*session)->run(options);
  EXPECT_EQ(report.verdict, Verdict::kError);
  ASSERT_FALSE(report.diagnostics.list().empty());
  EXPECT_EQ(report.diagnostics.list().front().code, Code::kTimeout);
}

TEST(RealtimeRunDeathTest, L7_APrimitiveThatNeverReturnsEndsARunInLockStepWithItsName) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  const auto stuck = [] {
    const auto session = session_of(R"({
      "nets": {"ill": {"primitives": [{"id": "sick", "type": "HangsForTest"},
                                      {"id": "end", "type": "Termination", "parameters": {"condition": false}}]}},
      "program": {"do": "net", "net": "ill"}})");
    RunOptions options;
    options.watchdog = 300 * kMillisecond;
    if (session) (void)session->run(options);
  };
  EXPECT_EXIT(stuck(), testing::ExitedWithCode(3), "stuck in primitive 'sick' of net [0-9]+ \\('ill'\\)");
}

}  // namespace
}  // namespace takt::cell::realtime_run_test
