#include "core/activity/motion_step.h"

#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/goal.h"
#include "core/activity/net_run.h"
#include "core/base/object_reader.h"
#include "core/command/condition.h"
#include "core/command/motion_net.h"
#include "core/kinematics/solutions.h"
#include "core/motion/planner.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

enum class PathKind { kPtp, kLin };

/// What a motion step says, in numbers.
struct MotionRequest {
  PathKind kind = PathKind::kPtp;
  std::string name;
  std::string arm;
  Goal goal;
  motion::MotionOptions options;
  std::optional<command::Condition> until;
  bool must_touch = true;  ///< a guarded motion that reaches its end is a failure
};

Result<JointVector> nearest_configuration(const device::ArmDescription& arm, const Eigen::Isometry3d& X_BF,
                                          const JointVector& q) {
  kinematics::SolutionOptions options;
  options.reference = q;
  options.most = 1;
  const auto solutions = kinematics::inverse_solutions(*arm.chain, X_BF, options);
  if (!solutions.empty()) return solutions.front();
  const Eigen::Vector3d p = X_BF.translation();
  return failure("/to",
                 fmt::format("the goal is out of reach: flange at ({:.3f}, {:.3f}, {:.3f}) m in the arm's base", p.x(),
                             p.y(), p.z()),
                 "a pose that some joint configuration inside the limits reaches");
}

/// The planner speaks of "/goal/2" and "/start/2"; the file has the goal at "/to".
Findings as_seen_in_file(const Findings& findings) {
  Findings renamed;
  for (Finding finding : findings.list()) {
    if (finding.pointer.starts_with("/goal")) finding.pointer = "/to";
    if (finding.pointer.starts_with("/start") || finding.pointer.starts_with("/options")) finding.pointer.clear();
    renamed.add(std::move(finding));
  }
  return renamed;
}

Result<motion::Motion> plan(const MotionRequest& request, const command::Cell& cell, const JointVector& q) {
  const command::MountedArm& arm = cell.arms.find(request.arm)->second;
  const device::ArmDescription& description = arm.device->description();
  auto goal = resolve(request.goal, cell, request.arm, q);
  if (!goal) {
    Findings findings;
    findings.append(goal.error(), "/to");
    return std::unexpected(std::move(findings));
  }
  Result<motion::Motion> motion = std::unexpected(Findings{});
  if (request.kind == PathKind::kLin) {
    motion::MotionOptions options = request.options;
    options.X_FM = arm.X_FT;
    const auto* q_goal = std::get_if<JointVector>(&*goal);
    const Eigen::Isometry3d X_BT = q_goal ? tool_pose(arm, *q_goal) : std::get<Eigen::Isometry3d>(*goal);
    motion = motion::plan_lin(*description.chain, *description.inverse, description.limits, description.cartesian, q,
                              X_BT, {}, options);
  } else {
    JointVector q_goal;
    if (const auto* X_BT = std::get_if<Eigen::Isometry3d>(&*goal)) {
      auto found = nearest_configuration(description, *X_BT * arm.X_FT.inverse(), q);
      if (!found) return std::unexpected(std::move(found.error()));
      q_goal = *found;
    } else {
      q_goal = std::get<JointVector>(*goal);
    }
    motion = motion::plan_ptp(*description.chain, description.limits, q, q_goal, request.options);
  }
  if (!motion) return std::unexpected(as_seen_in_file(motion.error()));
  return motion;
}

/// Where the net of a motion takes its arm over and leaves it: at rest at both ends of the plan (row L3). A condition
/// may end it before, then nobody knows where.
rcc::LoadOptions load_options(const motion::Motion& motion, const MotionRequest& request, Nanoseconds period) {
  const auto at_rest = [&request](const device::JointVector& q) {
    const device::JointVector zero = device::JointVector::Zero(q.size());
    return rcc::NetSeam{request.arm, {.q = q, .dq = zero, .ddq = zero}};
  };
  rcc::LoadOptions options{.cancel_bound_cycles = command::cancel_bound_cycles(motion, period),
                           .begins = {at_rest(motion.q_start)}};
  if (!request.until) options.ends.push_back(at_rest(motion.q_goal));
  return options;
}

/// Plans when it begins, loads and starts the net, and takes note of a touch when the net has ended.
class MotionRun final : public StepRun {
 public:
  explicit MotionRun(const MotionRequest& request) : request_(request) {}

  Progress advance(Context& context, Findings& findings) override {
    if (!net_.begun()) return begin(context, findings);
    const Progress progress = net_.advance(context, findings);
    if (progress == Progress::kDone) return finish(context, findings);
    return progress;
  }

  void cancel(Context&) override {
    cancelled_ = true;
    net_.cancel();
  }

 private:
  Progress begin(Context& context, Findings& findings) {
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    // The first step of a program may come before the first sample.
    if (arm.device->set_point().q.size() == 0) return Progress::kRunning;
    auto motion = plan(request_, context.cell, arm.device->set_point().q);
    if (!motion) {
      findings.append(motion.error());
      return Progress::kFailed;
    }
    const command::MotionCommand command{request_.name, request_.arm, &*motion, arm.X_FT, request_.until};
    const rcc::LoadOptions options = load_options(*motion, request_, context.core.period());
    return net_.begin(context, command::motion_net(command, context.cell, context.variables.biases), options, findings);
  }

  Progress finish(Context& context, Findings& findings) {
    context.variables.touches.erase(request_.arm);
    if (!request_.until) return Progress::kDone;
    if (was_true(command::motion_ports::kTouched)) return note_touch(context, findings);
    if (cancelled_) return Progress::kDone;
    if (was_true(command::motion_ports::kStopped)) {
      findings.error("/until", "a sensor of the condition did not answer, so the arm stopped on its path");
      return Progress::kFailed;
    }
    if (!request_.must_touch) return Progress::kDone;
    findings.error("/until", "the motion reached its end and the condition never held",
                   "a longer motion, another threshold, or \"on_end\": \"continue\"");
    return Progress::kFailed;
  }

  [[nodiscard]] bool was_true(std::string_view port) const {
    const auto* slot = net_.net()->find<net::Boolean>(port);
    return slot && !slot->null && slot->value;
  }

  Progress note_touch(Context& context, Findings& findings) {
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    const auto* X_BT = net_.net()->find<net::Frame>(command::motion_ports::kTouchFrame);
    const auto X_WB = context.cell.frames.pose(request_.arm);
    if (!X_BT || X_BT->null || !X_WB) {
      findings.error("/until", "the condition held, but the arm's position was not known in that cycle");
      return Progress::kFailed;
    }
    const Eigen::Vector3d p_W = *X_WB * X_BT->value.translation();
    context.variables.touches[request_.arm] = {p_W, arm.ball_radius, context.core.cycle()};
    context.event(request_.arm, "touch", fmt::format("({:.5f}, {:.5f}, {:.5f}) m", p_W.x(), p_W.y(), p_W.z()));
    return Progress::kDone;
  }

  const MotionRequest& request_;
  NetRun net_;
  bool cancelled_ = false;
};

class MotionStep final : public Step {
 public:
  explicit MotionStep(MotionRequest request) : request_(std::move(request)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    rehearsal.touched[request_.arm] = request_.until.has_value();
    JointVector& q = rehearsal.q[request_.arm];
    const auto motion = plan(request_, rehearsal.cell, q);
    if (!motion) {
      findings.append(motion.error(), pointer);
      return;
    }
    q = motion->q_goal;
    rehearsal.duration += motion->duration();
    const command::MountedArm& arm = rehearsal.cell.arms.find(request_.arm)->second;
    const command::MotionCommand command{request_.name, request_.arm, &*motion, arm.X_FT, request_.until};
    rehearse_net(command::motion_net(command, rehearsal.cell, {}), rehearsal, pointer, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<MotionRun>(request_); }

 private:
  MotionRequest request_;
};

std::string read_arm(ObjectReader& reader, const command::Cell& cell) {
  std::vector<std::string> names;
  for (const auto& [name, arm] : cell.arms) names.push_back(name);
  // With a single arm there is nothing to choose.
  return reader.choice("arm", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
}

std::unique_ptr<Step> parse_motion(PathKind kind, const Json& json, const std::string& pointer,
                                   const command::Cell& cell, Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  MotionRequest request;
  request.kind = kind;
  request.name = reader.text("name", reader.text("do"));
  request.arm = read_arm(reader, cell);
  const auto arm = cell.arms.find(request.arm);
  request.goal = read_goal(reader, arm == cell.arms.end() ? nullptr : &arm->second);
  request.options.velocity = reader.number("speed", 1.0, {.low = 0, .high = 1, .low_open = true});
  request.options.acceleration = reader.number("acceleration", 1.0, {.low = 0, .high = 1, .low_open = true});
  if (kind == PathKind::kLin && reader.has("velocity_m_s")) {
    request.options.linear_velocity = reader.number("velocity_m_s", {}, kPositive);
  }
  if (const Json* until = reader.object("until", false)) {
    auto condition = command::parse_condition(*until, reader.at("until"), cell);
    if (condition) {
      request.until = std::move(*condition);
    } else {
      findings.append(condition.error());
    }
    request.must_touch = reader.choice("on_end", {"fail", "continue"}, "fail") == "fail";
  }
  reader.finish();
  return std::make_unique<MotionStep>(std::move(request));
}

}  // namespace

std::unique_ptr<Step> parse_ptp(const Json& json, const std::string& pointer, const command::Cell& cell,
                                Findings& findings) {
  return parse_motion(PathKind::kPtp, json, pointer, cell, findings);
}

std::unique_ptr<Step> parse_lin(const Json& json, const std::string& pointer, const command::Cell& cell,
                                Findings& findings) {
  return parse_motion(PathKind::kLin, json, pointer, cell, findings);
}

}  // namespace takt::activity
