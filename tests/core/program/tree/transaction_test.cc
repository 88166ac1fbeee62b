// Steps that are trees of commands: who starts and ends whom, what is known afterwards, interruptions.
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::program {
namespace {

using takt::test::Reports;

/// The papers' screw: insert, cancel at 5 N, then hold the force and turn until the clutch answers.
constexpr const char* kScrew = R"({"do": "sequence", "variables": {"down": "$-0.02[m]"}, "steps": [
  {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.033], "rpy_deg": [180, 0, 0]}},
  {"do": "tare", "cycles": 20},
  {"do": "transaction", "name": "screw in", "raised": ["tight"],
   "commands": {
     "insert": {"do": "lin", "start": true, "to": {"by_m": [0, 0, "$down"]}, "velocity_m_s": "$1[mm/s]",
                "on": [{"entered": {"sensor": "wrist", "above_N": 5}, "cancel": "insert"}]},
     "press": {"do": "press", "direction": [0, 0, -1], "in": "block", "force_N": 20, "approach_m_s": 0.001},
     "turn": {"do": "set", "output": "driver", "value": true},
     "turned": {"do": "wait", "seconds": 2},
     "off": {"do": "set", "output": "driver", "value": false}},
   "on": [{"entered": {"completed": "insert"}, "start": ["press", "turn", "turned"]},
          {"entered": {"any": [{"input": "button"}, {"completed": "turned"}]}, "raise": "tight"},
          {"entered": {"raised": "tight"}, "start": "off", "cancel": ["press", "turned"], "tell": "tight"}],
   "capture": {"force": {"value": {"sensor": "wrist"}, "when": {"raised": "tight"}},
               "way": {"value": {"progress": "insert"}, "when": {"cancelled": "insert"}}}},
  {"do": "lin", "to": {"by_m": [0, 0, 0.02]}}]})";

class TransactionTest : public test::CommandStepTest {
 protected:
  double pressed_with() const {
    const double z = (cell.X_WO_true.inverse() * cell.tool_in_world(cell.backend->state().q).translation()).z();
    return std::max(0.0, 0.025 + cell.cell.arms.at("arm").tip.ball_radius - z) * test::FakeCell::kStiffness;
  }
  static std::string lamp_after(const std::string& on) {
    return R"({"do": "transaction", "name": "t", "commands": {
        "move": {"do": "lin", "start": true, "to": {"by_m": [0, 0.05, 0]}, "velocity_m_s": 0.1},
        "lamp": {"do": "set", "output": "lamp", "value": true}}, "on": [)" +
           on + "]}";
  }
};

TEST_F(TransactionTest, TheScrewIsInsertedThenPressedAndTurnedTogether) {
  const Program program = good(kScrew);
  bool driver_before_contact = false, driver_while_moving = false;
  double pressed_at_end = 0.0;
  EXPECT_EQ(run(program,
                [&](int, ProgramRunner&) {
                  driver_before_contact |= driver() && pressed_with() == 0.0;
                  driver_while_moving |= driver() && !logged("begin screw in");
                  if (driver()) pressed_at_end = pressed_with();
                }),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(cell.driver_terminal->written.size() > 1);
  EXPECT_FALSE(driver_before_contact);
  EXPECT_FALSE(driver_while_moving);
  EXPECT_NEAR(pressed_at_end, 20.0, 6.0) << "pressed while it turned";
  EXPECT_FALSE(driver());
  EXPECT_TRUE(logged("arm: touch ("));
  EXPECT_NEAR(std::stod(variables.monitors["screw in"]["force"]), 20.0, 6.0);
  const double way = std::stod(variables.monitors["screw in"]["way"]);
  EXPECT_NEAR(way, 0.15, 0.01) << "3 mm of 20 mm";
  EXPECT_EQ(variables.monitors["screw in"]["tight"], "1");
  EXPECT_TRUE(logged("screw in: told tight (cycle "));
  expect_good_end();
}

TEST_F(TransactionTest, AnInputEndsItInTheSameCycle) {
  const Program program = good(kScrew);
  int pushed = -1, off = -1;
  EXPECT_EQ(run(program,
                [&](int cycle, ProgramRunner&) {
                  if (driver() && pushed < 0) {
                    pushed = cycle;
                    cell.button->sample.value = true;
                  }
                  if (!driver() && pushed >= 0 && off < 0) off = cycle;
                }),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LE(off - pushed, 3) << "input, raised state and output in one net";
  EXPECT_EQ(variables.monitors["screw in"]["tight"], "1");
}

TEST_F(TransactionTest, P2_AHandlerHearsThatACommandIsPaused) {
  const Program program = good(lamp_after(R"({"entered": {"paused": "move"}, "start": "lamp"})"));
  int lit = -1;
  EXPECT_EQ(run(program,
                [&](int cycle, ProgramRunner&) {
                  if (cycle == 200) (void)cell.speed->write(0.0);
                  if (lit < 0 && cell.cell.digital_outputs.at("lamp")->value()) lit = cycle;
                  if (cycle == 700) (void)cell.speed->write(1.0);
                }),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_GT(lit, 200);
  EXPECT_LT(lit, 205) << "in the cycle in which it is paused, while the arm still brakes";
  expect_good_end();
}

TEST_F(TransactionTest, L6_ACancelAtAnyTimeEndsInOrderAndAPauseGoesOn) {
  const Program program = good(kScrew);
  ASSERT_EQ(run(program), operations::Progress::kDone);
  const int whole = cycles;
  for (int at = 3; at < whole; at += whole / 23) {
    SCOPED_TRACE(at);
    for (const bool pause : {false, true}) {
      test::CommandCell own;
      activity::Variables known;
      activity::Context context{own.cell, own.core, known, 2, [](auto, auto, auto) {}};
      ProgramRunner runner(program, context);
      int cycle = 0;
      for (; cycle < 20'000; ++cycle) {
        if (cycle == at && !pause) runner.cancel();
        if (cycle == at && pause) runner.hold(true), (void)own.speed->write(0.0);
        if (cycle == at + 500 && pause) {
          EXPECT_LT(own.core_arm().set_point().dq.cwiseAbs().maxCoeff(), 1e-3) << "it stands, or holds its force";
          runner.hold(false), (void)own.speed->write(1.0);
        }
        if (runner.advance() != operations::Progress::kRunning) break;
        own.step();
      }
      EXPECT_EQ(runner.progress(), operations::Progress::kDone) << runner.diagnostics().to_string();
      if (!pause) {
        EXPECT_LT(cycle, at + 700) << "it comes to its end soon";
      }
      own.step(400);
      EXPECT_TRUE(own.core_arm().at_rest());
      EXPECT_FALSE(own.core_arm().held());
      EXPECT_FALSE(own.cell.digital_outputs.at("driver")->held());
      EXPECT_LE(own.worst_limit_share(), 1.0);
      if (HasFailure()) return;
    }
  }
}

TEST_F(TransactionTest, AStateOfAMotionStartsSomethingOnItsWay) {
  const Eigen::Vector3d from = tool();
  double way = 0.0;
  const Program program = good(lamp_after(R"({"entered": {"action": "move", "at_path": 0.5}, "start": "lamp"})"));
  EXPECT_EQ(run(program,
                [&](int, ProgramRunner&) {
                  if (!lamp()) way = (tool() - from).norm();
                }),
            operations::Progress::kDone);
  EXPECT_TRUE(lamp());
  EXPECT_NEAR(way, 0.025, 5e-4);
  EXPECT_NEAR((tool() - from).norm(), 0.05, 1e-6);
}

TEST_F(TransactionTest, LeavingDelayAndDurationsCount) {
  // The button is held from 100 to 300 ms; it counts after 50 ms, leaving it 100 ms later.
  int lit = -1;
  const Program program = good(R"({"do": "transaction", "name": "t", "commands": {
      "time": {"do": "wait", "start": true, "seconds": 1}, "lamp": {"do": "set", "output": "lamp", "value": true}},
      "on": [{"left": {"input": "button", "held_for_s": 0.05}, "after_s": 0.1, "start": "lamp"},
             {"entered": {"input": "button", "held_for_s": 0.05}, "tell": "held"},
             {"entered": {"input": "button"}, "first_only": true, "tell": "pushed"}]})");
  EXPECT_EQ(run(program,
                [&](int cycle, ProgramRunner&) {
                  cell.button->sample.value = (cycle >= 100 && cycle < 300) || (cycle >= 500 && cycle < 520);
                  if (lamp() && lit < 0) lit = cycle;
                }),
            operations::Progress::kDone);
  EXPECT_NEAR(lit, 400, 4);
  EXPECT_EQ(variables.monitors["t"]["held"], "1") << "20 ms are too short";
  EXPECT_EQ(variables.monitors["t"]["pushed"], "1") << "only the first time";
}

TEST_F(TransactionTest, ToldEventsAreCountedHoweverOftenTheyCome) {
  const Program program = good(R"({"do": "transaction", "name": "t", "commands": {
      "time": {"do": "wait", "start": true, "seconds": 0.4}},
      "on": [{"entered": {"input": "button"}, "tell": "pushed"}]})");
  EXPECT_EQ(run(program, [&](int cycle, ProgramRunner&) { cell.button->sample.value = cycle % 2 == 0; }),
            operations::Progress::kDone);
  const int times = std::stoi(variables.monitors["t"]["pushed"]);
  EXPECT_NEAR(times, 200, 3);
  EXPECT_EQ(std::ranges::count_if(log, [](const auto& line) { return line.starts_with("t: told pushed (cycle "); }),
            times);
}

TEST_F(TransactionTest, WhatAnEarlierRunToldIsForgotten) {
  const Program program = good(R"_({"do": "repeat", "times": 2, "as": "round", "steps": [
      {"do": "transaction", "name": "t", "commands": {"stay": {"do": "wait", "start": true, "seconds": 0.1}},
       "on": [{"entered": {"input": "button"}, "tell": "pushed"}]},
      {"do": "log", "text": "$text(round) + ': ' + text(known(monitor('t', 'pushed')))"}]})_");
  EXPECT_EQ(run(program, [&](int cycle, ProgramRunner&) { cell.button->sample.value = cycle >= 20 && cycle < 40; }),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(logged("log 0: true"));
  EXPECT_TRUE(logged("log 1: false")) << "a screw that was lost in the first try is not in the second";
}

TEST_F(TransactionTest, C3C4_StopEndsAllInsideAndACancelDoesWhatIsSaid) {
  const auto with = [](const std::string& policy) {
    return R"({"do": "transaction", "name": "t", "commands": {"inner": {
        "do": "transaction", "start": true, "commands": {
        "long": {"do": "wait", "start": true, "seconds": 5}, "short": {"do": "wait", "start": true, "seconds": 0.3}},
        "on_cancel": )" +
           policy + R"(}}, "on": [{"entered": {"input": "button"}, "cancel": "inner"}]})";
  };
  const auto length = [&](const std::string& text) {
    EXPECT_EQ(run(good(text), [&](int cycle, ProgramRunner&) { cell.button->sample.value = cycle > 100; }),
              operations::Progress::kDone);
    return cycles;
  };
  EXPECT_NEAR(length(with("\"forward\"")), 104, 4);
  EXPECT_NEAR(length(with("[\"long\"]")), 304, 6) << "the short one goes on";
  EXPECT_NEAR(length(with("\"ignore\"")), 5'004, 6);
  std::string stop = with("\"ignore\"");
  stop.replace(stop.rfind("\"cancel\""), 8, "\"stop\"");
  EXPECT_NEAR(length(stop), 104, 4) << "whatever a cancel does";
}

TEST_F(TransactionTest, MotionsAreBlendedIntoOneAndTellWhatTheyPassed) {
  int lit = -1;
  const Eigen::Vector3d from = tool();
  const Program program = good(R"({"do": "transaction", "name": "t", "commands": {
      "corner": {"do": "motions", "start": true, "steps": [
        {"do": "lin", "to": {"by_m": [0, 0.1, 0]}, "velocity_m_s": 0.2, "blend_m": 0.02},
        {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "velocity_m_s": 0.2}]},
      "lamp": {"do": "set", "output": "lamp", "value": true}},
      "on": [{"entered": {"action": "corner", "via_passed": 0}, "start": "lamp"}]})");
  Eigen::Vector3d at = from;
  EXPECT_EQ(run(program,
                [&](int cycle, ProgramRunner&) {
                  if (lamp() && lit < 0) lit = cycle, at = tool();
                }),
            operations::Progress::kDone)
      << diagnostics.to_string();
  ASSERT_GT(lit, 0);
  EXPECT_LT((at - from - Eigen::Vector3d(0, 0.1, 0)).norm(), 0.02) << "in the blend";
  EXPECT_GT((at - from - Eigen::Vector3d(0, 0.1, 0)).norm(), 1e-4) << "the corner is cut";
  EXPECT_LT((tool() - from - Eigen::Vector3d(0, 0.1, 0.1)).norm(), 1e-6);
  expect_good_end();
}

TEST_F(TransactionTest, WhatAStepWouldFailOfFailsTheTransactionAtItsPlace) {
  EXPECT_EQ(run(R"({"do": "transaction", "name": "t", "commands": {
      "down": {"do": "lin", "start": true, "to": {"by_m": [0, 0, -0.01]}, "until": {"sensor": "wrist", "above_N": 5e3}},
      "w": {"do": "wait", "start": true, "until": {"input": "button"}, "timeout_s": 0.1}}})"),
            operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/commands/down/until"));
  EXPECT_THAT(diagnostics, Reports(Code::kTimeout, "/program/commands/w/until", {"0.1"}));
  expect_good_end();
}

TEST_F(TransactionTest, WhatFailsStartsNothingThatWaitsForItsCompletion) {
  EXPECT_EQ(run(R"({"do": "transaction", "name": "t", "commands": {
      "down": {"do": "lin", "start": true, "to": {"by_m": [0, 0, -0.01]}, "until": {"sensor": "wrist", "above_N": 5e3}},
      "screw": {"do": "set", "output": "driver", "value": true},
      "alarm": {"do": "set", "output": "lamp", "value": true}},
    "on": [{"entered": {"completed": "down"}, "start": "screw"},
           {"entered": {"failed": "down"}, "start": "alarm"}]})"),
            operations::Progress::kFailed);
  EXPECT_FALSE(driver()) << "there is nothing to screw";
  EXPECT_TRUE(lamp());
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/commands/down/until"));
  expect_good_end();
}

TEST_F(TransactionTest, TheSeamIsNotWeldedWithoutAnArc) {
  const Eigen::Vector3d from = tool();
  EXPECT_EQ(run(R"({"do": "transaction", "name": "weld", "commands": {
      "gas": {"do": "set", "start": true, "output": "driver", "value": true},
      "arc": {"do": "wait", "start": true, "until": {"input": "button"}, "timeout_s": 0.1},
      "seam": {"do": "lin", "to": {"by_m": [0, 0.05, 0]}, "velocity_m_s": 0.1},
      "off": {"do": "set", "output": "driver", "value": false}},
    "on": [{"entered": {"completed": "arc"}, "start": "seam"},
           {"entered": {"timed_out": "arc"}, "start": "off"}]})"),
            operations::Progress::kFailed);
  EXPECT_LT((tool() - from).norm(), 1e-9) << "no arc, no seam";
  EXPECT_FALSE(driver()) << "the gas is off";
  EXPECT_THAT(diagnostics, Reports(Code::kTimeout, "/program/commands/arc/until"));
  expect_good_end();
}

TEST_F(TransactionTest, N3_ASilentSensorBrakesAGuardedMotionAndIsTold) {
  EXPECT_EQ(run(good(R"({"do": "transaction", "name": "t", "commands": {
      "down": {"do": "lin", "start": true, "to": {"by_m": [0, 0, -0.1]}, "velocity_m_s": 0.05,
               "until": {"sensor": "wrist", "above_N": 500}}}})"),
                [&](int cycle, ProgramRunner&) { cell.sensor->silent = cycle > 300; }),
            operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/commands/down/until"));
  expect_good_end();
}

TEST_F(TransactionTest, AGripIsJudgedByHowItEnded) {
  const auto grip = [&](const std::string& width) {
    return good(R"({"do": "transaction", "name": "t", "commands": {
        "grip": {"do": "grip", "start": true, "part": "block", "width_m": )" +
                width + R"(},
        "up": {"do": "lin", "to": {"by_m": [0, 0, 0.05]}}},
        "on": [{"entered": {"completed": "grip"}, "start": "up"}]})");
  };
  const auto answer = [&](device::GripperState state) {
    return [this, state](int cycle, ProgramRunner&) {
      cell.fingers->sample.stamp = cell.core.time();  // it answers in every cycle
      if (cycle > 50) cell.fingers->answer(state, 0.03);
    };
  };
  const Eigen::Isometry3d X_WF = cell.tool_in_world(cell.q()) * cell.cell.arms.at("arm").X_FT.inverse();
  const Eigen::Isometry3d X_FO = X_WF.inverse() * *cell.cell.frames.pose("block");
  EXPECT_EQ(run(grip("0.01"), answer(device::GripperState::kHolding)), operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_TRUE(cell.cell.held["gripper"].X_FO.isApprox(X_FO, 1e-9)) << "where it was gripped, not where the arm is";
  EXPECT_EQ(run(grip("0.02"), answer(device::GripperState::kIdle)), operations::Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/commands/grip"));
}

TEST_F(TransactionTest, TheRehearsalTakesArmsToTheirNaturalEnds) {
  const Eigen::Vector3d from = tool();
  EXPECT_EQ(run(R"({"do": "sequence", "steps": [{"do": "transaction", "name": "t", "commands": {
      "a": {"do": "lin", "start": true, "to": {"by_m": [0, 0.05, 0]}},
      "b": {"do": "lin", "to": {"by_m": [0.05, 0, 0]}}}, "on": [{"entered": {"completed": "a"}, "start": "b"}]},
      {"do": "lin", "to": {"by_m": [0, 0, 0.05]}}]})"),
            operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_LT((tool() - from - Eigen::Vector3d(0.05, 0.05, 0.05)).norm(), 1e-6);
  expect_good_end();
}

}  // namespace
}  // namespace takt::program
