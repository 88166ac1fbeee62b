#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/table/schema.h"

namespace takt::table {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWidth = 120;

/// On one line, with spaces after commas and colons.
std::string line_of(const Json& json) {
  if (!json.is_structured() || json.empty()) return json.dump();
  std::string text;
  for (const auto& [key, value] : json.items()) {
    if (!text.empty()) text += ", ";
    text += json.is_object() ? Json(key).dump() + ": " + line_of(value) : line_of(value);
  }
  return json.is_object() ? "{" + text + "}" : "[" + text + "]";
}

/// @param lead  columns that its key takes on the first line
std::string text_of(const Json& json, std::size_t indent, std::size_t lead) {
  std::string line = line_of(json);
  if (line.size() + indent + lead + 1 <= kWidth || !json.is_structured() || json.empty()) return line;
  const std::string space(indent + 2, ' ');
  std::string text;
  for (const auto& [key, value] : json.items()) {
    const std::string name = json.is_object() ? Json(key).dump() + ": " : "";
    text += fmt::format("{}{}{}{}", text.empty() ? "" : ",\n", space, name, text_of(value, indent + 2, name.size()));
  }
  return fmt::format("{}\n{}\n{}{}", json.is_object() ? "{" : "[", text, std::string(indent, ' '),
                     json.is_object() ? "}" : "]");
}

}  // namespace

std::string page_of(const Json& json) { return text_of(json, 0, 0) + "\n"; }

}  // namespace takt::table
