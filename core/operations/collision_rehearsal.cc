#include "core/operations/collision_rehearsal.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "core/operations/step.h"

namespace takt::activity {
namespace {

using collision::CellShapes;
using collision::Situation;

constexpr double kSameTime = 1e-9;  // s

bool is_checked(const Rehearsal& rehearsal) {
  return rehearsal.cell.shapes != nullptr && rehearsal.cell.shapes->off.empty();
}

/// @param time  s after the motion begins
FoundCollision found_in(const CheckedMotion& motion, const CellShapes& shapes, const collision::State& before,
                        const collision::Hit& hit, double time) {
  const CheckedMotion::Part& part = motion.part_at(time);
  FoundCollision found{.step = part.step,
                       .pointer = part.pointer,
                       .a = shapes.scene.body(hit.a).name,
                       .b = shapes.scene.body(hit.b).name,
                       .time = time - part.begin,
                       .distance = hit.distance,
                       .state = before};
  found.state.q = hit.q;
  return found;
}

using PlayedSteps = std::vector<std::shared_ptr<const PlayedStep>>;

/// Motions of one branch or of several, on one clock.
class Timeline {
 public:
  Timeline(const command::Cell& cell, Situation begin, PlayedSteps played)
      : cell_(cell), shapes_(*cell.shapes), begin_(std::move(begin)), played_(std::move(played)) {
    for (const auto& step : played_) first_of_branch_.try_emplace(step->branch, step.get());
    find_borders();
  }

  /// Between two borders nothing begins, ends or changes hands.
  void check(std::vector<FoundCollision>* found, Diagnostics& diagnostics) {
    for (std::size_t i = 0; i + 1 < borders_.size(); ++i)
      check_between(borders_[i], borders_[i + 1], found, diagnostics);
  }

 private:
  void find_borders() {
    for (const auto& step : played_) {
      borders_.push_back(step->begin);
      borders_.push_back(step->end());
    }
    std::ranges::sort(borders_);
    const auto same = std::ranges::unique(borders_, [](double a, double b) { return b - a < kSameTime; });
    borders_.erase(same.begin(), same.end());
  }

  void check_between(double from, double to, std::vector<FoundCollision>* found, Diagnostics& diagnostics) {
    std::vector<const PlayedStep*> moving;
    std::vector<PlayedTrack> tracks;
    collision::Touching touching;
    for (const auto& step : played_) {
      if (!step->motion || step->begin > from + kSameTime || step->end() < to - kSameTime) continue;
      moving.push_back(step.get());
      tracks.push_back({&*step->motion, step->begin, step->stops});
      touching.insert(step->motion->touching.begin(), step->motion->touching.end());
    }
    if (moving.empty()) return;
    Situation at_begin = situation_at(from);
    for (const PlayedStep* step : moving)
      at_begin.unknown.insert(step->before.unknown.begin(), step->before.unknown.end());
    const collision::ContactRules rules(shapes_, at_begin);
    collision::CheckOptions options{.margin = shapes_.margin, .rule = {}, .bodies = {}};
    options.rule = [&](int a, int b) {
      // When a tool touches what it may was looked at before: its motion stops there.
      const collision::Contact contact = rules.contact(a, b, touching);
      return collision::rule_for(contact == collision::Contact::kMeant ? collision::Contact::kIgnored : contact,
                                 collision::kSetDownOverlap);
    };
    const collision::Trajectory trajectory = trajectory_of(cell_, std::move(tracks), from, to);
    for (const collision::Hit& hit : collision::check_motion(shapes_.scene, at_begin.state, trajectory, options))
      report(hit, from, at_begin, moving, found, diagnostics);
  }

  /// One for each pair of machines or objects: what follows of a collision is no news.
  void report(const collision::Hit& hit, double from, const Situation& at_begin,
              const std::vector<const PlayedStep*>& moving, std::vector<FoundCollision>* found,
              Diagnostics& diagnostics) {
    const collision::Body &a = shapes_.scene.body(hit.a), &b = shapes_.scene.body(hit.b);
    const std::set<std::string> of_a = arms_of(hit.a, at_begin), of_b = arms_of(hit.b, at_begin);
    const PlayedStep* first = mover_of(of_a, moving);
    const PlayedStep* second = mover_of(of_b, moving);
    if (first == nullptr) std::swap(first, second);
    if (first == nullptr) return;  // neither moves
    if (!reported_.insert({first, a.owner, b.owner}).second) return;
    const double time = from + hit.time;
    FoundCollision one = found_in(*first->motion, shapes_, at_begin.state, hit, time - first->begin);
    std::string meanwhile;
    if (second != nullptr && second != first) meanwhile = second->motion->part_at(time - second->begin).step;
    const Severity severity = is_certain(of_a, of_b, time) ? Severity::kError : Severity::kNote;
    diagnostics.add(diagnostic_of(one, shapes_, severity, meanwhile));
    if (found != nullptr) found->push_back(std::move(one));
  }

  /// All arms that carry a body, an arm's base among them.
  [[nodiscard]] std::set<std::string> arms_of(int body, const Situation& situation) const {
    std::set<std::string> arms;
    for (int at = body; at >= 0;) {
      const collision::Body& one = shapes_.scene.body(at);
      if (shapes_.arms.contains(one.owner)) arms.insert(one.owner);
      at = one.root ? situation.state.fixings[static_cast<std::size_t>(at)].parent : one.parent;
    }
    return arms;
  }
  static bool drives(const PlayedStep& step, const std::set<std::string>& arms) {
    return step.motion &&
           std::ranges::any_of(step.motion->tracks, [&](const ArmTrack& track) { return arms.contains(track.arm); });
  }
  static const PlayedStep* mover_of(const std::set<std::string>& arms, const std::vector<const PlayedStep*>& moving) {
    const auto found = std::ranges::find_if(moving, [&](const PlayedStep* step) { return drives(*step, arms); });
    return found == moving.end() ? nullptr : *found;
  }
  /// Either one branch alone brings both where they meet, or all times are known until then.
  [[nodiscard]] bool is_certain(const std::set<std::string>& of_a, const std::set<std::string>& of_b,
                                double time) const {
    std::set<int> branches;
    bool timed = true;
    for (const auto& step : played_) {
      if (step->begin > time || !(drives(*step, of_a) || drives(*step, of_b))) continue;
      branches.insert(step->branch);
      timed = timed && step->timed;
    }
    return timed || branches.size() < 2;
  }

  // -- How things are at a time
  // ----------------------------------------------------------------------------------------

  /// What its branch has changed since it began is so; the latest counts.
  template <class Differs>
  [[nodiscard]] const Situation& latest(double time, const Differs& differs) const {
    const PlayedStep* last = nullptr;
    for (const auto& step : played_) {
      if (step->begin > time + kSameTime || (last != nullptr && step->begin < last->begin)) continue;
      if (differs(step->before, first_of_branch_.at(step->branch)->before)) last = step.get();
    }
    return last != nullptr ? last->before : begin_;
  }

  [[nodiscard]] Situation situation_at(double time) const {
    Situation now = begin_;
    put_objects(time, now);
    put_fingers(time, now);
    std::vector<const PlayedStep*> over;
    for (const auto& step : played_)
      if (step->motion && step->end() <= time + kSameTime) over.push_back(step.get());
    std::ranges::stable_sort(over, {}, &PlayedStep::end);
    for (const PlayedStep* step : over)
      for (const ArmTrack& track : step->motion->tracks)
        command::set_joints(shapes_, track.arm, track.joints.at(track.joints.duration()), now.state);
    return now;
  }

  void put_objects(double time, Situation& now) const {
    const auto with = [](const auto& map, int body) {
      const auto found = map.find(body);
      return found == map.end() ? std::set<std::string>() : found->second;
    };
    for (const std::string& object : shapes_.objects) {
      const int body = shapes_.scene.root_of(object);
      if (body < 0) continue;
      const auto number = static_cast<std::size_t>(body);
      const Situation& there = latest(time, [&](const Situation& a, const Situation& b) {
        const collision::Fixing &one = a.state.fixings[number], &other = b.state.fixings[number];
        return one.parent != other.parent || !one.X_P.isApprox(other.X_P) ||
               a.unknown.contains(body) != b.unknown.contains(body) || with(a.holders, body) != with(b.holders, body);
      });
      now.state.fixings[number] = there.state.fixings[number];
      if (there.unknown.contains(body)) now.unknown.insert(body);
      if (!there.unknown.contains(body)) now.unknown.erase(body);
      now.holders.erase(body);
      if (const auto holders = with(there.holders, body); !holders.empty()) now.holders[body] = holders;
    }
  }

  void put_fingers(double time, Situation& now) const {
    for (const auto& [gripper, joints] : shapes_.grippers) {
      for (const int joint : joints) {
        const auto number = static_cast<std::size_t>(joint);
        const Situation& there = latest(
            time, [&](const Situation& a, const Situation& b) { return a.state.q[number] != b.state.q[number]; });
        now.state.q[number] = there.state.q[number];
      }
    }
  }

  const command::Cell& cell_;
  const CellShapes& shapes_;
  Situation begin_;
  PlayedSteps played_;
  std::map<int, const PlayedStep*> first_of_branch_;
  std::vector<double> borders_;
  std::set<std::tuple<const PlayedStep*, std::string, std::string>> reported_;
};

/// Whether a body never moves, whatever the program does: furniture, and the first link of a machine in the world.
bool never_moves(const CellShapes& shapes, const collision::ContactRules& rules, const Situation& situation, int body) {
  const collision::Body& one = shapes.scene.body(body);
  const bool in_world = one.root && situation.state.fixings[static_cast<std::size_t>(body)].parent < 0;
  return (in_world || rules.arm_of(body).empty()) && !shapes.free_objects.contains(one.owner);
}

void add_unknown_arms(const CellShapes& shapes, const std::set<std::string>& arms, Situation& situation) {
  if (arms.empty()) return;
  const collision::ContactRules rules(shapes, situation);
  const int count = static_cast<int>(shapes.scene.bodies().size());
  for (int body = 0; body < count; ++body)
    if (arms.contains(rules.arm_of(body))) situation.unknown.insert(body);
}

void report_early_touches(const Rehearsal& rehearsal, const PlayedStep& step, const FirstTouch& touch,
                          Diagnostics& diagnostics) {
  const CellShapes& shapes = *rehearsal.cell.shapes;
  for (const collision::Hit& hit : touch.too_soon) {
    FoundCollision one = found_in(*step.motion, shapes, step.before.state, hit, hit.time);
    diagnostics.add(diagnostic_of(one, shapes, Severity::kError));
    if (rehearsal.collisions.found != nullptr) rehearsal.collisions.found->push_back(std::move(one));
  }
}

/// An arm that was made compliant before may touch all the time.
void add_compliant(const Rehearsal& rehearsal, CheckedMotion& motion) {
  for (const ArmTrack& track : motion.tracks) {
    const auto mode = rehearsal.modes.find(track.arm);
    if (mode == rehearsal.modes.end() || mode->second == device::ControlMode::kPosition) continue;
    motion.touching.insert(track.arm);
    motion.touch_from = 0.0;
    motion.ends_at_touch = false;
  }
}

}  // namespace

/// A part that a gripper without a named one has moved may be any like it: once it is let go nobody knows where it is.
Situation situation_of(const Rehearsal& rehearsal) {
  Situation situation = believed_situation(rehearsal.cell, rehearsal.q, rehearsal.collisions.widths);
  for (const std::string& object : rehearsal.one_of_many) {
    const int body = rehearsal.cell.shapes->scene.root_of(object);
    if (body >= 0 && !rehearsal.cell.is_held(object)) situation.unknown.insert(body);
  }
  return situation;
}

void check_start(const Rehearsal& rehearsal, Diagnostics& diagnostics) {
  if (!is_checked(rehearsal)) return;
  const CellShapes& shapes = *rehearsal.cell.shapes;
  const Situation start = situation_of(rehearsal);
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
    FoundCollision one{.step = {},
                       .pointer = {},
                       .a = shapes.scene.body(hit.a).name,
                       .b = shapes.scene.body(hit.b).name,
                       .distance = hit.distance,
                       .state = start.state};
    diagnostics.add(diagnostic_of(one, shapes, Severity::kError));
    if (rehearsal.collisions.found != nullptr) rehearsal.collisions.found->push_back(std::move(one));
  }
}

void check_planned(Rehearsal& rehearsal, CheckedMotion motion, Diagnostics& diagnostics,
                   const std::set<std::string>& unknown) {
  if (!is_checked(rehearsal) || motion.tracks.empty()) return;
  add_compliant(rehearsal, motion);
  auto step = std::make_shared<PlayedStep>(PlayedStep{.begin = rehearsal.duration,
                                                      .branch = rehearsal.collisions.branch,
                                                      .timed = rehearsal.collisions.timed,
                                                      .before = situation_of(rehearsal),
                                                      .motion = std::move(motion)});
  add_unknown_arms(*rehearsal.cell.shapes, unknown, step->before);
  const FirstTouch touch = first_touch(rehearsal.cell, step->before, *step->motion);
  step->stops = touch.time;
  report_early_touches(rehearsal, *step, touch, diagnostics);
  if (rehearsal.collisions.branch != 0) return rehearsal.collisions.played.push_back(std::move(step));
  Situation begin = step->before;
  Timeline(rehearsal.cell, std::move(begin), {std::move(step)}).check(rehearsal.collisions.found, diagnostics);
}

void lose_time(Rehearsal& rehearsal) { rehearsal.collisions.timed = false; }

void note_fingers(Rehearsal& rehearsal, const std::string& gripper, double width, const std::string& object) {
  if (!is_checked(rehearsal)) return;
  if (!object.empty()) {
    const double widest = rehearsal.cell.grippers.find(gripper)->second.device->description().stroke;
    width = std::max(width, width_around(*rehearsal.cell.shapes, situation_of(rehearsal), gripper, object, widest));
  }
  rehearsal.collisions.widths[gripper] = width;
}

// -- Branches
// -----------------------------------------------------------------------------------------------------------

BranchesTogether::BranchesTogether(Rehearsal& rehearsal)
    : rehearsal_(rehearsal), outer_(rehearsal.collisions.branch), timed_(rehearsal.collisions.timed) {
  if (!is_checked(rehearsal)) return;
  if (outer_ != 0) {
    note();
    return;
  }
  rehearsal.collisions.branches = std::make_shared<int>(0);
  begin_ = situation_of(rehearsal);
  timed_ = true;
}

/// How the branch that is being played believes the cell to be now.
void BranchesTogether::note() {
  if (!is_checked(rehearsal_)) return;
  rehearsal_.collisions.played.push_back(
      std::make_shared<const PlayedStep>(PlayedStep{.begin = rehearsal_.duration,
                                                    .branch = rehearsal_.collisions.branch,
                                                    .timed = rehearsal_.collisions.timed,
                                                    .before = situation_of(rehearsal_)}));
}

void BranchesTogether::begin_branch() {
  if (!is_checked(rehearsal_)) return;
  rehearsal_.collisions.branch = ++*rehearsal_.collisions.branches;
  rehearsal_.collisions.timed = timed_;
  note();
}

void BranchesTogether::end_branch() {
  note();
  all_timed_ = all_timed_ && rehearsal_.collisions.timed;
}

void BranchesTogether::finish(Diagnostics& diagnostics) {
  if (!is_checked(rehearsal_)) return;
  CollisionRecord& record = rehearsal_.collisions;
  record.branch = outer_;
  record.timed = all_timed_;
  if (outer_ != 0) return;
  Timeline(rehearsal_.cell, std::move(*begin_), std::exchange(record.played, {})).check(record.found, diagnostics);
  record.timed = true;
}

}  // namespace takt::activity
