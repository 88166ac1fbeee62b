// "weld": the order of its signals, and what comes of pauses, cancels and a lost arc, on a cell without physics whose
// torch lights some cycles after it is told to.
#include <algorithm>
#include <array>
#include <vector>

#include "core/activity/runtime.h"
#include "core/base/random.h"
#include "core/operations/process/weld.h"
#include "tests/core/activity/command_fixture.h"
#include "tests/support/random_runs.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::HasSubstr;

/// Outputs by the cycle, and an arc that burns `ignition` cycles after it is wanted.
struct FakeTorch {
  std::array<std::shared_ptr<test::FakeOutput<bool>>, 3> outputs{std::make_shared<test::FakeOutput<bool>>(),
                                                                 std::make_shared<test::FakeOutput<bool>>(),
                                                                 std::make_shared<test::FakeOutput<bool>>()};
  std::shared_ptr<test::FakeInput<bool>> established = std::make_shared<test::FakeInput<bool>>();
  int ignition = 30;
  bool broken = false;  ///< it does not burn
  int waited = 0;

  void add_to(test::CommandCell& cell) {
    constexpr std::array<const char*, 3> kNames = {"torch/gas", "torch/arc", "torch/wire"};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      device::SignalOutputDescription<bool> description;
      description.stop = false;
      cell.cell.digital_outputs[kNames[i]] = &cell.core.add(
          std::make_unique<device::DigitalOutput>(kNames[i], description, outputs[i], cell.core.period()));
    }
    cell.cell.digital_inputs["torch/established"] = &cell.core.add(std::make_unique<device::DigitalInput>(
        "torch/established", device::SignalInputDescription<bool>{}, established));
    const Diagnostics wrong = activity::declare_channels(cell.core, cell.cell);
    EXPECT_FALSE(wrong.has_errors()) << wrong.to_string();
  }
  [[nodiscard]] static bool on(const test::FakeOutput<bool>& output) {
    return !output.written.empty() && output.written.back();
  }
  [[nodiscard]] bool gas() const { return on(*outputs[0]); }
  [[nodiscard]] bool arc() const { return on(*outputs[1]); }
  [[nodiscard]] bool wire() const { return on(*outputs[2]); }
  void step(Nanoseconds now) {
    waited = arc() && !broken ? waited + 1 : 0;
    established->sample.value = waited > ignition;
    established->sample.stamp = now;
  }
  [[nodiscard]] bool burns() const { return established->sample.value; }
};

/// There before the cell to which it is added.
struct WithTorch {
  FakeTorch torch;
};

class WeldTest : protected WithTorch, public test::CommandStepTest {
 protected:
  WeldTest() : test::CommandStepTest([this](test::CommandCell& own) { torch.add_to(own); }) {
    cell.run_cycle = [this, one = cell.run_cycle] {
      torch.step(cell.core.time());
      one();
      note();
    };
    add_line("edge", {{0.0, -0.03, 0.0}, {0.0, 0.02, 0.0}, {0.03, 0.02, 0.0}});
  }

  /// Frames of a line on the top of the block, with the torch as it is held at the start.
  void add_line(const std::string& line, const std::vector<Eigen::Vector3d>& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
      X.translation() = points[i] + Eigen::Vector3d(0.0, 0.0, 0.025);
      X.linear() = (cell.cell.frames.pose("block")->inverse() * cell.tool_in_world(cell.q())).linear();
      EXPECT_TRUE(cell.cell.frames.add(fmt::format("block/{}/{}", line, i + 1), "block", X).empty());
    }
  }

  static std::string weld(const std::string& more = "") {
    return R"({"do": "weld", "name": "seam", "workpiece": "block", "line": "edge", "travel_m_s": 0.02,
               "stick_out_m": 0.015,
               "preflow_s": 0.2, "crater_s": 0.1, "postflow_s": 0.3, "ignition_timeout_s": 0.4, "retract_m": 0.03,
               "overlap_m": 0.004)" +
           more + "}";
  }

  /// What the torch did, by cycles of the core.
  struct Note {
    bool gas = false, arc = false, wire = false, burns = false, moves = false;
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();  ///< end of the wire in the frame of the block, m
  };
  void note() {
    const device::ArmSetPoint& sent = cell.core_arm().set_point();
    const Eigen::Isometry3d X_WT = cell.tool_in_world(sent.q);
    const Eigen::Isometry3d X_WO = *cell.cell.frames.pose("block");
    notes.push_back({.gas = torch.gas(),
                     .arc = torch.arc(),
                     .wire = torch.wire(),
                     .burns = torch.burns(),
                     .moves = sent.dq.cwiseAbs().maxCoeff() > 1e-9,
                     .tip = X_WO.inverse() * (X_WT * Eigen::Vector3d(0.0, 0.0, 0.015))});
  }
  [[nodiscard]] int first(bool Note::*what, bool value = true, int from = 0) const {
    for (int i = from; i < static_cast<int>(notes.size()); ++i)
      if (notes[static_cast<std::size_t>(i)].*what == value) return i;
    return -1;
  }
  [[nodiscard]] const Note& at(int cycle) const { return notes[static_cast<std::size_t>(cycle)]; }
  void expect_off() {
    EXPECT_FALSE(torch.gas());
    EXPECT_FALSE(torch.arc());
    EXPECT_FALSE(torch.wire());
    EXPECT_FALSE(torch.burns());
  }
  /// The way along the line that the arc has left out, m: no point of it is farther from all places where it burned.
  [[nodiscard]] double largest_gap() const {
    double gap = 0.0;
    for (double along = 0.0; along <= 0.08; along += 5e-4) {
      const Eigen::Vector3d point =
          along < 0.05 ? Eigen::Vector3d(0.0, -0.03 + along, 0.025) : Eigen::Vector3d(along - 0.05, 0.02, 0.025);
      double nearest = 1.0;
      for (const Note& one : notes)
        if (one.burns) nearest = std::min(nearest, (one.tip - point).norm());
      gap = std::max(gap, nearest);
    }
    return gap;
  }

  std::vector<Note> notes;
};

TEST_F(WeldTest, GasArcSeamCraterGasInTheirOrder) {
  ASSERT_EQ(run(weld()), Progress::kDone) << diagnostics.to_string();
  expect_good_end();
  expect_off();
  const int gas = first(&Note::gas), arc = first(&Note::arc), burns = first(&Note::burns);
  ASSERT_GT(gas, 0);
  EXPECT_FALSE(at(gas).moves) << "the gas flows when the arm is there";
  EXPECT_NEAR(arc - gas, 200, 3);
  EXPECT_EQ(at(arc).wire, true);
  for (int i = arc; i < burns; ++i) EXPECT_FALSE(at(i).moves) << i;
  EXPECT_TRUE(at(burns).moves) << "the seam begins in the cycle in which the arc burns";
  EXPECT_LT((at(burns).tip - Eigen::Vector3d(0.0, -0.03, 0.025)).norm(), 1e-4);
  const int dark = first(&Note::arc, false, burns), stops = first(&Note::moves, false, burns);
  EXPECT_NEAR(dark - stops, 100, 4) << "the crater is filled at rest";
  EXPECT_LT((at(dark).tip - Eigen::Vector3d(0.03, 0.02, 0.025)).norm(), 1e-4);
  const int shut = first(&Note::gas, false, gas);
  EXPECT_NEAR(shut - dark, 300, 4);
  EXPECT_LT(largest_gap(), 2e-3) << "the corner is blended";
  EXPECT_NEAR((tool() - *cell.cell.frames.pose("block") * Eigen::Vector3d(0.03, 0.02, 0.025)).norm(), 0.045, 1e-4);
}

TEST_F(WeldTest, AnOverrideDoesNotScaleTheSeam) {
  const auto seam_cycles = [&](double rate) {
    notes.clear();
    (void)cell.speed->write(rate);
    EXPECT_EQ(run(weld()), Progress::kDone) << diagnostics.to_string();
    return first(&Note::arc, false, first(&Note::burns)) - first(&Note::burns);
  };
  const int planned = seam_cycles(1.0), slow = seam_cycles(0.3);
  EXPECT_EQ(slow, planned);
}

TEST_F(WeldTest, APausePutsTheArcOutAndItIsLitAgainWithAnOverlap) {
  int paused = -1;
  ASSERT_EQ(run(good(weld()),
                [&](int cycle, program::ProgramRunner&) {
                  const int burns = first(&Note::burns);
                  if (paused < 0 && burns >= 0 && static_cast<int>(notes.size()) == burns + 1000) {
                    paused = cycle;
                    (void)cell.speed->write(0.0);
                  }
                  if (paused >= 0 && cycle == paused + 800) (void)cell.speed->write(1.0);
                }),
            Progress::kDone)
      << diagnostics.to_string();
  expect_good_end();
  expect_off();
  const int out = first(&Note::arc, false, first(&Note::burns)), again = first(&Note::arc, true, out);
  ASSERT_GT(again, out + 700);
  for (int i = out; i <= again; ++i) EXPECT_TRUE(at(i).gas) << i;
  const double overlap = (at(out).tip - at(first(&Note::burns, true, again)).tip).norm();
  EXPECT_GT(overlap, 0.0035);
  EXPECT_LT(overlap, 0.006) << "and what it takes to brake";
  EXPECT_LT(largest_gap(), 2e-3);
}

TEST_F(WeldTest, ALostArcStopsOnTheLineAndFails) {
  int lost = -1;
  ASSERT_EQ(run(good(weld()),
                [&](int, program::ProgramRunner&) {
                  const int burns = first(&Note::burns);
                  if (lost < 0 && burns >= 0 && static_cast<int>(notes.size()) == burns + 1500) {
                    lost = static_cast<int>(notes.size());
                    torch.broken = true;
                  }
                }),
            Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program"));
  expect_good_end();
  expect_off();
  EXPECT_FALSE(at(lost).arc) << "in the cycle in which the input falls";
  const int rest = first(&Note::moves, false, lost);
  EXPECT_LT(rest - lost, 250);
  EXPECT_LT(std::abs(at(rest).tip.x()), 1e-4) << "on the line";
  const double back = (at(static_cast<int>(notes.size()) - 1).tip - at(rest).tip).norm();
  EXPECT_NEAR(back, 0.03, 0.004) << "it withdraws along the torch";
}

TEST_F(WeldTest, ALostArcIsLitAgainAsOftenAsItMay) {
  int lost = -1;
  ASSERT_EQ(run(good(weld(R"(, "restarts": 1)")),
                [&](int, program::ProgramRunner&) {
                  const int burns = first(&Note::burns), now = static_cast<int>(notes.size());
                  if (lost < 0 && burns >= 0 && now == burns + 1500) {
                    lost = now;
                    torch.broken = true;
                  }
                  if (lost >= 0 && now == lost + 100) torch.broken = false;
                }),
            Progress::kDone)
      << diagnostics.to_string();
  expect_off();
  EXPECT_LT(largest_gap(), 2e-3);
}

TEST_F(WeldTest, NoIgnitionEndsWithGasAndArcOff) {
  torch.broken = true;
  ASSERT_EQ(run(weld()), Progress::kFailed);
  EXPECT_THAT(diagnostics, Reports(Code::kConditionNotMet, "/program/ignition_timeout_s"));
  expect_good_end();
  expect_off();
  EXPECT_NEAR(first(&Note::arc, false, first(&Note::arc)) - first(&Note::arc), 400, 4);
}

TEST_F(WeldTest, AnInputThatIsSilentIsAnArcThatIsOut) {
  for (const int at : {0, 1500}) {
    SCOPED_TRACE(at);
    notes.clear();
    torch.established->silent = at == 0;
    ASSERT_EQ(run(good(weld()),
                  [&](int, program::ProgramRunner&) {
                    const int burns = first(&Note::burns);
                    if (burns >= 0 && static_cast<int>(notes.size()) == burns + at) torch.established->silent = true;
                  }),
              Progress::kFailed);
    EXPECT_THAT(diagnostics, Reports(Code::kSensorSilent, "/program/torch"));
    torch.established->silent = false;
    expect_good_end();
    EXPECT_FALSE(torch.gas());
    EXPECT_FALSE(torch.arc());
    EXPECT_FALSE(torch.wire());
  }
}

TEST_F(WeldTest, ACancelEndsInOrder) {
  ASSERT_EQ(run(good(weld()),
                [&](int, program::ProgramRunner& runner) {
                  const int burns = first(&Note::burns);
                  if (burns >= 0 && static_cast<int>(notes.size()) == burns + 1500) runner.cancel();
                }),
            Progress::kDone)
      << diagnostics.to_string();
  expect_good_end();
  expect_off();
  const int burns = first(&Note::burns), rest = first(&Note::moves, false, burns),
            dark = first(&Note::arc, false, burns);
  EXPECT_NEAR(dark - rest, 100, 4) << "crater";
  EXPECT_NEAR(first(&Note::gas, false, dark) - dark, 300, 4) << "postflow";
  EXPECT_LT(std::abs(at(rest).tip.x()), 1e-4);
  EXPECT_NEAR((at(static_cast<int>(notes.size()) - 1).tip - at(rest).tip).norm(), 0.03, 0.004);
}

TEST_F(WeldTest, AWeaveCircAndTorchAnglesKeepTheLimits) {
  Eigen::Isometry3d X = *cell.cell.frames.pose("block/edge/3", "block");
  X.translation() += Eigen::Vector3d(-0.005, 0.01, 0.0);
  EXPECT_TRUE(cell.cell.frames.add("block/edge/3/via", "block", X).empty());
  ASSERT_EQ(run(weld(R"(, "travel_angle_deg": 15, "work_angle_deg": -10, "rotation_deg": 20,
                         "weave": {"amplitude_m": 0.001, "frequency_Hz": 2})")),
            Progress::kDone)
      << diagnostics.to_string();
  expect_good_end();
  expect_off();
}

TEST_F(WeldTest, BadInputIsRefusedAtOnce) {
  EXPECT_THAT(wrong(weld(R"(, "torch": "torsch")")), Reports(Code::kUnknownName, "/program/torch", {"torch"}));
  std::string other = weld();
  other.replace(other.find("\"edge\""), 6, "\"edgy\"");
  EXPECT_THAT(wrong(other), Reports(Code::kUnknownName, "/program/line", {"edge"}));
  const Diagnostics several =
      wrong(R"({"do": "weld", "workpiece": "blok", "travel_m_s": -1, "restarts": 1.5, "speed": 3})");
  EXPECT_THAT(several, Reports(Code::kUnknownName, "/program/workpiece", {"block"}));
  EXPECT_THAT(several, Reports(Code::kMissing, "/program", {"line"}));
  EXPECT_THAT(several, Reports(Code::kOutOfRange, "/program/travel_m_s"));
  EXPECT_GE(several.list().size(), 5u) << several.to_string();
}

TEST_F(WeldTest, ProgramsInCppGiveTheSameParameters) {
  const WeldParameters good{.arm = "arm", .workpiece = "block", .line = "edge", .weave = WeldWeave{.amplitude = 0.001}};
  const auto accepted = weld_parameters().accept(good, cell.cell);
  ASSERT_TRUE(accepted) << accepted.error().to_string();
  EXPECT_EQ(accepted->torch, "torch") << "the only one";
  const auto refused = weld_parameters().accept(
      {.arm = "arm", .workpiece = "block", .line = "edge", .travel = -1.0, .restarts = 200}, cell.cell);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), Reports(Code::kOutOfRange, "/travel_m_s"));
  EXPECT_THAT(refused.error(), Reports(Code::kOutOfRange, "/restarts"));
}

TEST_F(WeldTest, ALineOutOfReachIsRefusedBeforeAnythingMoves) {
  add_line("far", {{0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}});
  std::string far = weld();
  far.replace(far.find("\"edge\""), 6, "\"far\"");
  EXPECT_TRUE(wrong(far).has_errors());
  EXPECT_EQ(first(&Note::gas), -1);
}

// Whatever comes between at whatever time: in the end everything is off, the arm rests within its limits, the arc never
// burns without gas, and the arm moves on no line without an arc that was wanted before.
TEST_F(WeldTest, RandomInterruptionsEndWithEverythingOff) {
  const program::Program program = good(weld(R"(, "restarts": 2)"));
  const test::RandomRuns runs(100);
  for (long i = 0; i < runs.count; ++i) {
    SCOPED_TRACE(i);
    Random random(runs.first_seed + static_cast<std::uint64_t>(i), "weld");
    notes.clear();
    torch.broken = torch.established->silent = false;
    (void)cell.speed->write(1.0);
    const int at = static_cast<int>(random.uniform(0.0, 7000.0)), what = static_cast<int>(random.uniform(0.0, 5.0));
    const int again = at + static_cast<int>(random.uniform(1.0, 1500.0));
    (void)run(program, [&](int cycle, program::ProgramRunner& runner) {
      if (cycle == at) {
        if (what == 0) runner.cancel();
        if (what == 1) (void)cell.speed->write(0.0);
        if (what == 2) torch.broken = true;
        if (what == 3) torch.established->silent = true;
        if (what == 4) (void)cell.speed->write(0.0);
      }
      if (cycle == again) {
        if (what == 4) runner.cancel();
        (void)cell.speed->write(1.0);
        torch.broken = torch.established->silent = false;
      }
    });
    cell.step(600);
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_FALSE(torch.gas() || torch.arc() || torch.wire());
    for (const Note& one : notes) {
      ASSERT_FALSE((one.arc || one.wire) && !one.gas) << "an arc without gas";
    }
    ASSERT_LE(cell.worst_limit_share(), 1.0);
    cell.backend->sent.clear();
    // A cycle must not allocate.
    for (const auto& output : torch.outputs) output->written.clear();
    for (const auto& output : {cell.driver_terminal, cell.lamp_terminal}) output->written.clear();
    cell.valve_terminal->written.clear();
    if (testing::Test::HasFailure()) break;
  }
}

}  // namespace
}  // namespace takt::operations
