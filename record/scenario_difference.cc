#include "record/scenario_difference.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/utf8.h"

namespace takt::record {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostDifferences = 100, kLongestValue = 120;
constexpr const char* kScenarioFile = "scenario.json";

std::string short_value(const Json* value) {
  if (value == nullptr) return {};
  const std::string text = value->dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= kLongestValue ? text : std::string(cut_utf8(text, kLongestValue)) + " ...";
}

class Differ {
 public:
  explicit Differ(std::size_t most) : most_(most) {}

  void compare(const Json& a, const Json& b, const std::string& at) {
    if (found.size() >= most_ || a == b) return;
    if (a.is_object() && b.is_object()) return compare_objects(a, b, at);
    if (a.is_array() && b.is_array() && !all_numbers(a, b)) return compare_arrays(a, b, at);
    add(at, &a, &b);
  }

  std::vector<ScenarioDifference> found;

 private:
  /// A position is one value.
  static bool all_numbers(const Json& a, const Json& b) {
    const auto is_number = [](const Json& one) { return one.is_number(); };
    return std::ranges::all_of(a, is_number) && std::ranges::all_of(b, is_number);
  }

  void add(const std::string& at, const Json* a, const Json* b) {
    if (found.size() < most_) found.push_back({at, short_value(a), short_value(b)});
  }

  void compare_objects(const Json& a, const Json& b, const std::string& at) {
    for (const auto& [key, value] : a.items()) {
      const auto other = b.find(key);
      if (other != b.end()) {
        compare(value, *other, at + pointer_segment(key));
      } else {
        add(at + pointer_segment(key), &value, nullptr);
      }
    }
    for (const auto& [key, value] : b.items())
      if (!a.contains(key)) add(at + pointer_segment(key), nullptr, &value);
  }

  void compare_arrays(const Json& a, const Json& b, const std::string& at) {
    const std::size_t shorter = std::min(a.size(), b.size());
    std::size_t front = 0, back = 0;
    while (front < shorter && a[front] == b[front]) ++front;
    while (back < shorter - front && a[a.size() - 1 - back] == b[b.size() - 1 - back]) ++back;
    const std::size_t end_a = a.size() - back, end_b = b.size() - back;
    const bool same_length = a.size() == b.size();
    for (std::size_t i = front; i < std::max(end_a, end_b); ++i) {
      const std::string pointer = at + pointer_segment(i);
      if (same_length) {
        compare(a[i], b[i], pointer);
      } else {
        add(pointer, i < end_a ? &a[i] : nullptr, i < end_b ? &b[i] : nullptr);
      }
    }
  }

  std::size_t most_;
};

std::optional<Json> scenario_of(const Recording& recording) {
  const auto text = recording.attachment(kScenarioFile);
  auto json = text ? parse_json(*text) : Result<Json>(std::unexpected(Diagnostics()));
  return json ? std::optional(std::move(*json)) : std::nullopt;
}

}  // namespace

std::vector<ScenarioDifference> json_differences(const Json& a, const Json& b, std::size_t most) {
  Differ differ(most);
  differ.compare(a, b, "");
  return std::move(differ.found);
}

std::vector<ScenarioDifference> scenario_differences(const Recording& a, const Recording& b) {
  const auto in_a = scenario_of(a), in_b = scenario_of(b);
  return in_a && in_b ? json_differences(*in_a, *in_b, kMostDifferences) : std::vector<ScenarioDifference>();
}

}  // namespace takt::record
