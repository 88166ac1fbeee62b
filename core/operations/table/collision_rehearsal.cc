#include "core/operations/table/collision_rehearsal.h"

#include <algorithm>
#include <utility>

#include "core/operations/table/step.h"

namespace takt::operations {
namespace {

using collision::CellShapes;
using collision::CellState;

/// Whether a body never moves, whatever the program does: furniture, and the first link of a machine in the world.
bool never_moves(const CellShapes& shapes, const collision::ContactRules& rules, const CellState& situation, int body) {
  const collision::Body& one = shapes.scene.body(body);
  const bool in_world = one.root && situation.state.fixings[static_cast<std::size_t>(body)].parent < 0;
  return (in_world || rules.arm_of(body).empty()) && !shapes.free_objects.contains(one.owner);
}

void add_unknown_arms(const CellShapes& shapes, const std::set<std::string>& arms, CellState& situation) {
  if (arms.empty()) return;
  const collision::ContactRules rules(shapes, situation);
  const int count = static_cast<int>(shapes.scene.bodies().size());
  for (int body = 0; body < count; ++body)
    if (arms.contains(rules.arm_of(body))) situation.unknown.insert(body);
}

void report_early_touches(const Rehearsal& rehearsal, const PlayedStep& step, const activity::FirstTouch& touch,
                          Diagnostics& diagnostics) {
  const CellShapes& shapes = *rehearsal.cell.shapes;
  for (const collision::Hit& hit : touch.too_soon) {
    activity::FoundCollision one = found_in(*step.motion, shapes, step.before.state, hit, hit.time);
    diagnostics.add(activity::diagnostic_of(one, shapes, Severity::kError));
    if (rehearsal.collisions.found != nullptr) rehearsal.collisions.found->push_back(std::move(one));
  }
}

/// An arm that was made compliant before may touch all the time.
void add_compliant(const Rehearsal& rehearsal, activity::CheckedMotion& motion) {
  for (const activity::ArmTrack& track : motion.tracks) {
    const auto mode = rehearsal.modes.find(track.arm);
    if (mode == rehearsal.modes.end() || mode->second == device::ControlMode::kPosition) continue;
    motion.touching.insert(track.arm);
    motion.touch_from = 0.0;
    motion.ends_at_touch = false;
  }
}

/// A `move` that was noted, and its motion now.
bool is_waiting(const PlayedStep& noted, const PlayedStep& planned) {
  return !noted.moves.empty() && !noted.motion && noted.branch == planned.branch && noted.begin == planned.begin &&
         planned.drives({noted.arm});
}

/// With what it touches too soon. A `move` that was noted before is that.
std::shared_ptr<const PlayedStep> played_step(Rehearsal& rehearsal, TimedMotion timed, const CellState& before,
                                              Diagnostics& diagnostics) {
  add_compliant(rehearsal, timed.motion);
  auto step =
      std::make_shared<PlayedStep>(PlayedStep{.begin = rehearsal.duration + timed.begin,
                                              .branch = timed.branch != 0 ? timed.branch : rehearsal.collisions.branch,
                                              .timed = rehearsal.collisions.timed && timed.timed,
                                              .before = before,
                                              .motion = std::move(timed.motion),
                                              .arm = std::move(timed.arm),
                                              .moves = std::move(timed.moves),
                                              .may_wait = timed.branch == 0,
                                              .never_beside = std::move(timed.never_beside)});
  const activity::FirstTouch touch = activity::first_touch(rehearsal.cell, step->before, *step->motion);
  step->stops = touch.time;
  report_early_touches(rehearsal, *step, touch, diagnostics);
  if (PlayedSteps& played = rehearsal.collisions.played; !played.empty() && is_waiting(*played.back(), *step)) {
    step->arm = played.back()->arm;
    step->moves = played.back()->moves;
    step->may_wait = played.back()->may_wait;
    played.pop_back();
  }
  return step;
}

/// How the branch that is being played believes the cell to be now.
void note_situation(Rehearsal& rehearsal) {
  rehearsal.collisions.played.push_back(
      std::make_shared<const PlayedStep>(PlayedStep{.begin = rehearsal.duration,
                                                    .branch = rehearsal.collisions.branch,
                                                    .timed = rehearsal.collisions.timed,
                                                    .before = situation_of(rehearsal)}));
}

/// Where the file puts one of two things that overlap: an object first, since it is moved more easily than a machine.
std::string pointer_of_either(const expression::Cell& cell, const std::string& a, const std::string& b) {
  for (const std::string& one : {b, a})
    if (cell.objects.contains(one) && !cell.tool_sides.contains(one)) return "/objects" + pointer_segment(one);
  for (const std::string& one : {a, b})
    if (cell.arms.contains(one) || cell.tools.contains(one) || cell.sensors.contains(one) ||
        cell.tool_sides.contains(one))
      return "/devices" + pointer_segment(one);
  return {};
}

}  // namespace

bool checks_motions(const Rehearsal& rehearsal) {
  return rehearsal.cell.shapes != nullptr && rehearsal.cell.shapes->off.empty();
}

/// A part that a gripper without a named one has moved may be any like it: once it is let go nobody knows where it is.
/// Of an arm whose step failed nothing is checked: what it met from a wrong start would be no fault of the program.
CellState situation_of(const Rehearsal& rehearsal) {
  CellState situation = believed_situation(rehearsal.cell, rehearsal.q, rehearsal.collisions.widths);
  for (const std::string& object : rehearsal.one_of_many) {
    const int body = rehearsal.cell.shapes->scene.root_of(object);
    if (body >= 0 && !rehearsal.cell.is_held(object)) situation.unknown.insert(body);
  }
  add_unknown_arms(*rehearsal.cell.shapes, rehearsal.lost, situation);
  return situation;
}

void check_start(const Rehearsal& rehearsal, Diagnostics& diagnostics) {
  if (!checks_motions(rehearsal)) return;
  const CellShapes& shapes = *rehearsal.cell.shapes;
  const CellState start = situation_of(rehearsal);
  const collision::ContactRules rules(shapes, start);
  collision::CheckOptions options{.margin = shapes.margin, .rule = {}, .bodies = {}};
  options.rule = [&](int a, int b) -> collision::PairRule {
    const bool still = never_moves(shapes, rules, start, a) && never_moves(shapes, rules, start, b);
    const bool known = !start.unknown.contains(a) && !start.unknown.contains(b);
    if (still || !known || shapes.is_relaxed(shapes.scene.body(a), shapes.scene.body(b)))
      return {.kind = collision::PairRule::Kind::kIgnored};
    return {.kind = collision::PairRule::Kind::kTouch, .overlap = collision::kSetDownOverlap};
  };
  const std::vector<bool> all(shapes.scene.bodies().size(), true);
  for (const collision::Hit& hit : check_state(shapes.scene, start.state, all, options)) {
    activity::FoundCollision one{
        .step = {},
        .pointer = pointer_of_either(rehearsal.cell, shapes.scene.body(hit.a).owner, shapes.scene.body(hit.b).owner),
        .a = shapes.scene.body(hit.a).name,
        .b = shapes.scene.body(hit.b).name,
        .distance = hit.distance,
        .state = start.state};
    diagnostics.add(activity::diagnostic_of(one, shapes, Severity::kError));
    if (rehearsal.collisions.found != nullptr) rehearsal.collisions.found->push_back(std::move(one));
  }
}

void check_planned(Rehearsal& rehearsal, activity::CheckedMotion motion, Diagnostics& diagnostics,
                   const std::set<std::string>& unknown) {
  check_together(rehearsal, {{std::move(motion), 0.0}}, diagnostics, unknown);
}

void check_together(Rehearsal& rehearsal, std::vector<TimedMotion> motions, Diagnostics& diagnostics,
                    const std::set<std::string>& unknown) {
  std::erase_if(motions, [](const TimedMotion& one) { return one.motion.tracks.empty(); });
  if (!checks_motions(rehearsal) || motions.empty()) return;
  CellState begin = situation_of(rehearsal);
  add_unknown_arms(*rehearsal.cell.shapes, unknown, begin);
  PlayedSteps steps;
  for (TimedMotion& one : motions) steps.push_back(played_step(rehearsal, std::move(one), begin, diagnostics));
  PlayedSteps& played = rehearsal.collisions.played;
  if (rehearsal.collisions.branch != 0) return (void)played.insert(played.end(), steps.begin(), steps.end());
  Timeline(rehearsal.cell, std::move(begin), std::move(steps)).check(rehearsal.collisions.found, diagnostics);
}

void check_fingers(const Rehearsal& rehearsal, const std::string& gripper, const CellState& before, bool closes,
                   const std::string& pointer, Diagnostics& diagnostics) {
  if (!checks_motions(rehearsal)) return;
  const CellShapes& shapes = *rehearsal.cell.shapes;
  const auto fingers = shapes.grippers.find(gripper);
  if (fingers == shapes.grippers.end() || rehearsal.lost.contains(rehearsal.cell.grippers.find(gripper)->second.arm))
    return;
  const std::vector<double> to = situation_of(rehearsal).state.q;
  const collision::ContactRules rules(shapes, before);
  const collision::Touching touching = closes ? collision::Touching{gripper} : collision::Touching{};
  collision::CheckOptions options{.margin = shapes.margin, .rule = {}, .bodies = {}};
  options.rule = [&](int a, int b) {
    const collision::Contact contact = rules.contact(a, b, touching);
    return collision::rule_for(contact == collision::Contact::kMeant ? collision::Contact::kIgnored : contact,
                               collision::kSetDownOverlap);
  };
  // Their way is what counts, and not when: one second, at constant speed.
  const collision::Trajectory way{.duration = 1.0,
                                  .joints = fingers->second,
                                  .acceleration = std::vector<double>(fingers->second.size(), 0.0),
                                  .at = [&](double time, std::vector<double>& q) {
                                    for (const int joint : fingers->second) {
                                      const auto number = static_cast<std::size_t>(joint);
                                      q[number] = (1.0 - time) * before.state.q[number] + time * to[number];
                                    }
                                  }};
  for (const collision::Hit& hit : collision::check_motion(shapes.scene, before.state, way, options)) {
    activity::FoundCollision one{.step = rehearsal.step,
                                 .pointer = pointer,
                                 .a = shapes.scene.body(hit.a).name,
                                 .b = shapes.scene.body(hit.b).name,
                                 .time = hit.time,
                                 .distance = hit.distance,
                                 .state = before.state};
    one.state.q = hit.q;
    diagnostics.add(activity::diagnostic_of(one, shapes, Severity::kError));
    if (rehearsal.collisions.found != nullptr) rehearsal.collisions.found->push_back(std::move(one));
  }
}

void note_moves(Rehearsal& rehearsal, const std::string& arm, std::vector<std::string> pointers, bool may_wait) {
  if (!checks_motions(rehearsal) || rehearsal.collisions.branch == 0 || pointers.empty()) return;
  rehearsal.collisions.played.push_back(
      std::make_shared<const PlayedStep>(PlayedStep{.begin = rehearsal.duration,
                                                    .branch = rehearsal.collisions.branch,
                                                    .timed = rehearsal.collisions.timed,
                                                    .before = situation_of(rehearsal),
                                                    .arm = arm,
                                                    .moves = std::move(pointers),
                                                    .may_wait = may_wait}));
}

int branch_within(Rehearsal& rehearsal) {
  if (!checks_motions(rehearsal) || rehearsal.collisions.branch == 0) return 0;
  // How its branch believes the cell to be by now: what begins within it does not tell that.
  note_situation(rehearsal);
  BranchParents& branches = *rehearsal.collisions.branches;
  branches.push_back(rehearsal.collisions.branch);
  return static_cast<int>(branches.size()) - 1;
}

void invalidate_timing(Rehearsal& rehearsal) { rehearsal.collisions.timed = false; }

void note_fingers(Rehearsal& rehearsal, const std::string& gripper, double width, const std::string& object) {
  if (!checks_motions(rehearsal)) return;
  if (!object.empty()) {
    const double widest = rehearsal.cell.grippers.find(gripper)->second.device->description().stroke;
    width = std::max(width,
                     activity::width_around(*rehearsal.cell.shapes, situation_of(rehearsal), gripper, object, widest));
  }
  rehearsal.collisions.widths[gripper] = width;
}

// -- Branches
// -----------------------------------------------------------------------------------------------------------

BranchesTogether::BranchesTogether(Rehearsal& rehearsal, const std::string& parallel)
    : rehearsal_(rehearsal), outer_(rehearsal.collisions.branch), timed_(rehearsal.collisions.timed) {
  if (!checks_motions(rehearsal)) return;
  if (outer_ != 0) {
    note();
    return;
  }
  CollisionRecord& record = rehearsal.collisions;
  record.branches = std::make_shared<BranchParents>(1, -1);
  record.meanwhile.parallel = parallel;
  begin_ = situation_of(rehearsal);
  timed_ = true;
  review_.emplace(parallel, record.meanwhile.spaces);
  before_ = std::make_unique<const Rehearsal>(rehearsal);
  nets_ = rehearsal.nets != nullptr ? rehearsal.nets->size() : 0;
  found_ = record.found != nullptr ? record.found->size() : 0;
}

void BranchesTogether::note() {
  if (checks_motions(rehearsal_)) note_situation(rehearsal_);
}

void BranchesTogether::begin_branch() {
  if (!checks_motions(rehearsal_)) return;
  BranchParents& branches = *rehearsal_.collisions.branches;
  rehearsal_.collisions.branch = static_cast<int>(branches.size());
  branches.push_back(outer_);
  rehearsal_.collisions.timed = timed_;
  note();
}

void BranchesTogether::end_branch() {
  note();
  all_timed_ = all_timed_ && rehearsal_.collisions.timed;
}

bool BranchesTogether::play_again(const Diagnostics& said) {
  if (!checks_motions(rehearsal_) || outer_ != 0) return false;
  const CollisionRecord& record = rehearsal_.collisions;
  if (!review_->review(Timeline(rehearsal_.cell, *begin_, record.played), *record.branches, said)) return false;
  go_back();
  return true;
}

void BranchesTogether::go_back() {
  rehearsal_ = *before_;
  rehearsal_.collisions.branches = std::make_shared<BranchParents>(1, -1);
  rehearsal_.collisions.meanwhile.spaces = review_->spaces();
  if (rehearsal_.nets != nullptr) rehearsal_.nets->resize(nets_);
  if (rehearsal_.collisions.found != nullptr) rehearsal_.collisions.found->resize(found_);
  all_timed_ = true;
}

void BranchesTogether::finish(Diagnostics& diagnostics) {
  if (!checks_motions(rehearsal_)) return;
  CollisionRecord& record = rehearsal_.collisions;
  record.branch = outer_;
  record.timed = all_timed_;
  if (outer_ != 0) return;
  diagnostics.append(review_->notes());
  Timeline(rehearsal_.cell, std::move(*begin_), std::exchange(record.played, {})).check(record.found, diagnostics);
  record.timed = true;
  record.meanwhile.parallel.clear();
}

}  // namespace takt::operations
