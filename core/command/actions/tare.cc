#include "core/command/actions/tare.h"

#include <string>

#include <nlohmann/json.hpp>

#include "core/command/actions/device_commands.h"
#include "core/expression/device_sensors.h"

namespace takt::command {
namespace {

/// A sensor that has been silent for so long is not waited for.
constexpr double kSilence_s = 0.5;

/// Averages readings of a sensor from the first cycle on. @param output  of the primitive: "bias", "done"
expression::ExpressionPtr tare_of(net::ValueType type, const expression::WrenchSensor& wrench, std::int64_t cycles,
                                  const char* output) {
  return expression::named(expression::apply(type, "Tare", {{"wrench", {.node = wrench.node()}}},
                                             {{"cycles", cycles}, {"trigger", true}}, output),
                           "tare");
}

}  // namespace

WaitCommand tare_command(const std::string& sensor, std::int64_t cycles, const expression::Cell& cell) {
  const expression::WrenchSensor wrench = expression::compensated_wrench(cell, sensor);
  const expression::State done(tare_of(net::ValueType::kBoolean, wrench, cycles, "done"));
  // Null readings are not averaged, so a dead sensor would keep the net for ever.
  const expression::State silent = expression::is_null(expression::force(wrench)).held_for(kSilence_s);
  WaitCommand tared("taring", done || silent);
  tared.observe(observed::kBias, expression::WrenchSensor(tare_of(net::ValueType::kWrench, wrench, cycles, "bias")));
  return tared;
}

}  // namespace takt::command
