#include "core/operations/grasp/closing_fingers.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/collision/scene.h"
#include "core/expression/believed_shapes.h"

namespace takt::operations {
namespace {

using collision::CellShapes;

constexpr int kHalvings = 20;  // a tenth of a micrometre of 80 mm
/// Cosine between the ways of two fingers that close on each other.
constexpr double kOpposite = -0.99;

int body_of_joint(const CellShapes& shapes, int joint) {
  const auto& bodies = shapes.scene.bodies();
  return static_cast<int>(std::ranges::find(bodies, joint, &collision::Body::joint) - bodies.begin());
}

/// One finger on its way to a part.
class Finger {
 public:
  Finger(const CellShapes& shapes, const collision::State& state, int joint, int part)
      : shapes_(shapes), state_(state), joint_(static_cast<std::size_t>(joint)), part_(part) {
    body_ = body_of_joint(shapes, joint);
  }

  /// How far it is open where it touches the part first, m; nothing: it does not, or it does when it is open.
  std::optional<double> first_touch(double open) {
    if (!touches_at(0.0) || touches_at(open)) return std::nullopt;
    double low = 0.0, high = open;
    for (int i = 0; i < kHalvings; ++i) (touches_at(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return high;
  }
  /// The way on which it closes, in the frame of a body.
  [[nodiscard]] Eigen::Vector3d way_in(int body) {
    shapes_.scene.place(state_, poses_);
    const Eigen::Matrix3d R_BF =
        poses_[static_cast<std::size_t>(body)].linear().transpose() * poses_[static_cast<std::size_t>(body_)].linear();
    return -(R_BF * shapes_.scene.body(body_).axis);
  }

 private:
  bool touches_at(double open) {
    state_.q[joint_] = open;
    shapes_.scene.place(state_, poses_);
    return collision::distance(shapes_.scene, poses_, body_, part_) <= 0.0;
  }

  const CellShapes& shapes_;
  collision::State state_;
  std::size_t joint_;
  int part_, body_ = -1;
  collision::Poses poses_;
};

}  // namespace

Eigen::Isometry3d pushed_by_fingers(const expression::Cell& cell, const std::string& gripper, const std::string& object,
                                    const Eigen::Isometry3d& X_FO) {
  const auto mounted = cell.grippers.find(gripper);
  if (cell.shapes == nullptr || mounted == cell.grippers.end()) return X_FO;
  const CellShapes& shapes = *cell.shapes;
  const auto fingers = shapes.grippers.find(gripper);
  const auto arm = shapes.arms.find(mounted->second.arm);
  const int part = shapes.scene.root_of(object);
  if (fingers == shapes.grippers.end() || fingers->second.size() != 2 || arm == shapes.arms.end() || part < 0)
    return X_FO;
  collision::State state = expression::believed_situation(cell, {}, {}).state;
  const int flange = arm->second.flange;
  state.fixings[static_cast<std::size_t>(part)] = {flange, X_FO};
  const double open = 0.5 * mounted->second.device->description().stroke;
  for (const int joint : fingers->second) state.q[static_cast<std::size_t>(joint)] = open;
  std::array<Finger, 2> both{Finger(shapes, state, fingers->second[0], part),
                             Finger(shapes, state, fingers->second[1], part)};
  const auto first = both[0].first_touch(open), second = both[1].first_touch(open);
  const Eigen::Vector3d way_F = both[0].way_in(flange);
  if (!first || !second || way_F.dot(both[1].way_in(flange)) > kOpposite) return X_FO;
  return Eigen::Translation3d(0.5 * (*first - *second) * way_F) * X_FO;
}

}  // namespace takt::operations
