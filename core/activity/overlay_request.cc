#include "core/activity/overlay_request.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/read_parts.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// Of length 1, in the axes of the tool.
Eigen::Vector3d read_unit_vector(ObjectReader& reader, const Eigen::Vector3d& fallback) {
  return read_direction(reader, "direction", fallback).normalized();
}

command::WeaveWish read_weave(const Json& json, const std::string& pointer, Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  command::WeaveWish wish;
  wish.amplitude = reader.number("amplitude_m", {}, {.low = 0.0, .high = 1.0, .low_open = true});
  wish.frequency = reader.number("frequency_Hz", {}, {.low = 0.0, .high = 100.0, .low_open = true});
  wish.direction_M = read_unit_vector(reader, wish.direction_M);
  wish.ramp = reader.number("ramp_s", wish.ramp, {.low = 0.0, .high = 100.0, .low_open = true});
  reader.finish();
  return wish;
}

std::string read_sensor(ObjectReader& reader, const std::string& arm, const command::Cell& cell) {
  std::vector<std::string> names;
  for (const auto& [name, sensor] : cell.sensors) names.push_back(name);
  const std::string sensor =
      reader.choice("sensor", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
  const auto mounted = cell.sensors.find(sensor);
  if (mounted != cell.sensors.end() && mounted->second.arm != arm) {
    reader.findings().error(reader.at("sensor"), fmt::format("'{}' is not on '{}'", sensor, arm),
                            "a sensor on this arm");
  }
  return sensor;
}

OverlayRequest::ForceOffset read_force_offset(const Json& json, const std::string& pointer, const std::string& arm,
                                              const command::Cell& cell, Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  OverlayRequest::ForceOffset request;
  request.sensor = read_sensor(reader, arm, cell);
  command::ForceOffsetWish& wish = request.wish;
  command::ForceWish& force = wish.force;
  wish.direction_M = read_unit_vector(reader, wish.direction_M);
  wish.reach = reader.number("reach_m", wish.reach, {.low = 0.0, .high = 1.0});
  wish.retreat = reader.number("retreat_m", wish.reach, {.low = 0.0, .high = 1.0});
  force.force = reader.number("force_N", {}, {.low = 0.1, .high = 1000.0});
  force.approach_velocity = reader.number("approach_m_s", 0.005, {.low = 0.0, .high = 0.1});
  force.velocity_max = reader.number("velocity_max_m_s", 0.02, {.low = 0.0, .high = 1.0, .low_open = true});
  force.acceleration_max = reader.number("acceleration_max_m_s2", 0.3, {.low = 0.0, .high = 10.0, .low_open = true});
  wish.jerk_max = reader.number("jerk_max_m_s3", 10.0, {.low = 0.0, .high = 1000.0, .low_open = true});
  force.gain = reader.number("gain_m_s_per_N", 5e-4, {.low = 0.0, .high = 1.0, .low_open = true});
  // As with "press": contact is from a third of the wanted force on, and lost below a third of that.
  force.contact_force = 0.3 * force.force;
  force.release_share = 1.0 / 3.0;
  reader.finish();
  return request;
}

}  // namespace

command::RealSensor OverlayRequest::ForceOffset::pressing(const std::string& arm, const command::Cell& cell,
                                                          const command::Biases& biases) const {
  return command::pressing_along(cell, sensor, wish.direction_M, cell.arms.find(arm)->second.X_FT, biases);
}

OverlayRequest read_overlay(ObjectReader& reader, const std::string& arm, const command::Cell& cell) {
  OverlayRequest overlay;
  Findings& findings = reader.findings();
  if (const Json* weave = reader.object("weave", false))
    overlay.weave = read_weave(*weave, reader.at("weave"), findings);
  if (const Json* force = reader.object("force_offset", false))
    overlay.force = read_force_offset(*force, reader.at("force_offset"), arm, cell, findings);
  if (overlay.weave && overlay.force)
    findings.error(reader.at("force_offset"), "a weave and a force offset", "one of them");
  return overlay;
}

}  // namespace takt::activity
