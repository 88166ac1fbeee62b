#pragma once

#include <string>

#include "tools/import/draft.h"
#include "tools/import/mjcf_source.h"

struct mjModel_;
struct mjSpec_;

namespace takt::tools {

/// What the actuators of a joint can do together; 0: the file does not say.
struct JointDrive {
  double effort = 0.0;    ///< Nm or N
  double velocity = 0.0;  ///< rad/s or m/s
};
[[nodiscard]] JointDrive drive_of(const mjModel_& model, int joint);

/// A text of MuJoCo's parser or compiler as a diagnostic with a code and a hint.
[[nodiscard]] Diagnostic mujoco_diagnostic(const std::string& text);

/// Notes what of the model a robot does not have: constraints, tendons, actuators and keyframes each by name, all else
/// by kind, with places.
void note_unused(const mjModel_& model, mjSpec_& spec, const MjcfSource& source, Draft& draft);

}  // namespace takt::tools
