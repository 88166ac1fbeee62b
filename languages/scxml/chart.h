#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/text_location.h"
#include "languages/script/data.h"

namespace takt::languages {

/// A text of the document: an expression, a name, an identifier.
struct ChartText {
  std::string text;
  TextLocation at;
  [[nodiscard]] bool empty() const { return text.empty(); }
};

/// <param>: a name with an expression or a location.
struct ChartParameter {
  std::string name;
  ChartText value;  ///< an expression; a location is one too
};

/// <content>, or what is written inside of <data> and <assign>.
struct ChartContent {
  bool given = false;
  ChartText expression;
  Data value;
};

struct ChartAction;
using ChartBlock = std::vector<ChartAction>;

/// A piece of executable content.
struct ChartAction {
  enum class Kind { kRaise, kSend, kCancel, kLog, kAssign, kScript, kIf, kForEach };
  /// A part of an <if>; the one of <else> has no condition.
  struct Part {
    ChartText condition;
    ChartBlock block;
  };

  Kind kind = Kind::kRaise;
  TextLocation at;
  std::map<std::string, ChartText, std::less<>> attributes;
  std::vector<ChartParameter> parameters;
  ChartContent content;  ///< of a script: its statements are the text of `script`
  std::string script;
  std::vector<Part> parts;  ///< of <if>
  ChartBlock block;         ///< of <foreach>

  /// An attribute; an empty text if it is not there.
  [[nodiscard]] const ChartText& at_name(std::string_view name) const;
  [[nodiscard]] const std::string& text(std::string_view name) const { return at_name(name).text; }
};

/// <data>.
struct ChartVariable {
  std::string id;
  TextLocation at;
  ChartContent initial;
};

/// <invoke>.
struct ChartInvoke {
  TextLocation at;
  std::map<std::string, ChartText, std::less<>> attributes;
  std::vector<ChartParameter> parameters;
  ChartContent content;
  ChartBlock finalize;
  bool has_finalize = false, autoforward = false;

  [[nodiscard]] const std::string& text(std::string_view name) const;
};

struct ChartTransition {
  int source = 0;
  std::vector<std::string> events;  ///< descriptors; none: it needs no event
  ChartText condition;
  ChartText sensors;  ///< takt:cond, an expression of program files over the cell
  std::vector<int> targets;
  bool internal = false;
  ChartBlock block;
  TextLocation at;
};

struct ChartDoneData {
  bool given = false;
  std::vector<ChartParameter> parameters;
  ChartContent content;
};

/// A state of any kind. Its index is its place in the order of the document.
struct ChartState {
  enum class Kind { kRoot, kState, kParallel, kFinal, kHistory, kDeepHistory };
  Kind kind = Kind::kState;
  std::string id;
  TextLocation at;
  int parent = -1;
  int last = 0;               ///< the greatest index of a state in it
  std::vector<int> children;  ///< without histories
  std::vector<int> histories;
  std::vector<int> transitions;  ///< of the chart; of a history its only one
  int initial = -1;              ///< transition to the states that are entered by default; -1: the first child
  std::vector<ChartBlock> on_entry, on_exit;
  std::vector<ChartInvoke> invokes;
  std::vector<ChartVariable> variables;
  ChartDoneData done;

  [[nodiscard]] bool is_history() const { return kind == Kind::kHistory || kind == Kind::kDeepHistory; }
  /// A state with states in it that is no parallel.
  [[nodiscard]] bool is_compound() const { return (kind == Kind::kState || kind == Kind::kRoot) && !children.empty(); }
  [[nodiscard]] bool is_atomic() const { return kind == Kind::kFinal || (kind == Kind::kState && children.empty()); }
};

/// A state chart as SCXML 1.0 (W3C, 2015) describes it, checked. Immutable.
struct Chart {
  enum class Model { kNull, kEcmascript };
  std::string name, file;
  std::filesystem::path folder;  ///< what it names lies in it or below
  Model model = Model::kEcmascript;
  bool early_binding = true;
  std::string script;  ///< run once, after the variables have their first values
  std::vector<ChartState> states;
  std::vector<ChartTransition> transitions;

  [[nodiscard]] bool is_inside(int state, int around) const {
    return state > around && state <= states[static_cast<std::size_t>(around)].last;
  }
  /// -1: there is none of this name.
  [[nodiscard]] int find(std::string_view id) const;
};

/// Reads a chart and checks it completely: all faults at once, each with line and column. Scripts with an error in
/// their syntax are warnings, since the standard makes them errors of the run. Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const Chart>> read_chart(std::string_view text,
                                                              const std::filesystem::path& folder,
                                                              Diagnostics* warnings = nullptr);
/// The same of a file; diagnostics name it.
[[nodiscard]] Result<std::shared_ptr<const Chart>> read_chart_file(const std::filesystem::path& file,
                                                                   Diagnostics* warnings = nullptr);
/// A file that a chart names ("file:part.txt", "part.txt"), below its folder.
[[nodiscard]] Result<std::string> read_named_file(const std::filesystem::path& folder, std::string_view name);

/// What a text between tags is worth: JSON if it is that, otherwise the text with its white space made even.
[[nodiscard]] Data data_of_text(std::string_view text);
/// "1.5s", "20ms"; nothing if it is no duration.
[[nodiscard]] std::optional<std::int64_t> duration_ns(std::string_view text);
/// "a.b" matches "a", "a.*", "*" and "a.b".
[[nodiscard]] bool event_matches(std::string_view descriptor, std::string_view event);

constexpr std::string_view kScxmlSpace = "http://www.w3.org/2005/07/scxml";
constexpr std::string_view kTaktSpace = "urn:takt:charts";
constexpr std::string_view kScxmlProcessor = "http://www.w3.org/TR/scxml/#SCXMLEventProcessor";

}  // namespace takt::languages
