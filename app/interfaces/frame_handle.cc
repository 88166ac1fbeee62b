#include "app/interfaces/frame_handle.h"

#include <utility>

#include <fmt/format.h>

#include "core/expression/frame_sensors.h"
#include "core/expression/moving_frames.h"
#include "core/operations/grasp/set_frame.h"

namespace takt::app {

Frame::Frame(activity::Runtime& runtime, std::string name) : runtime_(&runtime), name_(std::move(name)) {
  const world::FrameGraph& frames = runtime.cell().frames;
  if (frames.contains(name_)) return;
  Diagnostics why;
  why.error(Code::kUnknownName, pointer_segment(name_), fmt::format("there is no frame '{}'", name_),
            nearest_choice(name_, frames.names()));
  throw activity::ActivityError(std::move(why));
}

Frame Frame::then(const Eigen::Isometry3d& X) const {
  Frame beside = *this;
  beside.X_ = X_ * X;
  return beside;
}

Frame Frame::offset(double x, double y, double z) const {
  return then(Eigen::Isometry3d(Eigen::Translation3d(x, y, z)));
}

Frame Frame::turned(double roll, double pitch, double yaw) const {
  return then(Eigen::Isometry3d(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX())));
}

Eigen::Isometry3d Frame::in(const std::string& other) const {
  expression::update_flange_frames(runtime_->cell());
  const auto X = runtime_->cell().frames.pose(name_, other);
  if (!X) give_up(X.error());
  return *X * X_;
}

expression::FrameSensor Frame::pose_in(const std::string& other) const {
  return expression::pose_between(runtime_->cell(), name_, other) * expression::FrameTerm(net::Frame(X_));
}

expression::TwistSensor Frame::velocity_in(const std::string& other) const {
  const expression::Cell& cell = runtime_->cell();
  const auto X_OF = expression::pose_between(cell, name_, other);
  return expression::shift(expression::twist_between(cell, name_, other),
                           rotate(X_OF, expression::VectorTerm(net::Vector(X_.translation()))));
}

Frame Frame::keep_as(const std::string& name, const std::string& in) const {
  expression::update_flange_frames(runtime_->cell());
  expression::Cell& cell = runtime_->cell();
  Diagnostics why;
  if (!operations::is_free_frame_name(cell, name) || name.find('/') != std::string::npos)
    why.error(Code::kInvalidName, "", fmt::format("'{}' cannot be the name of a frame that a program makes", name),
              "Choose a name that the cell does not have yet, without '/'");
  if (!why.has_errors()) why = operations::set_frame(cell, {.as = name, .in = in, .of = name_, .X = X_});
  if (why.has_errors()) give_up(why);
  return {*runtime_, name};
}

Frame ScopedFrame::kept_alone(const Frame& frame, const std::string& name, const std::string& in) {
  if (!frame.runtime_->cell().frames.contains(name)) return frame.keep_as(name, in);
  Diagnostics taken;
  taken.error(Code::kDuplicate, "", fmt::format("there is a frame '{}'", name), "Give it a name of its own");
  frame.give_up(taken);
}

ScopedFrame::ScopedFrame(const Frame& frame, const std::string& name, const std::string& in)
    : frame_(kept_alone(frame, name, in)) {}

ScopedFrame::~ScopedFrame() { frame_.runtime_->cell().frames.remove(frame_.name_); }

void Frame::give_up(const Diagnostics& why) const {
  Diagnostics placed;
  placed.append(why, pointer_segment(name_));
  throw activity::ActivityError(std::move(placed));
}

}  // namespace takt::app
