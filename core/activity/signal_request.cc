#include "core/activity/signal_request.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/read_parts.h"

namespace takt::activity {
namespace {

constexpr Range kTime{.low = 0, .high = 3600};

SetRequest::Following read_following(ObjectReader& reader, const command::Cell& cell) {
  SetRequest::Following following;
  following.value = read_value(*reader.object("value"), reader.at("value"), cell, reader.findings());
  (void)check_number(following.value, cell, reader.at("value"), reader.findings());
  if (reader.has("factor")) following.factor = reader.number("factor");
  if (reader.has("offset")) following.offset = reader.number("offset");
  if (reader.has("seconds")) following.seconds = reader.number("seconds", {}, kTime);
  following.until = command::read_condition(reader, "until", cell);
  return following;
}

/// Without a factor the value is sent as it is.
bool check_unit(const SetRequest& request, const command::Cell& cell, const std::string& pointer, Findings& findings) {
  const auto unit = unit_of(request.following->value, cell);
  const std::string& own = cell.analog_outputs.find(request.output)->second->description().unit;
  if (request.following->factor || !unit || *unit == own) return true;
  findings.error(pointer + "/value",
                 fmt::format("a value in {} is not for '{}', which is in {}", *unit, request.output, own),
                 fmt::format("'factor', in {} for each {}", own, *unit));
  return false;
}

}  // namespace

bool sets_by_following(const nlohmann::ordered_json& json) {
  return json.is_object() && json.contains("value") && json.at("value").is_object();
}

SetRequest read_set(ObjectReader& reader, const command::Cell& cell) {
  (void)reader.text("do");
  (void)read_name(reader, "");
  std::vector<std::string> names;
  for (const auto& [name, output] : cell.digital_outputs) names.push_back(name);
  for (const auto& [name, output] : cell.analog_outputs) names.push_back(name);
  SetRequest request;
  request.output = reader.choice("output", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
  const bool analog = cell.analog_outputs.contains(request.output);
  if (analog && sets_by_following(reader.json())) {
    request.following = read_following(reader, cell);
  } else if (analog) {
    request.value = reader.number("value");
  } else if (cell.digital_outputs.contains(request.output)) {
    request.value = reader.boolean("value");
  } else {
    (void)reader.child("value");
  }
  return request;
}

bool check_range(const SetRequest& request, const command::Cell& cell, const std::string& pointer, Findings& findings) {
  if (request.following) return check_unit(request, cell, pointer, findings);
  const double* value = std::get_if<double>(&request.value);
  if (value == nullptr) return true;
  const auto& output = cell.analog_outputs.find(request.output)->second->description();
  if (*value >= output.lower && *value <= output.upper) return true;
  findings.error(pointer + "/value", fmt::format("{:g} {} is not for '{}'", *value, output.unit, request.output),
                 fmt::format("{:g} to {:g} {}", output.lower, output.upper, output.unit));
  return false;
}

WaitRequest read_wait(ObjectReader& reader, const command::Cell& cell) {
  (void)reader.text("do");
  (void)read_name(reader, "");
  WaitRequest request;
  if (!reader.has("until")) {
    request.seconds = reader.number("seconds", {}, kTime);
    return request;
  }
  request.until = command::read_condition(reader, "until", cell);
  if (reader.has("timeout_s")) request.timeout = reader.number("timeout_s", {}, kTime);
  return request;
}

}  // namespace takt::activity
