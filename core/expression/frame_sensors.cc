#include "core/expression/frame_sensors.h"

#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/expression/device_sensors.h"
#include "core/net/value_json.h"

namespace takt::expression {

TwistSensor shift(const TwistSensor& twist, const VectorTerm& way) {
  return TwistSensor(
      apply(net::ValueType::kTwist, "ShiftTwist", {{"twist", {.node = twist.node()}}, {"point", way.operand()}}));
}

namespace {

using Eigen::Isometry3d;
using world::Relation;

/// Pose of B in A, and B's velocity in A where there is one: at its origin, in the axes of A.
struct Place {
  Isometry3d constant = Isometry3d::Identity();  ///< while `X_AB` is empty
  std::optional<FrameSensor> X_AB;
  std::optional<TwistSensor> V_AB_A;

  [[nodiscard]] FrameTerm term() const { return X_AB ? FrameTerm(*X_AB) : FrameTerm(constant); }
};

TwistSensor scaled(const TwistSensor& twist, double factor) {
  return TwistSensor(apply(net::ValueType::kTwist, "ScaleTwist",
                           {{"twist", {.node = twist.node()}}, {"factor", RealTerm(factor).operand()}}));
}
VectorTerm origin(const Place& place) {
  if (place.X_AB) return position(*place.X_AB);
  return Eigen::Vector3d(place.constant.translation());
}

/// X_AC and V_AC from those of B in A and of C in B.
Place compose(const Place& b, const Place& c) {
  if (!b.X_AB && !c.X_AB) return {.constant = b.constant * c.constant, .X_AB = {}, .V_AB_A = {}};
  Place result{.constant = {}, .X_AB = b.term() * c.term(), .V_AB_A = {}};
  if (b.V_AB_A) result.V_AB_A = shift(*b.V_AB_A, rotate(b.term(), origin(c)));
  if (c.V_AB_A) {
    const TwistSensor inner = rotate(b.term(), *c.V_AB_A);
    result.V_AB_A = result.V_AB_A ? *result.V_AB_A + inner : inner;
  }
  return result;
}

/// A in B from B in A.
Place inverse(const Place& b) {
  if (!b.X_AB) return {.constant = b.constant.inverse(), .X_AB = {}, .V_AB_A = {}};
  Place result{.constant = {}, .X_AB = inverse(*b.X_AB), .V_AB_A = {}};
  if (b.V_AB_A) {
    const VectorSensor back = RealTerm(-1.0) * position(*b.X_AB);
    result.V_AB_A = scaled(rotate(*result.X_AB, shift(*b.V_AB_A, back)), -1.0);
  }
  return result;
}

TwistSensor flange_twist(const Cell& cell, const std::string& arm, const Isometry3d& X_FM) {
  auto node = std::make_shared<Expression>(*flange_fixed_pose(cell, arm, X_FM).node());
  if (node->fault)
    return TwistSensor(broken(node->fault->code, net::ValueType::kTwist, node->fault->message, node->fault->hint));
  node->type = net::ValueType::kTwist;
  node->output = "twist";
  node->inputs.emplace_back("dq", measured_velocities(cell, arm).node());
  node->primitive.id = id_of("twist", arm);
  return TwistSensor(node);
}

/// A frame in its parent.
Place in_parent(const Cell& cell, const Relation& relation) {
  switch (relation.kind) {
    case Relation::Kind::kFlange:
      return {.constant = {},
              .X_AB = flange_fixed_pose(cell, relation.source, relation.X_PF),
              .V_AB_A = flange_twist(cell, relation.source, relation.X_PF)};
    case Relation::Kind::kLink:
      return {.constant = {},
              .X_AB = link_fixed_pose(cell, relation.source, relation.link, relation.X_PF),
              .V_AB_A = link_fixed_twist(cell, relation.source, relation.link, relation.X_PF)};
    case Relation::Kind::kChannel:
      return compose({.constant = {},
                      .X_AB = channel<net::Frame>(cell, relation.source),
                      .V_AB_A = channel_twist(cell, relation.source)},
                     {.constant = relation.X_PF, .X_AB = {}, .V_AB_A = {}});
    default:
      return {.constant = relation.X_PF, .X_AB = {}, .V_AB_A = {}};
  }
}

std::vector<const Relation*> way_to_world(const Cell& cell, const std::string& frame) {
  std::vector<const Relation*> way;
  for (const Relation* at = cell.frames.relation(frame); at != nullptr; at = cell.frames.relation(at->parent)) {
    way.push_back(at);
  }
  return way;
}

/// The first frame of the path in the parent of the last of the first `count` ones.
Place along(const Cell& cell, const std::vector<const Relation*>& way, std::size_t count) {
  Place place;
  for (std::size_t i = 0; i < count; ++i) place = compose(in_parent(cell, *way[i]), place);
  return place;
}

/// @return nothing if a frame is not there, or nobody knows where it is.
std::optional<Place> between(const Cell& cell, const std::string& of, const std::string& in) {
  if (!cell.knows(of) || !cell.knows(in)) return std::nullopt;
  const auto from = way_to_world(cell, of), to = way_to_world(cell, in);
  std::size_t shared = 0;
  while (shared < from.size() && shared < to.size() && from[from.size() - 1 - shared] == to[to.size() - 1 - shared]) {
    ++shared;
  }
  return compose(inverse(along(cell, to, to.size() - shared)), along(cell, from, from.size() - shared));
}

ExpressionPtr unknown(const Cell& cell, net::ValueType type, const std::string& of, const std::string& in) {
  for (const std::string& name : {of, in}) {
    if (cell.frames.contains(name) && !cell.knows(name))
      return broken(Code::kUnknownPose, type, fmt::format("it is not known where '{}' is", name), "Measure it before");
  }
  const std::string& name = cell.frames.contains(of) ? in : of;
  return broken(Code::kUnknownName, type, "there is no frame '" + name + "'",
                nearest_choice(name, cell.frames.names()));
}

}  // namespace

TwistSensor channel_twist(const Cell& cell, const std::string& name) {
  constexpr double kOldest = 0.5;  // s; where values come more rarely, it is unknown
  auto node = std::make_shared<Expression>(*channel<net::Frame>(cell, name).node());
  if (node->fault)
    return TwistSensor(broken(node->fault->code, net::ValueType::kTwist, node->fault->message, node->fault->hint));
  const Nanoseconds timeout = cell.channels.find(name)->second->description().timeout;
  node->type = net::ValueType::kTwist;
  node->output = "twist";
  node->primitive = {.id = id_of("channel", name) + "-twist",
                     .type = "FrameChannelTwist",
                     .parameters = {{"channel", name}, {"age_max", timeout > 0 ? to_seconds(timeout) : kOldest}}};
  return TwistSensor(node);
}

FrameSensor pose_between(const Cell& cell, const std::string& of, const std::string& in) {
  const auto place = between(cell, of, in);
  if (!place) return FrameSensor(unknown(cell, net::ValueType::kFrame, of, in));
  if (place->X_AB) return *place->X_AB;
  return FrameSensor(apply(net::ValueType::kFrame, "ConstantFrame", {{"value", FrameTerm(place->constant).operand()}}));
}

TwistSensor twist_between(const Cell& cell, const std::string& of, const std::string& in) {
  const auto place = between(cell, of, in);
  if (!place) return TwistSensor(unknown(cell, net::ValueType::kTwist, of, in));
  if (place->V_AB_A) return *place->V_AB_A;
  return TwistSensor(
      apply(net::ValueType::kTwist, "ConstantTwist", {{"value", Term<net::Twist>(net::Twist{}).operand()}}));
}

}  // namespace takt::expression
