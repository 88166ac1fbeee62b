#include "serve/program_desk.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace takt::serve {
namespace {

constexpr std::chrono::milliseconds kIdle{50};

/// A step has begun or ended: keeps the paths of those that run.
void follow(const cell::LogEntry& entry, std::vector<std::string>& running) {
  if (entry.source != "program") return;
  const auto found = std::ranges::find(running, entry.step);
  if (entry.name == "begin") {
    running.push_back(entry.step);
  } else if ((entry.name == "end" || entry.name == "failed") && found != running.end()) {
    running.erase(found);
  }
}

}  // namespace

std::string_view name_of(ProgramDesk::State state) {
  static constexpr std::array<std::string_view, 5> kNames = {"awaits start", "runs", "paused", "awaits step", "ended"};
  return kNames.at(static_cast<std::size_t>(state));
}

ProgramDesk::ProgramDesk(bool steps, const std::atomic<int>* interrupt) : interrupt_(interrupt) { view_.steps = steps; }

ProgramDesk::State ProgramDesk::state() const {
  if (ended_) return State::kEnded;
  if (!begun_) return State::kAwaitsStart;
  if (wanted_.pause.value_or(paused_)) return State::kPaused;
  return waits_ ? State::kAwaitsStep : State::kRuns;
}

ProgramDesk::View ProgramDesk::view() const {
  const std::lock_guard lock(mutex_);
  View view = view_;
  view.state = state();
  return view;
}

std::vector<ProgramDesk::Entry> ProgramDesk::log_from(std::int64_t sequence, std::size_t most) const {
  const std::lock_guard lock(mutex_);
  std::vector<Entry> found;
  for (const Entry& one : log_)
    if (one.sequence >= sequence && found.size() < most) found.push_back(one);
  return found;
}

bool ProgramDesk::go_on() {
  const std::lock_guard lock(mutex_);
  if (ended_) return false;
  begun_ = true;
  view_.single = false;
  wanted_.pause = false;
  ++permits_;
  wake_.notify_all();
  return true;
}

bool ProgramDesk::pause() {
  const std::lock_guard lock(mutex_);
  if (ended_ || !begun_) return false;
  wanted_.pause = true;
  return true;
}

bool ProgramDesk::step() {
  const std::lock_guard lock(mutex_);
  if (ended_ || !view_.steps) return false;
  begun_ = true;
  view_.single = true;
  wanted_.pause = false;
  if (waits_) ++permits_;
  wake_.notify_all();
  return true;
}

bool ProgramDesk::set_speed(double share) {
  const std::lock_guard lock(mutex_);
  if (ended_) return false;
  wanted_.speed = view_.speed = share;
  return true;
}

bool ProgramDesk::cancel() {
  const std::lock_guard lock(mutex_);
  if (ended_) return false;
  wanted_.cancel = view_.cancelled = true;
  wake_.notify_all();
  return true;
}

void ProgramDesk::abort() {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  wanted_.abort = view_.cancelled = true;
  wake_.notify_all();
}

void ProgramDesk::operate(cell::Operator& panel) {
  Wanted wanted;
  {
    const std::lock_guard lock(mutex_);
    wanted = std::exchange(wanted_, {});
    // Where the time cannot stand, what has not begun is held.
    if (!begun_ && !view_.steps) wanted.pause = true;
    paused_ = wanted.pause.value_or(paused_);
  }
  // Without the lock: each of these is told to the log of the run, and so to heard().
  if (wanted.pause && *wanted.pause != panel.paused()) *wanted.pause ? panel.pause() : panel.resume();
  if (wanted.speed) panel.set_override(*wanted.speed);
  if (wanted.cancel && !panel.cancelled()) panel.cancel();
  if (wanted.abort && panel.broken_off().empty()) panel.abort();
  const std::lock_guard lock(mutex_);
  paused_ = panel.paused();
}

cell::StepAnswer ProgramDesk::before_step(const cell::NextStep& next, const std::function<void()>& idle) {
  std::unique_lock lock(mutex_);
  const auto decided = [this] { return wanted_.cancel || wanted_.abort || interrupted() || permits_ > 0; };
  if (begun_ && !view_.single) {
    permits_ = 0;
    return cell::StepAnswer::kNext;
  }
  permits_ = 0;
  waits_ = true;
  view_.next = next;
  while (!wake_.wait_for(lock, kIdle, decided)) {
    lock.unlock();
    idle();
    lock.lock();
  }
  waits_ = false;
  view_.next = {};
  const bool goes_on = permits_ > 0 && !wanted_.cancel && !wanted_.abort && !interrupted();
  permits_ = 0;
  return goes_on ? cell::StepAnswer::kNext : cell::StepAnswer::kCancel;
}

void ProgramDesk::heard(const cell::LogEntry& entry) {
  const std::lock_guard lock(mutex_);
  follow(entry, view_.running);
  log_.push_back({.sequence = next_sequence_++, .entry = entry});
  if (log_.size() > kLog) log_.pop_front();
}

void ProgramDesk::set_planned(double seconds) {
  const std::lock_guard lock(mutex_);
  view_.planned = seconds;
}

void ProgramDesk::ended(const cell::RunReport& report) {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  view_.running.clear();
  view_.verdict = name_of(report.verdict);
  for (const Diagnostic& diagnostic : report.diagnostics.list())
    if (diagnostic.severity == Severity::kError) view_.findings.push_back(diagnostic.message);
  for (const auto& result : report.expectations)
    if (result.judged && !result.passed) view_.findings.push_back(result.name + ": " + result.measured);
}

}  // namespace takt::serve
