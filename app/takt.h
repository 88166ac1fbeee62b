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
#include "core/expression/device_sensors.h"
#include "core/expression/frame_sensors.h"
#include "core/operations/force/pressing.h"

namespace takt::app {

/// The layer below: actions on actuators, transactions, event handlers (docs/command-layer.md).
namespace command = takt::command;

// Activities: what is done, and how it went.
using activity::Activity;
using activity::ActivityError;
using activity::guarded_outcome;
using activity::GuardedOutcome;
using activity::press_outcome;
using activity::PressOutcome;
using activity::ProgramCancelled;
using activity::Reaction;
using activity::RunFailure;
using activity::RunPtr;
using activity::RunState;
using activity::RunView;
using activity::ScopedFrame;

// Who does it, and what it offers.
using activity::Actuator;
using activity::ActuatorInterface;
using activity::ComposedDevice;
using activity::ControlModeInterface;
using activity::DeviceInterface;
using activity::DevicePart;
using activity::FollowInterface;
using activity::ForceInterface;
using activity::Frame;
using activity::FreedriveInterface;
using activity::GrippingInterface;
using activity::HoldInterface;
using activity::internal_force;
using activity::JogInterface;
using activity::JointInterface;
using activity::LinInterface;
using activity::MotionInterface;
using activity::OutputInterface;
using activity::PtpInterface;
using activity::RegisterInterface;
using activity::ToolChangerInterface;
using activity::TwoArms;

// How: parameters.
using activity::BlendingCondition;
using activity::CoupleParameters;
using activity::FollowParameters;
using activity::FreedriveParameters;
using activity::GripParameters;
using activity::HoldParameters;
using activity::JogParameters;
using activity::MotionParameters;
using activity::PressParameters;
using activity::ReleaseParameters;
using activity::SearchParameters;
using activity::SetParameters;
using activity::UncoupleParameters;
using command::CartesianCompliance;
using command::JointCompliance;
using command::Stiff;

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
using command::FrameSensor;
using command::JointsSensor;
using command::RealSensor;
using command::State;
using command::TwistSensor;
using command::VectorSensor;
using command::WrenchSensor;

// Commands of one's own.
using command::RuntimeCommand;
using command::TransactionCommand;
using command::WaitCommand;

// How a run ended.
using cell::RunReport;
using cell::Verdict;

}  // namespace takt::app
