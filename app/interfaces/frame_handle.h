#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/activity/runtime.h"
#include "core/expression/sensor.h"

/// Frames in C++: cell.frame("container").offset(0, 0, 0.1).in("arm"). Realtime: setup.
namespace takt::app {

/// A frame of the cell, or one beside it, as programs name poses: where the program believes it to be. A cheap value.
class Frame {
 public:
  /// Throws ActivityError, with the nearest name, if the cell has no such frame.
  Frame(activity::Runtime& runtime, std::string name);

  /// The frame beside this one: so far along its axes, m.
  [[nodiscard]] Frame offset(double x, double y, double z) const;
  /// The frame turned about its own axes: roll, pitch, yaw, rad.
  [[nodiscard]] Frame turned(double roll, double pitch, double yaw) const;
  [[nodiscard]] Frame then(const Eigen::Isometry3d& X) const;

  /// Where it is now in another frame, of an arm in its base: a goal of a motion, m. Throws ActivityError
  /// (Code::kUnknownPose) where that is not known.
  [[nodiscard]] Eigen::Isometry3d in(const std::string& other = std::string(world::FrameGraph::kWorld)) const;
  /// Pose in another frame, and velocity seen from it, as sensors: while machines move, and in nets.
  [[nodiscard]] expression::FrameSensor pose_in(const std::string& other) const;
  [[nodiscard]] expression::TwistSensor velocity_in(const std::string& other) const;
  /// Makes it a frame of the cell that rides on what this one rides on, or on `in` from where it is now. Throws
  /// ActivityError for a name that is not free. @return the frame of that name
  Frame keep_as(const std::string& name) const { return keep_as(name, name_); }
  Frame keep_as(const std::string& name, const std::string& in) const;

 private:
  friend class ScopedFrame;
  [[noreturn]] void give_up(const Diagnostics& why) const;

  activity::Runtime* runtime_;
  std::string name_;
  Eigen::Isometry3d X_ = Eigen::Isometry3d::Identity();  ///< in the frame of that name, m
};

/// A frame of the cell that ends with its scope, as those of a sequence of a file do: what was put down on it stays
/// where it is. The runtime has to outlive it.
class ScopedFrame {
 public:
  /// As Frame::keep_as(). Throws ActivityError for a name that is not free, also of a frame that another has made.
  ScopedFrame(const Frame& frame, const std::string& name, const std::string& in);
  ScopedFrame(const Frame& frame, const std::string& name) : ScopedFrame(frame, name, frame.name_) {}
  ~ScopedFrame();
  ScopedFrame(const ScopedFrame&) = delete;
  ScopedFrame& operator=(const ScopedFrame&) = delete;

  [[nodiscard]] const Frame& frame() const { return frame_; }

 private:
  static Frame kept_alone(const Frame& frame, const std::string& name, const std::string& in);

  Frame frame_;
};

}  // namespace takt::app
