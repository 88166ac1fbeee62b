#include "core/operations/online_parameters.h"

#include <fmt/format.h>

namespace takt::activity {
namespace {

template <class P>
ParameterTable<P> ended_parameters() {
  ParameterTable<P> table;
  table.name("arm", NameOf::kArm, &P::arm, "Arm that moves.")
      .number("seconds", "s", &P::seconds, {.low = 0.0, .high = 3600.0}, "Ends after this time.")
      .condition("until", &P::until, "Ends when this becomes true.")
      .compliance(&P::compliance);
  return table;
}

template <class P>
void add_bounds(ParameterTable<P>& table) {
  table
      .number(
          "linear_max_m_s", "m/s", [](P & p) -> auto& { return p.bounds.linear_max; },
          {.low = 0.0, .high = 1.0, .low_open = true}, "Largest speed of the tool.")
      .number(
          "angular_max_deg_s", "deg/s", [](P & p) -> auto& { return p.bounds.angular_max; },
          {.low = 0.0, .high = 180.0, .low_open = true}, "Largest angular speed of the tool.");
}

/// A channel by its name. Its type can only be checked where channels are known.
void check_channel(const std::string& name, net::ValueType type, const ReadContext& from) {
  const auto found = from.cell.channels.find(name);
  Diagnostics& diagnostics = from.reader.diagnostics();
  if (found == from.cell.channels.end()) {
    std::vector<std::string> names;
    for (const auto& [one, channel] : from.cell.channels) {
      if (channel == nullptr || channel->description().type == type) names.push_back(one);
    }
    diagnostics.error(
        Code::kUnknownName, from.reader.at("channel"), fmt::format("there is no channel '{}'", name),
        names.empty() ? fmt::format("the cell has none of type {}", net::name_of(type)) : nearest_choice(name, names));
  } else if (found->second != nullptr && found->second->description().type != type) {
    diagnostics.error(Code::kTypeMismatch, from.reader.at("channel"),
                      fmt::format("'{}' carries {}", name, net::name_of(found->second->description().type)),
                      fmt::format("a channel of type {}", net::name_of(type)));
  }
}

void check_jog(JogParameters& jog, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  const bool velocity = jog.linear || jog.angular;
  if (jog.channel) check_channel(*jog.channel, net::ValueType::kTwist, from);
  if (jog.channel && velocity) {
    reader.diagnostics().error(Code::kConflict, reader.at(jog.linear ? "linear_m_s" : "angular_deg_s"),
                               "a velocity from a channel and a velocity", "one of them");
  }
  if (!jog.channel && !velocity) {
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "no velocity is given",
                               "'channel', 'linear_m_s' or 'angular_deg_s'");
  }
}

void check_follow(FollowParameters& follow, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  if (follow.channel) {
    check_channel(*follow.channel, net::ValueType::kFrame, from);
    if (follow.in.empty()) follow.in = "world";
  } else if (follow.in.empty()) {
    reader.diagnostics().error(Code::kMissing, reader.at("in"), "nothing to follow is given",
                               "'in' (a frame), or 'channel'");
  }
}

}  // namespace

const ParameterTable<OnlineParameters>& hold_parameters() {
  static const auto table = ended_parameters<OnlineParameters>();
  return table;
}

const ParameterTable<JogParameters>& jog_parameters() {
  static const auto table = [] {
    auto jog = ended_parameters<JogParameters>();
    add_bounds(jog);
    jog.text("in", &JogParameters::in, "Frame along whose axes the velocity is; \"tcp\": those of the tool.")
        .optional_text("channel", &JogParameters::channel, "Channel of type Twist that gives the velocity.")
        .vector("linear_m_s", "m/s", &JogParameters::linear, "Velocity of the tool centre point.")
        .vector("angular_deg_s", "deg/s", &JogParameters::angular, "Angular velocity of the tool.")
        .condition("while", &JogParameters::enabled, "Dead-man switch: the arm moves only while this is true.")
        .required()
        .rule(check_jog);
    return jog;
  }();
  return table;
}

const ParameterTable<FollowParameters>& follow_parameters() {
  static const auto table = [] {
    auto follow = ended_parameters<FollowParameters>();
    add_bounds(follow);
    follow.optional_text("channel", &FollowParameters::channel, "Channel of type Frame: the pose of the tool in 'in'.")
        .text("in", &FollowParameters::in, "Frame that the tool follows; with a channel the frame of its poses.")
        .rule(check_follow);
    return follow;
  }();
  return table;
}

}  // namespace takt::activity
