#include "core/motion/plan_carried.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/motion/path_planner.h"
#include "core/motion/plan_checks.h"

namespace takt::motion {
namespace {

Diagnostics at(const char* place, const Diagnostics& diagnostics) {
  Diagnostics all;
  all.append(diagnostics, place);
  return all;
}

Diagnostics check(const CarriedArm& both, const JointVector& q_carrier, const JointVector& q_rider,
                  const JointVector& q_carrier_goal, const Eigen::Isometry3d& X_BM_goal) {
  Diagnostics diagnostics, of_carrier;
  if (both.carrier.chain.joint_count() != 3)
    diagnostics.error(Code::kWrongSize, "/carrier", fmt::format("{} joints", both.carrier.chain.joint_count()),
                      "Give three: x, y, yaw");
  if (both.rider.inverse == nullptr) diagnostics.error(Code::kRequires, "/goal", "the arm has no inverse kinematics");
  if (diagnostics.has_errors()) return diagnostics;
  check_configuration(both.carrier.chain, both.carrier.limits, q_carrier, "/start", of_carrier);
  check_configuration(both.carrier.chain, both.carrier.limits, q_carrier_goal, "/goal", of_carrier);
  diagnostics.append(of_carrier, "/carrier");
  check_configuration(both.rider.chain, both.rider.limits, q_rider, "/start", diagnostics);
  check_pose(X_BM_goal, "/goal", diagnostics);
  return diagnostics;
}

/// By how much a law must be stretched so that M goes no faster on its line.
double stretch_for_speed(const TimeLaw& law, double length, double speed) {
  double fastest = 0.0;
  for (const LawPoint& at : instants(law, kPartsPerSegment)) fastest = std::max(fastest, std::abs(at.ds));
  return length * fastest / (kLawShareOfVelocity * speed);
}

}  // namespace

Result<PairPlan> plan_carried_lin(const CarriedArm& both, const JointVector& q_carrier, const JointVector& q_rider,
                                  const JointVector& q_carrier_goal, const Eigen::Isometry3d& X_BM_goal,
                                  const PieceShares& shares) {
  Diagnostics diagnostics = check(both, q_carrier, q_rider, q_carrier_goal, X_BM_goal);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  const Eigen::Isometry3d X_BM =
      both.carrier.chain.forward(q_carrier) * both.X_FA * both.rider.chain.forward(q_rider) * both.rider.X_FM;
  const JointVector held = both.rider.inverse->held(q_rider);
  const CarriedLine line{.line = CartesianLine::between(X_BM, X_BM_goal, held, held),
                         .carrier_start = q_carrier,
                         .carrier_goal = q_carrier_goal,
                         .X_FA = both.X_FA};
  Motion carrier{.path = JointLine{.q_start = q_carrier, .q_goal = q_carrier_goal},
                 .law = {},
                 .clock = {},
                 .q_start = q_carrier,
                 .q_goal = q_carrier_goal,
                 .shares = {{.velocity = shares.velocity, .acceleration = shares.acceleration}}};
  const bool stands = line.line.length == 0.0 && line.line.angle == 0.0 && q_carrier == q_carrier_goal;
  if (stands) {
    Motion rider = carrier;
    rider.path = CompositePath{{{.geometry = line}}};
    rider.q_start = rider.q_goal = q_rider;
    return PairPlan{std::move(carrier), std::move(rider), {}};
  }
  // The law of whoever needs longer alone, stretched to what the other can: an arm that is only carried needs none.
  auto alone = plan_ptp(both.carrier.chain, both.carrier.limits, q_carrier, q_carrier_goal,
                        {.velocity = shares.velocity, .acceleration = shares.acceleration});
  if (!alone) return std::unexpected(at("/carrier", alone.error()));
  PieceShares of_joints = shares;  // the frame's speed is that in the room, not that past the arm's own base
  of_joints.linear_velocity = std::numeric_limits<double>::infinity();
  std::size_t failed = 0;
  auto rider =
      PathPlanner(both.rider).plan({{.piece = {.geometry = line}, .shares = of_joints}}, q_rider, "/goal", failed);
  if (!rider) return std::unexpected(std::move(rider.error()));
  if (alone->duration() > rider->duration()) rider->law = alone->law;
  carrier.law = rider->law;
  double stretch = stretch_for_speed(rider->law, line.line.length, shares.linear_velocity);
  const PathPlanner carriers(both.carrier), riders(both.rider);
  const auto base = carriers.follow(carrier, "/goal"), arm = riders.follow(*rider, "/goal");
  if (!base) return std::unexpected(at("/carrier", base.error()));
  if (!arm) return std::unexpected(arm.error());
  stretch = std::max({1.0, stretch, carriers.fit(*base, carrier).stretch, riders.fit(*arm, *rider).stretch});
  carrier.law = rider->law = rider->law.stretched(stretch);
  carrier.clock = rider->clock = common(carriers.fit(*base, carrier).clock, riders.fit(*arm, *rider).clock);
  return PairPlan{std::move(carrier), std::move(*rider), {}};
}

}  // namespace takt::motion
