#include "core/operations/command_step.h"
#include "core/operations/control_mode_step.h"
#include "core/operations/force_step.h"
#include "core/operations/freedrive_step.h"
#include "core/operations/grip_step.h"
#include "core/operations/measure_step.h"
#include "core/operations/motion_step.h"
#include "core/operations/net_step.h"
#include "core/operations/signal_step.h"
#include "core/operations/step.h"

namespace takt::activity {

const std::vector<StepKind>& step_kinds() {
  static const std::vector<StepKind> kinds{
      {"circ",
       "Moves the tool centre point on a circle. Keys: arm, to and via, or about, orientation, follower, speed, "
       "acceleration, velocity_m_s, blend_m, blend_fraction, until, on_end, unless, compliance, weave, force_offset.",
       parse_circ},
      {"control_mode", "Brings an arm into a control mode while nothing holds it. Keys: arm, mode.",
       parse_control_mode},
      {"fit_pose",
       "Finds the pose of an object from recorded contacts. Keys: object, as, contacts, free, max_residual_m.",
       parse_fit_pose},
      {"freedrive", "A person guides an arm by hand. Keys: arm, enabled, until, seconds, velocity_m_s, turn_deg_s.",
       parse_freedrive},
      {"follow",
       "The tool follows a frame that moves, or the pose that a channel says. Keys: arm, in, channel, linear_max_m_s, "
       "angular_max_deg_s, seconds, until, compliance.",
       parse_command_step},
      {"grip",
       "Closes a gripper until a part stops its fingers. Keys: gripper, force_N, width_m, speed_m_s, expect, part, "
       "part_mass_kg.",
       parse_grip},
      {"hold", "Holds an arm where it is. Keys: arm, seconds, until, compliance.", parse_command_step},
      {"jog",
       "Manual control with a dead-man switch. Keys: arm, channel, or linear_m_s and angular_deg_s, in, while, "
       "linear_max_m_s, angular_max_deg_s, seconds, until, compliance.",
       parse_command_step},
      {"lin",
       "Moves the tool centre point on a straight line. Keys: arm, to, follower, speed, acceleration, velocity_m_s, "
       "blend_m, blend_fraction, until, on_end, unless, compliance, weave, force_offset; base_to: where the base that "
       "carries the arm drives meanwhile.",
       parse_lin},
      {"net", "Runs a net of the cell to its end. Keys: net, cancel_after_s, within_s.", parse_net_step},
      {"press",
       "Touches along a direction and presses with a force. Keys: arm, sensor, direction, in, force_N, approach_m_s, "
       "travel_m, seconds, until, compliance.",
       parse_press},
      {"ptp",
       "Moves all joints together to a goal. Keys: arm, to, speed, acceleration, blend_m, blend_fraction, until, "
       "on_end, unless, compliance.",
       parse_ptp},
      {"record_contact", "Keeps the touch that the last guarded motion ended with. Keys: arm, as.",
       parse_record_contact},
      {"release", "Opens a gripper. Keys: gripper, width_m, speed_m_s, force_N.", parse_release},
      {"search",
       "Presses and follows a pattern until something is found. Keys: as of press but seconds, pattern, radius_m, "
       "pitch_m, "
       "velocity_m_s, drop_m, on_end.",
       parse_search},
      {"set",
       "Brings a digital or an analog output to a value, which stays; or an analog output follows one. Keys: output, "
       "value, factor, offset, seconds, until.",
       parse_set},
      {"spline",
       "Moves smoothly through points. Keys: arm, through, speed, acceleration, velocity_m_s, blend_m, blend_fraction, "
       "until, on_end, unless, compliance, weave, force_offset.",
       parse_spline},
      {"tare", "Averages a force/torque sensor at rest; its offset is then taken out. Keys: sensor, cycles.",
       parse_tare},
      {"transaction",
       "Commands in one real-time context, and what events do to them. Keys: commands, on, raised, capture, on_cancel.",
       parse_command_step},
      {"wait", "Lets time pass, or waits until a condition holds. Keys: seconds; or until, timeout_s.", parse_wait},
  };
  return kinds;
}

}  // namespace takt::activity
