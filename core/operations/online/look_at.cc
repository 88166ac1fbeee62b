#include "core/operations/online/look_at.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/look_action.h"
#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/expression/moving_frames.h"
#include "core/operations/command/command_step.h"

namespace takt::operations {
namespace {

constexpr const char* kOutOfReach = " out of reach";
/// Of `in_view`, m and rad.
constexpr double kInViewDistance = 0.005, kInViewAngle = std::numbers::pi / 180.0;

void check_look_at(LookAtParameters& look, const ReadContext& from) {
  for (const auto& [key, name] :
       {std::pair("distance_channel", look.distance_channel), std::pair("azimuth_channel", look.azimuth_channel),
        std::pair("elevation_channel", look.elevation_channel)}) {
    if (name) check_channel(*name, net::ValueType::kReal, from, key);
  }
}

class LookAtCommand final : public OnlineCommand {
 public:
  explicit LookAtCommand(LookAtParameters parameters) : OnlineCommand(parameters), look_(std::move(parameters)) {}

  /// What rides on the arm itself cannot be followed by it.
  void check(const expression::Cell& cell, Diagnostics& diagnostics) const override {
    for (const auto& [key, frame] : {std::pair("/at", look_.at), std::pair("/in", look_.in)}) {
      if (!expression::movers_between(cell.frames, frame, look_.arm).contains(look_.arm)) continue;
      diagnostics.error(Code::kConflict, pointer + key, fmt::format("'{}' rides on '{}' itself", frame, look_.arm),
                        "Name a frame that this arm does not move");
    }
  }

  void finish(const activity::RunView& ended, const std::string& key, bool, activity::Context&,
              Diagnostics& diagnostics) const override {
    if (!look_.must_reach || !ended.was_true(key + kOutOfReach)) return;
    diagnostics.error(Code::kUnreachable, pointer,
                      fmt::format("'{}' cannot look at '{}' from there", look_.arm, look_.at),
                      "Choose another distance or other angles, or set \"on_unreachable\": \"rest\"");
  }

 private:
  [[nodiscard]] command::Action action_of(const BuildContext& context) const override {
    const expression::Cell& cell = context.cell;
    command::TrackingParameters own = tool_limits(look_);
    own.distance = kInViewDistance;
    own.angle = kInViewAngle;
    return command::look_at({.X_BW = expression::pose_between(cell, look_.at, look_.arm),
                             .V_BW_B = velocity(cell, look_.at),
                             .X_BU = expression::pose_between(cell, look_.in, look_.arm),
                             .V_BU_B = velocity(cell, look_.in)},
                            {.distance = figure(cell, look_.distance_channel, look_.distance),
                             .azimuth = figure(cell, look_.azimuth_channel, look_.azimuth),
                             .elevation = figure(cell, look_.elevation_channel, look_.elevation),
                             .roll = look_.roll,
                             .linear_max = look_.orbit_linear_max,
                             .angular_max = look_.orbit_angular_max},
                            own);
  }
  void add_ends(MadeCommand& made, const BuildContext& context, const std::string& key) const override {
    const expression::State unreachable = made.action->state("unreachable");
    made.command.observe(key + kOutOfReach, expression::BooleanSensor(unreachable.node()));
    if (look_.must_reach) {
      made.command.on_entered(unreachable, cancel(made.command));
      made.command.fails_if(unreachable.once());
      made.handler_places.emplace_back("/on_unreachable");
    } else if (context.tell) {
      made.command.on_entered(unreachable, command::external("the perspective is out of reach", context.tell));
      made.handler_places.emplace_back("/on_unreachable");
    }
  }

  [[nodiscard]] std::optional<expression::TwistSensor> velocity(const expression::Cell& cell,
                                                                const std::string& frame) const {
    if (!expression::moves(cell.frames, frame, look_.arm)) return std::nullopt;
    return expression::twist_between(cell, frame, look_.arm);
  }
  /// A number; or a channel, and until that has a value the number.
  static expression::RealTerm figure(const expression::Cell& cell, const std::optional<std::string>& channel,
                                     double number) {
    if (!channel) return number;
    return expression::RealSensor(expression::apply(
        net::ValueType::kReal, "DefaultToReal",
        {{"input", {.node = expression::channel<net::Real>(cell, *channel).node()}}}, {{"fallback", number}}));
  }

  LookAtParameters look_;
};

}  // namespace

const ParameterTable<LookAtParameters>& look_at_parameters() {
  using P = LookAtParameters;
  static const auto table = [] {
    const std::vector<std::pair<std::string, bool>> ends{{"rest", false}, {"fail", true}};
    auto look = online_parameters<P>();
    add_tool_limits(look);
    look.text("at", &P::at, "Frame whose origin is kept in the middle of the picture.")
        .required()
        .text("in", &P::in, "Frame whose z is up and from whose x the azimuth counts.")
        .number("distance_m", "m", &P::distance, {.low = 0.05, .high = 5.0}, "From the frame to the camera.")
        .number("azimuth_deg", "deg", &P::azimuth, {.low = -360.0, .high = 360.0}, "Of the camera, about z of 'in'.")
        .number("elevation_deg", "deg", &P::elevation, {.low = -90.0, .high = 90.0},
                "Of the camera, above the x-y plane of 'in'.")
        .number("roll_deg", "deg", &P::roll, {.low = -180.0, .high = 180.0}, "Of the camera about its line of sight.")
        .text("distance_channel", &P::distance_channel, "Channel of type Real, in m, that gives the distance.")
        .text("azimuth_channel", &P::azimuth_channel, "Channel of type Real, in rad, that gives the azimuth.")
        .text("elevation_channel", &P::elevation_channel, "Channel of type Real, in rad, that gives the elevation.")
        .number("orbit_linear_max_m_s", "m/s", &P::orbit_linear_max, {.low = 0.0, .high = 1.0, .low_open = true},
                "How fast the distance may change.")
        .number("orbit_angular_max_deg_s", "deg/s", &P::orbit_angular_max,
                {.low = 0.0, .high = 180.0, .low_open = true}, "How fast azimuth and elevation may change.")
        .choice("on_unreachable", &P::must_reach, ends,
                "Whether it rests or fails where the arm cannot look from there.")
        .rule(check_look_at);
    return look;
  }();
  return table;
}

std::unique_ptr<OperationCommand> look_at_command(const LookAtParameters& parameters) {
  return std::make_unique<LookAtCommand>(parameters);
}

Operation look_at_operation() {
  return {.name = "look_at",
          .doc = "A camera on an arm keeps a frame in the middle of its picture, from a distance and at two angles.",
          .parameters = rows_of<look_at_parameters>,
          .read_step = step_of_command,
          .read_command = read_command<LookAtCommand, look_at_parameters>};
}

}  // namespace takt::operations
