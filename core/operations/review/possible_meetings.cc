#include "core/operations/review/possible_meetings.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/collision/body_pair.h"
#include "core/collision/swept_space.h"
#include "core/planning/sweep_tree.h"

namespace takt::operations {
namespace {

using collision::CellShapes;
using collision::CellState;
using collision::SweptSpace;

/// Poses of what is swept lie so near to each other, m: half of it is what a meeting may be reported too early.
constexpr double kPoseSpacing = 5e-3;

std::set<int> moved_bodies(const CellShapes& shapes, const collision::State& state,
                           const activity::CheckedMotion& motion) {
  std::vector<int> joints;
  for (const activity::ArmTrack& track : motion.tracks) {
    const auto arm = shapes.arms.find(track.arm);
    if (arm != shapes.arms.end()) joints.insert(joints.end(), arm->second.joints.begin(), arm->second.joints.end());
  }
  std::set<int> bodies;
  const std::vector<bool> moved = shapes.scene.moved_by(state, joints);
  for (std::size_t body = 0; body < moved.size(); ++body)
    if (moved[body] && !shapes.scene.bodies()[body].parts.empty()) bodies.insert(static_cast<int>(body));
  return bodies;
}

SweptSpace swept_by(const expression::Cell& cell, const CellState& begin, const activity::CheckedMotion& motion,
                    const std::vector<int>& bodies) {
  SweptSpace swept;
  const double stops = activity::first_touch(cell, begin, motion).time;
  const auto trajectory = activity::trajectory_of(cell, {{&motion, 0.0, stops}}, 0.0, stops);
  add_swept(cell.shapes->scene, begin.state, trajectory, bodies, kPoseSpacing, 0.0, 0, swept);
  return swept;
}

/// Two bodies, and when each is there, s after its motion begins.
struct Meeting {
  double time_a = 0.0, time_b = 0.0;
};

class Meetings {
 public:
  Meetings(const expression::Cell& cell, const CellState& begin, const activity::CheckedMotion& a,
           const activity::CheckedMotion& b)
      : shapes_(*cell.shapes), rules_(shapes_, begin) {
    touching_.insert(a.touching.begin(), a.touching.end());
    touching_.insert(b.touching.begin(), b.touching.end());
    const std::set<int> of_a = moved_bodies(shapes_, begin.state, a), of_b = moved_bodies(shapes_, begin.state, b);
    std::ranges::set_difference(of_a, of_b, std::back_inserter(bodies_a_));
    std::ranges::set_difference(of_b, of_a, std::back_inserter(bodies_b_));
    swept_a_ = swept_by(cell, begin, a, bodies_a_);
    swept_b_ = swept_by(cell, begin, b, bodies_b_);
    shapes_.scene.place(begin.state, poses_);
  }

  /// @param report  gets the two bodies and when they meet; the first of each pair of machines
  template <class Report>
  void find(Report&& report) {
    std::set<std::pair<std::string, std::string>> known;
    for (const int a : bodies_a_) {
      for (const int b : bodies_b_) {
        const std::pair owners{shapes_.scene.body(a).owner, shapes_.scene.body(b).owner};
        if (known.contains(owners) || shapes_.scene.never_meet(a, b)) continue;
        if (rules_.contact(a, b, touching_) != collision::Contact::kForbidden) continue;
        const auto meeting = meeting_of(a, b);
        if (!meeting) continue;
        known.insert(owners);
        report(a, b, *meeting);
      }
    }
  }

 private:
  [[nodiscard]] std::optional<Meeting> meeting_of(int a, int b) {
    const collision::Body &one = shapes_.scene.body(a), &other = shapes_.scene.body(b);
    const planning::SweepTree tree(swept_b_.bodies.at(b), other.box.center(), other.radius);
    collision::BodyPair pair(shapes_.scene, a, b);
    std::size_t nearest = 0;
    for (const collision::SweptPose& pose : swept_a_.bodies.at(a)) {
      const double near = shapes_.margin + pose.within;
      poses_[static_cast<std::size_t>(a)] = pose.X_WB;
      const auto apart_from = [&](std::size_t at, double within) {
        poses_[static_cast<std::size_t>(b)] = tree.pose(at).X_WB;
        return pair.distance(poses_, near + within) - within;
      };
      const double least = tree.least(pose.X_WB * one.box.center(), one.radius,
                                      {.enough = near, .worth = near, .least = near}, apart_from, nearest);
      if (least <= near) return Meeting{pose.time, tree.pose(nearest).time};
    }
    return std::nullopt;
  }

  const CellShapes& shapes_;
  collision::ContactRules rules_;
  collision::Touching touching_;
  std::vector<int> bodies_a_, bodies_b_;  ///< that one of the motions moves and the other does not
  SweptSpace swept_a_, swept_b_;
  collision::Poses poses_;
};

}  // namespace

void note_possible_meetings(const expression::Cell& cell, const CellState& begin, const activity::CheckedMotion& a,
                            const activity::CheckedMotion& b, Diagnostics& diagnostics) {
  if (a.tracks.empty() || b.tracks.empty()) return;
  const collision::Scene& scene = cell.shapes->scene;
  Meetings(cell, begin, a, b).find([&](int one, int other, const Meeting& meeting) {
    const activity::CheckedMotion::Part &of_a = a.part_at(meeting.time_a), &of_b = b.part_at(meeting.time_b);
    diagnostics.add(
        {.severity = Severity::kNote,
         .code = Code::kCollision,
         .file = {},
         .pointer = of_b.pointer,
         .message = fmt::format(
             "'{}' and '{}' may meet: {:.3f} s after '{}' begins the one is where the other is {:.3f} s after '{}' "
             "begins, and it shows in the run only when they begin",
             scene.body(one).name, scene.body(other).name, meeting.time_a - of_a.begin, of_a.step,
             meeting.time_b - of_b.begin, of_b.step),
         .hint = "Start it when the other has completed, or choose paths that keep clear of each other"});
  });
}

}  // namespace takt::operations
