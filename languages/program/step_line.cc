#include "languages/program/step_line.h"

#include <utility>

#include <nlohmann/json.hpp>

namespace takt::languages {

using program::Outcome;

/// @return false with failures
bool StepLine::make(Running& running) {
  Diagnostics own;
  const auto step = running.group->to_step(own);
  if (!own.has_errors()) {
    program::NodeParser parser(execution_.context.cell, nullptr, own);
    const program::NodeParser::Inner inner(parser, false);
    running.node = parser.node(step, node_.pointer);
  }
  running.scope = std::make_unique<program::Scope>();
  if (!own.has_errors()) return true;
  running.group->locate(own);
  failures_.append(own);
  failed_ = true;
  return false;
}

bool StepLine::begin(std::shared_ptr<const StepGroup> group) {
  auto next = std::make_unique<Running>(Running{.group = std::move(group)});
  if (!make(*next)) return false;
  next->run = next->node->begin(*next->scope);
  main_ = std::move(next);
  return true;
}

bool StepLine::begin_beside(std::shared_ptr<const StepGroup> group) {
  Running next{.group = std::move(group)};
  if (!make(next)) return false;
  next.line = std::make_unique<program::ControlLine>();
  next.run = std::make_unique<program::SettledRun>(next.node->begin(*next.scope));
  beside_.push_back(std::move(next));
  return true;
}

bool StepLine::advance() { return (main_ ? advance_main() : advance_open()) || advance_beside(); }

bool StepLine::advance_main() {
  Diagnostics own;
  const Outcome outcome = execution_.advance_in(node_.name, *main_->run, own);
  if (outcome == Outcome::kRunning) return false;
  end(outcome, own, main_->group.get());
  open_ = open_arm().empty() ? nullptr : main_->group;
  constexpr std::size_t kMostPast = 4;
  past_.push_back(std::move(main_));
  if (past_.size() > kMostPast) past_.pop_front();
  return true;
}

/// Nothing follows the motion that was left open, so far: it may have come to its goal.
bool StepLine::advance_open() {
  if (open_arm().empty()) {
    const bool ended = std::exchange(braking_, false);
    past_.clear();
    return ended && !cancelled_;
  }
  Diagnostics own;
  const operations::Progress progress = execution_.strand->advance(execution_, own);
  if (progress == operations::Progress::kRunning) return false;
  end(progress == operations::Progress::kFailed ? Outcome::kFailed : Outcome::kDone, own, open_.get());
  return true;
}

bool StepLine::advance_beside() {
  bool ended = false;
  for (std::size_t i = 0; i < beside_.size();) {
    Running& one = beside_[i];
    Diagnostics own;
    Outcome outcome = Outcome::kRunning;
    {
      const program::OnControlLine line(execution_, *one.line);
      outcome = execution_.advance_in(node_.name, *one.run, own);
    }
    if (outcome == Outcome::kRunning) {
      ++i;
      continue;
    }
    end(outcome, own, one.group.get());
    beside_.erase(beside_.begin() + static_cast<std::ptrdiff_t>(i));
    ended = true;
  }
  return ended;
}

void StepLine::end(Outcome outcome, Diagnostics& own, const StepGroup* group) {
  stopped_ = stopped_ || outcome == Outcome::kStopped;
  if (outcome != Outcome::kFailed || braking_ || cancelled_) return;
  if (group != nullptr) group->locate(own);
  fail(own);
}

void StepLine::fail(const Diagnostics& diagnostics) {
  failed_ = true;
  failures_.append(diagnostics);
}

void StepLine::stop() {
  braking_ = true;
  if (main_) main_->run->cancel(execution_);
  execution_.strand->cancel(execution_);
}

void StepLine::cancel() {
  cancelled_ = true;
  stop();
  for (Running& one : beside_) {
    const program::OnControlLine line(execution_, *one.line);
    one.run->cancel(execution_);
  }
}

}  // namespace takt::languages
