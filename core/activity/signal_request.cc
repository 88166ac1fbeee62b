#include "core/activity/signal_request.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::activity {

SetRequest read_set(ObjectReader& reader, const command::Cell& cell) {
  (void)reader.text("do");
  (void)reader.text("name", "");
  std::vector<std::string> names;
  for (const auto& [name, output] : cell.digital_outputs) names.push_back(name);
  for (const auto& [name, output] : cell.analog_outputs) names.push_back(name);
  SetRequest request;
  request.output = reader.choice("output", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
  if (cell.analog_outputs.contains(request.output)) {
    request.value = reader.number("value");
  } else if (cell.digital_outputs.contains(request.output)) {
    request.value = reader.boolean("value");
  } else {
    (void)reader.child("value");
  }
  return request;
}

bool check_range(const SetRequest& request, const command::Cell& cell, const std::string& pointer, Findings& findings) {
  const double* value = std::get_if<double>(&request.value);
  if (value == nullptr) return true;
  const auto& output = cell.analog_outputs.find(request.output)->second->description();
  if (*value >= output.lower && *value <= output.upper) return true;
  findings.error(pointer + "/value", fmt::format("{:g} {} is not for '{}'", *value, output.unit, request.output),
                 fmt::format("{:g} to {:g} {}", output.lower, output.upper, output.unit));
  return false;
}

WaitRequest read_wait(ObjectReader& reader, const command::Cell& cell) {
  constexpr Range kTime{.low = 0, .high = 3600};
  (void)reader.text("do");
  (void)reader.text("name", "");
  WaitRequest request;
  const nlohmann::ordered_json* until = reader.object("until", false);
  if (!until) {
    request.seconds = reader.number("seconds", {}, kTime);
    return request;
  }
  auto condition = command::parse_condition(*until, reader.at("until"), cell);
  if (condition) {
    request.until = std::move(*condition);
  } else {
    reader.findings().append(condition.error());
  }
  if (reader.has("timeout_s")) request.timeout = reader.number("timeout_s", {}, kTime);
  return request;
}

}  // namespace takt::activity
