#include "languages/program/chart_calls.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "languages/program/chart_values.h"
#include "languages/script/engine.h"
#include "languages/xml/document.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kPrefix = "takt:";

/// The programs and operations that a chart may name.
std::vector<std::string> callable_names(program::NodeParser& parser) {
  std::vector<std::string> names = operations::Operations::global().step_types();
  for (const auto& one : parser.programs()) names.push_back(one->name);
  names.emplace_back("steps");
  return names;
}

bool is_operation(const std::string& name) {
  const operations::Operation* found = operations::Operations::global().find(name);
  return found != nullptr && found->read_step != nullptr;
}

class CallReader {
 public:
  CallReader(ProgramChart& chart, const std::string& pointer, program::NodeParser& parser)
      : chart_(chart), pointer_(pointer), parser_(parser), diagnostics_(parser.diagnostics()) {}

  void read(const ChartState& state, const ChartInvoke& invoke) {
    const std::string type = invoke.text("type");
    if (!invoke.text("typeexpr").empty() || !invoke.text("src").empty() || !invoke.text("srcexpr").empty() ||
        !invoke.content.expression.empty()) {
      error(invoke.at, Code::kUnsupported, "what is invoked is known only while the chart runs",
            "Name it by 'type', and write a chart into <content>");
      return;
    }
    if (!type.starts_with(kPrefix)) return read_child(invoke);
    ChartProgram made{.name = type.substr(kPrefix.size()),
                      .id = chart_.name + "/" + state.id,
                      .node = nullptr,
                      .arguments = {},
                      .result = {}};
    const std::size_t first = diagnostics_.list().size();
    const program::NodeParser::Inner inner(parser_, false);
    if (made.name == "steps") {
      steps(invoke, made);
    } else if (is_operation(made.name)) {
      operation(invoke, made);
    } else if (const auto found = parser_.program(made.name, {})) {
      call(invoke, *found, made);
    } else if (diagnostics_.list().size() > first) {
      diagnostics_.list().back().hint = nearest_choice(made.name, callable_names(parser_));
    }
    move_to_chart(diagnostics_, first, *chart_.chart, invoke.at);
    if (made.node) chart_.programs.emplace(&invoke, std::move(made));
  }

 private:
  void error(const TextLocation& at, Code code, std::string message, std::string hint) {
    error_at(at, code, std::move(message), std::move(hint), diagnostics_);
    diagnostics_.list().back().file = chart_.chart->file;
  }

  /// A chart inside of this one runs by the same rules, but calls nothing of the cell.
  void read_child(const ChartInvoke& invoke) {
    Diagnostics own;
    const auto child = read_chart(invoke.content.value.text, {}, &own);
    if (!child) own.append(child.error());
    for (const Diagnostic& one : own.list())
      error(invoke.at, one.code, "in the chart that is invoked: " + one.message, one.hint);
    if (!child) return;
    for (const ChartState& state : (*child)->states)
      for (const ChartInvoke& inside : state.invokes)
        if (inside.text("type").starts_with(kPrefix))
          error(invoke.at, Code::kUnsupported,
                fmt::format("'{}' inside of a chart that is invoked", inside.text("type")),
                "Invoke it in the chart itself, or make that chart one of \"charts\"");
  }

  [[nodiscard]] std::optional<Data> constant(const ChartText& expression) {
    auto value = engine_.evaluate(expression.text);
    return value ? std::optional(std::move(*value)) : std::nullopt;
  }

  void call(const ChartInvoke& invoke, const program::SubProgram& program, ChartProgram& made) {
    Json with = Json::object();
    for (const ChartParameter& one : given(invoke)) {
      const auto known = std::ranges::find(program.parameters, one.name, &program::Declaration::name);
      if (known != program.parameters.end()) {
        parser_.scope().declare(one.name, {known->type, program::Value::unknown(known->type), {}});
        made.arguments.push_back({one.name, known->type, constant(one.value)});
        with[one.name] = "$" + one.name;
      } else {
        with[one.name] = nullptr;  // the call says what is wrong
      }
    }
    Json json{{"do", "call"}, {"name", made.name}, {"program", program.name}, {"with", with}};
    if (program.result) {
      parser_.scope().declare(kChartResult, {program.result_type, program::Value::unknown(program.result_type), {}});
      made.result = program.result_type;
      json["as"] = kChartResult;
    }
    made.node = parser_.node(json, pointer_);
  }

  static std::vector<ChartParameter> given(const ChartInvoke& invoke) {
    std::vector<ChartParameter> all = invoke.parameters;
    std::istringstream names(invoke.text("namelist"));
    for (std::string name; names >> name;) all.push_back({name, {name, invoke.at}});
    return all;
  }

  void operation(const ChartInvoke& invoke, ChartProgram& made) {
    Json json{{"do", made.name}};
    for (const ChartParameter& one : given(invoke)) {
      const auto value = constant(one.value);
      const auto read = value && value->kind == Data::Kind::kJson ? parse_json(value->text) : Result<Json>(Json());
      if (!value || !read) {
        error(one.value.at, Code::kUnsupported,
              fmt::format("'{}' of the operation '{}' depends on the chart's variables", one.name, made.name),
              "Write a constant, or a program with parameters that does it");
        continue;
      }
      json[one.name] = *read;
    }
    made.node = parser_.node(json, pointer_);
  }

  void steps(const ChartInvoke& invoke, ChartProgram& made) {
    const auto read =
        invoke.content.value.kind == Data::Kind::kJson ? parse_json(invoke.content.value.text) : Result<Json>(Json());
    if (!read || !read->is_array()) {
      error(invoke.at, Code::kWrongType, "takt:steps without an array of steps",
            "Write <content>[{\"do\": ...}]</content>");
      return;
    }
    made.node = parser_.node({{"do", "sequence"}, {"steps", *read}}, pointer_);
  }

  ProgramChart& chart_;
  const std::string& pointer_;
  program::NodeParser& parser_;
  Diagnostics& diagnostics_;
  ScriptEngine engine_;
};

}  // namespace

void move_to_chart(Diagnostics& diagnostics, std::size_t first, const Chart& chart, const TextLocation& at) {
  for (std::size_t i = first; i < diagnostics.list().size(); ++i) {
    Diagnostic& one = diagnostics.list()[i];
    if (!one.file.empty()) continue;
    one.file = chart.file;
    one.line = at.line;
    one.column = at.column;
    one.pointer.clear();
  }
}

void read_chart_programs(ProgramChart& chart, const std::string& pointer, program::NodeParser& parser) {
  CallReader calls(chart, pointer, parser);
  for (const ChartState& state : chart.chart->states)
    for (const ChartInvoke& invoke : state.invokes) calls.read(state, invoke);
  for (const ChartTransition& one : chart.chart->transitions) {
    if (one.sensors.empty()) continue;
    Diagnostics own;
    if (auto expression = program::Expression::parse(one.sensors.text)) {
      const program::Value value = expression->evaluate(parser.eval_context(), own);
      if (!own.has_errors() && !value.type.is(program::Type::Kind::kBoolean))
        own.error(Code::kWrongType, {}, "unexpected " + program::to_string(value.type), "Give a condition");
      chart.sensors.emplace(&one, std::move(*expression));
    } else {
      own.append(expression.error());
    }
    move_to_chart(own, 0, *chart.chart, one.sensors.at);
    parser.diagnostics().append(own);
  }
}

bool declare_arguments(const ChartProgram& program, const std::vector<std::pair<std::string, Data>>& parameters,
                       const program::EvalContext& eval_context, program::Scope& scope, Diagnostics& diagnostics) {
  Diagnostics own;
  for (const ChartArgument& one : program.arguments) {
    const auto given = std::ranges::find(parameters, one.name, &std::pair<std::string, Data>::first);
    const Data data = given != parameters.end() ? given->second : one.constant.value_or(Data{});
    Diagnostics wrong;
    program::Variable variable{one.type, program::Value::unknown(one.type), {}};
    program::Value value = to_value(data, one.type, eval_context, wrong);
    scope.declare(one.name, variable);
    if (!wrong.has_errors()) scope.assign(*scope.find(one.name), std::move(value), false);
    for (Diagnostic& each : wrong.list()) each.message = one.name + ": " + each.message;
    own.append(wrong);
  }
  if (program.result) scope.declare(kChartResult, {*program.result, program::Value::unknown(*program.result), {}});
  diagnostics.append(own);
  return !own.has_errors();
}

}  // namespace takt::languages
