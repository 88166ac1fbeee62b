#include "core/operations/overlay.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::activity {
command::RealSensor OverlayRequest::ForceOffset::pressing(const std::string& arm, const command::Cell& cell,
                                                          const command::Biases& biases) const {
  return command::pressing_along(cell, sensor, wish.direction_M, cell.arms.find(arm)->second.X_FT, biases);
}

OverlayRequest::ForceOffset::ForceOffset() {
  wish.force.approach_velocity = 0.005;
  wish.force.velocity_max = 0.02;
  wish.force.acceleration_max = 0.3;
  // As with "press": contact from a third of the wanted force on, and lost below a third of that.
  wish.force.release_share = 1.0 / 3.0;
}

const ParameterTable<command::WeaveWish>& weave_parameters() {
  using Weave = command::WeaveWish;
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

const ParameterTable<OverlayRequest::ForceOffset>& force_offset_parameters() {
  using Offset = OverlayRequest::ForceOffset;
  static const auto force = [](double command::ForceWish::*member) {
    return [member](Offset & p) -> auto& { return p.wish.force.*member; };
  };
  using command::ForceWish;
  static const auto table = [] {
    ParameterTable<Offset> offset;
    offset.name("sensor", NameOf::kSensor, &Offset::sensor, "Force/torque sensor on the arm.")
        .vector(
            "direction", "", [](Offset & p) -> auto& { return p.wish.direction_M; },
            "Direction of the force in the axes of the tool; any length but 0.")
        .number(
            "reach_m", "m", [](Offset & p) -> auto& { return p.wish.reach; }, {.low = 0.0, .high = 1.0},
            "Largest distance from the path along the direction.")
        .number(
            "retreat_m", "m", [](Offset & p) -> auto& { return p.wish.retreat; }, {.low = 0.0, .high = 1.0},
            "Largest distance from the path against the direction.")
        .fallback("as reach_m")
        .number("force_N", "N", force(&ForceWish::force), {.low = 0.1, .high = 1000.0}, "Force that the tool exerts.")
        .required()
        .number("approach_m_s", "m/s", force(&ForceWish::approach_velocity), {.low = 0.0, .high = 0.1},
                "Speed of the offset until contact.")
        .number("velocity_max_m_s", "m/s", force(&ForceWish::velocity_max), {.low = 0.0, .high = 1.0, .low_open = true},
                "Largest speed of the offset.")
        .number("acceleration_max_m_s2", "m/s^2", force(&ForceWish::acceleration_max),
                {.low = 0.0, .high = 10.0, .low_open = true}, "Largest acceleration of the offset.")
        .number(
            "jerk_max_m_s3", "m/s^3", [](Offset & p) -> auto& { return p.wish.jerk_max; },
            {.low = 0.0, .high = 1000.0, .low_open = true}, "Largest jerk of the offset.")
        .number("gain_m_s_per_N", "m/s/N", force(&ForceWish::gain), {.low = 0.0, .high = 1.0, .low_open = true},
                "Speed for each newton that is missing.")
        .rule([](Offset& p, const ReadContext& from) {
          p.wish.direction_M.normalize();
          if (!from.reader.has("retreat_m")) p.wish.retreat = p.wish.reach;
          p.wish.force.contact_force = 0.3 * p.wish.force.force;
        });
    return offset;
  }();
  return table;
}

}  // namespace takt::activity
