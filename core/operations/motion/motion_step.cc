#include "core/operations/motion/motion_step.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/activity/dual_entry_motion.h"
#include "core/command/single_net.h"
#include "core/expression/moving_frames.h"
#include "core/operations/motion/motion_activity.h"
#include "core/operations/table/rehearsed_net.h"
#include "core/operations/table/scheduled_run.h"
#include "core/operations/table/touch.h"

namespace takt::operations {
namespace {

/// How long they wait before they begin, for what others do meanwhile, s.
double wait_of_moves(const std::vector<MotionTask>& requests, const activity::ConcurrentMotions& meanwhile) {
  const auto move =
      std::ranges::find_if(requests, [](const MotionTask& request) { return request.kind == PathKind::kMove; });
  return move == requests.end() ? 0.0 : meanwhile.wait_before(move->pointer);
}

/// Takes note of a touch at its end. Several motions are one: they are blended into each other.
class MotionRun final : public ScheduledRun {
 public:
  explicit MotionRun(const std::vector<MotionTask>& requests) : requests_(requests), request_(requests.back()) {}

  [[nodiscard]] std::size_t part() const override { return run() ? run()->part().value_or(0) : 0; }
  [[nodiscard]] bool begun() const override { return run() && run()->part().has_value(); }
  [[nodiscard]] bool has_taken_over() const override { return run() && run()->blended(); }
  [[nodiscard]] bool can_blend_out() const override {
    // Who takes it over carries out the rest of it too, but not with its springs, nor with what is laid over it.
    const bool blends = request_.blends() && !request_.compliance && !request_.has_overlay();
    return blends && begun() && part() + 1 == requests_.size();
  }

 private:
  [[nodiscard]] double wait_before(const activity::Context& context) const override {
    return wait_of_moves(requests_, context.meanwhile);
  }
  [[nodiscard]] activity::ActivityPtr activity(activity::Context& context) override {
    return std::make_shared<const MotionActivity>(requests_.front().name, requests_, context.variables.biases,
                                                  context.meanwhile);
  }

  void ended(activity::Context& context) override {
    for (const std::string& arm : {request_.arm, request_.follower}) context.variables.touches.erase(arm);
  }
  Progress finish(activity::Context& context, Diagnostics& diagnostics) override {
    if (!request_.until) return Progress::kDone;
    const activity::GuardedOutcome outcome = activity::guarded_outcome(*run());
    if (!outcome.touched()) return Progress::kDone;
    const Diagnostics lost = note_touch(context, request_.arm, *outcome.X_BT);
    diagnostics.append(lost, "/until");
    return lost.has_errors() ? Progress::kFailed : Progress::kDone;
  }

  const std::vector<MotionTask>& requests_;
  const MotionTask& request_;  ///< the last: only a motion alone may be guarded
};

class MotionStep final : public Step {
 public:
  explicit MotionStep(MotionTask request) { requests_.push_back(std::move(request)); }

  bool absorb(Step& next) override {
    auto* motion = dynamic_cast<MotionStep*>(&next);
    if (!motion || !requests_.back().blends()) return false;
    const MotionTask& follower = motion->requests_.front();
    if (moved_by(follower) != moved_by(requests_.front())) return false;
    if (follower.compliance != requests_.back().compliance || follower.tool != requests_.back().tool) return false;
    requests_.insert(requests_.end(), std::make_move_iterator(motion->requests_.begin()),
                     std::make_move_iterator(motion->requests_.end()));
    return true;
  }

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const MotionTask& last = requests_.back();
    if (!check_compliance(rehearsal, pointer, diagnostics)) return;
    const double wait = wait_of_moves(requests_, rehearsal.collisions.meanwhile);
    const bool goes_on =
        wait == 0.0 && rehearsal.open && rehearsal.open->arm == moved_arm() && can_blend_from(rehearsal.cell);
    if (!goes_on) note_open_begin(rehearsal, diagnostics);
    rehearsal.open.reset();
    if (last.blends()) note_open_end(rehearsal, diagnostics);
    if (!last.follower.empty()) rehearsal.touched[last.follower] = false;
    rehearsal.touched[last.arm] = last.until.has_value();
    note_wait(wait, rehearsal, diagnostics);
    note_moves(rehearsal, last.arm, moves(), !goes_on);
    const Surroundings surroundings{.situation = [&rehearsal] { return situation_of(rehearsal); },
                                    .meanwhile = rehearsal.collisions.meanwhile};
    const MotionActivity motion(requests_.front().name, requests_, {});
    const auto alone = motion.alone(rehearsal.cell, rehearsal.q, surroundings);
    if (!alone) {
      diagnostics.append(alone.error(), pointer);
      return;
    }
    diagnostics.append(alone->notes);
    check_planned(rehearsal, checked(*alone->prepared.command, rehearsal.cell), diagnostics);
    if (last.until) invalidate_timing(rehearsal);
    for (const auto& [arm, q] : alone->q_goal) rehearsal.q[arm] = q;
    rehearsal.duration += alone->duration;
    const auto mapped = command::single_net(*alone->prepared.command, requests_.front().name);
    if (!mapped) return diagnostics.append(mapped.error(), pointer);
    rehearse_net(mapped->net, rehearsal, pointer, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<MotionRun>(requests_); }

  [[nodiscard]] std::string moved_arm() const override { return moved_by(requests_.front()); }
  [[nodiscard]] ArmTools arm_tools() const override {
    const MotionTask& first = requests_.front();
    return {{first.arm, first.tool, first.pointer}};
  }
  [[nodiscard]] bool can_blend_from(const expression::Cell& cell) const override {
    // What is laid over a path begins with it at rest, unless another motion of the same plan comes before.
    if (requests_.front().has_overlay()) return false;
    return std::ranges::none_of(
        requests_, [&](const auto& request) { return request.compliance || depends_on_moving_frame(request, cell); });
  }

 private:
  void note_wait(double wait, Rehearsal& rehearsal, Diagnostics& diagnostics) const {
    if (wait == 0.0) return;
    rehearsal.duration += wait;
    diagnostics.note(moves().front(),
                     fmt::format("it begins {:.3f} s later: before that no path keeps clear of what others move", wait),
                     "a 'wait' before it, or other branches first");
  }
  /// Pointers of those that find their own paths.
  [[nodiscard]] std::vector<std::string> moves() const {
    std::vector<std::string> pointers;
    for (const MotionTask& request : requests_)
      if (request.kind == PathKind::kMove) pointers.push_back(request.pointer);
    return pointers;
  }
  [[nodiscard]] activity::CheckedMotion checked(const command::Command& command, const expression::Cell& cell) const {
    if (cell.shapes == nullptr) return {};
    const command::PlannedMotion& motion = *command.node()->model().planned_motion();
    activity::CheckedMotion checked{.tracks = activity::tracks_of(motion, command.node()->actuator->model(), cell)};
    for (std::size_t i = 0; i < requests_.size(); ++i) {
      const double begin = i == 0 || i > motion.handed_over.size() ? 0.0 : motion.handed_over[i - 1];
      checked.parts.push_back({begin, requests_[i].name, requests_[i].pointer, goal_on(requests_[i], cell)});
    }
    const auto offset = first_offset(requests_);
    const MotionTask& last = requests_.back();
    if (!last.until && !offset && !last.compliance) return checked;
    checked.touching = {last.arm};
    if (!last.follower.empty()) checked.touching.insert(last.follower);
    checked.ends_at_touch = last.until && !offset && !last.compliance;
    const std::size_t first = last.compliance ? 0 : offset.value_or(requests_.size() - 1);
    if (first > 0 && first <= motion.handed_over.size()) checked.touch_from = motion.handed_over[first - 1];
    return checked;
  }
  /// Machines that it does not move itself and on which it depends where it goes to.
  [[nodiscard]] static std::set<std::string> goal_on(const MotionTask& request, const expression::Cell& cell) {
    const auto* pose = std::get_if<Goal::Pose>(&request.goal.value);
    if (pose == nullptr) return {};
    std::set<std::string> machines = expression::movers_between(cell.frames, pose->in, request.arm);
    machines.erase(request.arm);
    machines.erase(request.follower);
    if (request.base_goal) return {};
    return machines;
  }
  static std::string laid_over(const MotionTask& request) { return request.weave ? "weave" : "force offset"; }
  /// The one before is not gone on with: its blend is in vain.
  void note_open_begin(Rehearsal& rehearsal, Diagnostics& diagnostics) const {
    const MotionTask& first = requests_.front();
    const bool of_same_arm = rehearsal.open && rehearsal.open->arm == moved_arm();
    if (!of_same_arm || !first.has_overlay()) return settle_rehearsal(rehearsal, diagnostics);
    diagnostics.note(rehearsal.open->pointer,
                     fmt::format("'{}' ({}) does not follow it directly, and begins with a {}, at rest: it stops at "
                                 "the goal",
                                 first.name, first.pointer, laid_over(first)),
                     "the two right behind each other in the file, or no blend");
  }
  /// The next motion is decided in the run: whatever is laid over this one has to be gone, and so it stops.
  void note_open_end(Rehearsal& rehearsal, Diagnostics& diagnostics) const {
    const MotionTask& last = requests_.back();
    if (!last.has_overlay()) {
      rehearsal.open = {moved_arm(), last.pointer};
      return;
    }
    diagnostics.note(last.pointer,
                     fmt::format("no motion of this arm follows it directly, and it has a {}: it stops at the goal",
                                 laid_over(last)),
                     "the next motion right behind it in the file, or no blend");
  }
  /// The mode and the values of its compliance. @return false: with diagnostics
  bool check_compliance(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const {
    const MotionTask& last = requests_.back();
    if (!last.compliance) return true;
    std::vector<std::string> arms{last.arm};
    if (!last.follower.empty()) arms.push_back(last.follower);
    return rehearse_compliance(*last.compliance, rehearsal, arms, pointer, diagnostics);
  }

  std::vector<MotionTask> requests_;  ///< one, or several that are blended, and give way alike
};

}  // namespace

std::unique_ptr<Step> motion_step(MotionTask motion) { return std::make_unique<MotionStep>(std::move(motion)); }

}  // namespace takt::operations
