#include "cell/run/interruptions.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include "core/device/emergency_stop.h"

namespace takt::cell {
namespace {

constexpr int kAfterPause = 100;  ///< cycles: a paused run goes on for so long, and is cancelled then
constexpr int kStill = 50;        ///< cycles after which what stands counts as standing
constexpr int kLongWatch = 17;    ///< one case in so many is watched to the end of its time; prime: in all ways
constexpr double kSlow = 0.01;    ///< of the speed of a joint: what holds a force may follow a surface in a pause
constexpr std::size_t kMostFailures = 20;
constexpr int kAfterFault = 3000;  ///< cycles: a program that handles the fault is cancelled then
constexpr int kSilent = 500;       ///< cycles for which a device says nothing

}  // namespace

std::string_view Interruptions::name_of(Way way) {
  static constexpr std::array<std::string_view, kWays + 1> kNames = {
      "cancel", "pause", "abort", "stop of category 0", "stop of category 1", "stop of category 2", "fault"};
  return kNames[static_cast<std::size_t>(way)];
}

std::vector<std::string> Interruptions::failures() const {
  std::vector<std::string> failures;
  for (const Case& one : failed_)
    failures.push_back(fmt::format("{} in cycle {}: {}", name_of(one.way), one.cycle, one.wrong));
  return failures;
}

Interruptions Interruptions::again(const Case& tried) {
  Interruptions one(Plan{});
  one.tried_ = tried.number;
  one.child_ = true;
  one.long_watch_ = tried.number % kLongWatch == 0;
  one.way_ = tried.way;
  one.at_ = tried.cycle;
  return one;
}

std::vector<Interruptions::Way> Interruptions::by_program(std::int64_t /*point*/) {
  return {Way::kCancel, Way::kPause, Way::kAbort};
}

void Interruptions::attach(RunOptions& options) {
  options.operate = [this](Operator& panel) { before_cycle(panel); };
  options.after_cycle = [this](BuiltCell& built) {
    watch(built);
    return true;
  };
}

void Interruptions::before_cycle(Operator& panel) {
  if (built_ == nullptr) return;
  const std::int64_t cycle = built_->core->cycle();
  if (child_) return act(panel, cycle);
  if (cycle < plan_.first || (cycle - plan_.first) % plan_.every != 0 || failed_.size() >= kMostFailures) return;
  for (const Way way : plan_.ways(points_++)) {
    fork_child(way, cycle);
    if (child_) return act(panel, cycle);
  }
  if (plan_.progress) plan_.progress(cycle);
}

void Interruptions::fork_child(Way way, std::int64_t cycle) {
  ++tried_;
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  std::fflush(nullptr);  // what is buffered would be written twice
  const pid_t pid = fork();
  if (pid < 0) throw std::system_error(errno, std::generic_category(), "fork");
  way_ = way;
  at_ = cycle;
  if (pid > 0) {
    close(ends[1]);
    return hear(ends[0], pid);
  }
  child_ = true;
  long_watch_ = tried_ % kLongWatch == 0;
  answer_ = ends[1];
  close(ends[0]);
  // Only the parent talks to people.
  const int nowhere = open("/dev/null", O_WRONLY);
  for (const int out : {STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, out);
}

/// Waits for the child and notes what it says.
void Interruptions::hear(int from, int pid) {
  std::string said;
  std::array<char, 512> buffer{};
  for (ssize_t n = 0; (n = read(from, buffer.data(), buffer.size())) > 0;)
    said.append(buffer.data(), static_cast<std::size_t>(n));
  close(from);
  int status = 0;
  waitpid(pid, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && said.empty()) return;
  failed_.push_back({way_, at_, tried_, said.empty() ? "the process ended" : said});
}

void Interruptions::act(Operator& panel, std::int64_t cycle) {
  if (cycle < at_) return;
  const bool now = cycle == at_;
  switch (way_) {
    case Way::kCancel:
      if (now) panel.cancel();
      return;
    case Way::kPause:
      return pause(panel, cycle);
    case Way::kAbort:
      if (now) panel.abort();
      return;
    case Way::kFault:
      return fault(panel, cycle);
    case Way::kStop0:
    case Way::kStop1:
    case Way::kStop2:
      if (!now) return;
      built_->emergency_stop->set_category(
          static_cast<device::StopCategory>(static_cast<int>(way_) - static_cast<int>(Way::kStop0)));
      built_->emergency_stop->set_healthy(false);
  }
}

void Interruptions::fault(Operator& panel, std::int64_t cycle) {
  if (cycle == at_) break_something();
  if (cycle == at_ + kSilent) end_faults();
  if (cycle == at_ + kAfterFault) panel.cancel();
}

/// What it is follows from how often something has been tried.
void Interruptions::break_something() const {
  constexpr std::size_t kCategories = 3;
  const std::size_t arms = built_->cell.arms.size(), stops = kCategories * arms;
  const auto& points = built_->fault_points;
  if (stops + points.size() == 0) return;
  const std::size_t turn = static_cast<std::size_t>(tried_) % (stops + points.size());
  if (turn >= stops) {
    const auto& [name, point] = *std::next(points.begin(), static_cast<std::ptrdiff_t>(turn - stops));
    return point->begin({.kind = point->kinds().front()}, 0, name);
  }
  const auto arm = std::next(built_->cell.arms.begin(), static_cast<std::ptrdiff_t>(turn % arms));
  if (sim::SimArm* machine = built_->world->arm(arm->first))
    machine->stop(static_cast<device::StopCategory>(turn / arms));
}

void Interruptions::end_faults() const {
  for (const auto& [name, point] : built_->fault_points) point->end();
}

/// A pause ends when everything has stood for a while; the run goes on, and is cancelled, or comes to its end.
void Interruptions::pause(Operator& panel, std::int64_t cycle) {
  if (cycle == at_) panel.pause();
  if (resumed_ >= 0) {
    if (cycle == resumed_ + kAfterPause && !long_watch_) panel.cancel();
    return;
  }
  const std::string moving = faster_than(kSlow);
  still_ = moving.empty() ? still_ + 1 : 0;
  const bool over = cycle - at_ >= braking_cycles(*built_);
  if (over && still_ < kStill) complain(moving + " in the pause");
  if (!over && (long_watch_ || still_ < kStill)) return;
  panel.resume();
  resumed_ = cycle;
}

/// The first arm of which a joint is sent with more than this share of its speed; empty: there is none.
std::string Interruptions::faster_than(double most) const {
  for (const auto& [name, arm] : built_->cell.arms) {
    const device::JointVector share =
        arm.device->set_point().dq.cwiseQuotient(arm.device->description().limits.velocity).cwiseAbs();
    if (share.size() > 0 && share.maxCoeff() > most)
      return fmt::format("'{}' moves with {:.1f} % of its speed", name, 100.0 * share.maxCoeff());
  }
  return {};
}

int Interruptions::braking_cycles(const BuiltCell& built) {
  double longest = 0.0;
  for (const auto& [name, arm] : built.cell.arms)
    longest = std::max(longest, motion::longest_stop(arm.device->description().limits));
  return 300 + static_cast<int>(2.0 * longest / to_seconds(built.core->period()));
}

void Interruptions::watch(const BuiltCell& built) {
  built_ = &built;
  for (const auto& [name, arm] : built.cell.arms) {
    auto& monitor = monitors_[name];
    if (!monitor) {
      const device::ArmDescription& description = arm.device->description();
      monitor =
          std::make_unique<LimitMonitor>(description.limits, description.joint_names, to_seconds(built.core->period()));
    }
    monitor->watch(*arm.device);
  }
}

/// A machine that has stopped by itself follows no set point: it is judged by how fast it is.
bool Interruptions::rests(const device::Arm& arm) const {
  if (way_ != Way::kFault || arm.sample().fault == 0) return arm.at_rest();
  const device::JointVector& dq = arm.sample().dq;
  return dq.size() == 0 || (dq.cwiseQuotient(arm.description().limits.velocity)).cwiseAbs().maxCoeff() < kSlow;
}

void Interruptions::come_to_rest(const BuiltCell& built) {
  if (way_ == Way::kFault && built_ != nullptr) end_faults();
  const auto rests = [this](const auto& entry) {
    return this->rests(*entry.second.device) && !entry.second.device->held();
  };
  for (int i = braking_cycles(built); i > 0 && !std::ranges::all_of(built.cell.arms, rests); --i) {
    built.core->step();
    if (!built.world->step()) return complain(built.world->divergence());
    watch(built);
  }
}

void Interruptions::complain(const std::string& what) { complaints_ += complaints_.empty() ? what : "; " + what; }

void Interruptions::answer_after(const expression::Cell& cell, Nanoseconds period, const RunReport& report) {
  constexpr double kSoon = 6.0;  // s; what is cancelled brakes, and its program may say something yet
  const std::int64_t given = way_ == Way::kFault ? kAfterFault : paused_cycles();
  const double told = to_seconds(period) * static_cast<double>(at_ + given);
  const bool goes_on = way_ == Way::kPause && long_watch_;
  if (!goes_on && report.sim_time > told + kSoon)
    complain(fmt::format("the program ends only at {:.3f} s", report.sim_time));
  for (const auto& [name, arm] : cell.arms) {
    if (!rests(*arm.device)) complain(fmt::format("'{}' moves after the end", name));
    if (arm.device->held()) complain(fmt::format("'{}' is held after the end", name));
  }
  answer();
}

void Interruptions::answer() {
  for (const auto& [name, monitor] : monitors_)
    if (!monitor->held()) complain(fmt::format("'{}': {}", name, monitor->worst().what));
  const bool sent = write(answer_, complaints_.data(), complaints_.size()) >= 0;
  _exit(complaints_.empty() && sent ? 0 : 1);
}

}  // namespace takt::cell
