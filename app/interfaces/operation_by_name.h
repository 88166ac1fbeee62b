#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/activity.h"
#include "core/expression/condition_state.h"
#include "core/operations/motion/motion.h"
#include "core/operations/table/goal.h"

/// Operations by their names, with parameters as files have them: for programs in other languages than C++, whose
/// methods are printed from the operations' tables (docs/python.md). They become the activities that the interfaces of
/// C++ make (actuator_interfaces.h). Realtime: setup.
namespace takt::app {

/// Parameters that a program gives in a form that files do not have.
struct ProgramValues {
  std::map<std::string, expression::State, std::less<>> states =
      {};  ///< by key: "until", "abort_if", "enabled", "while"
  /// By key: "to", "via", "base_to" have one goal, "through" has all of its points.
  std::map<std::string, std::vector<operations::Goal>, std::less<>> goals = {};
  std::optional<double> blend_time_share = {};  ///< of motions: as MotionParameters::blend = 0.7
  std::optional<Eigen::Isometry3d> X_FM = {};   ///< of motions: as MotionParameters::X_FM
};

/// The parameters of a planned motion, with what the program gives. Throws ActivityError with all that is wrong.
[[nodiscard]] operations::MotionTask motion_by_name(const expression::Cell& cell, const nlohmann::ordered_json& json,
                                                    const ProgramValues& values = {});

/// An operation as an activity: {"do": "press", "arm": "left", "force_N": 20}. Throws ActivityError with all that is
/// wrong with the parameters, and for an operation that is a step only (is_activity()).
[[nodiscard]] activity::Activity operation_by_name(activity::Runtime& runtime, const nlohmann::ordered_json& json,
                                                   const ProgramValues& values = {});

/// It can begin beside others and be a part of a composition. False: it is carried out as a step of a file is.
[[nodiscard]] bool is_activity(const std::string& operation);

/// Carries out any operation and returns when it has ended. @return its run; null of what is a step only. Throws
/// ActivityError if it did not come to its end.
activity::RunPtr execute_by_name(activity::Runtime& runtime, const nlohmann::ordered_json& json,
                                 const ProgramValues& values = {});

}  // namespace takt::app
