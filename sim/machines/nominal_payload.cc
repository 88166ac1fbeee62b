#include "sim/machines/nominal_payload.h"

#include <map>

#include "core/device/description.h"

namespace takt::sim {
namespace {

using kinematics::Joint;
using kinematics::JointType;
using kinematics::Link;
using kinematics::RobotModel;

/// Poses of links in the frame of the link `start`, over all joints below it (at zero) or only over the fixed ones.
std::map<std::string, Pose> links_below(const RobotModel& model, const std::string& start, bool fixed_only) {
  std::map<std::string, Pose> X_SL = {{start, Pose::Identity()}};
  for (const Joint& joint : model.joints) {  // in tree order: parents come first
    const auto parent = X_SL.find(joint.parent);
    if (parent == X_SL.end() || (fixed_only && joint.type != JointType::kFixed)) continue;
    X_SL.emplace(joint.child, parent->second * joint.X_PJ);
  }
  return X_SL;
}

class Collector {
 public:
  explicit Collector(const WorldDescription& description) : world_(description) {}

  /// Adds all that is mounted on the body, which stands at X_FP.
  void add_mounted_on(const std::string& body, const Pose& X_FP) {
    for (const auto& robot : world_.robots) {
      if (robot.mount.parent == body) add(robot, X_FP * robot.mount.X_P);
    }
    for (const auto& object : world_.objects) {
      if (object.mount.parent != body) continue;
      const Pose X_FO = X_FP * object.mount.X_P;
      // A point mass: descriptions give no inertia of objects, and at a wrist theirs is small beside the arm's.
      sum_ = device::combine(sum_, device::transform(X_FO, {.mass = object.mass}));
      add_mounted_on(object.name, X_FO);
    }
  }

  [[nodiscard]] const device::PayloadSetting& sum() const { return sum_; }

 private:
  void add(const RobotDescription& robot, const Pose& X_FB) {
    const RobotModel& model = *robot.model;
    for (const auto& [name, X_BL] : links_below(model, model.root().name, false)) {
      const Link& link = *model.link(name);
      if (link.inertial) {
        const auto& inertial = *link.inertial;
        const device::PayloadSetting body = {inertial.mass, Eigen::Vector3d::Zero(), inertial.I_C};
        sum_ = device::combine(sum_, device::transform(X_FB * X_BL * inertial.X_LC, body));
      }
      add_mounted_on(robot.name + "/" + name, X_FB * X_BL);
    }
  }

  const WorldDescription& world_;
  device::PayloadSetting sum_;
};

}  // namespace

device::PayloadSetting nominal_payload(const WorldDescription& description, const std::string& robot,
                                       const std::string& flange_link) {
  Collector collector(description);
  for (const auto& candidate : description.robots) {
    if (candidate.name != robot) continue;
    for (const auto& [link, X_FL] : links_below(*candidate.model, flange_link, true)) {
      collector.add_mounted_on(robot + "/" + link, X_FL);
    }
  }
  return collector.sum();
}

}  // namespace takt::sim
