#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/kinematics/chain.h"

namespace takt::kinematics {
namespace {

/// A rotation that takes z onto `axis`; exact for axes along x, y, z, so that round models keep round numbers.
Eigen::Matrix3d z_onto(const Eigen::Vector3d& axis) {
  Eigen::Index smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix3d R;
  R.col(2) = axis;
  R.col(0) = Eigen::Vector3d::Unit(smallest).cross(axis).normalized();
  R.col(1) = axis.cross(R.col(0));
  if (axis == Eigen::Vector3d::UnitZ()) R.setIdentity();
  return R;
}

}  // namespace

/// Walks the tree once and fills a Chain.
struct ChainBuilder {
  const RobotModel& model;
  const std::string& base;
  const std::string& flange;
  std::span<const std::string> rolling;
  Diagnostics diagnostics;
  std::vector<const Joint*> path;  ///< from the base to the flange, fixed ones included

  /// Where a link of the subtree hangs: the movable joint that carries it (-1 = base) and its frame in that joint's.
  struct Place {
    int segment = -1;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  };

  bool known(const std::string& link, std::string_view role) {
    if (model.link(link) != nullptr) return true;
    std::vector<std::string> names;
    for (const Link& candidate : model.links) names.push_back(candidate.name);
    diagnostics.error(Code::kUnknownName, {},
                      fmt::format("{} link '{}' does not exist in robot '{}'", role, link, model.name),
                      nearest_choice(link, names));
    return false;
  }

  bool find_path() {
    const bool both = known(base, "base") & known(flange, "flange");
    if (!both) return false;
    for (std::string link = flange; link != base;) {
      const Joint* joint = model.joint_above(link);
      if (joint == nullptr) {
        diagnostics.error(Code::kInvalidValue, {}, fmt::format("link '{}' does not lie below link '{}'", flange, base),
                          "Put the flange below the base, joined by joints");
        return false;
      }
      path.insert(path.begin(), joint);
      link = joint->parent;
    }
    return check_count();
  }

  bool check_count() {
    const auto count =
        std::count_if(path.begin(), path.end(), [](const Joint* j) { return j->type != JointType::kFixed; });
    if (count == 0)
      diagnostics.error(Code::kMissing, {}, fmt::format("no movable joint between '{}' and '{}'", base, flange));
    if (count > kMaxJoints)
      diagnostics.error(Code::kInvalidValue, {},
                        fmt::format("{} movable joints between '{}' and '{}'", count, base, flange),
                        fmt::format("Keep it to at most {}", kMaxJoints));
    return count > 0 && count <= kMaxJoints;
  }

  /// Appends a joint to the chain; X is its frame J (q = 0) in the frame of the segment before.
  Place add_segment(Chain& chain, const Joint& joint, const Eigen::Isometry3d& X) const {
    const Eigen::Matrix3d turn = z_onto(joint.axis);
    Chain::Segment& segment = chain.segments_[static_cast<std::size_t>(chain.count_)];
    segment.R = X.linear() * turn;
    segment.p = X.translation();
    segment.prismatic = joint.type == JointType::kPrismatic;
    if (chain.count_ > 0) chain.reach_ += segment.p.norm();
    chain.names_.push_back(joint.name);
    Place place{chain.count_++, Eigen::Isometry3d::Identity()};
    place.X.linear() = turn.transpose();
    return place;
  }

  void add_body(Chain& chain, const Link& link, const Place& place) const {
    if (!link.inertial) return;
    chain.total_mass_ += link.inertial->mass;
    if (place.segment < 0) return;
    chain.segments_[static_cast<std::size_t>(place.segment)].body +=
        SpatialInertia::at(link.inertial->mass, place.X * link.inertial->X_LC, link.inertial->I_C);
  }

  void fill(Chain& chain) {
    std::map<std::string, Place> places{{base, Place{}}};
    add_body(chain, *model.link(base), Place{});
    // Parents stand before their children in the model, so one pass reaches the whole subtree.
    for (std::size_t i = 0; i < model.joints.size(); ++i) {
      const Joint& joint = model.joints[i];
      const auto parent = places.find(joint.parent);
      if (parent == places.end() || joint.child == base) continue;
      Place place{parent->second.segment, parent->second.X * joint.X_PJ};
      const bool on_path = std::ranges::find(path, &joint) != path.end();
      const bool rolls = std::ranges::find(rolling, joint.name) != rolling.end();
      if (joint.type != JointType::kFixed && on_path) {
        place = add_segment(chain, joint, place.X);
      } else if (joint.type != JointType::kFixed && !rolls) {
        diagnostics.error(
            Code::kInvalidValue, {},
            fmt::format("joint '{}' moves beside or beyond the chain from '{}' to '{}'", joint.name, base, flange),
            "Fix it, or choose a base link below which there is one chain");
        continue;
      }
      places[joint.child] = place;
      add_body(chain, model.links[i + 1], place);
    }
    chain.X_LF_ = places.at(flange).X;
    chain.reach_ += chain.X_LF_.translation().norm();
    fill_limits(chain);
  }

  void fill_limits(Chain& chain) const {
    for (JointVector* v : {&chain.lower_, &chain.upper_, &chain.velocity_limit_, &chain.effort_limit_, &chain.damping_,
                           &chain.friction_})
      v->resize(chain.count_);
    Eigen::Index i = 0;
    for (const Joint* joint : path) {
      if (joint->type == JointType::kFixed) continue;
      chain.lower_[i] = joint->lower;
      chain.upper_[i] = joint->upper;
      chain.velocity_limit_[i] = joint->velocity;
      chain.effort_limit_[i] = joint->effort;
      chain.damping_[i] = joint->damping;
      chain.friction_[i] = joint->friction;
      ++i;
    }
  }
};

Result<Chain> Chain::create(const RobotModel& model, const std::string& base_link, const std::string& flange_link,
                            std::span<const std::string> rolling) {
  ChainBuilder builder{model, base_link, flange_link, rolling, {}, {}};
  if (!builder.find_path()) return std::unexpected(std::move(builder.diagnostics));
  Chain chain;
  builder.fill(chain);
  if (builder.diagnostics.has_errors()) return std::unexpected(std::move(builder.diagnostics));
  return chain;
}

}  // namespace takt::kinematics
