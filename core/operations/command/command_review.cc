#include "core/operations/command/command_review.h"

#include <algorithm>
#include <utility>

#include "core/operations/command/command_collisions.h"
#include "core/operations/table/collision_rehearsal.h"
#include "core/operations/table/step.h"

namespace takt::operations {
namespace {

bool has_moves(const OperationCommand& root) {
  return std::ranges::any_of(root.all(), [](const auto* one) { return !one->own_paths().pointers.empty(); });
}

}  // namespace

activity::ConcurrentMotions meanwhile_of(const OperationCommand& root, activity::ConcurrentMotions around) {
  if (around.parallel.empty()) around.parallel = root.pointer;
  return around;
}

CommandReview::CommandReview(const OperationCommand& root, Rehearsal& rehearsal)
    : root_(root), rehearsal_(rehearsal), meanwhile_(meanwhile_of(root, rehearsal.collisions.meanwhile)) {
  if (checks_motions(rehearsal) && !is_in_parallel() && has_moves(root))
    review_.emplace(meanwhile_.parallel, meanwhile_.spaces);
}

bool CommandReview::is_in_parallel() const { return rehearsal_.collisions.branch != 0; }

bool CommandReview::plan_again(const CommandBuilder& tree, const Diagnostics& wrong) {
  if (wrong.has_errors() && is_in_parallel()) {
    for (const OperationCommand* one : root_.all())
      if (auto own = one->own_paths(); !own.pointers.empty())
        note_moves(rehearsal_, own.arm, std::move(own.pointers), /*may_wait=*/false);
  }
  if (!review_) return false;
  last_ = steps_of(tree, !wrong.has_errors());
  if (!review_->review(Timeline(rehearsal_.cell, situation_of(rehearsal_), last_), branches_, wrong)) return false;
  meanwhile_.spaces = review_->spaces();
  return true;
}

PlayedSteps CommandReview::steps_of(const CommandBuilder& tree, bool planned) {
  PlayedSteps steps;
  if (!planned) {
    for (const auto& before : last_) {
      auto step = std::make_shared<PlayedStep>(*before);
      if (!step->moves.empty()) step->motion.reset();
      steps.push_back(std::move(step));
    }
    return steps;
  }
  const collision::CellState begin = situation_of(rehearsal_);
  branches_ = {-1};
  for (TreeMotion& one : motions_of(tree, rehearsal_)) {
    const int branch = static_cast<int>(one.line) + 1;
    branches_.resize(std::max(branches_.size(), static_cast<std::size_t>(branch) + 1), 0);
    OperationCommand::OwnPaths own = one.part->request->own_paths();
    if (one.motion.tracks.empty()) continue;
    const double stops = activity::first_touch(rehearsal_.cell, begin, one.motion).time;
    steps.push_back(std::make_shared<const PlayedStep>(PlayedStep{.begin = rehearsal_.duration + one.begin,
                                                                  .branch = branch,
                                                                  .timed = one.timed,
                                                                  .before = begin,
                                                                  .motion = std::move(one.motion),
                                                                  .stops = stops,
                                                                  .arm = std::move(own.arm),
                                                                  .moves = std::move(own.pointers),
                                                                  .may_wait = false,
                                                                  .never_beside = std::move(one.never_beside)}));
  }
  return steps;
}

void CommandReview::finish(Diagnostics& diagnostics) {
  if (!review_) return;
  rehearsal_.collisions.meanwhile.spaces = review_->spaces();
  diagnostics.append(review_->notes());
}

}  // namespace takt::operations
