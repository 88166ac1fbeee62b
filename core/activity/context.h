#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "core/activity/meanwhile.h"
#include "core/expression/cell.h"
#include "core/rcc/control_core.h"
#include "core/world/pose_fit.h"

namespace takt::activity {

/// A touch that a guarded motion ended with.
struct Touch {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< tool centre point in the world when the condition first held, m
  double radius = 0.0;                            ///< of the probing ball, m
  std::int64_t cycle = -1;                        ///< in which the net had ended
};

/// What a program has measured so far.
struct Variables {
  std::map<std::string, world::Contact, std::less<>> contacts;      ///< recorded under a name, in the world
  std::map<std::string, Eigen::Isometry3d, std::less<>> estimates;  ///< fitted poses X_WO by name
  std::map<std::string, double, std::less<>> residuals;             ///< rms of each fit, m
  std::map<std::string, Touch, std::less<>> touches;                ///< last touch of each arm
  /// Last value of each monitor of a net that a step ran, as JSON text: net, monitor.
  std::map<std::string, std::map<std::string, std::string, std::less<>>, std::less<>> monitors;
  expression::Biases biases;
};

/// What happened, for logs and recordings.
using EventSink = std::function<void(std::string_view source, std::string_view name, std::string_view text)>;

struct RealtimeSupport;
class Scheduler;

/// All that a running step may use. Owned by the session.
struct Context {
  expression::Cell& cell;
  rcc::ControlCore& core;
  Variables& variables;
  std::int64_t program_latency_cycles = 2;  ///< from a command to its effect (row D2)
  EventSink event;
  const RealtimeSupport* realtime = nullptr;  ///< null: lock-step
  Scheduler* scheduler = nullptr;             ///< of the activities of the program that runs; its runner sets it
  ConcurrentMotions meanwhile = {};           ///< what the rehearsal found; a parallel that runs names itself in it
};

}  // namespace takt::activity
