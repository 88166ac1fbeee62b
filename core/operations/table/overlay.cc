#include "core/operations/table/overlay.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/operations/table/contact_figures.h"

namespace takt::operations {

command::ForceOffsetControlParameters ForceOffsetParameters::control_parameters(const expression::Cell& cell) const {
  command::ForceOffsetControlParameters control{
      .jerk_max = jerk_max, .direction_M = direction, .reach = reach, .retreat = retreat.value_or(reach)};
  control.lost_max = lost_max;
  control.off_max = off_max;
  control.force.force = force;
  control.force.approach_velocity = approach;
  control.force.velocity_max = velocity_max;
  control.force.acceleration_max = acceleration_max;
  control.force.gain = gain;
  set_contact_figures(control.force, cell, sensor);
  return control;
}

expression::RealSensor ForceOffsetParameters::pressing(const std::string& arm, const expression::Cell& cell,
                                                       const expression::Biases& biases) const {
  return command::pressing_along(cell, sensor, direction, cell.arms.find(arm)->second.X_FT, biases);
}

const ParameterTable<command::WeaveParameters>& weave_parameters() {
  using Weave = command::WeaveParameters;
  static const auto table = [] {
    ParameterTable<Weave> weave;
    weave
        .number("amplitude_m", "m", &Weave::amplitude, {.low = 0.0, .high = 1.0, .low_open = true},
                "Largest distance from the path.")
        .required()
        .number("frequency_Hz", "Hz", &Weave::frequency, {.low = 0.0, .high = 100.0, .low_open = true},
                "Oscillations in a second.")
        .required()
        .direction("direction", &Weave::direction_M, "Direction in the axes of the tool; any length but 0.")
        .number("ramp_s", "s", &Weave::ramp, {.low = 0.0, .high = 100.0, .low_open = true},
                "Time in which it grows at the start and fades at the end.")
        .rule([](Weave& p, const ReadContext&) { p.direction_M.normalize(); });
    return weave;
  }();
  return table;
}

const ParameterTable<ForceOffsetParameters>& force_offset_parameters() {
  using P = ForceOffsetParameters;
  static const auto table = [] {
    ParameterTable<P> offset;
    offset.name("sensor", NameOf::kSensor, &P::sensor, "Force/torque sensor on the arm.")
        .vector("direction", "", &P::direction, "Direction of the force in the axes of the tool; any length but 0.")
        .number("reach_m", "m", &P::reach, {.low = 0.0, .high = 1.0},
                "Largest distance from the path along the direction.")
        .number("retreat_m", "m", &P::retreat, {.low = 0.0, .high = 1.0},
                "Largest distance from the path against the direction.")
        .fallback("as reach_m")
        .number("force_N", "N", &P::force, {.low = 0.1, .high = 1000.0}, "Force that the tool exerts.")
        .required()
        .number("approach_m_s", "m/s", &P::approach, {.low = 0.0, .high = 0.1}, "Speed of the offset until contact.")
        .number("velocity_max_m_s", "m/s", &P::velocity_max, {.low = 0.0, .high = 1.0, .low_open = true},
                "Largest speed of the offset.")
        .number("acceleration_max_m_s2", "m/s^2", &P::acceleration_max, {.low = 0.0, .high = 10.0, .low_open = true},
                "Largest acceleration of the offset.")
        .number("jerk_max_m_s3", "m/s^3", &P::jerk_max, {.low = 0.0, .high = 1000.0, .low_open = true},
                "Largest jerk of the offset; where the motion leaves less, that, but no less than a quarter.")
        .number("lost_max_s", "s", &P::lost_max, {.low = 0.0, .high = 1e6},
                "Once it has touched it fails after so long without contact.")
        .number("off_force_max_s", "s", &P::off_max, {.low = 0.0, .high = 1e6},
                "Once it was at force it fails after so long farther than a tenth from it.")
        .fallback("no matter how long")
        .number("gain_m_s_per_N", "m/s/N", &P::gain, {.low = 0.0, .high = 1.0, .low_open = true},
                "Speed for each newton that is missing, at most twice what the arm allows.")
        .fallback("from the arm's stiffness and delay")
        .rule([](P& p, const ReadContext&) { p.direction.normalize(); });
    return offset;
  }();
  return table;
}

}  // namespace takt::operations
