// Wrong uses of control modes, springs and freedrive by activities.
#include "core/activity/composition.h"
#include "tests/core/activity/broken_activities.h"

namespace takt::test {
namespace {

using activity::Activity;
using app::Actuator;
using app::ControlModeInterface;
using app::FreedriveInterface;
using app::HoldInterface;
using command::JointCompliance;
using device::ControlMode;

JointCompliance springs(double stiffness, int joints = 7) {
  return {.stiffness = net::JointArray(device::JointVector(device::JointVector::Constant(joints, stiffness)))};
}
ControlModeInterface modes(ActivityCell& cell) { return cell.robot.use<ControlModeInterface>(); }
Activity held(ActivityCell& cell, const command::SpringParameters& wish) {
  return cell.robot.use<HoldInterface>().hold({.seconds = 0.1, .compliance = wish});
}

}  // namespace

std::vector<BrokenActivity> broken_modes() {
  return {
      {"a mode that is not there",
       [](auto& cell) { modes(cell).switch_to("postion").execute(); },
       "/arm",
       Code::kUnknownName,
       {"postion", "position"}},
      {"springs of a stiff arm",
       [](auto& cell) { cell.motion.ptp(cell.joints(0.2), {.compliance = springs(300)}).execute(); },
       "/arm PTP/compliance",
       Code::kNotPossibleNow,
       {"arm", "joint_impedance", "switch_to"}},
      {"springs of another mode",
       [](auto& cell) {
         modes(cell).switch_to(ControlMode::kCartesianImpedance).execute();
         held(cell, springs(300)).execute();
       },
       "/hold arm/compliance",
       Code::kNotPossibleNow,
       {"arm", "joint_impedance", "cartesian_impedance", "switch_to"}},
      {"springs that the device does not have",
       [](auto& cell) {
         modes(cell).switch_to(ControlMode::kJointImpedance).execute();
         held(cell, springs(2500)).execute();
       },
       "/hold arm/compliance/stiffness_Nm_rad/0",
       Code::kOutOfRange,
       {"arm", "2500", "0", "2000"}},
      {"a change in a sequence",
       [](auto& cell) {
         activity::sequence({modes(cell).switch_to(ControlMode::kJointImpedance), cell.motion.ptp(cell.joints(0.1))})
             .execute();
       },
       "/arm joint_impedance, arm PTP/0",
       Code::kConflict,
       {"arm joint_impedance"}},
      {"a device that does not come there",
       [](auto& cell) {
         cell.backend->ignores_modes = true;
         modes(cell).switch_to(ControlMode::kJointImpedance).execute();
       },
       "/arm joint_impedance/mode", Code::kNotPossibleNow},
      {"the mode of an arm that the core does not drive",
       [](auto& cell) {
         cell.cell.arms["second"] = cell.cell.arms.at("arm");
         Actuator(cell.program, "second").use<ControlModeInterface>().switch_to(ControlMode::kJointImpedance).execute();
       },
       "/second joint_impedance/mode",
       Code::kNotPossibleNow,
       {"second", "joint_impedance"}},
      {"a hand that may lead nowhere",
       [](auto& cell) { cell.robot.template use<FreedriveInterface>().freedrive({.velocity = 0.0}).execute(); },
       "/arm freedrive/velocity_m_s",
       Code::kOutOfRange,
       {"0"}},
  };
}

}  // namespace takt::test
