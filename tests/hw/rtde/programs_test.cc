// Programs on the emulated controller: motions, registers, watchdogs, stops.
#include "hw/emulators/rtde/programs.h"

#include <fmt/format.h>

#include "hw/emulators/rtde/script_service.h"
#include "tests/hw/rtde/controller_bench.h"

namespace takt::hw::rtde {
namespace {

using Kind = ControllerEvent::Kind;

class UrProgram : public testing::Test {
 protected:
  [[nodiscard]] double q(int joint) const { return bench.plant.q[joint]; }
  [[nodiscard]] std::string text() { return bench.last(Kind::kText); }
  test::ControllerBench bench;
};

TEST_F(UrProgram, MovesToJointPositionsAndEnds) {
  EXPECT_TRUE(
      bench.run("def go():\n  movej([0.1, -1.8, -1.5, -1.4, 1.6, 1.5], a=2, v=1)\n  textmsg(\"there\")\nend\n"));
  bench.frames(3);
  EXPECT_NEAR(q(0), 0.1, 1e-9);
  EXPECT_NEAR(q(1), -1.8, 1e-9);
  EXPECT_EQ(text(), "there");
  EXPECT_EQ(bench.field("runtime_state"), 1.0);
  EXPECT_EQ(bench.last(Kind::kKey), "go");
}

/// Differences of what the joints are told stay within the limits of the model.
TEST_F(UrProgram, MovesKeepTheLimits) {
  ASSERT_TRUE(bench.controller.programs().start("movej([1.5, -1.0, -1.0, -1.0, 1.0, 1.0], a=100, v=100)\n"));
  const auto& limits = test::ur5()->limits;
  JointVector before = bench.plant.q, dq = JointVector::Zero(6);
  double fastest = 0.0, hardest = 0.0;
  const double h = to_seconds(bench.controller.cycle());
  for (int i = 0; i < 5000 && bench.controller.programs().running(); ++i) {
    bench.frame();
    const JointVector now = (bench.plant.q - before) / h;
    fastest = std::max(fastest, now.cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff());
    hardest = std::max(hardest, ((now - dq) / h).cwiseAbs().cwiseQuotient(limits.acceleration).maxCoeff());
    before = bench.plant.q;
    dq = now;
  }
  EXPECT_LE(fastest, 1.0 + 1e-9);
  EXPECT_LE(hardest, 1.0 + 1e-6);
  EXPECT_GT(hardest, 0.5);
}

TEST_F(UrProgram, ATimeDecidesWhereTheJointsCan) {
  const auto duration = [&](const std::string& line) {
    const Nanoseconds begin = bench.controller.time();
    EXPECT_TRUE(bench.run(line, 60.0));
    return to_seconds(bench.controller.time() - begin);
  };
  EXPECT_NEAR(duration("movej([0.3, -1.745329, -1.570796, -1.396263, 1.570796, 1.570796], t=3)\n"), 3.0, 0.05);
  EXPECT_GT(duration("movej([-3, -1.745329, -1.570796, -1.396263, 1.570796, 1.570796], t=0.1)\n"), 1.0)
      << "a time that is too short is stretched";
}

TEST_F(UrProgram, MovesTheToolOnALine) {
  const hw::urscript::Pose before = to_pose(bench.controller.motion().kinematics().X_BT(bench.plant.q));
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  here = get_actual_tcp_pose()\n  movel(pose_add(here, p[0, 0.1, 0, 0, 0, 0]), a=1, v=0.2)\nend\n"));
  double off = 0.0;
  for (int i = 0; i < 5000 && bench.controller.programs().running(); ++i) {
    bench.frame();
    const hw::urscript::Pose at = to_pose(bench.controller.motion().kinematics().X_BT(bench.plant.q));
    off = std::max({off, std::abs(at[0] - before[0]), std::abs(at[2] - before[2])});
  }
  const hw::urscript::Pose after = to_pose(bench.controller.motion().kinematics().X_BT(bench.plant.q));
  EXPECT_NEAR(after[1] - before[1], 0.1, 1e-6);
  EXPECT_LT(off, 1e-6) << "m beside the line";
}

TEST_F(UrProgram, ALineThatLeadsNowhereIsAProtectiveStop) {
  EXPECT_FALSE(bench.run("movel(p[3, 0, 0, 0, 0, 0])\n", 1.0));
  EXPECT_EQ(bench.field("safety_mode"), 3.0);
  EXPECT_EQ(bench.field("runtime_state"), 4.0) << "the program is paused";
}

TEST_F(UrProgram, AnUnreachablePoseOfMovejEndsTheProgram) {
  EXPECT_TRUE(bench.run("movej(p[3, 0, 0, 0, 0, 0])\n", 1.0));
  EXPECT_NE(bench.last(Kind::kRuntimeException).find("out of reach"), std::string::npos);
  EXPECT_TRUE(bench.run("movej([7, 0, 0, 0, 0, 0])\n", 1.0));
  EXPECT_NE(bench.last(Kind::kRuntimeException).find("outside of its range"), std::string::npos);
}

TEST_F(UrProgram, AnArcGoesThroughItsPoint) {
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  p0 = get_actual_tcp_pose()\n"
      "  movec(pose_add(p0, p[0.05, 0.05, 0, 0, 0, 0]), pose_add(p0, p[0.1, 0, 0, 0, 0, 0]), a=1, v=0.1)\nend\n"));
  const Eigen::Vector3d from = bench.controller.motion().kinematics().X_BT(bench.plant.q).translation();
  const Eigen::Vector3d via = from + Eigen::Vector3d(0.05, 0.05, 0.0), to = from + Eigen::Vector3d(0.1, 0.0, 0.0);
  double nearest = 1.0;
  for (int i = 0; i < 5000 && bench.controller.programs().running(); ++i) {
    bench.frame();
    const Eigen::Vector3d at = bench.controller.motion().kinematics().X_BT(bench.plant.q).translation();
    nearest = std::min(nearest, (at - via).norm());
  }
  EXPECT_LT(nearest, 2e-3);
  EXPECT_LT((bench.controller.motion().kinematics().X_BT(bench.plant.q).translation() - to).norm(), 1e-6);
}

TEST_F(UrProgram, BlendedMovesDoNotStopBetween) {
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  p0 = get_actual_tcp_pose()\n  movel(pose_add(p0, p[0, 0.1, 0, 0, 0, 0]), a=1, v=0.1, r=0.03)\n"
      "  movel(pose_add(p0, p[0, 0.1, 0.1, 0, 0, 0]), a=1, v=0.1)\nend\n"));
  bench.seconds(0.5);
  double slowest = 1.0;
  for (int i = 0; i < 100; ++i) {
    bench.frame();
    slowest =
        std::min(slowest, bench.controller.motion().kinematics().twist(bench.plant.q, bench.plant.dq).head<3>().norm());
  }
  EXPECT_GT(slowest, 0.03) << "m/s";
}

TEST_F(UrProgram, ServoFollowsAndAKilledThreadBrakes) {
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  q0 = get_actual_joint_positions()\n  x = 0\n  thread servo():\n    while True:\n      q = q0\n     "
      " q[0] = q0[0] + x\n"
      "      servoj(q, t=0.008, lookahead_time=0.03, gain=2000)\n      x = x + 0.004\n    end\n  end\n"
      "  h = run servo()\n  sleep(0.5)\n  kill h\n  sleep(1.0)\nend\n"));
  bench.seconds(0.4);
  EXPECT_NEAR(bench.plant.dq[0], 0.5, 0.01) << "rad/s";
  bench.seconds(0.6);
  EXPECT_NEAR(bench.plant.dq[0], 0.0, 1e-9);
  EXPECT_NEAR(q(0), 0.25, 0.1);
}

TEST_F(UrProgram, SpeedsAreReachedAndStopped) {
  ASSERT_TRUE(
      bench.controller.programs().start("def go():\n  speedj([0.3, 0, 0, 0, 0, 0], 1.0, 1.0)\n  stopj(2)\nend\n"));
  bench.seconds(0.8);
  EXPECT_NEAR(bench.plant.dq[0], 0.3, 1e-9);
  bench.seconds(1.0);
  EXPECT_FALSE(bench.controller.programs().running());
  EXPECT_EQ(bench.plant.dq[0], 0.0);
  ASSERT_TRUE(bench.controller.programs().start("speedl([0, 0.05, 0, 0, 0, 0], 0.5, 1.0)\n"));
  bench.seconds(0.8);
  EXPECT_NEAR(bench.field("target_TCP_speed", 1), 0.05, 1e-3);
  EXPECT_NEAR(bench.field("target_TCP_speed", 0), 0.0, 1e-3);
}

TEST(UrForceMode, GivesWayAlikeInBothSeriesAndAsItsGainSays) {
  for (const auto& options : {ControllerOptions{}, test::e_series()}) {
    for (const double gain : {1.0, 0.5}) {
      test::ControllerBench bench(options);
      ASSERT_TRUE(bench.controller.programs().start(
          fmt::format("def go():\n  force_mode_set_gain_scaling({})\n  force_mode(p[0,0,0,0,0,0], [0,0,1,0,0,0], "
                      "[0,0,-10,0,0,0], 2, [0.1,0.1,0.05,0.5,0.5,0.5])\n"
                      "  sleep(2)\n  end_force_mode()\n  sleep(0.5)\nend\n",
                      gain)));
      const auto height = [&] { return bench.controller.motion().kinematics().X_BT(bench.plant.q).translation().z(); };
      bench.seconds(0.5);
      const double before = height();
      bench.seconds(1.0);
      EXPECT_NEAR(height() - before, -0.02 * gain, 5e-4) << "2 mm/s a newton";
      bench.seconds(1.5);
      EXPECT_NEAR(bench.plant.dq.cwiseAbs().maxCoeff(), 0.0, 1e-9);
    }
  }
}

// The stop of the jog before leaves no velocity for later.
TEST_F(UrProgram, AfterFreedriveTheArmStands) {
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  speedl([0, 0, 0.02, 0, 0, 0], 0.5, 0.3)\n  stopl(1.2)\n  freedrive_mode()\n  sleep(0.5)\n"
      "  end_freedrive_mode()\n  while True:\n    sync()\n  end\nend\n"));
  bench.seconds(0.6);
  bench.plant.tau_external[3] = 5.0;  // a hand
  bench.seconds(0.3);
  EXPECT_GT(std::abs(bench.plant.dq[3]), 0.01) << "it is led";
  bench.seconds(1.0);
  const JointVector stands = bench.plant.q;
  bench.seconds(2.0);
  EXPECT_EQ(bench.plant.q, stands);
}

TEST_F(UrProgram, AProtectiveStopEndsFreedrivesMotion) {
  ASSERT_TRUE(bench.controller.programs().start("def go():\n  freedrive_mode()\n  sleep(10)\nend\n"));
  bench.plant.tau_external[3] = 5.0;
  bench.seconds(0.5);
  EXPECT_GT(std::abs(bench.plant.dq[3]), 0.01);
  bench.controller.protective_stop("test");
  bench.seconds(1.0);
  const JointVector stands = bench.plant.q;
  bench.seconds(1.0);
  EXPECT_EQ(bench.plant.q, stands);
}

TEST_F(UrProgram, OneThreadIsCompliantWhileAnotherMoves) {
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  thread force():\n    while True:\n"
      "      force_mode(p[0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,-10,0,0,0], 2, [0.1,0.1,0.05,0.5,0.5,0.5])\n      sync()\n"
      "    end\n  end\n  h = run force()\n  sync()\n  movel(pose_add(get_actual_tcp_pose(), p[0,0.05,0,0,0,0]))\n"
      "  kill h\n  end_force_mode()\n  textmsg(\"moved\")\nend\n"));
  const Eigen::Vector3d before = bench.controller.motion().kinematics().X_BT(bench.plant.q).translation();
  bench.seconds(3.0);
  const Eigen::Vector3d way = bench.controller.motion().kinematics().X_BT(bench.plant.q).translation() - before;
  EXPECT_EQ(text(), "moved") << bench.last(Kind::kRuntimeException);
  EXPECT_NEAR(way.y(), 0.05, 1e-3);
  EXPECT_LT(way.z(), -0.005) << "2 mm/s a newton, meanwhile";
}

TEST_F(UrProgram, PausedMovesGoOnWhereTheyWere) {
  ASSERT_TRUE(bench.controller.programs().start(
      "movej([1, -1.745329, -1.570796, -1.396263, 1.570796, 1.570796], a=1, v=0.5)\n"));
  bench.seconds(1.0);
  bench.controller.protective_stop("test");
  bench.seconds(1.0);
  const double stands = q(0);
  EXPECT_NEAR(bench.plant.dq[0], 0.0, 1e-9);
  bench.seconds(5.0);
  EXPECT_TRUE(bench.controller.power().unlock());
  bench.seconds(1.0);
  EXPECT_EQ(q(0), stands) << "nothing moves by itself";
  EXPECT_TRUE(bench.controller.programs().resume());
  bench.seconds(5.0);
  EXPECT_NEAR(q(0), 1.0, 1e-9);
}

TEST_F(UrProgram, TheSliderSlowsMovesDown) {
  bench.controller.settings().slider = 0.5;
  const Nanoseconds begin = bench.controller.time();
  EXPECT_TRUE(bench.run("movej([0.3, -1.745329, -1.570796, -1.396263, 1.570796, 1.570796], t=2)\n"));
  EXPECT_NEAR(to_seconds(bench.controller.time() - begin), 4.0, 0.5);
}

TEST_F(UrProgram, RegistersGoBothWays) {
  bench.controller.inputs().ints[24] = 5;
  bench.controller.inputs().reals[24] = 2.5;
  bench.controller.inputs().bits[70] = true;
  EXPECT_TRUE(bench.run(
      "def go():\n  write_output_integer_register(24, read_input_integer_register(24) + 1)\n"
      "  write_output_float_register(24, 2 * read_input_float_register(24))\n"
      "  write_output_boolean_register(64, read_input_boolean_register(70))\n"
      "  set_standard_digital_out(3, True)\n  set_tool_digital_out(1, True)\n  set_digital_out(8, True)\nend\n"));
  EXPECT_EQ(bench.field("output_int_register_24"), 6.0);
  EXPECT_EQ(bench.field("output_double_register_24"), 5.0);
  EXPECT_EQ(bench.field("output_bit_register_64"), 1.0);
  EXPECT_EQ(bench.field("actual_digital_output_bits"), (1 << 3) + (1 << 17) + (1 << 16))
      << "8 and 9 of the old function are the tool's";
  EXPECT_TRUE(bench.run("write_output_integer_register(48, 1)\n"));
  EXPECT_NE(bench.last(Kind::kRuntimeException).find("expected 0 to 47"), std::string::npos);
}

/// As an installation with a gripper on the tool's connector begins its programs.
TEST_F(UrProgram, WhatInstallationsSetIsTakenOrCheckedAndRefused) {
  EXPECT_TRUE(bench.run(
      "def go():\n"
      "  set_standard_analog_input_domain(0, 0)\n  set_tool_analog_input_domain(1, 0)\n"
      "  set_analog_inputrange(2, 2)\n  set_analog_outputdomain(1, 0)\n  set_tool_voltage(24)\n"
      "  set_tool_output_mode(0)\n  set_tool_digital_output_mode(0, 1)\n"
      "  set_tool_communication(True, 115200, 0, 1, 1.5, 3.5)\n  set_runstate_outputs([])\n"
      "  set_input_actions_to_default()\n  set_tool_digital_input_action(1, \"default\")\n"
      "  set_safety_mode_transition_hardness(1)\n"
      "  modbus_add_signal(\"10.0.0.9\", 255, 128, 3, \"grip\", False)\n"
      "  modbus_set_signal_update_frequency(\"grip\", 10)\n  modbus_set_runstate_dependent_choice(\"grip\", 0)\n"
      "  set_payload(mass=1.5, cog=[0, 0, 0.1])\n  set_flag(31, True)\n"
      "  write_output_boolean_register(64, get_flag(31) and not get_flag(0))\nend\n"));
  EXPECT_EQ(bench.last(Kind::kRuntimeException), "");
  EXPECT_EQ(bench.field("analog_io_types"), 0b0110);
  EXPECT_EQ(bench.field("tool_analog_input_types"), 0.0);
  EXPECT_EQ(bench.field("payload"), 1.5);
  EXPECT_EQ(bench.field("output_bit_register_64"), 1.0);
  for (const char* wrong :
       {"set_tool_communication(True, 1234, 0, 1, 1.5, 3.5)", "set_tool_communication(True, 9600, 0, 1, 0.5, 3.5)",
        "set_flag(32, True)", "set_tool_voltage(5)", "set_tool_digital_output_mode(0, 4)",
        "set_analog_inputrange(4, 0)", "set_standard_digital_input_action(0, \"freedrive\")",
        "modbus_add_signal(\"a\", 1, 1, 1, \"\")"}) {
    EXPECT_TRUE(bench.run(std::string("def go():\n  ") + wrong + "\nend\n")) << wrong;
    EXPECT_NE(bench.last(Kind::kRuntimeException), "") << wrong;
    bench.controller.events().add({.kind = Kind::kRuntimeException, .title = {}, .text = {}});
  }
}

TEST_F(UrProgram, OutputsMayFollowWhetherAProgramRuns) {
  bench.controller.io().set_digital_out(0, true);
  bench.controller.io().set_digital_out(1, true);
  EXPECT_TRUE(
      bench.run("def go():\n  set_runstate_standard_digital_output_to_value(1, 1)\n"
                "  set_runstate_standard_digital_output_to_value(2, 2)\n  set_runstate_tool_digital_output_to_value(0, "
                "3)\nend\n"));
  EXPECT_EQ(bench.field("actual_digital_output_bits"), 0b101) << "0 is kept, 1 falls, 2 rises";
  ASSERT_TRUE(bench.controller.programs().start("def go():\n  sleep(1)\nend\n"));
  bench.frames(2);
  EXPECT_EQ(bench.field("actual_digital_output_bits"), 0b101 + (1 << 16));
  bench.controller.programs().stop();
  bench.frames(2);
  EXPECT_EQ(bench.field("actual_digital_output_bits"), 0b101);
}

TEST_F(UrProgram, PausingAndResumingAreEvents) {
  const auto last_title = [&] {
    std::string title;
    for (auto i = bench.controller.events().begin(); i < bench.controller.events().end(); ++i)
      if (bench.controller.events()[i].kind == Kind::kKey) title = bench.controller.events()[i].title;
    return title;
  };
  ASSERT_TRUE(bench.controller.programs().start("def go():\n  sleep(1)\nend\n"));
  bench.frames(2);
  EXPECT_EQ(last_title(), "PROGRAM_XXX_STARTED");
  bench.controller.programs().pause();
  EXPECT_EQ(last_title(), "PROGRAM_XXX_PAUSED");
  EXPECT_TRUE(bench.controller.programs().resume());
  EXPECT_EQ(last_title(), "PROGRAM_XXX_RESUMED");
  EXPECT_EQ(bench.last(Kind::kKey), "go");
}

TEST_F(UrProgram, MatricesAndWrenches) {
  EXPECT_TRUE(
      bench.run("def go():\n  m = transpose([[1, 2], [3, 5]])\n  write_output_float_register(0, m[0][1])\n"
                "  i = inv([[1, 2], [3, 5]])\n  write_output_float_register(1, i[0][0])\n"
                "  w = wrench_trans(p[0, 0, 0.5, 3.14159265358979, 0, 0], [10, 0, 4, 0, 0, 0])\n"
                "  write_output_float_register(2, w[2])\n  write_output_float_register(3, w[4])\n"
                "  write_output_boolean_register(64, random() < 1 and random() != random())\nend\n"));
  EXPECT_EQ(bench.last(Kind::kRuntimeException), "");
  EXPECT_EQ(bench.field("output_double_register_0"), 3.0);
  EXPECT_NEAR(bench.field("output_double_register_1"), -5.0, 1e-12);
  EXPECT_NEAR(bench.field("output_double_register_2"), -4.0, 1e-9) << "seen upside down";
  EXPECT_NEAR(bench.field("output_double_register_3"), 5.0, 1e-9) << "10 N at 0.5 m";
  EXPECT_EQ(bench.field("output_bit_register_64"), 1.0);
}

TEST_F(UrProgram, AWatchdogStopsAProgramThatHearsNothing) {
  const auto id = input_fields().at("input_int_register_24");
  ASSERT_TRUE(
      bench.controller.programs().start("def go():\n  rtde_set_watchdog(\"input_int_register_24\", 10, \"stop\")\n  "
                                        "while True:\n    speedj([0.2,0,0,0,0,0], 2, 0.008)\n  end\nend\n"));
  for (int i = 0; i < 100; ++i) {
    bench.frame();
    if (i % 5 == 0) bench.controller.apply_inputs({{id, {double(i)}}});
  }
  EXPECT_TRUE(bench.controller.programs().running());
  bench.seconds(0.05);
  EXPECT_TRUE(bench.controller.programs().running());
  bench.seconds(0.06);
  EXPECT_FALSE(bench.controller.programs().running());
  bench.seconds(1.0);
  EXPECT_EQ(bench.plant.dq[0], 0.0) << "and the robot brakes";
}

TEST_F(UrProgram, KinematicsAgreeWithThemselves) {
  EXPECT_TRUE(
      bench.run("def go():\n  q0 = [0.2, -1.5, -1.4, -1.3, 1.2, 0.4]\n  x = get_forward_kin(q0)\n"
                "  q1 = get_inverse_kin(x, q0)\n  textmsg(norm(q1 - q0) < 0.000001)\nend\n"));
  EXPECT_EQ(text(), "True");
  EXPECT_TRUE(bench.run(
      "def go():\n  set_tcp(p[0, 0, 0.1, 0, 0, 0])\n  a = get_forward_kin()\n  set_tcp(p[0,0,0,0,0,0])\n"
      "  b = pose_trans(get_forward_kin(), p[0, 0, 0.1, 0, 0, 0])\n  textmsg(pose_dist(a, b) < 0.000001)\nend\n"));
  EXPECT_EQ(text(), "True");
  EXPECT_TRUE(bench.run("textmsg(get_inverse_kin_has_solution(p[3, 0, 0, 0, 0, 0]))\n"));
  EXPECT_EQ(text(), "False");
}

TEST_F(UrProgram, TwoThreadsMayNotMove) {
  EXPECT_TRUE(
      bench.run("def go():\n  thread t():\n    movej([1,-1,-1,-1,1,1])\n  end\n  run t()\n  sync()\n  "
                "movej([0,-1,-1,-1,1,1])\nend\n"));
  EXPECT_NE(bench.last(Kind::kRuntimeException).find("another thread"), std::string::npos);
}

TEST_F(UrProgram, ASecondaryProgramRunsBesideAndDoesNotMove) {
  ASSERT_TRUE(bench.controller.programs().start("def go():\n  sleep(1)\nend\n"));
  ASSERT_TRUE(bench.controller.programs().start(
      "sec beside():\n  set_standard_digital_out(0, True)\n  movej([0,0,0,0,0,0])\nend\n"));
  bench.frames(3);
  EXPECT_TRUE(bench.controller.programs().running());
  EXPECT_TRUE(bench.controller.io().digital_output(0));
  EXPECT_FALSE(bench.last(Kind::kRuntimeException).empty());
  EXPECT_TRUE(bench.controller.motion().at_rest());
}

TEST_F(UrProgram, ANewProgramReplacesTheOldOne) {
  ASSERT_TRUE(bench.controller.programs().start("def one():\n  while True:\n    sync()\n  end\nend\n"));
  bench.frames(3);
  ASSERT_FALSE(bench.controller.programs().start("def bad():\n  unknown()\nend\n"));
  EXPECT_TRUE(bench.controller.programs().running()) << "what does not compile changes nothing";
  EXPECT_EQ(bench.last(Kind::kRuntimeException), "compile_error_name_not_found:unknown:");
  EXPECT_TRUE(bench.run("def two():\n  textmsg(2)\nend\n"));
  EXPECT_EQ(text(), "2");
}

TEST_F(UrProgram, LinesOfTheScriptPort) {
  const auto line = [&](const std::string& text) { run_piece(bench.controller, {text + "\n", false}); };
  line("digital_out[2]=True");
  bench.frame();
  EXPECT_TRUE(bench.controller.io().digital_output(2));
  line("set_payload(1.5, [0, 0, 0.1])");
  bench.frame();
  EXPECT_EQ(bench.field("payload"), 1.5);
  EXPECT_EQ(bench.field("payload_cog", 2), 0.1);
  line("movej([0.5, -1.745329, -1.570796, -1.396263, 1.570796, 1.570796])");
  bench.frames(3);
  EXPECT_TRUE(bench.controller.programs().running());
  line("stop program");
  EXPECT_FALSE(bench.controller.programs().running());
  line("power off");
  bench.frame();
  EXPECT_EQ(bench.field("robot_mode"), 3.0);
  line("movej([0.5, -1, -1, -1, 1, 1])");
  EXPECT_FALSE(bench.controller.programs().running()) << "without power nothing starts";
  line("set robotmode run");
  bench.seconds(2.0);
  EXPECT_EQ(bench.field("robot_mode"), 7.0);
}

TEST_F(UrProgram, AJointLimitIsAProtectiveStop) {
  ASSERT_TRUE(bench.controller.programs().start(
      "def go():\n  while True:\n    speedj([0, 0, 0, 0, 0, 3], 10, 0.1)\n  end\nend\n"));
  bench.seconds(4.0);
  EXPECT_EQ(bench.field("safety_mode"), 3.0);
  EXPECT_LE(q(5), test::ur5()->limits.upper[5]);
  EXPECT_NE(bench.last(Kind::kError).find("joint 5"), std::string::npos);
}

TEST(UrProgramE, ScriptsNeedRemoteControl) {
  hw::rtde::ControllerOptions options = test::e_series();
  options.remote_control = false;
  test::ControllerBench bench(options);
  run_piece(bench.controller, {"textmsg(1)\n", false});
  EXPECT_FALSE(bench.controller.programs().running());
  EXPECT_NE(bench.last(Kind::kError).find("remote control"), std::string::npos);
}

}  // namespace
}  // namespace takt::hw::rtde
