#include "core/base/json_lines.h"

#include <algorithm>
#include <string_view>

#include <nlohmann/json.hpp>

namespace takt {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWidth = 120;

std::string key_text(const std::string& key) { return Json(key).dump() + ": "; }

/// `json` in one line, with a space after each comma and colon.
std::string one_line(const Json& json) {
  if (!json.is_structured()) return json.dump();
  std::string text;
  for (const auto& [key, value] : json.items()) {
    if (!text.empty()) text += ", ";
    if (json.is_object()) text += key_text(key);
    text += one_line(value);
  }
  return (json.is_object() ? "{" : "[") + text + (json.is_object() ? "}" : "]");
}

/// @param column  where it begins @param indent  of the line in which it ends
/// Recursion is bounded by the depth that JSON files may have.
void append(const Json& json, std::size_t column, std::size_t indent, std::string& text) {
  std::string whole = one_line(json);
  if (!json.is_structured() || column + whole.size() <= kWidth) {
    text += whole;
    return;
  }
  const std::size_t inner = indent + 2;
  const bool fills = json.is_array() && std::ranges::none_of(json, [](const Json& one) { return one.is_structured(); });
  text += json.is_object() ? '{' : '[';
  std::size_t at = kWidth;
  bool first = true;
  for (const auto& [key, value] : json.items()) {
    const std::string plain = fills ? one_line(value) : "";
    const bool same_line = fills && at + 2 + plain.size() < kWidth;
    if (!first) text += same_line ? ", " : ",";
    if (!same_line) {
      text += '\n';
      text.append(inner, ' ');
      at = inner;
    }
    first = false;
    if (fills) {
      text += plain;
      at += plain.size() + 2;
      continue;
    }
    const std::string label = json.is_object() ? key_text(key) : "";
    text += label;
    append(value, inner + label.size(), inner, text);
  }
  text += '\n';
  text.append(indent, ' ');
  text += json.is_object() ? '}' : ']';
}

}  // namespace

std::string in_lines(const Json& json) {
  std::string text;
  append(json, 0, 0, text);
  return text;
}

}  // namespace takt
