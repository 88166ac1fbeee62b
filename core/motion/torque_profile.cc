#include "core/motion/torque_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/motion/clock_bounds.h"
#include "core/motion/plan_checks.h"

namespace takt::motion {
namespace {

/// Of the torque limits, for plan and clock; the rest is for the controller, which corrects what the plan does not
/// know.
constexpr double kShareOfTorque = 0.95;
/// Of a torque limit: with less than that to move with, a joint carries its load but goes nowhere in any useful time.
constexpr double kLeastRoom = 0.02;

}  // namespace

void TorqueProfile::add(double s, const JointVector& q, const JointVector& first, const JointVector& second) {
  const kinematics::Chain::PathDynamics dynamics =
      chain_.path_dynamics(q, first, second, load_.gravity_B, load_.payload);
  nodes_.push_back({.s = s,
                    .inertial = dynamics.inertial,
                    .centrifugal = dynamics.centrifugal,
                    .viscous = chain_.damping().cwiseProduct(first),
                    .gravity = dynamics.gravity});
  if (load_.armature.size() != q.size()) return;
  nodes_.back().inertial += load_.armature.cwiseProduct(first);
  nodes_.back().centrifugal += load_.armature.cwiseProduct(second);
}

double TorqueProfile::room(int joint, double gravity) const {
  return kShareOfTorque * chain_.effort_limit()[joint] - std::abs(gravity) - chain_.friction()[joint];
}

Diagnostics TorqueProfile::overloads(const std::string& pointer) const {
  Diagnostics diagnostics;
  for (int i = 0; i < chain_.joint_count(); ++i) {
    const double limit = chain_.effort_limit()[i];
    if (!std::isfinite(limit)) continue;
    const auto heaviest = std::ranges::max_element(nodes_, {}, [i](const Node& n) { return std::abs(n.gravity[i]); });
    if (heaviest == nodes_.end() || room(i, heaviest->gravity[i]) > kLeastRoom * limit) continue;
    const char* unit = chain_.is_prismatic(i) ? "N" : "N m";
    diagnostics.error(
        Code::kLimitExceeded, pointer,
        fmt::format("joint '{}' cannot carry arm and load of {:.2f} kg: at {:.0f} % of the path it needs "
                    "{:.1f} {} to hold them and {:.1f} {} of friction",
                    chain_.joint_names()[static_cast<std::size_t>(i)], load_.payload.mass, 100.0 * heaviest->s,
                    std::abs(heaviest->gravity[i]), unit, chain_.friction()[i], unit),
        fmt::format("Keep it below {:.1f} {}: lighten the load, or choose a posture nearer to the base",
                    (kShareOfTorque - kLeastRoom) * limit, unit));
  }
  return diagnostics;
}

template <class Visit>
void TorqueProfile::look(const TimeLaw& law, Visit visit) const {
  if (nodes_.empty()) return;
  // Laws of many segments are made of the cells of their path; few segments are long.
  constexpr std::size_t kMany = 64;
  const int parts = law.segments().size() > kMany ? 1 : kPartsPerSegment;
  std::size_t cell = 0;
  for (const LawPoint& at : instants(law, parts)) {
    while (cell + 2 < nodes_.size() && at.s >= nodes_[cell + 1].s) ++cell;
    const Node& a = nodes_[cell];
    const Node& b = nodes_[std::min(cell + 1, nodes_.size() - 1)];
    const double t = b.s > a.s ? std::clamp((at.s - a.s) / (b.s - a.s), 0.0, 1.0) : 0.0;
    const auto between = [t](double x, double y) { return x + t * (y - x); };
    for (int i = 0; i < chain_.joint_count(); ++i) {
      if (!std::isfinite(chain_.effort_limit()[i])) continue;
      const double m = between(a.inertial[i], b.inertial[i]);
      const double c = between(a.centrifugal[i], b.centrifugal[i]);
      visit(at.s, std::max(room(i, between(a.gravity[i], b.gravity[i])), kLeastRoom * chain_.effort_limit()[i]),
            std::abs(m * at.ds), std::abs(m * at.dds + c * at.ds * at.ds),
            std::abs(between(a.viscous[i], b.viscous[i]) * at.ds));
    }
  }
}

TorqueProfile::Need TorqueProfile::need(const TimeLaw& law, double share) const {
  Need most;
  look(law, [&](double s, double room, double, double second, double viscous) {
    // A law stretched by k asks for second / k^2 of what viscous / k leaves: share (room - viscous / k) k^2 = second.
    // Nearly all need less than the most, which is asked without root; what is next to it by rounding is looked at.
    constexpr double kRounding = 1e-12;
    if (share * (room * most.stretch - viscous) * most.stretch > second * (1.0 + kRounding)) return;
    const double k = (share * viscous + std::sqrt(share * share * viscous * viscous + 4.0 * share * room * second)) /
                     (2.0 * share * room);
    if (k > most.stretch) most = {.stretch = k, .s = s};
  });
  return most;
}

ClockBounds TorqueProfile::clock(const TimeLaw& law) const {
  ClockSearch search;
  look(law, [&](double, double room, double first, double second, double viscous) {
    const double left = std::max(room - viscous, second);
    if (left <= 0.0) return;
    search.add({.first_by_acceleration = first / left,
                .second_by_acceleration = second / left,
                .first_by_jerk = 0.0,
                .second_by_jerk = 0.0,
                .third_by_jerk = 0.0});
  });
  ClockBounds bounds = search.bounds();
  bounds.stop = stop_table(law);
  return bounds;
}

StopTable TorqueProfile::stop_table(const TimeLaw& law) const {
  StopTable table;
  std::vector<StopLoad> loads;
  const FastestOf fastest(law);
  for (std::size_t k = 0; k + 1 < nodes_.size(); ++k) {
    if (!(nodes_[k + 1].s > nodes_[k].s)) continue;
    const double speed = fastest.between(nodes_[k].s, nodes_[k + 1].s);
    loads.clear();
    for (const std::size_t at : {k, k + 1}) {
      const Node& node = nodes_[at];
      for (int i = 0; i < chain_.joint_count(); ++i) {
        const double limit = chain_.effort_limit()[i];
        if (!std::isfinite(limit)) continue;
        const double left = room(i, node.gravity[i]) - std::abs(node.viscous[i]) * speed;
        loads.push_back({.first = std::abs(node.inertial[i]),
                         .along = node.inertial[i] < 0.0 ? -node.centrifugal[i] : node.centrifugal[i],
                         .acceleration = std::max(left, kLeastRoom * limit)});
      }
    }
    table.push_back(stop_cell(loads, speed, nodes_[k + 1].s));
  }
  if (!table.empty()) table.back().s_end = 1.0;
  return table;
}

}  // namespace takt::motion
