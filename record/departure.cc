#include "record/departure.h"

#include <algorithm>
#include <map>
#include <tuple>

#include <fmt/format.h>

namespace takt::record {
namespace {

struct Run {
  Nanoseconds begin = 0, end = 0;
};

/// By path and number of the time that it runs, in the order in which the steps begin.
class StepRuns {
 public:
  StepRuns(const std::vector<StepEvent>& events, Nanoseconds end) {
    for (const StepEvent& event : events) {
      if (event.name == "begin") {
        open_.push_back(add(event, end));
      } else if (event.name == "end" || event.name == "failed") {
        close(event);
      }
    }
  }
  [[nodiscard]] const std::vector<std::pair<std::string, Run>>& list() const { return runs_; }
  [[nodiscard]] const Run* find(const std::string& step) const {
    const auto found = index_.find(step);
    return found == index_.end() ? nullptr : &runs_[found->second].second;
  }

 private:
  std::size_t add(const StepEvent& event, Nanoseconds end) {
    const int round = ++rounds_[event.step];
    std::string name = round == 1 ? event.step : fmt::format("{} #{}", event.step, round);
    paths_.push_back(event.step);
    index_[name] = runs_.size();
    runs_.emplace_back(std::move(name), Run{.begin = event.time, .end = std::max(event.time, end)});
    return runs_.size() - 1;
  }
  void close(const StepEvent& event) {
    const auto open = std::ranges::find_if(open_, [&](std::size_t i) { return paths_[i] == event.step; });
    if (open == open_.end()) return;
    runs_[*open].second.end = event.time;
    open_.erase(open);
  }

  std::vector<std::pair<std::string, Run>> runs_;
  std::vector<std::string> paths_;  ///< without the number
  std::vector<std::size_t> open_;
  std::map<std::string, int> rounds_;
  std::map<std::string, std::size_t> index_;
};

bool is_inside(const std::string& inner, const std::string& outer) { return inner.starts_with(outer + " / "); }

/// The steps of A that run at `time`, without those that others of them are part of. A step that ends then runs: that
/// it ends is what differs.
std::vector<const StepDuration*> running_at(const std::vector<StepDuration>& steps, Nanoseconds time) {
  std::vector<const StepDuration*> running;
  for (const StepDuration& step : steps)
    if (step.a && step.begin < time + 1 && step.begin + *step.a >= time) running.push_back(&step);
  std::erase_if(running, [&](const StepDuration* outer) {
    return std::ranges::any_of(running, [&](const StepDuration* other) { return is_inside(other->step, outer->step); });
  });
  return running;
}

/// Of several steps at a time the first one that took another time.
std::string step_at(const std::vector<StepDuration>& steps, Nanoseconds time) {
  const auto running = running_at(steps, time);
  const auto other = std::ranges::find(running, false, &StepDuration::same);
  if (other != running.end()) return (*other)->step;
  return running.empty() ? std::string() : running.back()->step;
}

Departure departure_of(const StepDuration& step, Nanoseconds time) {
  Departure departure{
      .time = time, .step = step.step, .topic = std::string(kProgramTopic), .column = "duration", .unit = "s"};
  if (step.a) departure.a = to_seconds(*step.a);
  if (step.b) departure.b = to_seconds(*step.b);
  if (!step.a || !step.b) departure.note = step.a ? "this step runs in A only" : "this step runs in B only";
  return departure;
}

bool is_measured(const ColumnComparison& column) { return !column.topic.ends_with("/set_point"); }

}  // namespace

std::vector<StepEvent> step_events(const Recording& recording) {
  constexpr std::size_t kMost = 200'000;
  std::vector<StepEvent> events;
  recording.for_each_event(kProgramTopic, [&](const RecordedEvent& event) {
    if (event.source == "program" && !event.step.empty()) events.push_back({event.time, event.name, event.step});
    return events.size() < kMost;
  });
  return events;
}

std::vector<StepDuration> compare_durations(const std::vector<StepEvent>& a, const std::vector<StepEvent>& b,
                                            Nanoseconds end_a, Nanoseconds end_b, Nanoseconds window) {
  const StepRuns in_a(a, end_a), in_b(b, end_b);
  std::vector<StepDuration> durations;
  for (const auto& [step, run] : in_a.list()) {
    StepDuration duration{.step = step, .begin = run.begin, .a = run.end - run.begin};
    if (const Run* other = in_b.find(step)) duration.b = other->end - other->begin;
    duration.same = duration.b && std::abs(*duration.a - *duration.b) <= window;
    durations.push_back(std::move(duration));
  }
  for (const auto& [step, run] : in_b.list())
    if (in_a.find(step) == nullptr)
      durations.push_back({.step = step, .begin = run.begin, .b = run.end - run.begin, .same = false});
  return durations;
}

void find_departure(Comparison& comparison) {
  if (comparison.passed) return;
  const ColumnComparison* first = nullptr;
  const auto order = [](const ColumnComparison& c) { return std::tuple(*c.first_outside, is_measured(c)); };
  for (const ColumnComparison& column : comparison.columns)
    if (!column.passed && column.first_outside && (first == nullptr || order(column) < order(*first))) first = &column;
  if (first != nullptr)
    comparison.departure = Departure{.time = *first->first_outside,
                                     .step = step_at(comparison.durations, *first->first_outside),
                                     .topic = first->topic,
                                     .column = first->column,
                                     .unit = first->unit,
                                     .a = first->first_a,
                                     .b = first->first_b,
                                     .note = first->note};
  for (const StepDuration& step : comparison.durations) {
    if (step.same) continue;
    const Nanoseconds time = step.begin + std::min(step.a.value_or(0), step.b.value_or(0));
    if (!comparison.departure || time < comparison.departure->time) comparison.departure = departure_of(step, time);
  }
}

}  // namespace takt::record
