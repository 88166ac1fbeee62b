#pragma once

/// All that a program of a cell needs, under one name space (docs/cpp-api.md):
///   #include <takt/takt.h>
///   using namespace takt::app;
#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "app/cell.h"
#include "app/interfaces/actuator_interfaces.h"
#include "app/interfaces/composed_device.h"
#include "app/interfaces/frame_handle.h"
#include "app/interfaces/two_arms.h"
#include "app/run.h"
#include "core/activity/command_activity.h"
#include "core/activity/composition.h"
#include "core/activity/dual_entry_motion.h"
#include "core/command/actions/device_action.h"
#include "core/command/actions/online_action.h"
#include "core/command/actions/overlay_action.h"
#include "core/command/actions/process_action.h"
#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/operations/force/pressing.h"
#include "core/operations/process/weld.h"

namespace takt::app {

/// The layers below: actions on actuators, transactions, event handlers (docs/command-layer.md); sensors, states and
/// conditions as formulas.
namespace command = takt::command;
namespace expression = takt::expression;

// Activities: what is done, and how it went.
using activity::Activity;
using activity::ActivityError;
using activity::guarded_outcome;
using activity::GuardedOutcome;
using activity::ProgramCancelled;
using activity::Reaction;
using activity::RunFailure;
using activity::RunPtr;
using activity::RunState;
using activity::RunView;
using operations::press_outcome;
using operations::PressOutcome;

// Who does it, and what it offers.
using expression::internal_force;

// How: parameters.
using activity::BlendingCondition;
using command::CartesianCompliance;
using command::JointCompliance;
using command::Stiff;
using operations::CoupleParameters;
using operations::FollowParameters;
using operations::FreedriveParameters;
using operations::GripParameters;
using operations::HoldParameters;
using operations::JogParameters;
using operations::MotionParameters;
using operations::PressParameters;
using operations::ReleaseParameters;
using operations::SearchParameters;
using operations::SetParameters;
using operations::UncoupleParameters;
using operations::WeldParameters;

// Several as one; several beside each other.
using activity::abort_if;
using activity::conditional;
using activity::ended;
using activity::parallel;
using activity::sequence;
using activity::started;
using activity::Subtask;
using activity::Task;
using activity::wait;
using activity::with_subtasks;

// Sensors and states. Operators and functions over them are found without a name space: norm(force), is_greater(a, b).
using expression::FrameSensor;
using expression::JointsSensor;
using expression::RealSensor;
using expression::State;
using expression::TwistSensor;
using expression::VectorSensor;
using expression::WrenchSensor;

// Commands of one's own.
using command::RuntimeCommand;
using command::TransactionCommand;
using command::WaitCommand;

// How a run ended.
using cell::RunReport;
using cell::Verdict;

}  // namespace takt::app
