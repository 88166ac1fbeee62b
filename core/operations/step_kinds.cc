#include "core/operations/command_request.h"
#include "core/operations/command_step.h"
#include "core/operations/control_mode_step.h"
#include "core/operations/force_request.h"
#include "core/operations/force_step.h"
#include "core/operations/freedrive_step.h"
#include "core/operations/grip_request.h"
#include "core/operations/grip_step.h"
#include "core/operations/measure_step.h"
#include "core/operations/motion_request.h"
#include "core/operations/motion_step.h"
#include "core/operations/net_step.h"
#include "core/operations/online_parameters.h"
#include "core/operations/signal_request.h"
#include "core/operations/signal_step.h"
#include "core/operations/step.h"

namespace takt::activity {
namespace {

/// The rows of a table, whatever it fills.
template <auto table>
const std::vector<ParameterInfo>& list_of() {
  return table().list();
}
template <PathKind kind>
const std::vector<ParameterInfo>& motion_list() {
  return motion_parameters(kind).list();
}

}  // namespace

const std::vector<StepKind>& step_kinds() {
  static const std::vector<StepKind> kinds{
      {"circ", "Moves the tool centre point on a circle.", motion_list<PathKind::kCirc>, parse_circ},
      {"control_mode", "Brings an arm into a control mode while nothing holds it.", control_mode_parameter_list,
       parse_control_mode},
      {"fit_pose", "Finds the pose of an object from recorded contacts.", fit_pose_parameter_list, parse_fit_pose},
      {"freedrive", "A person guides an arm by hand.", freedrive_parameter_list, parse_freedrive},
      {"follow", "The tool follows a moving frame, or the poses of a channel.", list_of<follow_parameters>,
       parse_command_step},
      {"grip", "Closes a gripper until a part stops its fingers.", list_of<grip_parameters>, parse_grip},
      {"hold", "Holds an arm where it is.", list_of<hold_parameters>, parse_command_step},
      {"jog", "Manual control with a dead-man switch.", list_of<jog_parameters>, parse_command_step},
      {"lin",
       "Moves the tool centre point on a straight line; with 'base_to' the base that carries the arm drives meanwhile.",
       motion_list<PathKind::kLin>, parse_lin},
      {"net", "Runs a net of the cell to its end.", net_parameter_list, parse_net_step},
      {"press", "Approaches along a direction until contact, then presses with a force.", list_of<press_parameters>,
       parse_press},
      {"ptp", "Moves all joints together to a goal.", motion_list<PathKind::kPtp>, parse_ptp},
      {"record_contact", "Keeps the contact that the last guarded motion ended with.", record_contact_parameter_list,
       parse_record_contact},
      {"release", "Opens a gripper.", list_of<release_parameters>, parse_release},
      {"search", "Presses and follows a pattern until something is found.", list_of<search_parameters>, parse_search},
      {"set", "Sets a digital or analog output, which keeps its value; or lets an analog output follow a value.",
       list_of<set_parameters>, parse_set},
      {"spline", "Moves smoothly through points.", motion_list<PathKind::kSpline>, parse_spline},
      {"tare", "Averages a force/torque sensor at rest and takes that offset out of its later readings.",
       tare_parameter_list, parse_tare},
      {"transaction", "Runs commands in one real-time context, with handlers for events.", transaction_parameter_list,
       parse_command_step},
      {"wait", "Lets time pass, or waits until a condition becomes true.", list_of<wait_parameters>, parse_wait},
  };
  return kinds;
}

}  // namespace takt::activity
