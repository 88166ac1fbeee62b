#include "core/operations/review/timeline.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace takt::operations {
namespace {

using collision::CellShapes;
using collision::CellState;

constexpr double kSameTime = 1e-9;  // s

const PlayedStep* mover_of(const std::set<std::string>& arms, const std::vector<const PlayedStep*>& moving) {
  const auto found = std::ranges::find_if(moving, [&](const PlayedStep* step) { return step->drives(arms); });
  return found == moving.end() ? nullptr : *found;
}

}  // namespace

activity::FoundCollision found_in(const activity::CheckedMotion& motion, const CellShapes& shapes,
                                  const collision::State& before, const collision::Hit& hit, double time) {
  const activity::CheckedMotion::Part& part = motion.part_at(time);
  activity::FoundCollision found{.step = part.step,
                                 .pointer = part.pointer,
                                 .a = shapes.scene.body(hit.a).name,
                                 .b = shapes.scene.body(hit.b).name,
                                 .time = time - part.begin,
                                 .distance = hit.distance,
                                 .state = before};
  found.state.q = hit.q;
  return found;
}

bool PlayedStep::drives(const std::set<std::string>& arms) const {
  return motion &&
         std::ranges::any_of(motion->tracks, [&](const activity::ArmTrack& track) { return arms.contains(track.arm); });
}

Timeline::Timeline(const expression::Cell& cell, CellState begin, PlayedSteps played)
    : cell_(cell), shapes_(*cell.shapes), begin_(std::move(begin)), played_(std::move(played)) {
  for (const auto& step : played_) first_of_branch_.try_emplace(step->branch, step.get());
  find_borders();
}

void Timeline::check(std::vector<activity::FoundCollision>* found, Diagnostics& diagnostics) {
  check_goals(diagnostics);
  for (std::size_t i = 0; i + 1 < borders_.size(); ++i) check_between(borders_[i], borders_[i + 1], found, diagnostics);
}

/// A goal is looked up when its motion begins. What it is on has to stand until the motion has ended.
void Timeline::check_goals(Diagnostics& diagnostics) const {
  for (const auto& step : played_) {
    if (!step->motion) continue;
    for (const activity::CheckedMotion::Part& part : step->motion->parts) {
      const auto moves_meanwhile = [&](const auto& other) {
        return other->branch != step->branch && other->drives(part.goal_on) && other->begin < step->end() - kSameTime &&
               other->end() > step->begin + kSameTime;
      };
      const auto other = std::ranges::find_if(played_, moves_meanwhile);
      if (other == played_.end()) continue;
      const activity::CheckedMotion& motion = *(*other)->motion;
      const auto on = std::ranges::find_if(
          motion.tracks, [&](const activity::ArmTrack& track) { return part.goal_on.contains(track.arm); });
      diagnostics.add(
          {.severity = step->timed && (*other)->timed ? Severity::kError : Severity::kNote,
           .code = Code::kUnknownPose,
           .file = {},
           .pointer = part.pointer + "/to",
           .message = fmt::format("where the goal is depends on '{}', which '{}' moves meanwhile", on->arm,
                                  motion.part_at(std::max(0.0, step->begin - (*other)->begin)).step),
           .hint = "Begin the motion once that stands, or give the goal in a frame that goes with the arm"});
    }
  }
}

void Timeline::find_borders() {
  for (const auto& step : played_) {
    borders_.push_back(step->begin);
    borders_.push_back(step->end());
  }
  std::ranges::sort(borders_);
  const auto same = std::ranges::unique(borders_, [](double a, double b) { return b - a < kSameTime; });
  borders_.erase(same.begin(), same.end());
}

void Timeline::check_between(double from, double to, std::vector<activity::FoundCollision>* found,
                             Diagnostics& diagnostics) {
  std::vector<const PlayedStep*> moving;
  std::vector<activity::PlayedTrack> tracks;
  collision::Touching touching;
  for (const auto& step : played_) {
    if (!step->motion || step->begin > from + kSameTime || step->end() < to - kSameTime) continue;
    moving.push_back(step.get());
    tracks.push_back({&*step->motion, step->begin, step->stops});
    touching.insert(step->motion->touching.begin(), step->motion->touching.end());
  }
  if (moving.empty()) return;
  CellState at_begin = situation_at(from);
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
  const collision::Trajectory trajectory = activity::trajectory_of(cell_, std::move(tracks), from, to);
  for (const collision::Hit& hit : collision::check_motion(shapes_.scene, at_begin.state, trajectory, options))
    report(hit, from, at_begin, moving, found, diagnostics);
}

void Timeline::report(const collision::Hit& hit, double from, const CellState& at_begin,
                      const std::vector<const PlayedStep*>& moving, std::vector<activity::FoundCollision>* found,
                      Diagnostics& diagnostics) {
  const collision::Body &a = shapes_.scene.body(hit.a), &b = shapes_.scene.body(hit.b);
  const std::set<std::string> of_a = arms_of(hit.a, at_begin), of_b = arms_of(hit.b, at_begin);
  const PlayedStep* first = mover_of(of_a, moving);
  const PlayedStep* second = mover_of(of_b, moving);
  if (first == nullptr) std::swap(first, second);
  if (first == nullptr) return;  // neither moves
  if (!reported_.insert({first, a.owner, b.owner}).second) return;
  const double time = from + hit.time;
  activity::FoundCollision one = found_in(*first->motion, shapes_, at_begin.state, hit, time - first->begin);
  std::string meanwhile;
  if (second != nullptr && second != first) meanwhile = second->motion->part_at(time - second->begin).step;
  const Severity severity = is_certain(of_a, of_b, time) ? Severity::kError : Severity::kNote;
  diagnostics.add(activity::diagnostic_of(one, shapes_, severity, meanwhile));
  if (found != nullptr) found->push_back(std::move(one));
}

std::set<std::string> Timeline::arms_of(int body, const CellState& situation) const {
  std::set<std::string> arms;
  for (int at = body; at >= 0;) {
    const collision::Body& one = shapes_.scene.body(at);
    if (shapes_.arms.contains(one.owner)) arms.insert(one.owner);
    at = one.root ? situation.state.fixings[static_cast<std::size_t>(at)].parent : one.parent;
  }
  return arms;
}

bool Timeline::is_certain(const std::set<std::string>& of_a, const std::set<std::string>& of_b, double time) const {
  std::set<int> branches;
  bool timed = true;
  for (const auto& step : played_) {
    if (step->begin > time || !(step->drives(of_a) || step->drives(of_b))) continue;
    branches.insert(step->branch);
    timed = timed && step->timed;
  }
  return timed || branches.size() < 2;
}

// -- How things are at a time
// ----------------------------------------------------------------------------------------

template <class Differs>
const CellState& Timeline::latest(double time, const Differs& differs) const {
  const PlayedStep* last = nullptr;
  for (const auto& step : played_) {
    if (step->begin > time + kSameTime || (last != nullptr && step->begin < last->begin)) continue;
    if (differs(step->before, first_of_branch_.at(step->branch)->before)) last = step.get();
  }
  return last != nullptr ? last->before : begin_;
}

CellState Timeline::situation_at(double time) const {
  CellState now = begin_;
  put_objects(time, now);
  put_fingers(time, now);
  std::vector<const PlayedStep*> over;
  for (const auto& step : played_)
    if (step->motion && step->end() <= time + kSameTime) over.push_back(step.get());
  std::ranges::stable_sort(over, {}, &PlayedStep::end);
  for (const PlayedStep* step : over)
    for (const activity::ArmTrack& track : step->motion->tracks)
      expression::set_joints(shapes_, track.arm, track.joints.at(track.joints.duration()), now.state);
  return now;
}

void Timeline::put_objects(double time, CellState& now) const {
  const auto with = [](const auto& map, int body) {
    const auto found = map.find(body);
    return found == map.end() ? std::set<std::string>() : found->second;
  };
  for (const std::string& object : shapes_.objects) {
    const int body = shapes_.scene.root_of(object);
    if (body < 0) continue;
    const auto number = static_cast<std::size_t>(body);
    const CellState& there = latest(time, [&](const CellState& a, const CellState& b) {
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

void Timeline::put_fingers(double time, CellState& now) const {
  for (const auto& [gripper, joints] : shapes_.grippers) {
    for (const int joint : joints) {
      const auto number = static_cast<std::size_t>(joint);
      const CellState& there =
          latest(time, [&](const CellState& a, const CellState& b) { return a.state.q[number] != b.state.q[number]; });
      now.state.q[number] = there.state.q[number];
    }
  }
}

}  // namespace takt::operations
