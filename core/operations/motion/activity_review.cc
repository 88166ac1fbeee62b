#include "core/operations/motion/activity_review.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/operations/motion/motion_plan.h"

namespace takt::operations {
namespace {

constexpr const char* kProgram = "program";

bool meets_own(const activity::FoundCollision& found, const Timeline& timeline, const collision::CellState& begin,
               const MotionTask& own) {
  const collision::Scene& scene = timeline.cell().shapes->scene;
  return std::ranges::any_of(std::array{found.a, found.b}, [&](const std::string& body) {
    const auto arms = timeline.arms_of(scene.find(body), begin);
    return arms.contains(own.arm) || arms.contains(own.follower);
  });
}

}  // namespace

ActivityReview::ActivityReview(const std::vector<MotionTask>& requests, const activity::PlanningContext& planning,
                               const expression::Cell& seen)
    : requests_(requests), planning_(planning), seen_(seen) {
  const auto& shapes = planning.cell.shapes;
  if (planning.beside.empty() || shapes == nullptr || !shapes->off.empty()) return;
  begin_ = activity::situation_before(planning);
  add_beside();
  const bool moves =
      std::ranges::any_of(requests, [](const MotionTask& request) { return request.kind == PathKind::kMove; });
  if (!moves) return;
  meanwhile_.parallel = kProgram;
  review_.emplace(kProgram, nullptr, MoveReview::Unclear::kInTheWay);
}

/// Each is a branch of its own: they run at the same time.
void ActivityReview::add_beside() {
  for (const activity::ConcurrentMotion& one : planning_.beside) {
    activity::CheckedMotion motion{.tracks = activity::tracks_of(one.motion, one.actuator.model(), planning_.cell),
                                   .parts = {{0.0, one.name, {}}},
                                   .touching = one.touching,
                                   .ends_at_touch = true};
    if (motion.tracks.empty()) continue;
    branches_.push_back(0);
    const double stops = activity::first_touch(planning_.cell, *begin_, motion).time;
    beside_.push_back(std::make_shared<const PlayedStep>(PlayedStep{.begin = one.begin.value_or(0.0),
                                                                    .branch = static_cast<int>(branches_.size()) - 1,
                                                                    .timed = one.begin.has_value(),
                                                                    .before = *begin_,
                                                                    .motion = std::move(motion),
                                                                    .stops = stops}));
  }
  branches_.push_back(0);
}

std::vector<activity::ArmTrack> ActivityReview::tracks_along(const motion::SequencePlan& plan) const {
  const std::string& arm = requests_.back().arm;
  auto joints = motion::JointTrack::follow(expression::planning_model(seen_.arms.find(arm)->second), plan.motion);
  if (!joints) return {};
  std::vector<activity::ArmTrack> tracks;
  tracks.push_back({arm, std::move(*joints)});
  return tracks;
}

/// @param tracks  of its arms; none: there is no plan
PlayedSteps ActivityReview::steps_with(std::vector<activity::ArmTrack> tracks) const {
  const MotionTask& last = requests_.back();
  const expression::MountedArm& arm = planning_.cell.arms.find(last.arm)->second;
  // What is held still carries on with what it does: when it ends is not looked at.
  PlayedStep own{.begin = 0.0,
                 .branch = static_cast<int>(branches_.size()) - 1,
                 .timed = !arm.device->held(),
                 .before = *begin_,
                 .arm = last.arm,
                 .may_wait = false};
  for (const MotionTask& request : requests_)
    if (request.kind == PathKind::kMove) own.moves.push_back(request.pointer);
  if (!tracks.empty()) {
    own.motion = activity::CheckedMotion{.tracks = std::move(tracks), .parts = {{0.0, last.name, last.pointer}}};
    if (last.until || last.compliance || last.force_offset)
      for (const activity::ArmTrack& track : own.motion->tracks) own.motion->touching.insert(track.arm);
    own.motion->ends_at_touch = last.until.has_value();
    own.stops = activity::first_touch(planning_.cell, *begin_, *own.motion).time;
  }
  PlayedSteps steps = beside_;
  steps.push_back(std::make_shared<const PlayedStep>(std::move(own)));
  return steps;
}

bool ActivityReview::plan_again(const Result<motion::SequencePlan>& plan) {
  if (!review_) return false;
  const Diagnostics said = plan ? Diagnostics() : plan.error();
  const Timeline timeline(planning_.cell, *begin_,
                          steps_with(plan ? tracks_along(*plan) : std::vector<activity::ArmTrack>()));
  if (!review_->review(timeline, branches_, said)) return false;
  meanwhile_.spaces = review_->spaces();
  return true;
}

Diagnostics ActivityReview::collisions(const motion::SequencePlan& plan) const {
  return begin_ ? met_by(tracks_along(plan)) : Diagnostics();
}

Diagnostics ActivityReview::collisions(const activity::Grasp& grasp, const motion::PairPlan& plan) const {
  if (!begin_) return {};
  const command::Actuator pair = command::arm_pair(seen_, grasp.leader, grasp.follower);
  return met_by(activity::tracks_of(activity::planned(grasp, {}, plan), pair.model(), seen_));
}

Diagnostics ActivityReview::met_by(std::vector<activity::ArmTrack> tracks) const {
  Diagnostics own;
  if (tracks.empty()) return own;
  Timeline timeline(planning_.cell, *begin_, steps_with(std::move(tracks)));
  std::vector<activity::FoundCollision> found;
  Diagnostics said;
  timeline.check(&found, said);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Diagnostic& one = said.list()[i];
    if (one.severity == Severity::kError && meets_own(found[i], timeline, *begin_, requests_.back())) own.add(one);
  }
  return own;
}

}  // namespace takt::operations
