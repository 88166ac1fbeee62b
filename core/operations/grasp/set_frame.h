#pragma once

#include <string>

#include "core/operations/table/operation.h"

/// "set_frame": makes a frame, puts one that a step has made somewhere else, or says where an object has been found.
/// Realtime: setup.
namespace takt::operations {

struct SetFrameParameters {
  std::string as = {};                                 ///< its name
  std::string in = "world";                            ///< frame that it depends on from now on
  std::string of = {};                                 ///< frame from whose present pose it is counted; empty: `in`
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in `of`, m
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();       ///< roll, pitch, yaw in `of`, rad
  std::string name = {}, pointer = {};                 ///< for people; in its file
};
[[nodiscard]] const ParameterTable<SetFrameParameters>& set_frame_parameters();
[[nodiscard]] Operation set_frame_operation();

/// @param position  m   @param rpy  roll, pitch, yaw about the fixed axes, rad
[[nodiscard]] Eigen::Isometry3d pose_of(const Eigen::Vector3d& position, const Eigen::Vector3d& rpy);

/// A step may make a frame of this name, or replace the one that a step has made.
[[nodiscard]] bool is_free_frame_name(const expression::Cell& cell, const std::string& name);

/// Makes a frame at X in frame `of` (empty: `in`), as that is now; from then on it depends on `in`. Or it replaces it.
/// An object is believed to be there from then on, on what it stands on.
/// @return diagnostics below the step: an unknown frame, one whose pose is not known
struct NewFrame {
  std::string as, in, of = {};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  ///< m
};
[[nodiscard]] Diagnostics set_frame(expression::Cell& cell, const NewFrame& frame);

}  // namespace takt::operations
