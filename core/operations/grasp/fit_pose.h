#pragma once

#include <string>
#include <vector>

#include "core/operations/table/operation.h"
#include "core/world/pose_fit.h"

/// "fit_pose": finds the pose of an object whose surface explains recorded contacts. The object is believed to be there
/// from then on, and a frame keeps the pose. Realtime: setup.
namespace takt::operations {

struct FitPoseParameters {
  std::string object = {}, as = {};          ///< as: name of the frame that gets the pose
  std::vector<std::string> contacts = {};    ///< names under which they were recorded
  std::vector<world::Coordinate> free = {};  ///< of the object, which are fitted
  double max_residual = 1e-3;                ///< m, rms of a good fit
  std::string name = {}, pointer = {};       ///< for people; in its file
};
[[nodiscard]] const ParameterTable<FitPoseParameters>& fit_pose_parameters();
[[nodiscard]] Operation fit_pose_operation();

}  // namespace takt::operations
