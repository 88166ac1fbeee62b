// Row L6 for whole programs: cancelled, paused or stopped at every tenth cycle, no limit is broken, every device is
// free and at rest afterwards, and the next program runs.
#include "tests/core/activity/fixture.h"

namespace takt::program {
namespace {

constexpr const char* kProgram = R"({"do": "sequence", "variables": {"h": "$20[mm]"}, "steps": [
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.06]}, "speed": 0.8, "blend_m": 0.01},
    {"do": "lin", "to": {"by_m": [0.02, 0, 0], "in": "block"}},
    {"do": "tare", "cycles": 20},
    {"do": "parallel", "end": "first", "branches": [
      {"do": "lin", "to": {"by_m": [0, 0, "$-3 * h"], "in": "block"}, "velocity_m_s": 0.2,
       "until": {"sensor": "wrist", "above_N": 8}}, {"do": "wait", "seconds": 2}]},
    {"do": "record_contact", "as": "top"},
    {"do": "try", "steps": [{"do": "branch", "cases": [{"when": {"sensor": "wrist", "above_N": 1}, "steps": [
        {"do": "lin", "to": {"by_m": [0, 0, "$h"], "in": "block"}, "velocity_m_s": 0.2}]}]},
        {"do": "fail", "text": "on purpose"}],
     "on_error": {"steps": [{"do": "ptp", "to": "home", "speed": 0.8}]}}]})";

class InterruptionsTest : public test::ActivityTest {
 protected:
  /// A cell of its own for each case; `act` is called before cycle `at`. @return the progress, run to the end.
  struct Case {
    test::FakeCell fake;
    activity::Variables variables;
    Diagnostics diagnostics;
    operations::Progress progress = operations::Progress::kRunning;
    int cycles = 0;
  };
  using Act = std::function<void(Case&, ProgramRunner&)>;

  static void play(Case& one, const Program& program, int at, const Act& act, int later, const Act& then) {
    activity::Context context{one.fake.cell, one.fake.core, one.variables, 2, [](auto, auto, auto) {}};
    ProgramRunner runner(program, context);
    for (; one.cycles < 20'000; ++one.cycles) {
      if (one.cycles == at) act(one, runner);
      if (one.cycles == at + later && then) then(one, runner);
      one.progress = runner.advance();
      if (one.progress != operations::Progress::kRunning) break;
      one.fake.step();
    }
    one.diagnostics = runner.diagnostics();
  }

  /// Nothing moves any more, nobody holds the arm, all was within the limits, and the arm can be used.
  static void expect_good_end(Case& one) {
    one.fake.step(400);
    EXPECT_TRUE(one.fake.core_arm().at_rest());
    EXPECT_FALSE(one.fake.core_arm().held());
    EXPECT_LE(one.fake.worst_limit_share(), 1.0);
    (void)one.fake.speed->write(1.0);
    const auto home = Program::parse(test::Json::parse(R"({"do": "ptp", "to": "home"})"), "/program", one.fake.cell);
    Case& again = one;
    again.cycles = 0;
    play(again, *home, -1, {}, 0, {});
    EXPECT_EQ(again.progress, operations::Progress::kDone) << again.diagnostics.to_string();
    EXPECT_EQ(one.fake.q(), one.fake.arm->home);
  }

  int length() {
    Case one;
    play(one, good(kProgram), -1, {}, 0, {});
    EXPECT_EQ(one.progress, operations::Progress::kDone) << one.diagnostics.to_string();
    return one.cycles;
  }
  static constexpr int kEvery = 10;
};

TEST_F(InterruptionsTest, RowL6ACancelAtEveryTenthCycleEndsInOrder) {
  const int whole = length();
  ASSERT_GT(whole, 500);
  for (int at = 0; at < whole; at += kEvery) {
    SCOPED_TRACE(at);
    Case one;
    play(one, good(kProgram), at, [](Case&, ProgramRunner& runner) { runner.cancel(); }, 0, {});
    EXPECT_EQ(one.progress, operations::Progress::kDone) << one.diagnostics.to_string();
    EXPECT_LT(one.cycles, at + 600) << "it comes to its end soon";
    expect_good_end(one);
    if (HasFailure()) return;
  }
}

TEST_F(InterruptionsTest, RowP2APauseAtEveryTenthCycleStandsAndGoesOn) {
  const int whole = length();
  constexpr int kPause = 500;
  for (int at = 0; at < whole; at += kEvery) {
    SCOPED_TRACE(at);
    Case one;
    play(
        one, good(kProgram), at,
        [](Case& c, ProgramRunner& runner) {
          runner.hold(true);
          (void)c.fake.speed->write(0.0);
        },
        kPause,
        [](Case& c, ProgramRunner& runner) {
          EXPECT_TRUE(c.fake.core_arm().at_rest()) << "it stands in the pause";
          runner.hold(false);
          (void)c.fake.speed->write(1.0);
        });
    EXPECT_EQ(one.progress, operations::Progress::kDone) << one.diagnostics.to_string();
    expect_good_end(one);
    if (HasFailure()) return;
  }
}

TEST_F(InterruptionsTest, RowL6AStopAtEveryTenthCycleLeavesNothingBehind) {
  const int whole = length();
  for (int at = 0; at < whole; at += kEvery) {
    SCOPED_TRACE(at);
    Case one;
    play(one, good(kProgram), at,
         [](Case& c, ProgramRunner& runner) {
           c.fake.core.stop_all(net::Cause::Code::kAborted, "test");
           runner.cancel();
         },
         0, {});
    EXPECT_NE(one.progress, operations::Progress::kRunning);
    expect_good_end(one);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace takt::program
