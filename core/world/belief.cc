#include "core/world/belief.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace takt::world {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Kind = Relation::Kind;

/// How an object hangs on the flange of the arm that holds it. @param X_BO  where it is now, in the arm's base
Relation on_flange(const Hold& hold, const std::optional<Isometry3d>& X_BO) {
  return {.kind = Kind::kFlange, .parent = hold.arm, .X_PF = hold.X_FO, .source = hold.arm, .X_seen = X_BO};
}

std::optional<Isometry3d> known(const Result<Isometry3d>& X) { return X ? std::optional(*X) : std::nullopt; }

/// The share of one of several holders: at rest the weight alone counts, so each bears a point mass where it holds.
MassProperties share_of(const MassProperties& whole, const Hold& hold, std::size_t holders) {
  if (holders == 1) return transform(hold.X_FO, whole);
  return {whole.mass / static_cast<double>(holders), hold.p_FG, Eigen::Matrix3d::Zero()};
}

/// The least distance of these points to an object that stands at X_WO, m.
double least_distance(const std::vector<Vector3d>& points_W, const Object& object, const Isometry3d& X_WO) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3d& p : points_W) least = std::min(least, std::abs(signed_distance(object, X_WO.inverse() * p)));
  return least;
}

/// The outline of an object as far as it lies below a height.
std::vector<Vector3d> outline_below(const Object& object, const Isometry3d& X_WO, double height) {
  std::vector<Vector3d> points = outline(object);
  for (Vector3d& p : points) p = X_WO * p;
  std::erase_if(points, [&](const Vector3d& p) { return p.z() >= height; });
  return points;
}

}  // namespace

bool Belief::knows(std::string_view frame) const {
  if (frame == FrameGraph::kWorld) return true;
  if (!frames.contains(frame)) return false;
  return std::ranges::none_of(frames.path_to_world(frame),
                              [&](std::string_view name) { return frames.relation(name)->kind == Kind::kUnknown; });
}

std::optional<Carrier> Belief::carrier_of(std::string_view frame) const {
  Isometry3d X = Isometry3d::Identity();
  for (const std::string_view name : frames.path_to_world(frame)) {
    const Relation& relation = *frames.relation(name);
    X = relation.X_PF * X;
    if (relation.rides_on_arm()) return Carrier{relation.source, X, relation.link};
    if (relation.kind == Kind::kChannel || relation.kind == Kind::kUnknown) return std::nullopt;
  }
  return std::nullopt;
}

std::vector<std::string> Belief::holders_of(std::string_view object) const {
  std::vector<std::string> grippers;
  for (const auto& [gripper, hold] : held)
    if (!object.empty() && hold.object == object) grippers.push_back(gripper);
  return grippers;
}

bool Belief::is_held(std::string_view object) const {
  const auto path = frames.path_to_world(object);
  return std::ranges::any_of(path, [&](std::string_view name) { return !holders_of(name).empty(); });
}

std::vector<std::string> Belief::riders(std::string_view frame) const {
  std::vector<std::string> names;
  for (const auto& [name, object] : objects)
    if (name != frame && frames.contains(name) && frames.depends_on(name, frame)) names.push_back(name);
  return names;
}

MassProperties Belief::mass_of(const std::string& object) const {
  const auto found = objects.find(object);
  if (found == objects.end()) return {};
  MassProperties sum = found->second.mass;
  for (const std::string& rider : riders(object)) {
    const auto X_OR = frames.pose(rider, object);
    if (X_OR) sum = combine(sum, transform(*X_OR, objects.find(rider)->second.mass));
  }
  return sum;
}

MassProperties Belief::load_in(const std::string& gripper) const {
  const auto found = held.find(gripper);
  if (found == held.end()) return {};
  const Hold& hold = found->second;
  const MassProperties whole = mass_of(hold.object);
  if (whole.mass > 0.0) return share_of(whole, hold, holders_of(hold.object).size());
  return {.mass = hold.mass, .p_OC = hold.p_FG};  // of what no file describes only what the program said is known
}

MassProperties Belief::load_of(std::string_view arm) const {
  MassProperties sum;
  for (const auto& [gripper, hold] : held)
    if (hold.arm == arm) sum = combine(sum, load_in(gripper));
  return sum;
}

std::optional<std::string> Belief::free_object_at(const Vector3d& p_W, double within) const {
  std::optional<std::string> nearest;
  double least = within;
  for (const auto& [name, object] : objects) {
    const auto X_WO = frames.pose(name);
    if (object.fixed || is_held(name) || !X_WO) continue;
    const double distance = signed_distance(object, X_WO->inverse() * p_W);
    if (distance > least) continue;
    least = distance;
    nearest = name;
  }
  return nearest;
}

std::optional<std::string> Belief::support_of(const std::string& object, const Isometry3d& X_WO, double within) const {
  const auto lying = objects.find(object);
  if (lying == objects.end()) return std::nullopt;
  const double centre = (X_WO * lying->second.mass.p_OC).z();
  const auto below = outline_below(lying->second, X_WO, centre);
  std::optional<std::string> support;
  double least = within;
  for (const auto& [name, other] : objects) {
    const auto X_WS = frames.pose(name);
    if (name == object || !X_WS || frames.depends_on(name, object)) continue;
    // Corners of either may be what touches: a plate lies on a pin with none of its own.
    std::vector<Vector3d> its = outline_below(other, *X_WS, centre);
    const double distance = std::min(least_distance(below, other, *X_WS), least_distance(its, lying->second, X_WO));
    if (distance >= least) continue;
    least = distance;
    support = name;
  }
  return support;
}

Diagnostics Belief::take(const std::string& gripper, const Hold& hold) {
  Diagnostics diagnostics;
  const bool first = holders_of(hold.object).empty();
  if (!hold.object.empty() && first)
    diagnostics = frames.set(hold.object, on_flange(hold, known(frames.pose(hold.object, hold.arm))));
  if (!diagnostics.has_errors()) held[gripper] = hold;
  return diagnostics;
}

Result<std::optional<Hold>> Belief::let_go(const std::string& gripper, const Isometry3d& X_WO,
                                           const std::string& onto) {
  const auto found = held.find(gripper);
  if (found == held.end()) return std::nullopt;
  const Hold hold = found->second;
  held.erase(found);
  if (hold.object.empty()) return hold;
  Diagnostics diagnostics;
  if (const auto others = holders_of(hold.object); !others.empty()) {
    const Hold& other = held.find(others.front())->second;
    const auto X_WB = frames.pose(other.arm);
    const auto X_BO = X_WB ? std::optional<Isometry3d>(X_WB->inverse() * X_WO) : std::nullopt;
    diagnostics = frames.set(hold.object, on_flange(other, X_BO));
  } else if (const auto X_WP = frames.pose(onto); X_WP) {
    diagnostics = frames.set(hold.object, {.kind = Kind::kEstimate, .parent = onto, .X_PF = X_WP->inverse() * X_WO});
  } else {
    diagnostics = X_WP.error();
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return hold;
}

std::string Belief::standing_on(std::string_view object) const {
  const Relation* relation = frames.relation(object);
  const bool stands = relation != nullptr && (relation->kind == Kind::kFixed || relation->kind == Kind::kEstimate);
  return stands ? relation->parent : std::string(FrameGraph::kWorld);
}

Diagnostics Belief::found(const std::string& object, const Isometry3d& X_WO) {
  const auto holders = holders_of(object);
  if (holders.empty()) {
    const std::string parent = standing_on(object);
    const auto X_WP = frames.pose(parent);
    if (!X_WP) return X_WP.error();
    return frames.set(object, {.kind = Kind::kEstimate, .parent = parent, .X_PF = X_WP->inverse() * X_WO});
  }
  const auto X_WO_before = frames.pose(object);
  if (!X_WO_before) return X_WO_before.error();
  const Isometry3d correction = X_WO_before->inverse() * X_WO;
  for (const std::string& gripper : holders)
    held.find(gripper)->second.X_FO = held.find(gripper)->second.X_FO * correction;
  Relation relation = *frames.relation(object);
  relation.X_PF = relation.X_PF * correction;
  if (relation.X_seen) relation.X_seen = *relation.X_seen * correction;
  return frames.set(object, relation);
}

void Belief::lose(std::string_view object) {
  std::erase_if(held, [&](const auto& one) { return one.second.object == object; });
  if (!frames.contains(object) || object == FrameGraph::kWorld) return;
  // It depends on the world, which is always there.
  (void)frames.set(std::string(object), {.kind = Kind::kUnknown, .parent = std::string(FrameGraph::kWorld)});
}

}  // namespace takt::world
