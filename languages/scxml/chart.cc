#include "languages/scxml/chart.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "core/base/json.h"
#include "languages/scxml/reader.h"

namespace takt::languages {

namespace {

/// A file that a chart names is no larger than a chart.
constexpr std::size_t kMostBytes = 1u << 20;
/// A delay longer than a year is a mistake.
constexpr double kLongestDelay_s = 366.0 * 86'400.0;

}  // namespace

const ChartText& ChartAction::at_name(std::string_view name) const {
  static const ChartText kNothing;
  const auto found = attributes.find(name);
  return found == attributes.end() ? kNothing : found->second;
}

const std::string& ChartInvoke::text(std::string_view name) const {
  static const std::string kNothing;
  const auto found = attributes.find(name);
  return found == attributes.end() ? kNothing : found->second.text;
}

int Chart::find(std::string_view id) const {
  for (std::size_t i = 1; i < states.size(); ++i)
    if (states[i].id == id) return static_cast<int>(i);
  return -1;
}

Result<std::shared_ptr<const Chart>> read_chart(std::string_view text, const std::filesystem::path& folder,
                                                Diagnostics* warnings) {
  auto root = parse_xml(text);
  if (!root) return std::unexpected(std::move(root.error()));
  Diagnostics diagnostics;
  ChartReader reader(folder, diagnostics);
  std::unique_ptr<Chart> chart = reader.read(**root);
  if (!chart->states.empty()) check_chart(*chart, diagnostics);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  if (warnings != nullptr) warnings->append(diagnostics);
  return std::shared_ptr<const Chart>(std::move(chart));
}

Result<std::shared_ptr<const Chart>> read_chart_file(const std::filesystem::path& file, Diagnostics* warnings) {
  auto text = read_file(file, kMostBytes);
  if (!text) return std::unexpected(std::move(text.error()));
  Diagnostics own;
  auto chart = read_chart(*text, file.parent_path(), &own);
  if (!chart) {
    chart.error().set_file(file.string());
    return chart;
  }
  own.set_file(file.string());
  if (warnings != nullptr) warnings->append(own);
  auto named = std::make_shared<Chart>(**chart);
  named->file = file.string();
  if (named->name.empty()) named->name = file.stem().string();
  return std::shared_ptr<const Chart>(std::move(named));
}

Result<std::string> read_named_file(const std::filesystem::path& folder, std::string_view name) {
  if (name.starts_with("file:")) name.remove_prefix(5);
  const auto path = resolve_below(folder.empty() ? std::filesystem::path(".") : folder, name, {});
  if (!path) return std::unexpected(path.error());
  return read_file(*path, kMostBytes);
}

Data data_of_text(std::string_view text) {
  if (const auto json = parse_json(text)) return Data::of_json(json->dump());
  std::string even;
  for (const char c : text) {
    const bool white = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!white) {
      even += c;
    } else if (!even.empty() && even.back() != ' ') {
      even += ' ';
    }
  }
  if (!even.empty() && even.back() == ' ') even.pop_back();
  return Data::of_json(
      nlohmann::ordered_json(even).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

std::optional<std::int64_t> duration_ns(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  double scale = 0;
  if (text.ends_with("ms")) {
    scale = 1e6;
    text.remove_suffix(2);
  } else if (text.ends_with("s")) {
    scale = 1e9;
    text.remove_suffix(1);
  }
  double value = 0;
  if (text.starts_with("+")) text.remove_prefix(1);
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (scale == 0 || text.empty() || wrong != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(value) || value < 0 || value * scale > kLongestDelay_s * 1e9) return std::nullopt;
  return static_cast<std::int64_t>(std::llround(value * scale));
}

bool event_matches(std::string_view descriptor, std::string_view event) {
  if (descriptor.ends_with(".*")) descriptor.remove_suffix(2);
  if (descriptor.ends_with('.')) descriptor.remove_suffix(1);
  if (descriptor == "*") return true;
  return event.starts_with(descriptor) && (event.size() == descriptor.size() || event[descriptor.size()] == '.');
}

}  // namespace takt::languages
