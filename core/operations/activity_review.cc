#include "core/operations/activity_review.h"

#include <algorithm>
#include <utility>

#include "core/operations/motion_plan.h"

namespace takt::activity {
namespace {

constexpr const char* kProgram = "program";

bool meets_own(const FoundCollision& found, const Timeline& timeline, const collision::Situation& begin,
               const std::string& arm) {
  const collision::Scene& scene = timeline.cell().shapes->scene;
  return timeline.arms_of(scene.find(found.a), begin).contains(arm) ||
         timeline.arms_of(scene.find(found.b), begin).contains(arm);
}

}  // namespace

ActivityReview::ActivityReview(const std::vector<MotionTask>& requests, const PlanningContext& planning)
    : requests_(requests), planning_(planning) {
  const auto& shapes = planning.cell.shapes;
  const bool moves =
      std::ranges::any_of(requests, [](const MotionTask& request) { return request.kind == PathKind::kMove; });
  if (!moves || planning.beside.empty() || shapes == nullptr || !shapes->off.empty()) return;
  begin_ = situation_before(planning);
  add_beside();
  meanwhile_.parallel = kProgram;
  review_.emplace(kProgram, nullptr, MoveReview::Unclear::kInTheWay);
}

/// Each is a branch of its own: they run at the same time.
void ActivityReview::add_beside() {
  for (const MotionBeside& one : planning_.beside) {
    CheckedMotion motion{.tracks = tracks_of(one.motion, one.actuator.model(), planning_.cell),
                         .parts = {{0.0, one.name, {}}},
                         .touching = one.touching,
                         .ends_at_touch = true};
    if (motion.tracks.empty()) continue;
    branches_.push_back(0);
    const double stops = first_touch(planning_.cell, *begin_, motion).time;
    beside_.push_back(std::make_shared<const PlayedStep>(PlayedStep{.begin = one.begin.value_or(0.0),
                                                                    .branch = static_cast<int>(branches_.size()) - 1,
                                                                    .timed = one.begin.has_value(),
                                                                    .before = *begin_,
                                                                    .motion = std::move(motion),
                                                                    .stops = stops}));
  }
  branches_.push_back(0);
}

PlayedSteps ActivityReview::steps_with(const motion::SequencePlan* plan) const {
  const MotionTask& last = requests_.back();
  const command::MountedArm& arm = planning_.cell.arms.find(last.arm)->second;
  // What is held still carries on with what it does: when it ends is not looked at.
  PlayedStep own{.begin = 0.0,
                 .branch = static_cast<int>(branches_.size()) - 1,
                 .timed = !arm.device->held(),
                 .before = *begin_,
                 .arm = last.arm,
                 .may_wait = false};
  for (const MotionTask& request : requests_)
    if (request.kind == PathKind::kMove) own.moves.push_back(request.pointer);
  if (plan != nullptr) {
    if (auto joints = motion::JointTrack::follow(command::planning_model(arm), plan->motion)) {
      own.motion = CheckedMotion{.tracks = {{last.arm, std::move(*joints)}}, .parts = {{0.0, last.name, last.pointer}}};
      if (last.until || last.compliance || last.force_offset) own.motion->touching = {last.arm};
      own.motion->ends_at_touch = last.until.has_value();
      own.stops = first_touch(planning_.cell, *begin_, *own.motion).time;
    }
  }
  PlayedSteps steps = beside_;
  steps.push_back(std::make_shared<const PlayedStep>(std::move(own)));
  return steps;
}

bool ActivityReview::plan_again(const Result<motion::SequencePlan>& plan) {
  if (!review_) return false;
  const Diagnostics said = plan ? Diagnostics() : plan.error();
  const Timeline timeline(planning_.cell, *begin_, steps_with(plan ? &*plan : nullptr));
  if (!review_->review(timeline, branches_, said)) return false;
  meanwhile_.spaces = review_->spaces();
  return true;
}

Diagnostics ActivityReview::collisions(const motion::SequencePlan& plan) const {
  Diagnostics own;
  if (!review_) return own;
  Timeline timeline(planning_.cell, *begin_, steps_with(&plan));
  std::vector<FoundCollision> found;
  Diagnostics said;
  timeline.check(&found, said);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Diagnostic& one = said.list()[i];
    if (one.severity == Severity::kError && meets_own(found[i], timeline, *begin_, requests_.back().arm)) own.add(one);
  }
  return own;
}

}  // namespace takt::activity
