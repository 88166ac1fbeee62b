#include "core/activity/carried_step.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/motion_request.h"
#include "core/activity/net_run.h"
#include "core/command/carried_motion.h"
#include "core/command/single_net.h"
#include "core/kinematics/chain.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

struct CarriedRequest {
  MotionRequest tool;  ///< of the arm, in the room
  Goal base_goal;
};

/// Where the tool is to be, in the frame in which the base drives.
Result<Eigen::Isometry3d> tool_goal(const CarriedRequest& request, const command::Cell& cell, const std::string& base,
                                    const JointVector& q_base, const JointVector& q_arm) {
  const std::string& arm = request.tool.arm;
  const auto goal = resolve(request.tool.goal, cell, arm, q_arm);
  if (!goal) return std::unexpected(goal.error());
  const auto* joints = std::get_if<JointVector>(&*goal);
  const Eigen::Isometry3d X_AM =
      joints ? tool_pose(cell.arms.find(arm)->second, *joints) : std::get<Eigen::Isometry3d>(*goal);
  const Eigen::Isometry3d X_BF = cell.arms.find(base)->second.device->description().chain->forward(q_base);
  return Eigen::Isometry3d(X_BF * cell.frames.relation(arm)->X_PF * X_AM);
}

std::unexpected<Findings> below(const char* place, const Findings& found) {
  Findings placed;
  placed.append(found, place);
  return std::unexpected(std::move(placed));
}

Result<command::PlannedMotion> plan(const CarriedRequest& request, const command::Cell& cell, const std::string& base,
                                    const JointVector& q_base, const JointVector& q_arm) {
  const auto X_goal = tool_goal(request, cell, base, q_base, q_arm);
  if (!X_goal) return below("/to", X_goal.error());
  Findings unheard;  // a base turns as it is told, or not at all
  const auto q_goal = goal_joints(request.base_goal, cell, base, q_base, unheard);
  if (!q_goal) return below("/base_to", q_goal.error());
  command::MotionWish wish{.velocity = request.tool.velocity,
                           .acceleration = request.tool.acceleration,
                           .linear_velocity = request.tool.linear_velocity};
  wish.clock = command::override_of(cell);
  auto planned = command::carried_lin(cell, request.tool.arm, {q_base, q_arm, *q_goal, *X_goal}, wish);
  if (planned) return planned;
  // The planner speaks of goals, the file of keys.
  Findings renamed;
  for (Finding finding : planned.error().list()) {
    finding.pointer = finding.pointer.starts_with("/carrier") ? "/base_to" : "/to";
    renamed.add(std::move(finding));
  }
  return std::unexpected(std::move(renamed));
}

net::NetDescription net_of(const CarriedRequest& request, const command::Cell& cell,
                           const command::PlannedMotion& motion) {
  const command::RuntimeCommand moved("motion", command::arm_on_base(cell, request.tool.arm), command::planned(motion));
  return command::single_net(moved, request.tool.name).net;
}

rcc::LoadOptions load_options(const command::PlannedMotion& motion, const CarriedRequest& request,
                              const std::string& base) {
  const auto at_rest = [](const std::string& name, const JointVector& q) {
    const JointVector zero = JointVector::Zero(q.size());
    return rcc::NetSeam{name, {.q = q, .dq = zero, .ddq = zero}};
  };
  const motion::Motion &of_base = *motion.motion, &of_arm = *motion.partner->motion;
  return {.begins = {at_rest(base, of_base.q_start), at_rest(request.tool.arm, of_arm.q_start)},
          .ends = {at_rest(base, of_base.q_goal), at_rest(request.tool.arm, of_arm.q_goal)}};
}

class CarriedRun final : public OneNetRun {
 public:
  explicit CarriedRun(const CarriedRequest& request) : request_(request) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    const auto sent = [&](const std::string& name) -> const JointVector& {
      return context.cell.arms.find(name)->second.device->set_point().q;
    };
    const auto base = command::carrier_of(context.cell, request_.tool.arm);
    if (!base) return fail(base.error(), findings);
    // The first step of a program may come before the first sample.
    if (sent(*base).size() == 0 || sent(request_.tool.arm).size() == 0) return Progress::kRunning;
    const auto motion = plan(request_, context.cell, *base, sent(*base), sent(request_.tool.arm));
    if (!motion) return fail(motion.error(), findings);
    const rcc::LoadOptions options = load_options(*motion, request_, *base);
    return load(context, net_of(request_, context.cell, *motion), findings, options);
  }

  static Progress fail(const Findings& why, Findings& findings) {
    findings.append(why);
    return Progress::kFailed;
  }

  const CarriedRequest& request_;
};

class CarriedStep final : public Step {
 public:
  explicit CarriedStep(CarriedRequest request) : request_(std::move(request)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    const auto base = command::carrier_of(rehearsal.cell, request_.tool.arm);
    if (!base) return findings.append(base.error(), pointer);
    JointVector &q_base = rehearsal.q[*base], &q_arm = rehearsal.q[request_.tool.arm];
    const auto motion = plan(request_, rehearsal.cell, *base, q_base, q_arm);
    if (!motion) return findings.append(motion.error(), pointer);
    rehearsal.touched[request_.tool.arm] = rehearsal.touched[*base] = false;
    q_base = motion->motion->q_goal;
    q_arm = motion->partner->motion->q_goal;
    rehearsal.duration += motion->motion->duration();
    rehearse_net(net_of(request_, rehearsal.cell, *motion), rehearsal, pointer, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<CarriedRun>(request_); }

 private:
  CarriedRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_carried_lin(const Json& json, const std::string& pointer, const command::Cell& cell,
                                        Findings& findings) {
  CarriedRequest request;
  request.base_goal = read_goal(json.at("base_to"), pointer + "/base_to", nullptr, findings);
  Json alone = json;
  alone.erase("base_to");
  for (const char* key : {"blend_m", "blend_fraction", "until", "unless", "follower", "compliance"}) {
    if (alone.contains(key))
      findings.error(pointer + "/" + key, fmt::format("a motion with a base has no '{}'", key), "two motions");
    alone.erase(key);
  }
  request.tool = read_motion(PathKind::kLin, alone, pointer, cell, findings);
  return std::make_unique<CarriedStep>(std::move(request));
}

}  // namespace takt::activity
