#include "core/operations/parameter.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/expression/condition.h"
#include "core/operations/parameter_table.h"

namespace takt::activity {
namespace {

using Type = ParameterInfo::Type;

template <class Map>
void add_names(const Map& map, std::vector<std::string>& names) {
  for (const auto& [name, member] : map) names.push_back(name);
}

bool is_index(std::string_view segment) {
  return !segment.empty() && std::ranges::all_of(segment, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::vector<std::string> names_in(const command::Cell& cell, NameOf what) {
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
    default:
      break;
  }
  return names;
}

std::optional<table::FileUnit> unit_at(std::span<const ParameterInfo> parameters, std::string_view pointer) {
  if (!pointer.starts_with('/')) return std::nullopt;
  pointer.remove_prefix(1);
  const std::string_view segment = pointer.substr(0, pointer.find('/'));
  const std::string_view rest = pointer.substr(segment.size());
  // Elements of a list have the parameters of the list.
  if (is_index(segment)) return unit_at(parameters, rest);
  const auto found = std::ranges::find(parameters, segment, &ParameterInfo::key);
  if (found == parameters.end()) return std::nullopt;
  if (found->type == Type::kCondition) return command::unit_in_condition(rest);
  if (!found->fields.empty()) return unit_at(found->fields, rest);
  if (found->type == Type::kObject || found->unit_of_device) return std::nullopt;
  const bool counts = found->type == Type::kNumber || found->type == Type::kNumbers || found->type == Type::kVector ||
                      found->type == Type::kInteger;
  return counts ? std::optional(table::file_unit(found->unit)) : std::nullopt;
}

void check_tool_name(const ToolChoice& choice, const ReadContext& from) {
  if (choice.tool.empty() || from.cell.tools.contains(choice.tool)) return;
  std::vector<std::string> names;
  add_names(from.cell.tools, names);
  from.reader.diagnostics().error(Code::kUnknownName, from.reader.at("tool"),
                                  fmt::format("there is no tool '{}'", choice.tool),
                                  names.empty() ? "no 'tool': the cell has none" : nearest_choice(choice.tool, names));
}

}  // namespace takt::activity
