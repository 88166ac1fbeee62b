// Every scenario of the repository, interrupted at many cycles in every way (rows L6, P2, S1, S4): no limit is broken,
// all arms come to rest and are free, and the cell works again afterwards. At each chosen cycle the run is forked; the
// child is interrupted, the parent goes on. A child goes on for as long as something moves; a few are watched for
// seconds, so that what wakes up late is seen too.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/run/interruptions.h"
#include "cell/run/session.h"
#include "core/program/tree/program.h"
#include "tests/support/random_runs.h"
#include "tests/support/scenario_names.h"

namespace takt::cell {
namespace {

using Way = Interruptions::Way;

constexpr int kRestCycles = 1'500;  ///< within which everything must be at rest after the end, beside its braking
constexpr int kStill = 50;          ///< cycles after which what is at rest counts as resting

/// The ways that are tried at a cycle: all that a program is told by, and one category of stops by turns; or one way.
std::vector<Way> ways_at(std::int64_t point, bool dense) {
  const auto turn = [point](int ways, int from) { return static_cast<Way>(from + static_cast<int>(point % ways)); };
  if (!dense) return {turn(Interruptions::kWays, 0)};
  return {Way::kCancel, Way::kPause, Way::kAbort, turn(3, 3)};
}

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

/// One run of a scenario, in the parent or, from a fork on, in a child.
class Interrupted {
 public:
  /// @param dense  as in ways_at()
  Interrupted(const std::filesystem::path& file, std::int64_t every, std::int64_t first, bool dense)
      : tries({.first = first, .every = every, .ways = {}, .progress = {}}) {
    tries.plan().ways = [this, dense](std::int64_t point) {
      return share_.has(point) ? ways_at(point, dense) : std::vector<Way>{};
    };
    tries.plan().progress = [this](std::int64_t cycle) {
      progress_.tell([&] {
        return fmt::format("cycle {}: {} cases, {} failures", cycle, tries.tried(), tries.failures().size());
      });
    };
    // Nobody presses the button, but the cell has one.
    OpenOptions options;
    options.overrides.push_back({"/faults", R"([{"at_s": 3600, "do": "emergency_stop"}])"});
    auto session = Session::open(file, models(), options);
    EXPECT_TRUE(session) << session.error().to_string();
    if (session) session_ = std::move(*session);
  }

  void run() {
    if (!session_) return;
    RunOptions options;
    options.repeat = options.measure_times = false;
    tries.attach(options);
    options.after_cycle = [this](BuiltCell& built) {
      built_ = &built;
      tries.watch(built);
      return true;
    };
    const RunReport report = session_->run(options);
    if (tries.in_child()) finish_child(report);
    EXPECT_EQ(report.verdict, Verdict::kPassed) << to_text(report, "uninterrupted");
  }

  Interruptions tries;

 private:
  // -- In the child --------------------------------------------------------------------------------------------------

  void step(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      built_->core->step();
      if (!built_->world->step()) return tries.complain(built_->world->divergence());
      tries.watch(*built_);
    }
  }

  /// What still moves or is held; empty: nothing.
  [[nodiscard]] std::string not_at_rest() const {
    std::string who;
    const auto add = [&](const std::string& name, const char* does) {
      who += fmt::format("{}'{}' {}", who.empty() ? "" : ", ", name, does);
    };
    for (const auto& [name, arm] : built_->cell.arms) {
      if (!arm.device->lost() && !arm.device->at_rest()) add(name, "moves");
      if (arm.device->held()) add(name, "is held");
    }
    for (const auto& [name, gripper] : built_->cell.grippers)
      if (gripper.device->held()) add(name, "is held");
    return who;
  }

  /// Steps until everything is at rest and free and stays so, and complains of what is not.
  void come_to_rest() {
    const int most = Interruptions::braking_cycles(*built_) + kRestCycles;
    int still = 0;
    for (int i = 0; i < most && (tries.long_watch() || still < kStill); ++i) {
      step(1);
      still = not_at_rest().empty() ? still + 1 : 0;
    }
    if (still < kStill) tries.complain(not_at_rest() + " after the end");
  }

  [[noreturn]] void finish_child(const RunReport& report) {
    if (report.diagnostics.to_string().find("did not end within") != std::string::npos)
      tries.complain(report.diagnostics.to_string());
    come_to_rest();
    release();
    move_again();
    tries.answer();
  }

  /// What people do after a stop.
  void release() {
    if (tries.way() < Way::kStop0) return;
    built_->emergency_stop->set_healthy(true);
    for (const auto& [name, arm] : built_->cell.arms) built_->world->arm(name)->release_brakes();
    step(1);
    built_->emergency_stop->set_reset(true);
    step(1);
    built_->emergency_stop->set_reset(false);
    for (int i = 0; i < 200 && (i < 5 || !all_ready()); ++i) step(1);
  }

  [[nodiscard]] bool all_ready() const {
    return std::ranges::all_of(
        built_->cell.arms, [](const auto& one) { return one.second.device->phase() == device::Arm::Phase::kFrozen; });
  }

  /// Every arm turns its first joint by a fifth of a degree, towards the middle of its range.
  void move_again() {
    nlohmann::ordered_json branches = nlohmann::ordered_json::array();
    for (const auto& [name, arm] : built_->cell.arms) {
      const motion::JointLimits& limits = arm.device->description().limits;
      device::JointVector q = arm.device->set_point().q * 57.29577951308232;
      q[0] += q[0] > 28.64788975654116 * (limits.lower[0] + limits.upper[0]) ? -0.2 : 0.2;
      branches.push_back({{"do", "ptp"},
                          {"arm", name},
                          {"to", {{"joints_deg", std::vector<double>(q.begin(), q.end())}}},
                          {"speed", 0.2}});
    }
    built_->cell.shapes = nullptr;  // it is asked whether the arms can move, not whether there is room amid things
    const auto program = program::Program::parse({{"do", "sequence"}, {"steps", branches}}, "/again", built_->cell);
    if (!program) return tries.complain(program.error().to_string());
    activity::Variables variables;
    activity::Context context{built_->cell, *built_->core, variables, 2, [](auto, auto, auto) {}};
    program::ProgramRunner runner(*program, context);
    if (auto* override = built_->core->find_channel(Operator::kOverride)) (void) override->write(1.0);
    auto progress = operations::Progress::kRunning;
    for (int i = 0; i < 5'000 && progress == operations::Progress::kRunning; ++i) {
      progress = runner.advance();
      step(1);
    }
    if (progress != operations::Progress::kDone)
      tries.complain("does not move again: " + runner.diagnostics().to_string());
  }

  std::unique_ptr<Session> session_;
  BuiltCell* built_ = nullptr;
  test::Share share_;
  test::Progress progress_;
};

class InterruptionsTest : public testing::TestWithParam<std::string> {};

TEST_P(InterruptionsTest, RowsL6S1S4_LeaveNothingBehind) {
  const test::RandomRuns runs(48);
  const std::filesystem::path file = "scenarios/" + GetParam() + ".json";
  const auto session = Session::open(file, models());
  ASSERT_TRUE(session) << session.error().to_string();
  const auto cycles = static_cast<std::int64_t>(1e3 * (*session)->planned_duration());
  // Many runs: every tenth cycle. Few: spread over the run.
  constexpr std::int64_t kDense = 10;
  const bool dense = runs.count > cycles;
  const std::int64_t every = dense ? kDense : std::max<std::int64_t>(1, cycles / runs.count);
  Interrupted interrupted(file, every,
                          static_cast<std::int64_t>(runs.first_seed * 7 % static_cast<std::uint64_t>(every)), dense);
  interrupted.run();
  std::printf("%d interruptions, every %ld cycles\n", interrupted.tries.tried(), static_cast<long>(every));
  EXPECT_GE(interrupted.tries.tried(), std::min<long>(runs.count / 2 / test::Share().of, 20))
      << "the run was shorter than it was planned";
  for (const std::string& failure : interrupted.tries.failures()) ADD_FAILURE() << failure;
}

INSTANTIATE_TEST_SUITE_P(Scenarios, InterruptionsTest, testing::ValuesIn(test::scenario_names()),
                         [](const auto& one) { return one.param; });

}  // namespace
}  // namespace takt::cell
