#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "languages/script/engine.h"
#include "languages/scxml/chart.h"
#include "languages/xml/document.h"

namespace takt::languages {

/// From the elements of a document to a chart: all diagnostics at once. Realtime: setup.
class ChartReader {
 public:
  ChartReader(const std::filesystem::path& folder, Diagnostics& diagnostics)
      : chart_(std::make_unique<Chart>()), folder_(folder), diagnostics_(diagnostics) {}

  /// Never null; only without errors a chart that can run.
  std::unique_ptr<Chart> read(const XmlElement& root);

 private:
  /// Targets of a transition as they are written; ids are known only at the end.
  struct Named {
    int transition;
    ChartText ids;
  };

  int state(const XmlElement& element, ChartState::Kind kind, int parent);
  void state_child(const XmlElement& child, int index);
  int transition(const XmlElement& element, int source);
  void initial(const XmlElement& element, int index);
  void initial_attribute(const XmlElement& element, int index);
  void variables(const XmlElement& element, int index);
  void done_data(const XmlElement& element, ChartDoneData& done);
  ChartInvoke invoke(const XmlElement& element);
  ChartBlock block(const XmlElement& element);
  void action(const XmlElement& element, ChartBlock& block);
  void if_parts(const XmlElement& element, ChartAction& action);
  void parameters(const XmlElement& element, std::vector<ChartParameter>& list, ChartContent& content);
  ChartContent content_of(const XmlElement& element);
  std::string script_of(const XmlElement& element);
  void resolve_targets();

  /// Refuses attributes that the element does not have.
  void check_attributes(const XmlElement& element, const std::vector<std::string_view>& known);
  ChartText attribute(const XmlElement& element, std::string_view name, bool required = false);
  std::string choice(const XmlElement& element, std::string_view name, std::initializer_list<std::string_view> allowed);
  void check_expression(const ChartText& text, bool statements = false);
  /// True for an element of SCXML; one of another namespace is left out as the standard says.
  bool is_ours(const XmlElement& element);
  void unexpected(const XmlElement& element, const XmlElement& around);
  void error(const TextLocation& at, Code code, std::string message, std::string hint) {
    error_at(at, code, std::move(message), std::move(hint), diagnostics_);
  }
  void conflict(const XmlElement& element, std::string_view one, std::string_view other);

  std::unique_ptr<Chart> chart_;
  std::filesystem::path folder_;
  Diagnostics& diagnostics_;
  std::vector<Named> named_;
  std::set<std::string> ids_;
  int unnamed_ = 0;
  std::unique_ptr<ScriptEngine> syntax_;
};

/// What is wrong with states and transitions as a whole.
void check_chart(const Chart& chart, Diagnostics& diagnostics);

}  // namespace takt::languages
