#include "cell/file/chart_files.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "languages/program/charts_node.h"
#include "languages/program/tree_node.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostChartBytes = 1u << 20;

/// The kind of node is known to whoever can read it from a file.
[[maybe_unused]] const bool kChartsKnown =
    (program::add_node_kind(languages::charts_kind()), program::add_node_kind(languages::tree_kind()), true);

/// @param key  that gets the text
void take_in_chart(Json& place, const char* key, const std::string& pointer, const std::filesystem::path& folder,
                   Diagnostics& diagnostics) {
  if (!place.is_string()) return;
  const auto name = place.get<std::string>();
  if (const auto inside = resolve_below(folder, name, pointer); !inside) {
    diagnostics.append(inside.error());
    return;
  }
  const std::filesystem::path file = folder / name;
  auto text = read_file(file, kMostChartBytes);
  if (text) {
    place = Json{{"file", file.string()}, {key, std::move(*text)}};
  } else {
    diagnostics.append(text.error(), pointer);
  }
}

void visit(Json& json, const std::string& pointer, const std::filesystem::path& folder, Diagnostics& diagnostics) {
  if (!json.is_structured()) return;
  const bool is_node = json.is_object() && json.contains("charts") && json["charts"].is_object() &&
                       json.contains("do") && json["do"] == "charts";
  const bool is_tree = json.is_object() && json.contains("tree") && json.contains("do") && json["do"] == "tree";
  std::size_t index = 0;
  for (auto& [key, value] : json.items()) {
    const std::string inside = pointer + (json.is_array() ? pointer_segment(index++) : pointer_segment(key));
    if (is_tree && key == "tree") {
      take_in_chart(value, "xml", inside, folder, diagnostics);
      continue;
    }
    if (!is_node || key != "charts") {
      visit(value, inside, folder, diagnostics);
      continue;
    }
    for (auto& [name, place] : value.items())
      take_in_chart(place, "scxml", inside + pointer_segment(name), folder, diagnostics);
  }
}

}  // namespace

void read_charts(Json& document, const std::filesystem::path& folder, Diagnostics& diagnostics) {
  for (const char* key : {"program", "programs"})
    if (document.is_object() && document.contains(key))
      visit(document[key], "/" + std::string(key), folder, diagnostics);
}

}  // namespace takt::cell
