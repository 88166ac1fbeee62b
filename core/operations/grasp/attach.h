#pragma once

#include <optional>
#include <string>

#include "core/operations/table/operation.h"

/// "attach": from now on an object rides on a tool that holds it without fingers: a magnet, a suction cup, a hook.
/// "detach": it does so no more (docs/world.md). Both change the belief alone; nothing moves. Realtime: setup.
namespace takt::operations {

struct AttachParameters {
  std::string tool = {};                  ///< device with a tool centre point; empty: the only one
  std::optional<std::string> part = {};   ///< object; nothing: the free one at the tool centre point
  std::optional<std::string> grasp = {};  ///< of the object: it is at the tool centre point; nothing: as believed
  std::string name = {}, pointer = {};    ///< for people; in its file
};
struct DetachParameters {
  std::string tool = {};                         ///< device with a tool centre point; empty: the only one
  std::optional<std::string> onto = {};          ///< that the part stands on then; nothing: what is there
  std::optional<Eigen::Vector3d> position = {};  ///< where it is then, in `onto`, m; nothing: where the tool has it
  std::optional<Eigen::Vector3d> rpy = {};       ///< roll, pitch, yaw in `onto`, rad
  std::string name = {}, pointer = {};           ///< for people; in its file
};
[[nodiscard]] const ParameterTable<AttachParameters>& attach_parameters();
[[nodiscard]] const ParameterTable<DetachParameters>& detach_parameters();

/// The same for programs in C++, the arm as it is measured now. The tool exists.
/// @return the name of the object, or diagnostics below the step: there is none, it is fixed, the tool holds one
Result<std::string> attach(expression::Cell& cell, const AttachParameters& parameters);
/// @return the name of the object, or diagnostics below the step: nothing is held, there is no such frame
Result<std::string> detach(expression::Cell& cell, const DetachParameters& parameters);

[[nodiscard]] Operation attach_operation();
[[nodiscard]] Operation detach_operation();

}  // namespace takt::operations
