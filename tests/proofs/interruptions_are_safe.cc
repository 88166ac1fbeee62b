// Every scenario of the repository, interrupted at many cycles in every way (rows L6, P2, S1, S4): no limit is broken,
// all arms come to rest and are free, and the cell works again afterwards. At each chosen cycle the run is forked; the
// child is interrupted, the parent goes on.
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/activity/program.h"
#include "scenario/limit_monitor.h"
#include "scenario/operator.h"
#include "scenario/session.h"
#include "tests/support/random_runs.h"
#include "tests/support/scenario_names.h"

namespace takt::scenario {
namespace {

enum class Act { kCancel, kPause, kAbort, kStop0, kStop1, kStop2 };
constexpr std::array kActs = {Act::kCancel, Act::kPause, Act::kAbort, Act::kStop0, Act::kStop1, Act::kStop2};
constexpr std::array kNames = {
    "cancel", "pause", "abort", "stop of category 0", "stop of category 1", "stop of category 2"};

constexpr int kAfterPause = 100;    ///< a paused run goes on for so long, and is cancelled then
constexpr int kRestCycles = 1'500;  ///< within which everything must be at rest after the end, beside its braking

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

/// One run of a scenario, in the parent or, from a fork on, in a child.
class Interrupted {
 public:
  Interrupted(const std::filesystem::path& file, std::int64_t every, std::int64_t first, bool all)
      : every_(every), next_(first), all_(all) {
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
    options.operate = [this](Operator& panel) { before_cycle(panel); };
    options.after_cycle = [this](BuiltCell& built) { return after_cycle(built); };
    const RunReport report = session_->run(options);
    if (child_) finish_child(report);
    EXPECT_EQ(report.verdict, Verdict::kPassed) << to_text(report, "uninterrupted");
  }

  int tried = 0;
  std::vector<std::string> failures;

 private:
  void before_cycle(Operator& panel) {
    if (built_ == nullptr) return;
    const std::int64_t cycle = built_->core->cycle();
    if (child_) return act(panel, cycle);
    if (cycle < next_ || failures.size() >= 20) return;
    next_ += every_;
    for (std::size_t i = 0; i < kActs.size(); ++i) {
      if (!all_ && i != static_cast<std::size_t>(tried) % kActs.size()) continue;
      fork_child(kActs[i], cycle);
      if (child_) return act(panel, cycle);
      if (all_) continue;
      break;
    }
  }

  void fork_child(Act act, std::int64_t cycle) {
    ++tried;
    std::array<int, 2> pipe_ends{};
    ASSERT_EQ(pipe(pipe_ends.data()), 0);
    const pid_t pid = fork();
    ASSERT_GE(pid, 0);
    if (pid == 0) {
      child_ = true;
      act_ = act;
      at_ = cycle;
      answer_ = pipe_ends[1];
      close(pipe_ends[0]);
      return;
    }
    close(pipe_ends[1]);
    std::string said;
    std::array<char, 512> buffer{};
    for (ssize_t n = 0; (n = read(pipe_ends[0], buffer.data(), buffer.size())) > 0;)
      said.append(buffer.data(), static_cast<std::size_t>(n));
    close(pipe_ends[0]);
    int status = 0;
    waitpid(pid, &status, 0);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !said.empty())
      failures.push_back(fmt::format("{} in cycle {}: {}", kNames[static_cast<std::size_t>(act)], cycle,
                                     said.empty() ? "the process ended" : said));
  }

  void act(Operator& panel, std::int64_t cycle) {
    const std::int64_t since = cycle - at_;
    switch (act_) {
      case Act::kCancel:
        if (since == 0) panel.cancel();
        return;
      case Act::kPause:
        if (since == 0) panel.pause();
        if (since == pause_cycles()) {
          expect_slow();
          panel.resume();
        }
        if (since == pause_cycles() + kAfterPause) panel.cancel();
        return;
      case Act::kAbort:
        if (since == 0) panel.abort();
        return;
      default:
        if (since != 0) return;
        built_->emergency_stop->set_category(
            static_cast<device::StopCategory>(static_cast<int>(act_) - static_cast<int>(Act::kStop0)));
        built_->emergency_stop->set_healthy(false);
    }
  }

  /// So long that everything stands: on its path a machine brakes with a part of its acceleration.
  [[nodiscard]] int pause_cycles() const {
    double longest = 0.0;
    for (const auto& [name, arm] : built_->cell.arms)
      longest = std::max(longest, motion::longest_stop(arm.device->description().limits));
    return 300 + static_cast<int>(2.0 * longest / to_seconds(built_->core->period()));
  }

  bool after_cycle(BuiltCell& built) {
    built_ = &built;
    for (const auto& [name, arm] : built.cell.arms) {
      const device::ArmDescription& description = arm.device->description();
      auto monitor = monitors_.find(name);
      if (monitor == monitors_.end())
        monitor = monitors_
                      .emplace(name, std::make_unique<LimitMonitor>(description.limits, description.joint_names,
                                                                    to_seconds(built.core->period())))
                      .first;
      if (arm.device->phase() == device::Arm::Phase::kNotReady) {
        monitor->second->restart();
      } else if (arm.device->set_point().q.size() > 0) {
        monitor->second->add(arm.device->set_point().q);
      }
    }
    return true;
  }

  // -- In the child --------------------------------------------------------------------------------------------------

  void complain(const std::string& what) { complaints_ += complaints_.empty() ? what : "; " + what; }

  void step(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      built_->core->step();
      if (!built_->world->step()) return complain("the physics diverged");
      after_cycle(*built_);
    }
  }

  /// What holds a force may follow a surface; nothing else moves in a pause.
  void expect_slow() {
    constexpr double kSlow = 0.01;
    for (const auto& [name, arm] : built_->cell.arms) {
      const device::JointVector share =
          arm.device->set_point().dq.cwiseQuotient(arm.device->description().limits.velocity).cwiseAbs();
      if (share.size() > 0 && share.maxCoeff() > kSlow)
        complain(fmt::format("'{}' moves in the pause, with {:.1f} % of its speed", name, 100.0 * share.maxCoeff()));
    }
  }

  void expect_rest(const std::string& when, bool free) {
    for (const auto& [name, arm] : built_->cell.arms) {
      const bool rests = arm.device->lost() || arm.device->at_rest();
      if (!rests) complain(fmt::format("'{}' moves {}", name, when));
      if (free && arm.device->held()) complain(fmt::format("'{}' is held {}", name, when));
    }
    for (const auto& [name, gripper] : built_->cell.grippers)
      if (free && gripper.device->held()) complain(fmt::format("'{}' is held {}", name, when));
  }

  [[noreturn]] void finish_child(const RunReport& report) {
    if (report.findings.to_string().find("did not end within") != std::string::npos)
      complain(report.findings.to_string());
    step(pause_cycles() + kRestCycles);
    expect_rest("after the end", /*free=*/true);
    release();
    move_again();
    for (const auto& [name, monitor] : monitors_)
      if (!monitor->held()) complain(fmt::format("'{}': {}", name, monitor->worst().what));
    (void)!write(answer_, complaints_.data(), complaints_.size());
    _exit(complaints_.empty() ? 0 : 1);
  }

  /// What people do after a stop.
  void release() {
    if (static_cast<int>(act_) < static_cast<int>(Act::kStop0)) return;
    built_->emergency_stop->set_healthy(true);
    for (const auto& [name, arm] : built_->cell.arms) built_->world->arm(name)->release_brakes();
    step(1);
    built_->emergency_stop->set_reset(true);
    step(1);
    built_->emergency_stop->set_reset(false);
    step(200);
  }

  /// Every arm turns its first joint by a degree, towards the middle of its range.
  void move_again() {
    nlohmann::ordered_json branches = nlohmann::ordered_json::array();
    for (const auto& [name, arm] : built_->cell.arms) {
      const motion::JointLimits& limits = arm.device->description().limits;
      device::JointVector q = arm.device->set_point().q * 57.29577951308232;
      q[0] += q[0] > 28.64788975654116 * (limits.lower[0] + limits.upper[0]) ? -1.0 : 1.0;
      branches.push_back({{"do", "ptp"},
                          {"arm", name},
                          {"to", {{"joints_deg", std::vector<double>(q.begin(), q.end())}}},
                          {"speed", 0.2}});
    }
    const auto program = activity::Program::parse({{"do", "sequence"}, {"steps", branches}}, "/again", built_->cell);
    if (!program) return complain(program.error().to_string());
    activity::Variables variables;
    activity::Context context{built_->cell, *built_->core, variables, 2, [](auto, auto, auto) {}};
    activity::ProgramRunner runner(*program, context);
    if (auto* override = built_->core->find_channel(Operator::kOverride)) (void) override->write(1.0);
    auto progress = activity::Progress::kRunning;
    for (int i = 0; i < 5'000 && progress == activity::Progress::kRunning; ++i) {
      progress = runner.advance();
      step(1);
    }
    if (progress != activity::Progress::kDone) complain("does not move again: " + runner.findings().to_string());
  }

  std::unique_ptr<Session> session_;
  BuiltCell* built_ = nullptr;
  std::map<std::string, std::unique_ptr<LimitMonitor>> monitors_;
  std::int64_t every_, next_;
  bool all_;

  bool child_ = false;
  Act act_ = Act::kCancel;
  std::int64_t at_ = 0;
  int answer_ = -1;
  std::string complaints_;
};

class InterruptionsTest : public testing::TestWithParam<std::string> {};

TEST_P(InterruptionsTest, RowsL6S1S4_LeaveNothingBehind) {
  const test::RandomRuns runs(48);
  const std::filesystem::path file = "scenarios/" + GetParam() + ".json";
  const auto session = Session::open(file, models());
  ASSERT_TRUE(session) << session.error().to_string();
  const auto cycles = static_cast<std::int64_t>(1e3 * (*session)->planned_duration());
  // Many runs: every tenth cycle, each in every way. Few: spread over the run, the ways by turns.
  constexpr std::int64_t kDense = 10;
  const bool all = runs.count > static_cast<long>(kActs.size()) * cycles / kDense;
  const std::int64_t every = all ? kDense : std::max<std::int64_t>(1, cycles / runs.count);
  Interrupted interrupted(file, every,
                          static_cast<std::int64_t>(runs.first_seed * 7 % static_cast<std::uint64_t>(every)), all);
  interrupted.run();
  std::printf("%d interruptions, every %ld cycles\n", interrupted.tried, static_cast<long>(every));
  EXPECT_GE(interrupted.tried, std::min<long>(runs.count / 2, 20)) << "the run was shorter than it was planned";
  for (const std::string& failure : interrupted.failures) ADD_FAILURE() << failure;
}

INSTANTIATE_TEST_SUITE_P(Scenarios, InterruptionsTest, testing::ValuesIn(test::scenario_names()),
                         [](const auto& one) { return one.param; });

}  // namespace
}  // namespace takt::scenario
