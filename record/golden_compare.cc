// A run against a golden.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>

#include "record/compare_columns.h"
#include "record/departure.h"
#include "record/golden.h"
#include "record/golden_curves.h"
#include "record/golden_digest.h"

namespace takt::record {

namespace {

Nanoseconds nanoseconds_of(double seconds) { return static_cast<Nanoseconds>(std::llround(seconds * 1e9)); }

std::vector<StepEvent> golden_steps(const Golden& golden) {
  std::vector<StepEvent> events;
  for (const GoldenEvent& event : golden.events)
    if (event.source == "program" && !event.step.empty())
      events.push_back({nanoseconds_of(event.time_s), event.name, event.step});
  return events;
}

void compare_golden_events(const Recording& recording, const Golden& golden, const CompareOptions& options,
                           Comparison& comparison) {
  std::vector<std::string> topics;
  for (const GoldenEvent& event : golden.events) {
    if (std::ranges::find(topics, event.topic) == topics.end()) topics.push_back(event.topic);
  }
  for (const std::string& topic : topics) {
    std::vector<RecordedEvent> reference;
    for (const GoldenEvent& event : golden.events)
      if (event.topic == topic)
        reference.push_back({nanoseconds_of(event.time_s), 0, event.source, event.name, {}, {}});
    const auto events = recording.events(topic);
    if (!events) {
      note_missing(fmt::format("events '{}' are only in the golden", topic), comparison);
      continue;
    }
    note_lost_rows(recording, topic, events->size(), "run", comparison);
    Tolerance tolerance = choose_tolerance(options.rules, topic, "events", golden.event_tolerance);
    comparison.columns.push_back(compare_events(topic, *events, reference, tolerance));
  }
}

/// Compares the columns of a golden one by one, with the tables of the run.
class GoldenComparer {
 public:
  GoldenComparer(const Recording& recording, const Golden& golden, const CompareOptions& options,
                 Comparison& comparison)
      : recording_(recording), golden_(golden), options_(options), comparison_(comparison), reader_(golden) {}

  void compare() {
    for (std::size_t i = 0; i < golden_.columns.size(); ++i) {
      const GoldenColumn& column = golden_.columns[i];
      const bool has_table = load(column.topic);
      const auto rotation = rotation_from(i);
      // Each column is read in any case: others may follow it.
      if (rotation) {
        compare_rotation_from(i, *rotation, has_table);
        i += kQuaternion - 1;
      } else if (auto curve = reader_.read(column); curve && has_table) {
        compare_one(column, *curve);
      }
    }
  }

 private:
  static constexpr std::size_t kQuaternion = 4;

  /// The run's table of a topic; one at a time.
  bool load(const std::string& topic) {
    if (table_ && table_->topic == topic) return true;
    auto read = recording_.table(topic);
    if (!read) {
      if (told_.insert(topic).second) note_missing(fmt::format("topic '{}' is only in the golden", topic), comparison_);
      return false;
    }
    table_ = std::move(*read);
    if (!told_.insert(topic).second) return true;
    note_lost_rows(recording_, *table_, "run", comparison_);
    note_holes(topic);
    return true;
  }

  void note_holes(const std::string& topic) {
    const auto grid = golden_.grids.find(topic);
    if (grid == golden_.grids.end()) return;
    std::vector<Nanoseconds> times;
    for (std::size_t i = 0; i < grid->second.samples; ++i)
      times.push_back(grid->second.start + static_cast<Nanoseconds>(i) * grid->second.period);
    const Nanoseconds end = common_end(comparison_);
    note_hole(topic, "the run", find_hole(table_->time, times, end, Tolerance{}.dt), comparison_);
    note_hole(topic, "the golden", find_hole(times, table_->time, end, Tolerance{}.dt), comparison_);
  }

  /// The run's values of a column; nothing: they are only in the golden.
  const std::vector<double>* values_of_run(const GoldenColumn& column) {
    const auto found = std::ranges::find(table_->columns, column.column);
    if (found != table_->columns.end())
      return &table_->values[static_cast<std::size_t>(found - table_->columns.begin())];
    note_missing(fmt::format("column '{}' of '{}' is only in the golden", column.column, column.topic), comparison_);
    return nullptr;
  }

  void compare_one(const GoldenColumn& column, const GoldenReader::Curve& curve) {
    const std::vector<double>* values = values_of_run(column);
    if (values == nullptr) return;
    const Tolerance tolerance = choose_tolerance(options_.rules, column.topic, column.column, column.tolerance);
    comparison_.columns.push_back(compare_column({column.topic, column.column, column.unit}, {table_->time, *values},
                                                 {curve.time, curve.value}, tolerance, options_.plot_points));
  }

  /// The orientation that begins with a column of the golden: "FRAME.rotation".
  [[nodiscard]] std::optional<std::string> rotation_from(std::size_t first) const {
    std::vector<std::string> names;
    for (std::size_t i = first; i < std::min(first + kQuaternion, golden_.columns.size()); ++i)
      if (golden_.columns[i].topic == golden_.columns[first].topic) names.push_back(golden_.columns[i].column);
    auto frame = rotation_at(names, 0);
    if (frame) *frame += ".rotation";
    return frame;
  }

  /// An orientation is judged by the angle, as between recordings. The tolerance of the four numbers is half an angle:
  /// a small turn changes the numbers by half of it.
  void compare_rotation_from(std::size_t first, const std::string& name, bool has_table) {
    const GoldenColumn& head = golden_.columns[first];
    std::array<GoldenReader::Curve, kQuaternion> curves;
    std::array<std::vector<double>, kQuaternion> reference;
    RotationView run{{}, {}}, golden_run{{}, {}};
    Tolerance otherwise = head.tolerance;
    for (std::size_t k = 0; k < kQuaternion; ++k) {
      const GoldenColumn& part = golden_.columns[first + k];
      auto curve = reader_.read(part);
      const std::vector<double>* values = has_table ? values_of_run(part) : nullptr;
      if (!curve || values == nullptr) return;
      run.time = golden_run.time = table_->time;
      run.wxyz[k] = *values;
      for (const Nanoseconds t : table_->time) reference[k].push_back(value_at({curve->time, curve->value}, t));
      golden_run.wxyz[k] = reference[k];
      otherwise.dv = std::max(otherwise.dv, part.tolerance.dv);
    }
    otherwise.dv *= 2.0;
    const Tolerance tolerance = choose_tolerance(options_.rules, head.topic, name, otherwise);
    comparison_.columns.push_back(
        compare_rotation({head.topic, name, "rad"}, run, golden_run, tolerance, options_.plot_points));
  }

  const Recording& recording_;
  const Golden& golden_;
  const CompareOptions& options_;
  Comparison& comparison_;
  GoldenReader reader_;
  std::optional<Table> table_;
  std::set<std::string> told_;
};

void compare_golden_digest(const Recording& recording, const Golden& golden, Comparison& comparison) {
  const auto [cycles, digest] = last_digest(recording);
  comparison.cycles_a = cycles;
  comparison.cycles_b = golden.cycles;
  comparison.digests_compared = !digest.empty() && !golden.digest.empty();
  if (!comparison.digests_compared) return;
  comparison.identical = digest == golden.digest && cycles == golden.cycles;
  if (!comparison.identical) {
    comparison.notes.push_back(fmt::format("the digest at the end is {}, the golden's is {}", digest, golden.digest));
  }
}

/// Of a golden: its topics and columns, and its events and samples.
JudgedShare golden_share(const Golden& golden) {
  std::set<std::string_view> topics;
  JudgedShare share;
  share.messages = golden.events.size();
  for (const GoldenEvent& event : golden.events) topics.insert(event.topic);
  for (const GoldenColumn& column : golden.columns) {
    if (!topics.insert(column.topic).second) continue;
    const auto grid = golden.grids.find(column.topic);
    share.messages += grid == golden.grids.end() ? column.time_s.size() : grid->second.samples;
  }
  share.channels = share.channels_in_file = topics.size();
  share.messages_in_file = share.messages;
  return share;
}

}  // namespace

Comparison compare_with_golden(const Recording& recording, const Golden& golden, const CompareOptions& options) {
  Comparison comparison;
  comparison.name_a = "run";
  comparison.name_b = "golden";
  comparison.end_a = recording.end_time();
  comparison.end_b = nanoseconds_of(golden.end_s);
  compare_golden_digest(recording, golden, comparison);
  comparison.steps = steps_of(recording);
  note_differences(recording, "run", golden.fingerprint, comparison);
  const Tolerance of_events = choose_tolerance(options.rules, kProgramTopic, "events", golden.event_tolerance);
  // A golden whose events have no steps says nothing of durations; those of the run name the steps all the same.
  const auto steps = step_events(recording), steps_before = golden_steps(golden);
  comparison.durations = steps_before.empty()
                             ? compare_durations(steps, steps, comparison.end_a, comparison.end_a, of_events.dt)
                             : compare_durations(steps, steps_before, comparison.end_a, comparison.end_b, of_events.dt);
  comparison.columns.push_back(compare_end(comparison.end_a, comparison.end_b,
                                           choose_tolerance(options.rules, "run", "end", golden.event_tolerance)));
  compare_golden_events(recording, golden, options, comparison);
  GoldenComparer(recording, golden, options, comparison).compare();
  comparison.judged_a = judged_share(recording, comparison);
  comparison.judged_b = golden_share(golden);
  if (comparison.judged_a.messages == 0) note_missing("there is nothing that could be judged", comparison);
  judge(options, comparison);
  find_departure(comparison);
  return comparison;
}

Result<Comparison> verify(const std::filesystem::path& recording, const std::filesystem::path& golden,
                          const CompareOptions& options) {
  Diagnostics diagnostics;
  const auto run = Recording::open(recording);
  const auto reference = read_golden(golden);
  if (!run) diagnostics.append(run.error());
  if (!reference) diagnostics.append(reference.error());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  Comparison comparison = compare_with_golden(*run, *reference, options);
  comparison.name_a = recording.string();
  comparison.name_b = golden.string();
  return comparison;
}

}  // namespace takt::record
