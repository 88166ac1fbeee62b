#include "tools/chart_picture.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/xml_text.h"
#include "languages/scxml/chart.h"
#include "tools/graphviz.h"

namespace takt::tools {
namespace {

using languages::Chart;
using languages::ChartAction;
using languages::ChartState;
using languages::ChartTransition;
using Kind = ChartState::Kind;

constexpr std::size_t kLongestRow = 44;
constexpr std::size_t kMostRows = 6;

/// A line for people: one space for all white space, cut where it is too long.
std::string short_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool white = c == ' ' || c == '\n' || c == '\t' || c == '\r';
    if (!white || (!line.empty() && line.back() != ' ')) line += white ? ' ' : c;
  }
  if (line.size() > kLongestRow) line = line.substr(0, kLongestRow - 1) + "…";
  return xml_text(line);
}

std::string words_of(const ChartAction& action) {
  switch (action.kind) {
    case ChartAction::Kind::kRaise:
      return "raise " + action.text("event");
    case ChartAction::Kind::kSend: {
      const std::string to = action.text("target") + action.text("targetexpr");
      const std::string delay = action.text("delay") + action.text("delayexpr");
      return "send " + action.text("event") + action.text("eventexpr") + (to.empty() ? "" : " to " + to) +
             (delay.empty() ? "" : " after " + delay);
    }
    case ChartAction::Kind::kAssign:
      return action.text("location") + " = " + action.content.expression.text;
    case ChartAction::Kind::kLog:
      return "log " + action.text("label");
    case ChartAction::Kind::kCancel:
      return "cancel " + action.text("sendid") + action.text("sendidexpr");
    case ChartAction::Kind::kScript:
      return "script";
    case ChartAction::Kind::kIf:
      return "if " + action.parts.front().condition.text;
    case ChartAction::Kind::kForEach:
      return "for each " + action.text("item") + " of " + action.text("array");
  }
  return "";
}

class ChartDrawing {
 public:
  explicit ChartDrawing(const Chart& chart) : chart_(chart) {}

  std::string graph() {
    text_ =
        "digraph chart { compound=true; rankdir=TB; nodesep=0.45; ranksep=0.5; fontname=\"DejaVu Sans\"; "
        "bgcolor=\"white\"; pad=0.2;\nnode [fontname=\"DejaVu Sans\", fontsize=11, color=\"#475569\", "
        "fontcolor=\"#0f172a\"];\nedge [fontname=\"DejaVu Sans\", fontsize=9, color=\"#64748b\", "
        "fontcolor=\"#334155\", "
        "arrowsize=0.7];\n";
    text_ += fmt::format("labelloc=t; labeljust=l; fontsize=16; label=<<b>{}</b>>;\n", short_line(chart_.name));
    inside(0);
    for (const ChartTransition& one : chart_.transitions) {
      const bool is_initial = std::ranges::any_of(chart_.states, [&](const ChartState& state) {
        return state.initial >= 0 && &chart_.transitions[static_cast<std::size_t>(state.initial)] == &one;
      });
      if (!is_initial) arrow(one);
    }
    return text_ + "}\n";
  }

 private:
  [[nodiscard]] const ChartState& state(int index) const { return chart_.states[static_cast<std::size_t>(index)]; }
  [[nodiscard]] bool is_box(int index) const { return !state(index).children.empty(); }

  /// What a state does, line by line.
  [[nodiscard]] std::vector<std::string> lines(const ChartState& one) const {
    std::vector<std::string> all;
    for (const auto& block : one.on_entry)
      for (const ChartAction& action : block) all.push_back("entry / " + words_of(action));
    for (const auto& invoke : one.invokes) {
      const std::string what = invoke.text("type") + invoke.text("typeexpr");
      all.push_back("do / " + (what.empty() ? "chart " : what) +
                    (invoke.text("src").empty() ? "" : " " + invoke.text("src")));
    }
    for (const auto& block : one.on_exit)
      for (const ChartAction& action : block) all.push_back("exit / " + words_of(action));
    if (all.size() > kMostRows) {
      all.resize(kMostRows - 1);
      all.emplace_back("…");
    }
    return all;
  }
  [[nodiscard]] std::string label(const ChartState& one) const {
    std::string text = fmt::format("<b>{}</b>", short_line(one.id));
    for (const std::string& line : lines(one))
      text += fmt::format("<br align=\"left\"/><font point-size=\"9\" color=\"#475569\">{}</font>", short_line(line));
    return text + (lines(one).empty() ? "" : "<br align=\"left\"/>");
  }

  void inside(int index) {
    const ChartState& own = state(index);
    const bool parallel = own.kind == Kind::kParallel;
    text_ +=
        fmt::format("s{} [shape=point, width=0.11, color=\"#0f172a\"{}];\n", index, parallel ? ", style=invis" : "");
    for (const int history : own.histories)
      text_ += fmt::format("s{} [shape=circle, width=0.25, fixedsize=true, label=\"{}\", tooltip=\"{}\"];\n", history,
                           state(history).kind == Kind::kDeepHistory ? "H*" : "H", short_line(state(history).id));
    for (const int child : own.children) node(child, parallel);
    if (parallel) return;
    std::vector<int> first = own.children.empty() ? std::vector<int>{} : std::vector<int>{own.children.front()};
    if (own.initial >= 0) first = chart_.transitions[static_cast<std::size_t>(own.initial)].targets;
    for (const int target : first)
      text_ += fmt::format("s{} -> s{} [color=\"#0f172a\"{}];\n", index, target, head(target, index));
  }

  void node(int index, bool is_region) {
    const ChartState& own = state(index);
    if (is_box(index)) {
      text_ += fmt::format(
          "subgraph cluster_{} {{ style=\"rounded,filled{}\"; margin=12; color=\"#64748b\"; fillcolor=\"{}\"; "
          "labeljust=l; "
          "fontsize=11; label=<{}>;\n",
          index, is_region ? ",dashed" : "", own.kind == Kind::kParallel ? "#eef2ff" : "#f8fafc", label(own));
      inside(index);
      text_ += "}\n";
      return;
    }
    const bool is_final = own.kind == Kind::kFinal;
    const bool invokes = !own.invokes.empty();
    text_ += fmt::format("s{} [shape=box, style=\"rounded,filled\", peripheries={}, fillcolor=\"{}\", label=<{}>];\n",
                         index, is_final ? 2 : 1,
                         invokes    ? "#dbeafe"
                         : is_final ? "#dcfce7"
                                    : "#ffffff",
                         label(own));
  }

  /// An arrow ends at the border of a box, unless it comes from inside of it.
  [[nodiscard]] std::string head(int target, int source) const {
    return is_box(target) && !chart_.is_inside(source, target) && source != target
               ? fmt::format(", lhead=cluster_{}", target)
               : "";
  }
  [[nodiscard]] std::string tail(int source, int target) const {
    return is_box(source) && !chart_.is_inside(target, source) && source != target
               ? fmt::format(", ltail=cluster_{}", source)
               : "";
  }

  void arrow(const ChartTransition& one) {
    std::vector<std::string> rows;
    if (!one.events.empty()) rows.push_back(short_line(fmt::format("{}", fmt::join(one.events, " "))));
    if (!one.condition.empty()) rows.push_back("[" + short_line(one.condition.text) + "]");
    if (!one.sensors.empty()) rows.push_back("[" + short_line(one.sensors.text) + "]");
    for (const ChartAction& action : one.block)
      if (rows.size() < kMostRows) rows.push_back("/ " + short_line(words_of(action)));
    const std::string text = fmt::format("<{}>", fmt::join(rows, "<br/>"));
    const std::string shown = rows.empty() ? "\"\"" : text;
    if (one.targets.empty()) text_ += fmt::format("s{0} -> s{0} [label={1}, style=dotted];\n", one.source, shown);
    for (const int target : one.targets)
      text_ += fmt::format("s{} -> s{} [label={}{}{}{}];\n", one.source, target, shown, head(target, one.source),
                           tail(one.source, target), one.internal ? ", style=dashed" : "");
  }

  const Chart& chart_;
  std::string text_;
};

}  // namespace

Result<std::string> chart_svg(const Chart& chart) { return run_dot(ChartDrawing(chart).graph(), "svg", "--svg"); }

}  // namespace takt::tools
