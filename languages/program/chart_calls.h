#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/program/tree/node.h"
#include "languages/scxml/session.h"

namespace takt::languages {

/// A parameter of a program as a chart gives it.
struct ChartArgument {
  std::string name;
  program::Type type;
  std::optional<Data> constant;  ///< what it is worth if its expression needs no variable of the chart
};

/// What an <invoke> with type="takt:NAME" runs: a node, and the variables through which values go in and out.
/// Immutable.
struct ChartProgram {
  std::string name;  ///< for people: "pick", an operation
  std::string id;    ///< "cell/working": chart and state
  std::unique_ptr<program::Node> node;
  std::vector<ChartArgument> arguments;
  std::optional<program::Type> result;
};

/// A chart that is a part of a program, with all that it invokes.
struct ProgramChart {
  std::string name;
  std::shared_ptr<const Chart> chart;
  std::map<const ChartInvoke*, ChartProgram> programs;
  std::map<const ChartTransition*, program::Expression> sensors;
};

/// The variable that gets the result of a program.
constexpr const char* kChartResult = "result";

/// Makes the nodes of what a chart invokes, and its conditions over sensors: all diagnostics at once, in the chart's
/// file.
/// @param pointer  of the chart in the scenario. Realtime: setup.
void read_chart_programs(ProgramChart& chart, const std::string& pointer, program::NodeParser& parser);

/// Declares the variables of a call. @return false with diagnostics if a value does not fit
[[nodiscard]] bool declare_arguments(const ChartProgram& program,
                                     const std::vector<std::pair<std::string, Data>>& parameters,
                                     const program::EvalContext& eval_context, program::Scope& scope,
                                     Diagnostics& diagnostics);

/// Puts diagnostics of a node where its <invoke> is written.
void move_to_chart(Diagnostics& diagnostics, std::size_t first, const Chart& chart, const TextLocation& at);

}  // namespace takt::languages
