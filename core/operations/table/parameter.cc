#include "core/operations/table/parameter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/expression/condition.h"
#include "core/operations/table/parameter_table.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;
using Type = ParameterInfo::Type;

template <class Map>
void add_names(const Map& map, std::vector<std::string>& names) {
  for (const auto& [name, member] : map) names.push_back(name);
}

/// "above 0, at most 1000"; empty for any number.
std::string describe_range(const Range& range) {
  std::string text;
  if (std::isfinite(range.low)) text += fmt::format("{} {:g}", range.low_open ? "above" : "at least", range.low);
  if (std::isfinite(range.high)) text += fmt::format("{}at most {:g}", text.empty() ? "" : ", ", range.high);
  return text;
}

/// As people write it: 5, not 5.0.
Json plain_number(double value) {
  constexpr double kMostWhole = 1e15;
  if (std::trunc(value) == value && std::abs(value) < kMostWhole) return static_cast<std::int64_t>(value);
  return value;
}

void limit(const Range& range, Json& schema) {
  if (std::isfinite(range.low)) schema[range.low_open ? "exclusiveMinimum" : "minimum"] = plain_number(range.low);
  if (std::isfinite(range.high)) schema["maximum"] = plain_number(range.high);
}

Json reference(std::string_view definition) { return {{"$ref", fmt::format("#/definitions/{}", definition)}}; }

/// The schema of a value that is no expression.
Json schema_of_value(const ParameterInfo& parameter) {
  Json schema;
  switch (parameter.type) {
    case Type::kBoolean:
      return {{"type", "boolean"}};
    case Type::kInteger:
      schema["type"] = "integer";
      limit(parameter.range, schema);
      return schema;
    case Type::kNumber:
      schema["type"] = "number";
      limit(parameter.range, schema);
      return schema;
    case Type::kText:
      return {{"type", "string"}};
    case Type::kTexts:
      return {{"type", "array"}, {"items", {{"type", "string"}}}};
    case Type::kChoice:
      return {{"enum", parameter.choices}};
    case Type::kName:
      return {{"type", "string"}};
    case Type::kVector:
      return reference("program_vector");
    case Type::kNumbers:
    case Type::kCondition:
    case Type::kObject:
      return reference(parameter.definition);
  }
  return schema;
}

bool is_index(std::string_view segment) {
  return !segment.empty() && std::ranges::all_of(segment, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::string_view to_text(NameOf what) {
  static constexpr std::array<std::string_view, 7> kTexts{
      "arm", "force/torque sensor", "gripper", "tool changer", "output", "object", "net"};
  return kTexts.at(static_cast<std::size_t>(what));
}

std::vector<std::string> names_in(const expression::Cell& cell, NameOf what) {
  std::vector<std::string> names;
  switch (what) {
    case NameOf::kArm:
      add_names(cell.arms, names);
      break;
    case NameOf::kSensor:
      add_names(cell.sensors, names);
      break;
    case NameOf::kGripper:
      add_names(cell.grippers, names);
      break;
    case NameOf::kToolChanger:
      add_names(cell.changers, names);
      break;
    case NameOf::kOutput:
      add_names(cell.digital_outputs, names);
      add_names(cell.analog_outputs, names);
      break;
    case NameOf::kObject:
      add_names(cell.objects, names);
      break;
    case NameOf::kNet:
      add_names(cell.nets, names);
      break;
  }
  return names;
}

std::string to_text(double value) { return fmt::format("{:g}", value); }

std::string to_text(const Eigen::Vector3d& value) {
  return fmt::format("[{:g}, {:g}, {:g}]", value.x(), value.y(), value.z());
}

std::string describe_type(const ParameterInfo& parameter) {
  const std::string in = parameter.unit.empty() ? "" : " in " + parameter.unit;
  const std::string range = describe_range(parameter.range);
  switch (parameter.type) {
    case Type::kBoolean:
      return "true or false";
    case Type::kInteger:
      return "whole number" + (range.empty() ? "" : ", " + range);
    case Type::kNumber:
      return "number" + in + (range.empty() ? "" : ", " + range);
    case Type::kNumbers:
      return "numbers" + in;
    case Type::kVector:
      return "three numbers" + in;
    case Type::kText:
      return "text";
    case Type::kTexts:
      return "list of texts";
    case Type::kChoice:
      return fmt::format("{}", fmt::join(parameter.choices, ", "));
    case Type::kName:
      return fmt::format("name of {} {}",
                         parameter.names == NameOf::kArm || parameter.names >= NameOf::kOutput ? "an" : "a",
                         to_text(parameter.names));
    case Type::kCondition:
      return "condition";
    case Type::kObject:
      return parameter.definition;
  }
  return {};
}

std::optional<net::FileUnit> unit_at(std::span<const ParameterInfo> parameters, std::string_view pointer) {
  if (!pointer.starts_with('/')) return std::nullopt;
  pointer.remove_prefix(1);
  const std::string_view segment = pointer.substr(0, pointer.find('/'));
  const std::string_view rest = pointer.substr(segment.size());
  // Elements of a list have the parameters of the list.
  if (is_index(segment)) return unit_at(parameters, rest);
  const auto found = std::ranges::find(parameters, segment, &ParameterInfo::key);
  if (found == parameters.end()) return std::nullopt;
  if (found->type == Type::kCondition) return expression::unit_in_condition(rest);
  if (found->type == Type::kObject) return unit_at(found->fields, rest);
  if (found->unit_of_device) return std::nullopt;
  const bool counts = found->type == Type::kNumber || found->type == Type::kNumbers || found->type == Type::kVector ||
                      found->type == Type::kInteger;
  return counts ? std::optional(net::file_unit(found->unit)) : std::nullopt;
}

Json schema_of(const ParameterInfo& parameter) {
  Json schema;
  schema["description"] = parameter.doc;
  if (!parameter.fallback.empty())
    schema["description"] = fmt::format("{} Default: {}.", parameter.doc, parameter.fallback);
  const bool holds_expressions = parameter.type == Type::kNumber || parameter.type == Type::kInteger ||
                                 parameter.type == Type::kBoolean || parameter.type == Type::kChoice ||
                                 parameter.type == Type::kTexts;
  if (holds_expressions) {
    schema["anyOf"] = Json::array({reference("expression"), schema_of_value(parameter)});
  } else {
    const Json value = schema_of_value(parameter);
    // Beside a reference draft-07 ignores every other key, the description too.
    if (value.contains("$ref")) {
      schema["allOf"] = Json::array({value});
    } else {
      schema.update(value);
    }
  }
  return schema;
}

ParameterWriter::ParameterWriter() : json_(std::make_unique<Json>(Json::object())) {}
ParameterWriter::~ParameterWriter() = default;
void ParameterWriter::number(const std::string& key, double value) { (*json_)[key] = plain_number(value); }
void ParameterWriter::integer(const std::string& key, std::int64_t value) { (*json_)[key] = value; }
void ParameterWriter::boolean(const std::string& key, bool value) { (*json_)[key] = value; }
void ParameterWriter::text(const std::string& key, const std::string& value) { (*json_)[key] = value; }
void ParameterWriter::texts(const std::string& key, const std::vector<std::string>& values) { (*json_)[key] = values; }
void ParameterWriter::vector(const std::string& key, const Eigen::Vector3d& value) {
  (*json_)[key] = {value.x(), value.y(), value.z()};
}
void ParameterWriter::object(const std::string& key, const ParameterWriter& parameters) {
  (*json_)[key] = parameters.result();
}
void ParameterWriter::json(const std::string& key, Json value) { (*json_)[key] = std::move(value); }

void check_tool_name(const ToolChoice& choice, const ReadContext& from) {
  if (choice.tool.empty() || from.cell.tools.contains(choice.tool)) return;
  std::vector<std::string> names;
  add_names(from.cell.tools, names);
  from.reader.diagnostics().error(
      Code::kUnknownName, from.reader.at("tool"), fmt::format("there is no tool '{}'", choice.tool),
      names.empty() ? "Remove 'tool': the cell has none" : nearest_choice(choice.tool, names));
}

}  // namespace takt::operations
