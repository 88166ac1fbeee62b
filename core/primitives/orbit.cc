// Families "frame" and "kinematics": where a camera looks at a point from, and whether an arm can bring it there.
#include <algorithm>
#include <cmath>

#include "core/kinematics/differential.h"
#include "core/kinematics/pose_error.h"
#include "core/net/registry.h"
#include "core/primitives/arm_kinematics.h"
#include "core/primitives/function.h"

namespace takt::primitives {
namespace {

using kinematics::JointVector;
using kinematics::Vector6;
using net::Frame;
using net::Twist;
using net::Vector;

constexpr auto kOrbit = [] {
  return ports({{"center", "", "X_AW: the camera looks at the origin of W", "A>W"},
                {"center_twist", "m/s,rad/s", "of W in A, at its origin, in the axes of A", "A"},
                {"axes", "", "X_AU: z of U is up, azimuth counts from x of U", "A>U"},
                {"axes_twist", "m/s,rad/s", "of U in A; only its angular velocity matters", "A"},
                {"distance", "m", "from W to the camera; null below 1 mm"},
                {"azimuth", "rad", "about z of U, at which the camera is"},
                {"elevation", "rad", "of the camera above the x-y plane of U"},
                {"distance_rate", "m/s", "how fast it changes"},
                {"azimuth_rate", "rad/s", "how fast it changes"},
                {"elevation_rate", "rad/s", "how fast it changes"}},
               {{"frame", "", "X_AC of the camera: z looks at W, x is to the right, y is down", "A>C"},
                {"twist", "m/s,rad/s", "of C in A, at its origin, in the axes of A", "A"}},
               {{"roll", "rad", "of the camera about its z", "(-inf,inf)", "0.5", 0.0}});
};

struct OrbitSpeed {
  double distance, azimuth, elevation;
};

constexpr double kNearest = 1e-3;  // m: at the point itself there is no direction

std::optional<std::tuple<Frame, Twist>> orbit(const Frame& X_AW, const Twist& V_AW, const Frame& X_AU,
                                              const Twist& V_AU, double distance, double azimuth, double elevation,
                                              const OrbitSpeed& rate, double roll) {
  if (!(distance >= kNearest) || !std::isfinite(distance + azimuth + elevation)) return std::nullopt;
  const double ca = std::cos(azimuth), sa = std::sin(azimuth), ce = std::cos(elevation), se = std::sin(elevation);
  const Vector out_U(ce * ca, ce * sa, se);  // from W to the camera
  const Vector right_U(-sa, ca, 0.0);
  const Vector rise_U(-se * ca, -se * sa, ce);  // as the elevation grows
  Eigen::Matrix3d R_UC;
  R_UC << right_U, -rise_U, -out_U;
  const Eigen::Matrix3d R_AU = X_AU.linear();
  const Vector p_WC_A = R_AU * (distance * out_U);
  Frame X_AC = Frame::Identity();
  X_AC.linear() = R_AU * R_UC * Eigen::AngleAxisd(roll, Vector::UnitZ()).toRotationMatrix();
  X_AC.translation() = X_AW.translation() + p_WC_A;
  const Vector away_U = rate.distance * out_U + distance * (rate.azimuth * ce * right_U + rate.elevation * rise_U);
  const Vector turn_U = rate.azimuth * Vector::UnitZ() - rate.elevation * right_U;
  return std::tuple(X_AC, Twist{.linear = V_AW.linear + V_AU.angular.cross(p_WC_A) + R_AU * away_U,
                                .angular = V_AU.angular + R_AU * turn_U});
}

using OrbitFrame =
    Function<kOrbit,
             [](const Frame& X_AW, const Twist& V_AW, const Frame& X_AU, const Twist& V_AU, double distance,
                double azimuth, double elevation, double distance_rate, double azimuth_rate, double elevation_rate,
                double roll) -> std::optional<std::tuple<Frame, Twist>> {
               return orbit(X_AW, V_AW, X_AU, V_AU, distance, azimuth, elevation,
                            {distance_rate, azimuth_rate, elevation_rate}, roll);
             }>;

/// A shadow of the arm walks to the pose by some Newton steps in each cycle.
class FrameReach final : public net::Primitive {
 public:
  explicit FrameReach(net::Setup& setup)
      : frame_(setup.in<Frame>("frame", {.unit = "m", .doc = "pose of T in the arm's base B"})),
        q_(setup.in<net::JointArray>("q", {.unit = "rad", .doc = "where the arm is"})),
        reachable_(setup.out<net::Boolean>(
            "reachable", {.doc = "joint positions for the pose are known, within their ranges", .may_be_null = true})),
        kinematics_(setup),
        length_(length_parameter(setup)),
        margin_(setup.parameter<net::Real>("margin", 0.01,
                                           {.unit = "rad", .doc = "to the ends of the ranges", .range = "[0,inf)"})),
        distance_max_(setup.parameter<net::Real>(
            "distance_max", 1e-3, {.unit = "m", .doc = "within which a pose counts as reached", .range = "(0,inf)"})),
        angle_max_(setup.parameter<net::Real>(
            "angle_max", 3e-3, {.unit = "rad", .doc = "within which a pose counts as reached", .range = "(0,inf)"})) {
    setup.costs(3'000.0);
  }

  Diagnostics prepare() override { return kinematics_.check(); }

  void update(const net::Cycle& cycle) override {
    if (frame_.null() || !kinematics_.look(q_)) {
      stuck_ = kRestart;
      return reachable_.set_null();
    }
    if (cycle.first || stuck_ >= kRestart) {
      shadow_ = q_->map();
      stuck_ = 0;
    }
    bool there = false;
    for (int step = 0; step < kSteps && !there; ++step) there = walk();
    stuck_ = there ? 0 : stuck_ + 1;
    reachable_.set(there);
  }

 private:
  static constexpr int kSteps = 3;         // a cycle: a pose that moves needs one
  static constexpr int kRestart = 100;     // cycles without success until it begins anew
  static constexpr double kLongest = 0.2;  // rad or m of a joint and step: further is no line any more
  static constexpr double kDampedBelow = 0.02;

  /// One step of the shadow, unless it is there. @return it is there
  bool walk() {
    if (!kinematics_.look(shadow_)) return false;
    const Vector6 way = kinematics::pose_error(kinematics_.X_BT, *frame_);
    if (way.head<3>().norm() <= distance_max_ && way.tail<3>().norm() <= angle_max_) return true;
    const auto& limits = kinematics_.arm->description().limits;
    const auto n = shadow_.size();
    const JointVector longest = JointVector::Constant(n, kLongest), margin = JointVector::Constant(n, margin_);
    kinematics::RateBounds bounds{.lower = (limits.lower + margin - shadow_).cwiseMin(0.0).cwiseMax(-longest),
                                  .upper = (limits.upper - margin - shadow_).cwiseMax(0.0).cwiseMin(longest)};
    shadow_ += kinematics::bounded_rates(kinematics_.J_BT, way, bounds, length_, kDampedBelow);
    return false;
  }

  net::In<Frame> frame_;
  net::In<net::JointArray> q_;
  net::Out<net::Boolean> reachable_;
  ArmKinematics kinematics_;
  double length_, margin_, distance_max_, angle_max_;
  JointVector shadow_;
  int stuck_ = 0;
};

TAKT_PRIMITIVE(OrbitFrame, "frame",
               "Where a camera is that looks at a point from a distance and at two angles, and how it moves when the "
               "point moves, the axes turn, or distance and angles change. Null below a distance of 1 mm.");
TAKT_PRIMITIVE(
    FrameReach, "kinematics",
    "Whether an arm can bring its tool to a pose on the branch where it is, whatever it does at the moment: three "
    "Newton "
    "steps in a cycle, within the ranges of the joints, from the solution of the last cycle; after 100 cycles without "
    "success, and in the first, from where the arm is. So a pose far away is reachable some cycles later. Null if the "
    "number of joints is not the arm's.");

}  // namespace
}  // namespace takt::primitives
