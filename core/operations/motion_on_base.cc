#include "core/operations/motion_on_base.h"

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/carried_motion.h"
#include "core/expression/moving_frames.h"
#include "core/kinematics/chain.h"
#include "core/operations/motion_plan.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;
using Planned = Result<command::PlannedMotion>;

struct MotionOnBaseParameters {
  MotionTask tool;  ///< of the arm, in the room
  Goal base_goal;
};

/// Where the tool is to be, in the frame in which the base drives.
Result<Eigen::Isometry3d> tool_goal(const MotionOnBaseParameters& request, const command::Cell& cell,
                                    const std::string& base, const JointVector& q_base, const JointVector& q_arm) {
  const std::string& arm = request.tool.arm;
  const auto goal = resolve(request.tool.goal, cell, arm, q_arm);
  if (!goal) return std::unexpected(goal.error());
  const auto* joints = std::get_if<JointVector>(&*goal);
  const Eigen::Isometry3d X_AM =
      joints ? tool_pose(cell.arms.find(arm)->second, *joints) : std::get<Eigen::Isometry3d>(*goal);
  const Eigen::Isometry3d X_BF = cell.arms.find(base)->second.device->description().chain->forward(q_base);
  return Eigen::Isometry3d(X_BF * cell.frames.relation(arm)->X_PF * X_AM);
}

std::unexpected<Diagnostics> below(const char* place, const Diagnostics& found) {
  Diagnostics placed;
  placed.append(found, place);
  return std::unexpected(std::move(placed));
}

/// From where both will be, with machines where they are then.
Planned plan(const MotionOnBaseParameters& request, const command::Cell& now, const command::Places& places) {
  const auto base = command::carrier_of(now, request.tool.arm);
  if (!base) return std::unexpected(base.error());
  const command::Cell cell = cell_at(now, places);
  const JointVector &q_base = places.at(*base), &q_arm = places.at(request.tool.arm);
  const auto X_goal = tool_goal(request, cell, *base, q_base, q_arm);
  if (!X_goal) return below("/to", X_goal.error());
  Diagnostics unheard;  // a base turns as it is told, or not at all
  const auto q_goal = goal_joints(request.base_goal, cell, *base, q_base, unheard);
  if (!q_goal) return below("/base_to", q_goal.error());
  command::PlanParameters wish{.velocity = request.tool.velocity,
                               .acceleration = request.tool.acceleration,
                               .linear_velocity = request.tool.linear_velocity};
  wish.clock = command::override_of(cell);
  auto planned = command::carried_lin(cell, request.tool.arm, {q_base, q_arm, *q_goal, *X_goal}, wish);
  if (planned) return planned;
  // The planner speaks of goals, the file of keys.
  Diagnostics renamed;
  for (Diagnostic diagnostic : planned.error().list()) {
    diagnostic.pointer = diagnostic.pointer.starts_with("/carrier") ? "/base_to" : "/to";
    renamed.add(std::move(diagnostic));
  }
  return std::unexpected(std::move(renamed));
}

class MotionOnBase final : public OperationCommand {
 public:
  MotionOnBaseParameters request;

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    const command::Actuator both = command::arm_on_base(making.cell, request.tool.arm);
    const auto planner = [this, &cell = making.cell](const command::Places& places) {
      return plan(request, cell, places);
    };
    const command::Action action = command::planned_by("LIN", command::SetPointKind::kPair, planner);
    command::RuntimeCommand moved(name, both, action);
    moved.observe(key + " started", command::BooleanSensor(moved.started().node()));
    return {.command = moved, .action = action, .actuator = both};
  }

  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    for (const std::string& device : devices(rehearsal.cell)) rehearsal.touched[device] = false;
  }

  void finish(const ActivityRun& ended, const std::string& key, bool, Context& context, Diagnostics&) const override {
    if (!ended.was_true(key + " started")) return;
    for (const std::string& device : devices(context.cell)) context.variables.touches.erase(device);
  }

 private:
  [[nodiscard]] std::vector<std::string> devices(const command::Cell& cell) const {
    return command::arm_on_base(cell, request.tool.arm).model().devices();
  }
};

}  // namespace

std::unique_ptr<OperationCommand> read_motion_on_base(const OperationSource& source) {
  const auto& [json, pointer, cell, diagnostics] = source;
  auto command = std::make_unique<MotionOnBase>();
  MotionOnBaseParameters& request = command->request;
  request.base_goal = read_goal(json.at("base_to"), pointer + "/base_to", nullptr, diagnostics);
  Json alone = json;
  alone.erase("base_to");
  for (const char* key :
       {"blend_m", "blend_fraction", "until", "abort_if", "follower", "compliance", "weave", "force_offset"}) {
    if (alone.contains(key))
      diagnostics.error(Code::kConflict, pointer + "/" + key, fmt::format("a motion with a base has no '{}'", key),
                        "two motions");
    alone.erase(key);
  }
  request.tool = read_motion(PathKind::kLin, {alone, pointer, cell, diagnostics});
  return command;
}

}  // namespace takt::activity
