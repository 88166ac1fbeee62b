#include "core/operations/review/move_review.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace takt::operations {
namespace {

using collision::CellState;
using collision::SweptSpace;

/// How often the branches are played again at most.
constexpr int kMostRounds = 12;
/// Others may be so much earlier or later than planned, s: the branches of a run begin some cycles after each other.
constexpr double kSpare = 0.1;
/// What others sweep so long before and after they are in the way is kept clear of; twice as long in each round. s
constexpr double kAround = 0.3;
/// Poses of what is swept lie so near to each other, m.
constexpr double kSpacing = 0.02;
constexpr double kSameInstant = 1e-9;  // s

bool is_part_of(const BranchParents& parents, int branch, int whole) {
  while (branch > 0 && branch != whole) branch = parents[static_cast<std::size_t>(branch)];
  return branch == whole;
}
/// Neither comes before the other.
bool at_the_same_time(const BranchParents& parents, int a, int b) {
  return !is_part_of(parents, a, b) && !is_part_of(parents, b, a);
}

void add_moved(const collision::Scene& scene, const collision::State& state, const std::vector<int>& joints,
               std::set<int>& bodies) {
  const std::vector<bool> moved = scene.moved_by(state, joints);
  for (std::size_t body = 0; body < moved.size(); ++body)
    if (moved[body]) bodies.insert(static_cast<int>(body));
}

/// One `move`, and what others do beside it.
class ConcurrentMotionCheck {
 public:
  ConcurrentMotionCheck(const Timeline& timeline, const BranchParents& parents, const PlayedStep& step)
      : timeline_(timeline), shapes_(*timeline.cell().shapes), step_(step) {
    own_joints_ = shapes_.arms.find(step.arm)->second.joints;
    add_moved(shapes_.scene, step.before.state, own_joints_, own_);
    carriers_ = timeline.arms_of(shapes_.arms.find(step.arm)->second.flange, step.before);
    carriers_.erase(step.arm);
    std::vector<const PlayedStep*> others;
    for (const auto& other : timeline.played()) {
      if (!is_beside(*other, parents)) continue;
      others.push_back(other.get());
      if (!other->drives(carriers_)) continue;
      ride();
      lost_ = lost_ || !step.timed || !other->timed;
    }
    for (const PlayedStep* other : others) add_other(*other);
  }

  /// Others move something.
  [[nodiscard]] bool matters() const { return !timed_bodies_.empty() || !any_bodies_.empty(); }
  [[nodiscard]] bool beside_any() const { return !any_.empty(); }

  /// When something that moves on the same clock comes too near, s after it begins; also where that is earlier or
  /// later than planned.
  [[nodiscard]] std::vector<double> hits() const {
    std::vector<double> times;
    if (!step_.motion || timed_.empty() || lost_) return times;
    for (const double later : {-kSpare, 0.0, kSpare}) {
      const auto cuts = cuts_between(step_.begin + later, step_.begin + later + step_.stops);
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i) add_hits(later, cuts[i], cuts[i + 1], times);
    }
    return times;
  }

  /// When motions of others end of which that is known, s.
  [[nodiscard]] std::vector<double> ends() const {
    std::vector<double> ends;
    for (const PlayedStep* other : timed_) ends.push_back(other->begin + other->stops);
    std::ranges::sort(ends);
    return ends;
  }
  /// All that others move, without what it sweeps.
  void add_bodies(activity::MeanwhileSpace& space) const {
    for (const std::set<int>* bodies : {&timed_bodies_, &any_bodies_})
      for (const int body : *bodies) space.swept.bodies.try_emplace(body);
    if (!view_) return;
    for (const std::string& carrier : carriers_) {
      const std::vector<int>& joints = shapes_.arms.find(carrier)->second.joints;
      kinematics::JointVector& q = space.carriers[carrier];
      q.resize(static_cast<Eigen::Index>(joints.size()));
      for (std::size_t j = 0; j < joints.size(); ++j)
        q[static_cast<Eigen::Index>(j)] = shapes_.scene.start().q[static_cast<std::size_t>(joints[j])];
    }
  }
  /// What is swept from and until so long after it begins, s.
  void add_window(double from, double to, SweptSpace& swept) const {
    const auto cuts = cuts_between(step_.begin + from, step_.begin + to);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const CellState situation = timeline_.situation_at(cuts[i]);
      const auto moving = moving_between(cuts[i], cuts[i + 1]);
      const auto trajectory = activity::trajectory_of(timeline_.cell(), tracks_of_all(moving), cuts[i], cuts[i + 1]);
      std::set<int> left = timed_bodies_;
      int carried = -1;  // by which motion all that has none of its own is seen to move
      for (const PlayedStep* other : moving) {
        const int source = swept.source(other->motion->part_at(cuts[i] - other->begin).step);
        if (other->drives(carriers_)) carried = source;
        std::vector<int> moved;
        std::ranges::set_intersection(left, moved_by_itself(*other, situation), std::back_inserter(moved));
        for (const int body : moved) left.erase(body);
        add_swept(shapes_.scene, situation.state, trajectory, moved, kSpacing, cuts[i] - step_.begin, source, swept,
                  view());
      }
      const std::vector<int> still(left.begin(), left.end());
      add_swept(shapes_.scene, situation.state, trajectory, still, kSpacing, cuts[i] - step_.begin, carried, swept,
                view());
    }
  }
  /// What may be swept at any time. Of what moves by itself while the base drives it is not known where it is seen: it
  /// is left out.
  void add_any(SweptSpace& swept) const {
    for (const PlayedStep* other : any_) {
      const bool carries = other->drives(carriers_);
      if (view_ && !carries) continue;
      std::set<int> bodies = carries ? seen_to_move() : moved_by_itself(*other, other->before);
      if (carries)
        for (const int body : moved_) bodies.erase(body);
      std::vector<int> moved;
      std::ranges::set_difference(bodies, own_, std::back_inserter(moved));
      const auto trajectory =
          activity::trajectory_of(timeline_.cell(), {{&*other->motion, 0.0, other->stops}}, 0.0, other->stops);
      add_swept(shapes_.scene, other->before.state, trajectory, moved, kSpacing,
                std::numeric_limits<double>::quiet_NaN(), swept.source(other->motion->parts.front().step), swept,
                view());
    }
  }

 private:
  /// Of two `move`s that of the later branch gives way.
  [[nodiscard]] bool is_beside(const PlayedStep& other, const BranchParents& parents) const {
    if (!other.motion || other.drives({step_.arm}) || !at_the_same_time(parents, other.branch, step_.branch))
      return false;
    if (step_.never_beside.contains(other.motion->parts.front().pointer)) return false;
    return other.moves.empty() || other.branch < step_.branch || other.drives(carriers_);
  }
  /// What carries its arm drives meanwhile: the motions of all else are seen from there.
  void ride() {
    collision::Poses poses;
    collision::State state = step_.before.state;
    for (const std::string& carrier : carriers_)
      for (const int joint : shapes_.arms.find(carrier)->second.joints)
        state.q[static_cast<std::size_t>(joint)] = shapes_.scene.start().q[static_cast<std::size_t>(joint)];
    shapes_.scene.place(state, poses);
    const int root = shapes_.scene.root_of(step_.arm);
    view_ = collision::Viewpoint{root, poses[static_cast<std::size_t>(root)]};
  }
  [[nodiscard]] const collision::Viewpoint* view() const { return view_ ? &*view_ : nullptr; }
  /// All that is not carried along. The floor looks the same from wherever a base stands on it.
  [[nodiscard]] std::set<int> seen_to_move() const {
    std::vector<int> joints;
    for (const std::string& carrier : carriers_) {
      const std::vector<int>& more = shapes_.arms.find(carrier)->second.joints;
      joints.insert(joints.end(), more.begin(), more.end());
    }
    std::set<int> carried, bodies;
    add_moved(shapes_.scene, step_.before.state, joints, carried);
    for (int body = 0; body < static_cast<int>(shapes_.scene.bodies().size()); ++body)
      if (body != shapes_.floor && !carried.contains(body)) bodies.insert(body);
    return bodies;
  }
  /// What joints move that are not below its arm.
  [[nodiscard]] std::set<int> moved_by_itself(const PlayedStep& other, const CellState& situation) const {
    std::vector<int> joints;
    for (const activity::ArmTrack& track : other.motion->tracks) {
      const auto arm = shapes_.arms.find(track.arm);
      if (arm == shapes_.arms.end() || carriers_.contains(track.arm)) continue;
      joints.insert(joints.end(), arm->second.joints.begin(), arm->second.joints.end());
    }
    std::set<int> bodies;
    add_moved(shapes_.scene, situation.state, joints, bodies);
    return bodies;
  }
  void add_other(const PlayedStep& other) {
    const bool timed = step_.timed && other.timed;
    (timed ? timed_ : any_).push_back(&other);
    std::set<int> bodies = moved_by_itself(other, other.before);
    moved_.insert(bodies.begin(), bodies.end());
    if (other.drives(carriers_)) bodies.merge(seen_to_move());
    for (const int body : bodies)
      if (!own_.contains(body)) (timed ? timed_bodies_ : any_bodies_).insert(body);
  }

  [[nodiscard]] std::vector<double> cuts_between(double from, double to) const {
    std::vector<double> cuts{from};
    for (const double border : timeline_.borders())
      if (border > from + kSameInstant && border < to - kSameInstant) cuts.push_back(border);
    cuts.push_back(to);
    return cuts;
  }
  [[nodiscard]] std::vector<const PlayedStep*> moving_between(double from, double to) const {
    std::vector<const PlayedStep*> moving;
    for (const PlayedStep* other : timed_)
      if (other->begin <= from + kSameInstant && other->end() >= to - kSameInstant) moving.push_back(other);
    return moving;
  }
  static std::vector<activity::PlayedTrack> tracks_of_all(const std::vector<const PlayedStep*>& moving) {
    std::vector<activity::PlayedTrack> tracks;
    for (const PlayedStep* other : moving) tracks.push_back({&*other->motion, other->begin, other->stops});
    return tracks;
  }

  void add_hits(double later, double from, double to, std::vector<double>& times) const {
    // What it holds is known from its begin on.
    const CellState situation = timeline_.situation_at(std::max(from, step_.begin));
    const auto moving = moving_between(from, to);
    std::vector<activity::PlayedTrack> tracks = tracks_of_all(moving);
    tracks.push_back({&*step_.motion, step_.begin + later, step_.stops});
    collision::Touching touching = step_.motion->touching;
    for (const PlayedStep* other : moving)
      touching.insert(other->motion->touching.begin(), other->motion->touching.end());
    const collision::ContactRules rules(shapes_, situation);
    collision::CheckOptions options{.margin = shapes_.margin, .rule = {}, .bodies = {}};
    options.rule = [&](int a, int b) -> collision::PairRule {
      if (!timed_bodies_.contains(a) && !timed_bodies_.contains(b))
        return {.kind = collision::PairRule::Kind::kIgnored};
      const collision::Contact contact = rules.contact(a, b, touching);
      return collision::rule_for(contact == collision::Contact::kMeant ? collision::Contact::kIgnored : contact,
                                 collision::kSetDownOverlap);
    };
    options.bodies.assign(shapes_.scene.bodies().size(), false);
    for (const int body : own_) options.bodies[static_cast<std::size_t>(body)] = true;
    const auto trajectory = activity::trajectory_of(timeline_.cell(), std::move(tracks), from, to);
    for (const collision::Hit& hit : check_motion(shapes_.scene, situation.state, trajectory, options))
      times.push_back(from + hit.time - step_.begin);
  }

  const Timeline& timeline_;
  const collision::CellShapes& shapes_;
  const PlayedStep& step_;
  std::vector<int> own_joints_;
  std::set<int> own_;
  std::set<std::string> carriers_;              ///< machines that its arm stands on
  std::optional<collision::Viewpoint> view_;    ///< they drive meanwhile: it is on them
  bool lost_ = false;                           ///< when these drive is not known, and so not where its arm is
  std::set<int> moved_;                         ///< what others move, but for these
  std::vector<const PlayedStep*> timed_, any_;  ///< on the same clock; at any time
  std::set<int> timed_bodies_, any_bodies_;
};

/// Both: a `move` in a loop keeps clear of what others do in any of its rounds.
void add_poses(const SweptSpace& more, SweptSpace& swept) {
  for (const auto& [body, poses] : more.bodies) {
    std::vector<collision::SweptPose>& known = swept.bodies[body];
    const std::size_t own = known.size();
    for (collision::SweptPose pose : poses) {
      const auto same = [&](const collision::SweptPose& one) {
        return one.X_WB.matrix() == pose.X_WB.matrix() && one.within == pose.within;
      };
      if (std::any_of(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(own), same)) continue;
      if (pose.source >= 0) pose.source = swept.source(more.sources[static_cast<std::size_t>(pose.source)]);
      known.push_back(pose);
    }
  }
}

bool has_errors_below(const Diagnostics& diagnostics, const std::string& pointer) {
  return std::ranges::any_of(diagnostics.list(), [&](const Diagnostic& one) {
    return one.severity == Severity::kError && one.pointer.starts_with(pointer);
  });
}

}  // namespace

bool MoveReview::review(const Timeline& timeline, const BranchParents& parents, const Diagnostics& said) {
  std::map<std::string, activity::MeanwhileSpace> found;
  for (const auto& step : timeline.played())
    if (!step->moves.empty()) review_step(timeline, parents, *step, said, found);
  activity::MeanwhileSpaces spaces = spaces_ != nullptr ? *spaces_ : activity::MeanwhileSpaces{};
  bool changed = false;
  for (auto& [pointer, beside] : found) {
    if (const auto before = of_rounds_before(pointer)) add_poses(before->swept, beside.swept);
    auto& space = spaces[{parallel_, pointer}];
    if (space != nullptr && space->wait == beside.wait && same_space(space->swept, beside.swept)) continue;
    space = std::make_shared<const activity::MeanwhileSpace>(std::move(beside));
    changed = true;
  }
  if (!changed || ++rounds_ > kMostRounds) return false;
  spaces_ = std::make_shared<const activity::MeanwhileSpaces>(std::move(spaces));
  return true;
}

std::shared_ptr<const activity::MeanwhileSpace> MoveReview::of_rounds_before(const std::string& pointer) const {
  return activity::ConcurrentMotions{before_, parallel_}.of(pointer);
}

void MoveReview::review_step(const Timeline& timeline, const BranchParents& parents, const PlayedStep& step,
                             const Diagnostics& said, std::map<std::string, activity::MeanwhileSpace>& found) {
  if (!timeline.cell().shapes->arms.contains(step.arm)) return;
  const ConcurrentMotionCheck beside(timeline, parents, step);
  if (!beside.matters()) return;
  const auto before = of_rounds_before(step.moves.front());
  const auto [at, fresh] = known_.try_emplace(step.moves.front());
  Known& known = at->second;
  if (fresh && before) known.wait = before->wait;
  if (known.beside_any && unclear_ == Unclear::kLeftOut) give_up_any(step, said, known);
  const bool failed =
      std::ranges::any_of(step.moves, [&](const std::string& pointer) { return has_errors_below(said, pointer); });
  if (failed && !step.motion && step.may_wait && !known.windows.empty()) wait_longer(step, beside.ends(), known);
  // Before it was played with others in mind it may have been in the way of what had not moved yet.
  if (std::exchange(known.reviewed, true) || before) {
    const auto hits = beside.hits();
    const double around = kAround * std::exp2(known.tries);
    if (!hits.empty()) ++known.tries;
    for (const double time : hits) known.windows.push_back({time - around, time + around});
    join(known.windows);
  }
  known.beside_any = beside.beside_any() && !known.leaves_out_any;
  activity::MeanwhileSpace space{.wait = known.wait};
  beside.add_bodies(space);
  for (const Window& window : known.windows) beside.add_window(window.from, window.to, space.swept);
  if (known.beside_any) beside.add_any(space.swept);
  for (const std::string& pointer : step.moves) found[pointer] = space;
}

/// If none is left it begins when it would have, and what is said then is the reason.
void MoveReview::wait_longer(const PlayedStep& step, const std::vector<double>& ends, Known& known) {
  if (known.waits_in_vain) return;
  const auto next = std::ranges::find_if(ends, [&](double end) { return end > step.begin + kSameInstant; });
  known.waits_in_vain = next == ends.end();
  if (known.waits_in_vain) {
    std::swap(known.windows, known.first_windows);
    known.wait = 0.0;
    return;
  }
  if (known.first_windows.empty()) known.first_windows = known.windows;
  known.wait += *next + kSpare - step.begin;
  known.windows.clear();
  known.tries = 0;
}

/// Those that overlap become one.
void MoveReview::join(std::vector<Window>& windows) {
  std::ranges::sort(windows, {}, &Window::from);
  std::vector<Window> joined;
  for (const Window& one : windows) {
    if (!joined.empty() && one.from <= joined.back().to) {
      joined.back().to = std::max(joined.back().to, one.to);
    } else {
      joined.push_back(one);
    }
  }
  windows = std::move(joined);
}

void MoveReview::give_up_any(const PlayedStep& step, const Diagnostics& said, Known& known) {
  const auto failed =
      std::ranges::find_if(step.moves, [&](const std::string& pointer) { return has_errors_below(said, pointer); });
  if (failed == step.moves.end()) return;
  known.leaves_out_any = true;
  for (const Diagnostic& one : said.list()) {
    if (one.severity != Severity::kError || !one.pointer.starts_with(*failed)) continue;
    notes_.note(one.pointer,
                fmt::format("no path keeps clear of all that others may do meanwhile, at times that are not known; the "
                            "branches may wait for each other: {}",
                            one.message),
                "a wait for what is in the way, right before it");
  }
}

}  // namespace takt::operations
