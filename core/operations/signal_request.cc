#include "core/operations/signal_request.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::activity {
namespace {

constexpr Range kTime{.low = 0, .high = 3600};

/// The value of an output: a level, a number in the output's own unit, or something that the output follows.
void read_output_value(const ParameterInfo& row, const ReadContext& from, SetRequest& request) {
  ObjectReader& reader = from.reader;
  const bool analog = from.cell.analog_outputs.contains(request.output);
  if (analog && sets_by_following(reader.json())) {
    request.source = read_value(*reader.object(row.key), reader.at(row.key), from.cell, reader.diagnostics());
    (void)check_number(*request.source, from.cell, reader.at(row.key), reader.diagnostics());
  } else if (analog) {
    request.value = reader.number(row.key);
  } else if (from.cell.digital_outputs.contains(request.output)) {
    request.value = reader.boolean(row.key);
  } else {
    (void)reader.child(row.key);
  }
}

void check_following(SetRequest& request, const ReadContext& from) {
  if (request.source) return;
  for (const char* key : {"factor", "offset", "seconds", "until"}) {
    if (from.reader.has(key)) {
      from.reader.diagnostics().error(Code::kConflict, from.reader.at(key),
                                      fmt::format("'{}' without a value to follow", key),
                                      "an analog output whose 'value' is an object, such as {\"input\": ...}");
    }
  }
}

void check_wait(WaitRequest& request, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  const bool until = reader.has("until");
  if (until && request.seconds)
    reader.diagnostics().error(Code::kConflict, reader.at("seconds"), "a time and a condition",
                               "'timeout_s' for the longest wait");
  if (!until && request.timeout)
    reader.diagnostics().error(Code::kConflict, reader.at("timeout_s"), "a timeout without a condition",
                               "'until', or 'seconds' alone");
  if (!until && !reader.has("seconds"))
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "neither a duration nor a condition is given",
                               "'seconds' or 'until'");
}

/// Without a factor the value is sent as it is.
bool check_unit(const SetRequest& request, const command::Cell& cell, const std::string& pointer,
                Diagnostics& diagnostics) {
  const auto unit = unit_of(*request.source, cell);
  const std::string& own = cell.analog_outputs.find(request.output)->second->description().unit;
  if (request.factor || !unit || *unit == own) return true;
  diagnostics.error(Code::kUnitMismatch, pointer + "/value",
                    fmt::format("a value in {} is not for '{}', which is in {}", *unit, request.output, own),
                    fmt::format("'factor', in {} for each {}", own, *unit));
  return false;
}

}  // namespace

bool sets_by_following(const nlohmann::ordered_json& json) {
  return json.is_object() && json.contains("value") && json.at("value").is_object();
}

const ParameterTable<SetRequest>& set_parameters() {
  static const auto table = [] {
    ParameterInfo value{.key = "value", .type = ParameterInfo::Type::kObject, .definition = "output_value"};
    value.required = true;
    value.doc = "Level, number in the unit of the output, or what an analog output follows.";
    ParameterTable<SetRequest> set;
    set.name("output", NameOf::kOutput, &SetRequest::output, "Digital or analog output.")
        .object(std::move(value), read_output_value)
        .device_number("factor", &SetRequest::factor,
                       "Of an output that follows: its value for each unit of the source.")
        .device_number("offset", &SetRequest::offset, "Of an output that follows: added, in the unit of the output.")
        .number("seconds", "s", &SetRequest::seconds, kTime, "How long the output follows.")
        .condition("until", &SetRequest::until, "The output follows until this becomes true.")
        .rule(check_following);
    return set;
  }();
  return table;
}

const ParameterTable<WaitRequest>& wait_parameters() {
  static const auto table = [] {
    ParameterTable<WaitRequest> wait;
    wait.number("seconds", "s", &WaitRequest::seconds, kTime, "Time that passes.")
        .condition("until", &WaitRequest::until, "Waits until this becomes true.")
        .number("timeout_s", "s", &WaitRequest::timeout, kTime, "The step fails if 'until' is not true by then.")
        .rule(check_wait);
    return wait;
  }();
  return table;
}

SetRequest read_set(ObjectReader& reader, const command::Cell& cell) { return set_parameters().read(reader, cell); }

bool check_range(const SetRequest& request, const command::Cell& cell, const std::string& pointer,
                 Diagnostics& diagnostics) {
  if (request.source) return check_unit(request, cell, pointer, diagnostics);
  const double* value = std::get_if<double>(&request.value);
  if (value == nullptr) return true;
  const auto& output = cell.analog_outputs.find(request.output)->second->description();
  if (*value >= output.lower && *value <= output.upper) return true;
  diagnostics.error(Code::kOutOfRange, pointer + "/value",
                    fmt::format("{:g} {} is not for '{}'", *value, output.unit, request.output),
                    fmt::format("{:g} to {:g} {}", output.lower, output.upper, output.unit));
  return false;
}

WaitRequest read_wait(ObjectReader& reader, const command::Cell& cell) { return wait_parameters().read(reader, cell); }

}  // namespace takt::activity
