#include "core/activity/motion_step.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/carried_step.h"
#include "core/activity/motion_request.h"
#include "core/activity/net_run.h"
#include "core/command/motion_net.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

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

/// The condition of a guarded motion that others are blended into counts from when it is the one that is done.
command::MotionCommand command_of(const std::vector<MotionRequest>& requests, const motion::Motion& motion,
                                  const command::MountedArm& arm, const std::vector<double>& handed_over) {
  const MotionRequest& last = requests.back();
  return {.name = requests.front().name,
          .arm = last.arm,
          .motion = &motion,
          .X_FM = arm.X_FT,
          .until = last.until,
          .until_from = last.until && !handed_over.empty() ? handed_over.back() : 0.0};
}

/// Plans when it begins, loads and starts the net, and takes note of a touch when the net has ended. Several motions
/// are one net: they are blended into each other.
class MotionRun final : public OneNetRun {
 public:
  explicit MotionRun(const std::vector<MotionRequest>& requests) : requests_(requests), request_(requests.back()) {}

  [[nodiscard]] std::size_t part() const override {
    const auto time = loaded() ? value_of<net::Real>(command::motion_ports::kPathTime) : std::nullopt;
    if (!time) return 0;
    const auto passed = std::ranges::upper_bound(handed_over_, *time);
    return static_cast<std::size_t>(passed - handed_over_.begin());
  }

 private:
  Progress begin(Context& context, Findings& findings) override {
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    // The first step of a program may come before the first sample.
    if (arm.device->set_point().q.size() == 0) return Progress::kRunning;
    auto plan = plan_motions(requests_, context.cell, arm.device->set_point().q);
    if (!plan) {
      findings.append(plan.error());
      return Progress::kFailed;
    }
    handed_over_ = std::move(plan->handed_over);
    const motion::Motion& motion = plan->motion;
    const command::MotionCommand command = command_of(requests_, motion, arm, handed_over_);
    const rcc::LoadOptions options = load_options(motion, request_, context.core.period());
    return load(context, command::motion_net(command, context.cell, context.variables.biases), findings, options);
  }

  Progress finish_cancelled(Context& context, Findings& findings) override {
    context.variables.touches.erase(request_.arm);
    return touched() ? note_touch(context, findings) : Progress::kDone;
  }

  Progress finish(Context& context, Findings& findings) override {
    if (touched() || !request_.until) return finish_cancelled(context, findings);
    context.variables.touches.erase(request_.arm);
    if (was_true(command::motion_ports::kStopped)) {
      findings.error("/until", "a sensor of the condition did not answer, so the arm stopped on its path",
                     "its power and its wires");
      return Progress::kFailed;
    }
    if (!request_.must_touch) return Progress::kDone;
    findings.error("/until", "the motion reached its end and the condition never held",
                   "a longer motion, another threshold, or \"on_end\": \"continue\"");
    return Progress::kFailed;
  }

  [[nodiscard]] bool touched() const { return request_.until && was_true(command::motion_ports::kTouched); }

  Progress note_touch(Context& context, Findings& findings) {
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    const auto X_BT = value_of<net::Frame>(command::motion_ports::kTouchFrame);
    const auto X_WB = context.cell.frames.pose(request_.arm);
    if (!X_BT || !X_WB) {
      findings.error("/until", "the condition held, but the arm's position was not known in that cycle",
                     "the arm's connection");
      return Progress::kFailed;
    }
    const Eigen::Vector3d p_W = *X_WB * X_BT->translation();
    context.variables.touches[request_.arm] = {p_W, arm.ball_radius, context.core.cycle()};
    context.event(request_.arm, "touch", fmt::format("({:.5f}, {:.5f}, {:.5f}) m", p_W.x(), p_W.y(), p_W.z()));
    return Progress::kDone;
  }

  const std::vector<MotionRequest>& requests_;
  const MotionRequest& request_;  ///< the last: only a motion alone may be guarded
  std::vector<double> handed_over_;
};

class MotionStep final : public Step {
 public:
  explicit MotionStep(MotionRequest request) { requests_.push_back(std::move(request)); }

  bool absorb(Step& next) override {
    auto* motion = dynamic_cast<MotionStep*>(&next);
    if (!motion || requests_.back().blend.kind == motion::Blend::Kind::kNone) return false;
    const MotionRequest& follower = motion->requests_.front();
    if (follower.arm != requests_.front().arm) return false;
    requests_.insert(requests_.end(), std::make_move_iterator(motion->requests_.begin()),
                     std::make_move_iterator(motion->requests_.end()));
    return true;
  }

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    const MotionRequest& last = requests_.back();
    rehearsal.touched[last.arm] = last.until.has_value();
    JointVector& q = rehearsal.q[last.arm];
    const auto plan = plan_motions(requests_, rehearsal.cell, q);
    if (!plan) {
      findings.append(plan.error(), pointer);
      return;
    }
    findings.append(plan->notes);
    if (last.blend.kind != motion::Blend::Kind::kNone) {
      findings.note(last.pointer, "there is no motion to blend into: the arm stops at the goal",
                    "a motion of the same arm as the next step");
    }
    const motion::Motion& motion = plan->motion;
    q = motion.q_goal;
    rehearsal.duration += motion.duration();
    const command::MountedArm& arm = rehearsal.cell.arms.find(last.arm)->second;
    const command::MotionCommand command = command_of(requests_, motion, arm, plan->handed_over);
    rehearse_net(command::motion_net(command, rehearsal.cell, {}), rehearsal, pointer, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<MotionRun>(requests_); }

 private:
  std::vector<MotionRequest> requests_;  ///< one, or several that are blended
};

template <PathKind kind>
std::unique_ptr<Step> parse(const Json& json, const std::string& pointer, const command::Cell& cell,
                            Findings& findings) {
  return std::make_unique<MotionStep>(read_motion(kind, json, pointer, cell, findings));
}

}  // namespace

std::unique_ptr<Step> parse_ptp(const Json& json, const std::string& pointer, const command::Cell& cell,
                                Findings& findings) {
  return parse<PathKind::kPtp>(json, pointer, cell, findings);
}

std::unique_ptr<Step> parse_lin(const Json& json, const std::string& pointer, const command::Cell& cell,
                                Findings& findings) {
  if (json.contains("base_to")) return parse_carried_lin(json, pointer, cell, findings);
  return parse<PathKind::kLin>(json, pointer, cell, findings);
}

std::unique_ptr<Step> parse_circ(const Json& json, const std::string& pointer, const command::Cell& cell,
                                 Findings& findings) {
  return parse<PathKind::kCirc>(json, pointer, cell, findings);
}

std::unique_ptr<Step> parse_spline(const Json& json, const std::string& pointer, const command::Cell& cell,
                                   Findings& findings) {
  return parse<PathKind::kSpline>(json, pointer, cell, findings);
}

}  // namespace takt::activity
