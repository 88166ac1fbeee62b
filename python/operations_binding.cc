#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nlohmann/json.hpp>

#include "app/interfaces/operation_by_name.h"
#include "cell/file/data_folder.h"
#include "core/base/version.h"
#include "core/operations/table/operation.h"
#include "python/bindings.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Json = nlohmann::ordered_json;
using operations::NameOf;
using operations::ParameterInfo;

const char* word_of(ParameterInfo::Type type) {
  switch (type) {
    case ParameterInfo::Type::kBoolean:
      return "boolean";
    case ParameterInfo::Type::kInteger:
      return "integer";
    case ParameterInfo::Type::kNumber:
      return "number";
    case ParameterInfo::Type::kNumbers:
      return "numbers";
    case ParameterInfo::Type::kVector:
      return "vector";
    case ParameterInfo::Type::kText:
      return "text";
    case ParameterInfo::Type::kTexts:
      return "texts";
    case ParameterInfo::Type::kChoice:
      return "choice";
    case ParameterInfo::Type::kName:
      return "name";
    case ParameterInfo::Type::kCondition:
      return "condition";
    case ParameterInfo::Type::kObject:
      return "object";
  }
  return "object";
}

const char* word_of(NameOf what) {
  switch (what) {
    case NameOf::kArm:
      return "arm";
    case NameOf::kSensor:
      return "sensor";
    case NameOf::kGripper:
      return "gripper";
    case NameOf::kToolChanger:
      return "tool_changer";
    case NameOf::kOutput:
      return "output";
    case NameOf::kObject:
      return "object";
    case NameOf::kNet:
      return "net";
  }
  return "";
}

Json rows(const std::vector<ParameterInfo>& parameters) {
  Json list = Json::array();
  for (const ParameterInfo& one : parameters) {
    if (one.refused) continue;
    Json row{{"key", one.key},   {"type", word_of(one.type)}, {"says", describe_type(one)},
             {"unit", one.unit}, {"required", one.required},  {"default", one.fallback},
             {"doc", one.doc}};
    if (one.type == ParameterInfo::Type::kName) row["names"] = word_of(one.names);
    if (one.type == ParameterInfo::Type::kObject) row["definition"] = one.definition;
    if (!one.choices.empty()) row["choices"] = one.choices;
    if (!one.fields.empty()) row["fields"] = rows(one.fields);
    list.push_back(std::move(row));
  }
  return list;
}

/// All operations with their parameters, as JSON.
std::string tables() {
  Json list = Json::array();
  for (const operations::Operation& one : operations::Operations::global().all()) {
    list.push_back({{"name", one.name},
                    {"doc", one.doc},
                    {"motion", one.is_motion},
                    {"step", one.read_step != nullptr},
                    {"command", one.read_command != nullptr},
                    {"activity", app::is_activity(std::string(one.name))},
                    {"parameters", rows(one.parameters())}});
  }
  return list.dump();
}

}  // namespace

void bind_operations(nb::module_& module) {
  module.def("operations", tables);
  module.def("data_folder", [] { return cell::data_folder().string(); });
  module.def("find_scenario", cell::find_scenario);
  module.attr("version") = TAKT_VERSION;
}

}  // namespace takt::python
