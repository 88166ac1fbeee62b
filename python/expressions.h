#pragma once

#include <array>

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>

#include "core/expression/sensor.h"
#include "core/expression/state.h"
#include "python/cell_handle.h"

/// Sensors and states as Python has them (takt.Real, takt.State, ...). Realtime: setup.
namespace takt::python {

using Real = Owned<expression::RealSensor>;
using Vector = Owned<expression::VectorSensor>;
using Frame = Owned<expression::FrameSensor>;
using Twist = Owned<expression::TwistSensor>;
using Wrench = Owned<expression::WrenchSensor>;
using Joints = Owned<expression::JointsSensor>;
using State = Owned<expression::State>;

/// Three numbers, as any sequence of Python has them.
using Triple = std::array<double, 3>;
[[nodiscard]] inline Eigen::Vector3d vector_from(const Triple& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

/// A pose out of a 4x4 array. Raises takt.UsageError for one that is no pose: key and value are in the message.
[[nodiscard]] Eigen::Isometry3d pose_from(const Eigen::Matrix4d& matrix, const char* key);

}  // namespace takt::python
