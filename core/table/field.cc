#include "core/table/field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace takt::table {
namespace {

using Type = Field::Type;

/// "above 0, at most 1000"; empty for any number.
std::string describe_range(const Range& range) {
  std::string text;
  if (std::isfinite(range.low)) text += fmt::format("{} {:g}", range.low_open ? "above" : "at least", range.low);
  if (std::isfinite(range.high)) text += fmt::format("{}at most {:g}", text.empty() ? "" : ", ", range.high);
  return text;
}

std::string describe_count(const Count& count) {
  if (count.min == count.max) return fmt::format("{} ", count.min);
  return {};
}

std::string join(const std::vector<std::string>& keys) { return fmt::format("'{}'", fmt::join(keys, "' and '")); }

bool given(const std::vector<std::string>& group, const ObjectReader& reader) {
  return std::ranges::all_of(group, [&](const std::string& key) { return reader.has(key); });
}

std::string all_groups(const Rule& rule) {
  std::vector<std::string> texts;
  for (const auto& group : rule.groups) texts.push_back(join(group));
  return fmt::format("{}", fmt::join(texts, ", "));
}

void check_rule(const Rule& rule, ObjectReader& reader) {
  std::vector<std::string> present;
  for (const auto& group : rule.groups)
    if (given(group, reader)) present.push_back(join(group));
  const std::string pointer = rule.at.empty() ? reader.pointer() : reader.at(rule.at);
  const auto report = [&](Code code, const std::string& text) {
    reader.diagnostics().error(code, pointer, text, rule.hint);
  };
  if (rule.kind == Rule::Kind::kNeeds) {
    if (given(rule.groups[0], reader) && !given(rule.groups[1], reader))
      report(rule.code, fmt::format("{} without {}", join(rule.groups[0]), join(rule.groups[1])));
  } else if (present.empty() && rule.kind != Rule::Kind::kNotTogether) {
    report(Code::kMissing, fmt::format("none of {} is given", all_groups(rule)));
  } else if (present.size() > 1 && rule.kind != Rule::Kind::kAnyOf) {
    report(rule.code, fmt::format("{} are given together", fmt::join(present, ", ")));
  }
}

}  // namespace

std::string_view to_text(NameOf what) {
  static constexpr std::array<std::string_view, 16> kTexts{"arm",      "force/torque sensor",
                                                           "gripper",  "tool changer",
                                                           "output",   "object",
                                                           "net",      "device",
                                                           "frame",    "camera",
                                                           "material", "thread",
                                                           "model",    "channel",
                                                           "step",     "body"};
  return kTexts.at(static_cast<std::size_t>(what));
}

Field field(std::string_view key, Type type, std::string_view doc) {
  Field row;
  row.key = key;
  row.type = type;
  row.doc = doc;
  return row;
}

Field reference(std::string_view key, std::string_view definition, const Field& (*form)(), std::string_view doc) {
  Field row = field(key, Type::kObject, doc);
  row.definition = definition;
  row.form = form;
  return row;
}

void check_rules(const std::vector<Rule>& rules, ObjectReader& reader) {
  for (const Rule& rule : rules)
    if (rule.checked) check_rule(rule, reader);
}

std::string to_text(double value) { return fmt::format("{:g}", value); }

std::string to_text(const Eigen::Vector3d& value) {
  return fmt::format("[{:g}, {:g}, {:g}]", value.x(), value.y(), value.z());
}

std::string describe_type(const Field& field) {
  const std::string in = field.unit.empty() ? "" : " in " + field.unit;
  const std::string range = describe_range(field.range);
  switch (field.type) {
    case Type::kBoolean:
      return "true or false";
    case Type::kInteger:
      return "whole number" + (range.empty() ? "" : ", " + range);
    case Type::kNumber:
      return "number" + in + (range.empty() ? "" : ", " + range);
    case Type::kNumbers:
      return describe_count(field.count) + "numbers" + in;
    case Type::kVector:
      return "three numbers" + in;
    case Type::kText:
      return "text";
    case Type::kTexts:
      return "list of texts";
    case Type::kChoice:
      return fmt::format("{}", fmt::join(field.choices, ", "));
    case Type::kName: {
      const std::string_view what = to_text(field.names);
      return fmt::format("name of {} {}", std::string_view("aeio").contains(what.front()) ? "an" : "a", what);
    }
    case Type::kCondition:
      return "condition";
    case Type::kObject:
      return field.definition.empty() ? "object" : field.definition;
    case Type::kList:
      return "list of " + describe_type(field.items.front());
    case Type::kMap:
      return "names to " + describe_type(field.items.front());
    case Type::kEither: {
      if (!field.definition.empty()) return field.definition;
      std::vector<std::string> texts;
      for (const Field& one : field.items) texts.push_back(describe_type(one));
      return fmt::format("{}", fmt::join(texts, " or "));
    }
    case Type::kAny:
      return field.definition.empty() ? "value" : field.definition;
  }
  return {};
}

}  // namespace takt::table
