#pragma once

#include <string>

#include "core/expression/cell.h"
#include "core/expression/sensor.h"

/// Poses and twists between any two frames of a cell, now and in a net. What does not move is a constant; arms and
/// channels on the path become the primitives that say where they are. Realtime: setup.
namespace takt::expression {

/// Pose of frame `of` in frame `in`. Frames of the cell; "ARM" is an arm's base.
[[nodiscard]] FrameSensor pose_between(const Cell& cell, const std::string& of, const std::string& in);

/// Velocity of frame `of` seen from frame `in`: of its origin, in the axes of `in`; measured. That of a frame that a
/// channel moves comes from the last two values of the channel (primitive FrameChannelTwist): null until there are
/// two, and when they are older than the channel's timeout, or, without one, than 0.5 s.
[[nodiscard]] TwistSensor twist_between(const Cell& cell, const std::string& of, const std::string& in);

/// Velocity of the frame whose poses a channel gives, as a channel moves one (twist_between).
[[nodiscard]] TwistSensor channel_twist(const Cell& cell, const std::string& name);

/// The velocity of a point of the same body, so far away from the one of `twist` (m, in the same axes).
[[nodiscard]] TwistSensor shift(const TwistSensor& twist, const VectorTerm& way);

}  // namespace takt::expression
