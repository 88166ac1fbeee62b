#include "languages/program/charts_node.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/activity/scheduler.h"
#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/expression/contact_reader.h"
#include "core/program/tree/node_forms.h"
#include "core/program/tree/strand.h"
#include "languages/program/beside_others.h"
#include "languages/program/chart_calls.h"
#include "languages/program/chart_rehearsal.h"
#include "languages/program/chart_values.h"
#include "languages/scxml/system.h"
#include "languages/xml/document.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;
using program::Execution;
using program::Outcome;

constexpr std::size_t kMostCharts = 16;

class ChartsNode final : public program::Node {
 public:
  std::vector<ProgramChart> charts;

  [[nodiscard]] std::unique_ptr<program::NodeRun> begin(program::Scope& scope) const override;
  void rehearse(operations::Rehearsal& rehearsal, program::Scope&, Diagnostics& diagnostics) const override {
    if (program::spend_rehearsal(rehearsal, *this, diagnostics)) rehearse_charts(charts, *this, rehearsal, diagnostics);
  }
  /// How often a state is entered is not known.
  [[nodiscard]] std::int64_t count() const override { return kMostSteps; }
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    for (const ProgramChart& chart : charts)
      for (const auto& [invoke, program] : chart.programs) program.node->collect_names(names);
  }
  [[nodiscard]] bool constant() const override { return false; }
};

/// One execution of what a chart has invoked.
struct RunningCall {
  std::string session, id;  ///< empty id: its state was left
  const ProgramChart* chart = nullptr;
  const ChartProgram* program = nullptr;
  const ChartInvoke* invoke = nullptr;
  std::unique_ptr<program::Scope> scope;
  std::unique_ptr<program::NodeRun> run;
  std::unique_ptr<program::ControlLine> line;
  bool begun = false;
};

class ChartsRun final : public program::NodeRun {
 public:
  explicit ChartsRun(const ChartsNode& node)
      : node_(node),
        system_(
            {.told = [this](const ChartSession& from, std::string_view what,
                            const std::string& text) { tell(from, what, text); },
             .begin = [this](const ChartSession& from, const ChartCall& call) { return begin(from, call); },
             .cancel = [this](const ChartSession& from, const std::string& id) { cancel_call(from, id); },
             .sensors = [this](const ChartSession& from, const ChartTransition& one) { return holds(from, one); }}) {
    for (const ProgramChart& chart : node.charts) (void)system_.add(chart.chart, chart.name);
  }

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    execution_ = &execution;
    const Outcome ready = begun_ < 0 ? program::settle(execution, diagnostics) : Outcome::kDone;
    if (ready != Outcome::kDone) return ready;
    const std::int64_t cycle = execution.context.core.cycle();
    if (begun_ < 0) begun_ = cycle;
    const std::int64_t now = (cycle - begun_) * execution.context.core.period();
    // What ends makes a chart begin something else in the same cycle.
    for (bool again = true; again && !failed_;) {
      const std::int64_t mark = execution.begun;
      again = advance_calls(execution, diagnostics);
      const std::size_t before = calls_.size();
      system_.advance(now);
      again = again || calls_.size() > before;
      if (again && !execution.charge_round(mark, node_.pointer, diagnostics)) return Outcome::kFailed;
    }
    note_failures();
    if (failed_ && !std::exchange(ended_, true)) system_.cancel();
    if (failed_) (void)advance_calls(execution, diagnostics);
    if (!system_.over() || !calls_.empty()) return Outcome::kRunning;
    diagnostics.append(failures_);
    return failed_ && !cancelled_ ? Outcome::kFailed : stopped_ ? Outcome::kStopped : Outcome::kDone;
  }

  void cancel(Execution& execution) override {
    execution_ = &execution;
    cancelled_ = true;
    system_.cancel();
  }

  [[nodiscard]] Json state() const override {
    Json states = Json::object();
    for (const ChartSession* one : system_.charts()) states[one->id()] = one->configuration();
    return {{"begun", begun_ >= 0}, {"states", std::move(states)}};
  }
  /// The charts begin again, as a step does that was running.
  void restore(const Json& state, Execution&, Diagnostics& diagnostics) override {
    if (state.value("begun", false))
      diagnostics.warning(Code::kNote, node_.pointer, "the charts begin in their initial states",
                          "Begin the program at a step before or after them to have a known state");
  }

 private:
  void tell(const ChartSession& from, std::string_view what, const std::string& text) {
    if (execution_ == nullptr || !execution_->context.event) return;
    execution_->context.event("chart", what, from.id() + ": " + text);
  }

  [[nodiscard]] const ProgramChart* chart_of(const ChartSession& session) const {
    const auto found = std::ranges::find_if(
        node_.charts, [&](const ProgramChart& one) { return one.chart.get() == &session.chart(); });
    return found == node_.charts.end() ? nullptr : &*found;
  }

  std::string begin(const ChartSession& from, const ChartCall& call) {
    const ProgramChart* const chart = chart_of(from);
    const auto found = chart != nullptr ? chart->programs.find(call.from) : decltype(chart->programs.end()){};
    if (chart == nullptr || found == chart->programs.end()) return fmt::format("nothing here runs '{}'", call.type);
    const ChartProgram& program = found->second;
    auto scope = std::make_unique<program::Scope>();
    Diagnostics wrong;
    if (!declare_arguments(program, call.parameters, execution_->eval_context(*scope), *scope, wrong))
      return program::messages_of(wrong);
    auto run = std::make_unique<program::SettledRun>(program.node->begin(*scope));
    calls_.push_back({from.id(), call.id, chart, &program, call.from, std::move(scope), std::move(run),
                      std::make_unique<program::ControlLine>()});
    return {};
  }

  void cancel_call(const ChartSession& from, const std::string& id) {
    for (RunningCall& call : calls_) {
      if (call.session != from.id() || call.id != id) continue;
      call.id.clear();
      const program::OnControlLine line(*execution_, *call.line);
      call.run->cancel(*execution_);
    }
  }

  std::optional<bool> holds(const ChartSession& from, const ChartTransition& transition) {
    const ProgramChart* const chart = chart_of(from);
    if (chart == nullptr) return std::nullopt;
    const auto found = chart->sensors.find(&transition);
    if (found == chart->sensors.end()) return std::nullopt;
    const program::Scope nothing;
    program::EvalContext eval_context = execution_->eval_context(nothing);
    eval_context.readers = &readers_;
    Diagnostics wrong;
    const program::Value value = found->second.evaluate(eval_context, wrong);
    return wrong.has_errors() || value.null() ? std::nullopt : std::optional(value.boolean());
  }

  /// Each that runs once, in the order in which they began. What was cancelled ends before something else begins.
  /// @return true if one has ended
  bool advance_calls(Execution& execution, Diagnostics& diagnostics) {
    bool ended = false;
    const BesideOthers beside(execution.context, calls_.size() > 1);
    const bool clears =
        std::ranges::any_of(calls_, [](const RunningCall& call) { return call.id.empty() && call.begun; });
    for (std::size_t i = 0; i < calls_.size();) {
      RunningCall& call = calls_[i];
      if (clears && !call.begun && !call.id.empty()) {
        ++i;
        continue;
      }
      call.begun = true;
      Diagnostics own;
      Outcome outcome = Outcome::kRunning;
      {
        const program::OnControlLine line(execution, *call.line);
        const Execution::Inside inside(execution, node_.name);
        outcome = execution.advance_in(call.program->id, *call.run, own);
      }
      if (outcome == Outcome::kRunning) {
        ++i;
        continue;
      }
      move_to_chart(own, 0, *call.chart->chart, call.invoke->at);
      const RunningCall over = std::move(call);
      calls_.erase(calls_.begin() + static_cast<std::ptrdiff_t>(i));
      end(over, outcome, own, diagnostics);
      ended = true;
    }
    return ended;
  }

  void end(const RunningCall& call, Outcome outcome, const Diagnostics& own, Diagnostics& diagnostics) {
    if (outcome == Outcome::kStopped) {
      stopped_ = true;
      system_.cancel();
    }
    if (call.id.empty() || outcome == Outcome::kStopped) return;
    ChartEvent event{.name = "done.invoke." + call.id};
    if (outcome == Outcome::kFailed) {
      const bool known = !own.list().empty();
      event.name = "error.platform." + call.id;
      event.type = ChartEvent::Type::kPlatform;
      event.data = Data::of_json(Json{
          {"code", known ? name_of(own.list().front().code) : name_of(Code::kNotPossibleNow)},
          {"text", program::messages_of(own)},
          {"program",
           call.program->name}}.dump(-1, ' ', false, Json::error_handler_t::replace));
      failures_of_calls_.append(own);
    } else if (call.program->result) {
      event.data = to_data(call.scope->find(kChartResult)->value);
    }
    if (!system_.end_call(call.session, call.id, std::move(event)) && outcome == Outcome::kFailed)
      diagnostics.append(own);
  }

  void note_failures() {
    if (failed_) return;
    for (const ChartSession* one : system_.charts()) {
      if (one->running()) continue;
      std::string why = one->failure();
      const Json data =
          one->result().kind == Data::Kind::kJson ? Json::parse(one->result().text, nullptr, false) : Json();
      if (why.empty() && data.is_object() && data.contains("failure"))
        why = data["failure"].is_string() ? data["failure"].get<std::string>() : data["failure"].dump();
      if (why.empty()) continue;
      failed_ = true;
      failures_.append(failures_of_calls_);
      failures_.error(Code::kConditionNotMet, node_.pointer, fmt::format("chart '{}' failed: {}", one->id(), why));
    }
  }

  const ChartsNode& node_;
  Execution* execution_ = nullptr;
  std::vector<RunningCall> calls_;
  expression::ContactReaders readers_;
  Diagnostics failures_, failures_of_calls_;
  std::int64_t begun_ = -1;
  bool cancelled_ = false, failed_ = false, ended_ = false, stopped_ = false;
  ChartSystem system_;
};

std::unique_ptr<program::NodeRun> ChartsNode::begin(program::Scope&) const {
  return std::make_unique<ChartsRun>(*this);
}

/// Scripts with an error in their syntax are refused: nothing moves before that is corrected.
void refuse_warnings(Diagnostics& diagnostics) {
  for (Diagnostic& one : diagnostics.list())
    if (one.code == Code::kSyntax) one.severity = Severity::kError;
}

/// Events that are sent to a chart that is not there.
void check_targets(const ChartsNode& node, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  for (const ProgramChart& one : node.charts) names.push_back(one.name);
  for (const ProgramChart& one : node.charts) {
    const auto visit = [&](const auto& self, const ChartBlock& block) -> void {
      for (const ChartAction& action : block) {
        const ChartText& target = action.at_name("target");
        if (action.kind == ChartAction::Kind::kSend && target.text.starts_with("#_scxml_") &&
            std::ranges::find(names, target.text.substr(8)) == names.end()) {
          error_at(target.at, Code::kUnknownName, fmt::format("there is no chart '{}'", target.text.substr(8)),
                   nearest_choice(target.text.substr(8), names), diagnostics);
          diagnostics.list().back().file = one.chart->file;
        }
        for (const ChartAction::Part& part : action.parts) self(self, part.block);
        self(self, action.block);
      }
    };
    for (const ChartState& state : one.chart->states) {
      for (const ChartBlock& block : state.on_entry) visit(visit, block);
      for (const ChartBlock& block : state.on_exit) visit(visit, block);
    }
    for (const ChartTransition& transition : one.chart->transitions) visit(visit, transition.block);
  }
}

void read_one(const std::string& name, const Json& json, const std::string& pointer, ChartsNode& node,
              program::NodeParser& parser) {
  ObjectReader reader(json, pointer, parser.diagnostics());
  const std::string file = reader.text("file", "");
  const std::string text = reader.text("scxml");
  reader.finish();
  if (!reader.has("scxml")) return;
  Diagnostics own;
  const auto chart = read_chart(text, {}, &own);
  if (!chart) own.append(chart.error());
  refuse_warnings(own);
  own.set_file(file);
  parser.diagnostics().append(own);
  if (!chart) return;  // what it invokes is looked at beside what is wrong in it
  auto named = std::make_shared<Chart>(**chart);
  named->file = file;
  if (named->name.empty()) named->name = name;
  node.charts.push_back({.name = name, .chart = std::move(named), .programs = {}, .sensors = {}});
  read_chart_programs(node.charts.back(), pointer, parser);
}

const Form& charts_form() {
  static const Form form = [] {
    Key charts = members_key("charts", any_of_key("", {"string", "object"}, ""),
                             "Name to the file of a state chart (SCXML), relative to this file and in its folder or "
                             "below.");
    charts.min_size = 1;
    charts.max_size = kMostCharts;
    return program::node_form("charts", "Runs state charts (SCXML) that coordinate what they invoke.",
                              {std::move(charts)});
  }();
  return form;
}

}  // namespace

std::unique_ptr<program::Node> parse_charts(const Json& json, const std::string& pointer, program::NodeParser& parser) {
  auto node = std::make_unique<ChartsNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "charts");
  if (const Json* all = reader.child("charts")) node->charts.reserve(all->size());  // calls refer to charts
  FormReader(charts_form(), reader)
      .members("charts", [&](const std::string& name, const Json& one, const std::string& place) {
        read_one(name, one, place, *node, parser);
      });
  reader.finish();
  check_targets(*node, parser.diagnostics());
  return node;
}

program::NodeKind charts_kind() { return {"charts", charts_form(), parse_charts}; }

}  // namespace takt::languages
