// Freedrive and control modes as steps: they are activities of the scheduler, with one way into a mode and back.
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using device::ControlMode;
using takt::test::Reports;
using testing::AllOf;

class FreedriveStepTest : public test::CommandStepTest {
 protected:
  ControlMode mode() const { return cell.core_arm().mode(); }
  /// Ends whatever runs by its stop reaction.
  void abort_all() {
    for (rcc::NetId net = 1; net < 1000; ++net)
      if (cell.core.knows(net) && cell.core.state(net) == rcc::NetState::kRunning) (void)cell.core.abort(net);
  }
  static std::string steps(const std::string& list) { return R"({"do": "sequence", "steps": [)" + list + "]}"; }
};

TEST_F(FreedriveStepTest, GoesIntoItsModeAndBackAndMotionsGoOnAfterIt) {
  bool was_soft = false;
  EXPECT_EQ(run(good(steps(R"({"do": "ptp", "to": {"by_m": [0, 0, 0.02]}}, {"do": "freedrive", "seconds": 0.3},
                              {"do": "lin", "to": {"by_m": [0, 0, 0.02]}})")),
                [&](int, program::ProgramRunner&) { was_soft = was_soft || mode() == ControlMode::kJointImpedance; }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(was_soft);
  EXPECT_EQ(mode(), ControlMode::kPosition);
  EXPECT_EQ(cell.backend->changes, 2);
  expect_good_end();
}

TEST_F(FreedriveStepTest, AfterAFailureTheHandlerFindsTheModeBefore) {
  const program::Program program = good(R"({"do": "try", "steps": [{"do": "freedrive", "seconds": 9}],
      "on_error": {"steps": [{"do": "ptp", "to": {"by_m": [0, 0, 0.02]}}]}})");
  EXPECT_EQ(run(program,
                [&](int cycle, program::ProgramRunner&) {
                  if (cycle == 900) abort_all();
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(mode(), ControlMode::kPosition);
  EXPECT_EQ(cell.backend->changes, 2);
  expect_good_end();
}

TEST_F(FreedriveStepTest, AFailureAndAWayBackThatFailsAreBothTold) {
  EXPECT_EQ(run(good(R"({"do": "freedrive", "seconds": 9})"),
                [&](int cycle, program::ProgramRunner&) {
                  if (cycle != 900) return;
                  cell.backend->ignores_modes = true;
                  abort_all();
                }),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, AllOf(Reports(Code::kStopped, "/program"),
                                 Reports(Code::kNotPossibleNow, "/program", {"arm", "joint_impedance"})));
}

TEST_F(FreedriveStepTest, CancelledAtAnyMomentItEndsInTheModeBefore) {
  const program::Program program = good(R"({"do": "freedrive", "seconds": 9})");
  for (const int at : {0, 1, 2, 3, 4, 5, 200, 700}) {
    SCOPED_TRACE(at);
    EXPECT_EQ(run(program,
                  [&](int cycle, program::ProgramRunner& runner) {
                    if (cycle == at) runner.cancel();
                  }),
              Progress::kDone)
        << diagnostics.to_string();
    EXPECT_EQ(mode(), ControlMode::kPosition);
    expect_good_end();
  }
}

TEST_F(FreedriveStepTest, AModeThatAStepAsksForIsReachedAfterItsLatency) {
  latency = 7;
  int changed = -1;
  EXPECT_EQ(run(good(R"({"do": "control_mode", "mode": "cartesian_impedance"})"),
                [&](int cycle, program::ProgramRunner&) {
                  if (changed < 0 && cell.backend->changes > 0) changed = cycle;
                }),
            Progress::kDone)
      << diagnostics.to_string();
  EXPECT_EQ(mode(), ControlMode::kCartesianImpedance);
  EXPECT_GT(changed, latency - 1);
  EXPECT_LE(changed, latency + 3);
}

}  // namespace
}  // namespace takt::operations
