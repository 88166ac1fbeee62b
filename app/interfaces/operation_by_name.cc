#include "app/interfaces/operation_by_name.h"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/interfaces/actuator_interfaces.h"
#include "core/base/read_parts.h"
#include "core/expression/tool_settings.h"
#include "core/operations/force/wipe.h"
#include "core/operations/online/control_mode.h"
#include "core/operations/process/weld.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/step.h"

namespace takt::app {
namespace {

using Json = nlohmann::ordered_json;
using activity::Activity;
using activity::ActivityError;
using activity::Runtime;

[[noreturn]] void refuse_operation(Diagnostics why) { throw ActivityError(std::move(why)); }

void require_clean(Diagnostics& diagnostics) {
  if (diagnostics.has_errors()) refuse_operation(std::move(diagnostics));
}

const operations::Operation& operation_of(const Json& json) {
  const std::string name = json.is_object() ? json.value("do", std::string()) : std::string();
  const auto* operation = operations::Operations::global().find(name);
  if (operation != nullptr) return *operation;
  std::vector<std::string> names;
  for (const auto& one : operations::Operations::global().all()) names.emplace_back(one.name);
  Diagnostics why;
  why.error(Code::kUnknownName, "/do", fmt::format("there is no operation '{}'", name),
            nearest_choice(name, names, 30));
  refuse_operation(std::move(why));
}

/// A state of the program into the member of this key. @return false: the operation has no such condition
template <class P>
bool put_state(const std::string& key, const expression::State& state, P& parameters) {
  if constexpr (requires { parameters.until = state; })
    if (key == "until") return parameters.until = state, true;
  if constexpr (requires { parameters.abort_if = state; })
    if (key == "abort_if") return parameters.abort_if = state, true;
  if constexpr (requires { parameters.enabled = state; })
    if (key == "enabled" || key == "while") return parameters.enabled = state, true;
  return false;
}

/// What a file would have in place of what the program gives, so that the rest of the object can be read.
Json with_stand_ins(const Json& json, const ProgramValues& values) {
  Json written = json;
  for (const auto& [key, goals] : values.goals)
    written[key] = key == "through" ? Json(std::vector<std::string>(goals.size(), "home")) : Json("home");
  return written;
}

/// Reads the parameters as those of a file; the keys that the program gives count as there.
template <class P>
P read_parameters(const operations::ParameterRows<P>& table, const Json& json, const expression::Cell& cell,
                  const ProgramValues& values) {
  Diagnostics diagnostics;
  const Json written = with_stand_ins(json, values);
  ObjectReader reader(written, "", diagnostics);
  std::set<std::string, std::less<>> given;
  for (const auto& [key, state] : values.states) given.insert(key);
  P parameters;
  (void)reader.text("do", "");
  parameters.name = read_name(reader, "");
  table.read_into(parameters, {reader, cell, &given});
  std::vector<std::string> keys;
  for (const operations::ParameterInfo& info : table.list()) {
    if (info.refused) continue;
    (void)reader.child(info.key);
    keys.push_back(info.key);
  }
  reader.finish();
  for (const auto& [key, state] : values.states) {
    if (std::ranges::find(keys, key) == keys.end() || !put_state(key, state, parameters))
      diagnostics.error(Code::kUnknownKey, pointer_segment(key), fmt::format("unknown key '{}'", key),
                        nearest_choice(key, keys));
  }
  require_clean(diagnostics);
  return parameters;
}

// -- Planned motions -------------------------------------------------------------------------------------------------

constexpr std::array<std::string_view, 5> kMotions = {"ptp", "lin", "circ", "spline", "move"};

std::optional<operations::PathKind> kind_of(std::string_view operation) {
  for (std::size_t i = 0; i < kMotions.size(); ++i)
    if (kMotions.at(i) == operation) return static_cast<operations::PathKind>(i);
  return std::nullopt;
}

void put_goals(const ProgramValues& values, operations::MotionTask& motion) {
  for (const auto& [key, goals] : values.goals) {
    if (key == "to") motion.goal = goals.front();
    if (key == "via") motion.via = goals.front();
    if (key == "base_to") motion.base_goal = goals.front();
    if (key == "through") motion.through = goals;
  }
}

// -- Operations with a form in C++ -----------------------------------------------------------------------------------

template <class P>
Activity by_form(Runtime& runtime, const Json& json, const ProgramValues& values) {
  const auto form = form_of(P{});
  const P parameters = read_parameters<P>(form.table(), json, runtime.cell(), values);
  return Actuator(runtime, parameters.*form.device).perform(parameters);
}

Activity freedrive_by_name(Runtime& runtime, const Json& json, const ProgramValues& values) {
  const auto parameters = read_parameters<operations::FreedriveParameters>(operations::freedrive_parameters(), json,
                                                                           runtime.cell(), values);
  return Actuator(runtime, parameters.arm).use<FreedriveInterface>().freedrive(parameters);
}

Activity control_mode_by_name(Runtime& runtime, const Json& json, const ProgramValues& values) {
  const auto parameters = read_parameters<operations::ControlModeParameters>(operations::control_mode_parameters(),
                                                                             json, runtime.cell(), values);
  return Actuator(runtime, parameters.arm).use<ControlModeInterface>().switch_to(parameters.mode);
}

struct Form {
  std::string_view operation;
  Activity (*make)(Runtime& runtime, const Json& json, const ProgramValues& values);
};
constexpr std::array<Form, 14> kForms{{{"press", by_form<operations::PressParameters>},
                                       {"search", by_form<operations::SearchParameters>},
                                       {"weld", by_form<operations::WeldParameters>},
                                       {"wipe", by_form<operations::WipeParameters>},
                                       {"hold", by_form<operations::HoldParameters>},
                                       {"jog", by_form<operations::JogParameters>},
                                       {"follow", by_form<operations::FollowParameters>},
                                       {"grip", by_form<operations::GripParameters>},
                                       {"release", by_form<operations::ReleaseParameters>},
                                       {"couple", by_form<operations::CoupleParameters>},
                                       {"uncouple", by_form<operations::UncoupleParameters>},
                                       {"set", by_form<operations::SetParameters>},
                                       {"freedrive", freedrive_by_name},
                                       {"control_mode", control_mode_by_name}}};

const Form* form_named(std::string_view operation) {
  for (const Form& form : kForms)
    if (form.operation == operation) return &form;
  return nullptr;
}

// -- Operations that are steps ---------------------------------------------------------------------------------------

void refuse_values(const ProgramValues& values, const operations::Operation& operation) {
  Diagnostics why;
  for (const auto& [key, state] : values.states)
    why.error(Code::kUnsupported, pointer_segment(key),
              fmt::format("'{}' accepts conditions in the form of files only", operation.name),
              "Give a condition like {\"sensor\": \"wrist\", \"above_N\": 5}");
  for (const auto& [key, goals] : values.goals)
    why.error(Code::kUnsupported, pointer_segment(key),
              fmt::format("'{}' accepts goals in the form of files only", operation.name), "Give it as an object");
  require_clean(why);
}

/// As a step of a file, between the cycles of the program.
void run_step(Runtime& runtime, const Json& json, const operations::Operation& operation) {
  runtime.require_outside();
  Diagnostics diagnostics;
  const std::string pointer;
  const auto step = operation.read_step({json, pointer, runtime.cell(), diagnostics});
  require_clean(diagnostics);
  diagnostics.append(operations::use_tools(runtime.cell(), step->arm_tools()));
  require_clean(diagnostics);
  expression::tell_tool_settings(runtime.cell());
  const auto run = step->begin();
  auto progress = operations::Progress::kRunning;
  runtime.run_until([&] {
    progress = run->advance(runtime.context(), diagnostics);
    return progress != operations::Progress::kRunning;
  });
  if (progress == operations::Progress::kFailed) refuse_operation(std::move(diagnostics));
}

}  // namespace

operations::MotionTask motion_by_name(const expression::Cell& cell, const Json& json, const ProgramValues& values) {
  const auto& operation = operation_of(json);
  const auto kind = kind_of(operation.name);
  if (!kind) {
    Diagnostics why;
    why.error(Code::kInvalidValue, "/do", fmt::format("'{}' is not a planned motion", operation.name),
              "Use ptp, lin, circ, spline or move");
    refuse_operation(std::move(why));
  }
  auto motion = read_parameters<operations::MotionTask>(operations::motion_parameters(*kind), json, cell, values);
  put_goals(values, motion);
  if (values.blend_time_share) motion.blend = *values.blend_time_share;
  if (values.X_FM) motion.X_FM = values.X_FM;
  return motion;
}

Activity operation_by_name(Runtime& runtime, const Json& json, const ProgramValues& values) {
  const operations::Operation& operation = operation_of(json);
  if (kind_of(operation.name)) return planned_motion(runtime, motion_by_name(runtime.cell(), json, values));
  if (const Form* form = form_named(operation.name)) return form->make(runtime, json, values);
  Diagnostics why;
  why.error(Code::kUnsupported, "/do", fmt::format("'{}' is a step of its own", operation.name),
            "Call it by itself, neither beside others nor inside of a composition");
  refuse_operation(std::move(why));
}

bool is_activity(const std::string& operation) {
  return kind_of(operation).has_value() || form_named(operation) != nullptr;
}

activity::RunPtr execute_by_name(Runtime& runtime, const Json& json, const ProgramValues& values) {
  const operations::Operation& operation = operation_of(json);
  if (is_activity(std::string(operation.name))) return operation_by_name(runtime, json, values).execute();
  refuse_values(values, operation);
  if (operation.read_step == nullptr) {
    Diagnostics why;
    why.error(Code::kUnsupported, "/do", fmt::format("'{}' exists only inside of a transaction", operation.name),
              "Write it as a command of a transaction");
    refuse_operation(std::move(why));
  }
  run_step(runtime, json, operation);
  return nullptr;
}

}  // namespace takt::app
