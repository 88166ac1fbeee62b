// chart: checks a state chart, draws it, runs it alone.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/base/output_file.h"
#include "core/base/text_location.h"
#include "languages/scxml/system.h"
#include "tools/chart_picture.h"
#include "tools/cli.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using languages::Chart;
using languages::ChartEvent;
using languages::ChartSession;
using languages::ChartSystem;
using languages::ChartTransition;
using languages::Data;

constexpr std::size_t kMostEventBytes = 16u << 20;
/// What a trial tells at most; then it ends.
constexpr std::size_t kMostTold = 200'000;
/// A chart that never comes to its end is followed for so long, s.
constexpr double kDefaultTime_s = 3600;

struct ChartArguments {
  std::string file, svg, events;
  double seconds = kDefaultTime_s;
  bool run = false;
};

/// A line of a file of events.
struct EventLine {
  std::int64_t time_ns = 0;
  ChartEvent event;                     ///< without a name: there is none
  std::map<std::string, bool> sensors;  ///< what conditions over sensors are worth from now on
};

EventLine read_line(const Json& json, int number, Diagnostics& diagnostics) {
  Diagnostics own;
  ObjectReader reader(json, "", own);
  EventLine line;
  line.time_ns = static_cast<std::int64_t>(reader.number("time_s", {}, {.low = 0, .high = 1e6}) * 1e9);
  line.event.name = reader.text("event", "");
  if (const Json* data = reader.child("data")) line.event.data = Data::of_json(data->dump());
  if (const Json* sensors = reader.object("sensors", false))
    for (const auto& [condition, value] : sensors->items()) {
      if (!value.is_boolean())
        own.error(Code::kWrongType, reader.at("sensors") + pointer_segment(condition), "unexpected " + value.dump(),
                  "Give true or false");
      line.sensors[condition] = value.is_boolean() && value.get<bool>();
    }
  reader.finish();
  if (line.event.name.empty() && line.sensors.empty())
    own.error(Code::kMissing, "", "a line with neither event nor sensors", "Give \"event\" or \"sensors\"");
  if (line.event.name.starts_with("done.invoke.")) line.event.invokeid = line.event.name.substr(12);
  for (Diagnostic& one : own.list()) {
    if (!one.pointer.empty()) one.message = one.pointer.substr(1) + ": " + one.message;
    one.pointer.clear();
    one.line = number;
    diagnostics.add(std::move(one));
  }
  return line;
}

/// A JSON object per line, in the order of time.
std::vector<EventLine> read_events(const std::string& file, Diagnostics& diagnostics) {
  std::vector<EventLine> lines;
  const auto text = read_file(file, kMostEventBytes);
  if (!text) {
    diagnostics.append(text.error());
    return lines;
  }
  Diagnostics own;
  std::istringstream stream(*text);
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto json = parse_json(line);
    if (!json) {
      for (Diagnostic one : json.error().list()) {
        one.line = number;
        own.add(std::move(one));
      }
      continue;
    }
    lines.push_back(read_line(*json, number, own));
    if (lines.size() > 1 && lines.back().time_ns < lines[lines.size() - 2].time_ns) {
      own.error(Code::kInvalidValue, "", "an event before the one above it",
                "Give the lines in the order of their times");
      own.list().back().line = number;
    }
  }
  own.set_file(file);
  diagnostics.append(own);
  return lines;
}

/// Runs a chart without a cell: what it would call begins, and ends by an event of the file.
class ChartTrial {
 public:
  explicit ChartTrial(const std::shared_ptr<const Chart>& chart)
      : system_({.told = [this](const ChartSession& from, std::string_view what,
                                const std::string& text) { tell(from, what, text); },
                 .begin = [](const ChartSession&, const languages::ChartCall&) { return std::string(); },
                 .sensors = [this](const ChartSession&, const ChartTransition& transition) -> std::optional<bool> {
                   const auto known = sensors_.find(transition.sensors.text);
                   return known == sensors_.end() ? std::nullopt : std::optional(known->second);
                 }}),
        session_(system_.add(chart, "chart")) {}

  void run(const std::vector<EventLine>& events, double seconds) {
    const auto end = static_cast<std::int64_t>(seconds * 1e9);
    system_.advance(0);
    for (const EventLine& line : events) {
      if (line.time_ns > end || system_.over()) break;
      system_.advance(line.time_ns);
      for (const auto& [condition, value] : line.sensors) sensors_[condition] = value;
      if (!line.event.name.empty()) (void)system_.post("chart", line.event);
      system_.advance(line.time_ns);
    }
    while (!system_.over() && system_.next_ns() >= 0 && system_.next_ns() <= end && trace_.size() < kMostTold)
      system_.advance(system_.next_ns());
    left_ = session_.configuration();
  }

  [[nodiscard]] const Json& trace() const { return trace_; }
  [[nodiscard]] const std::vector<std::string>& left() const { return left_; }
  [[nodiscard]] bool over() const { return system_.over(); }
  [[nodiscard]] const ChartSession& session() const { return session_; }

 private:
  void tell(const ChartSession& from, std::string_view what, const std::string& text) {
    trace_.push_back({{"time_s", static_cast<double>(system_.now_ns()) * 1e-9},
                      {"chart", from.id()},
                      {"what", what},
                      {"text", text}});
  }

  Json trace_ = Json::array();
  std::map<std::string, bool> sensors_;
  ChartSystem system_;
  ChartSession& session_;
  std::vector<std::string> left_;
};

void print_trial(const ChartTrial& trial) {
  for (const Json& one : trial.trace())
    fmt::print("{:10.3f} s  {:<8} {}\n", one["time_s"].get<double>(), one["what"].get<std::string>(),
               one["text"].get<std::string>());
  if (trial.over()) {
    fmt::print("over\n");
  } else {
    fmt::print("waits in {}\n", fmt::join(trial.left(), ", "));
  }
}

int run_chart(const ChartArguments& arguments, const Common& common) {
  Diagnostics diagnostics;
  const auto chart = languages::read_chart_file(arguments.file, &diagnostics);
  if (!chart) diagnostics.append(chart.error());
  std::vector<EventLine> events;
  if (!arguments.events.empty()) events = read_events(arguments.events, diagnostics);
  if (!arguments.svg.empty()) diagnostics.append(check_output(arguments.svg, {arguments.file}, "--svg"));
  if (diagnostics.has_errors()) return report(diagnostics, common);
  if (!arguments.svg.empty()) {
    const auto svg = chart_svg(**chart);
    const Diagnostics written = svg ? write_file(arguments.svg, *svg, "--svg") : svg.error();
    if (written.has_errors()) return report(written, common);
  }
  fmt::print(stderr, "{}", to_located_text(diagnostics));
  Json result{{"result", "passed"},
              {"name", (*chart)->name},
              {"states", (*chart)->states.size() - 1},
              {"transitions", (*chart)->transitions.size()},
              {"diagnostics", to_json(diagnostics)}};
  int status = kHeld;
  if (arguments.run || !arguments.events.empty()) {
    ChartTrial trial(*chart);
    trial.run(events, arguments.seconds);
    if (!trial.session().failure().empty()) status = kFault;
    result["result"] = status == kHeld ? "passed" : "failed";
    result["trace"] = trial.trace();
    result["states_at_end"] = trial.left();
    result["over"] = trial.over();
    if (!common.json) print_trial(trial);
  } else if (!common.json) {
    fmt::print("{}: {} states, {} transitions\n", (*chart)->name, (*chart)->states.size() - 1,
               (*chart)->transitions.size());
  }
  if (common.json) print(result);
  return status;
}

}  // namespace

std::pair<CLI::App*, Verb> add_chart(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<ChartArguments>();
  CLI::App* verb =
      app.add_subcommand("chart", "Check a state chart (SCXML), draw it, run it alone with events of a file");
  verb->add_option("FILE", arguments->file, "State chart, *.scxml")->required();
  verb->add_option("--svg", arguments->svg, "Draw the chart")->type_name("OUT.svg");
  verb->add_flag("--run", arguments->run, "Run it without a cell, on a clock that jumps to the next event");
  verb->add_option("--events", arguments->events,
                   "Run it with these events, a JSON object per line: time_s with event and data, or with sensors")
      ->type_name("FILE.jsonl");
  verb->add_option("--seconds", arguments->seconds, "Run it for so long at most")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  return {verb, [arguments, &common] { return run_chart(*arguments, common); }};
}

}  // namespace takt::tools
