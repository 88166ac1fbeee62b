#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "sim/model/world_description.h"

namespace takt::sim {

struct PlainOptions {
  std::string name;                                  ///< of the model
  std::map<std::string, Mount, std::less<>> frames;  ///< that become sites "frame/NAME"
};

/// A world for MuJoCo without us.
struct PlainModel {
  std::string mjcf;                                     ///< text of the file; meshes are in a folder "assets" beside it
  std::map<std::string, std::filesystem::path> assets;  ///< file in that folder: what it is a copy of
  std::vector<std::string> lacks;                       ///< what of the world it has not, for people
};

/// Bodies, joints, shapes, masses, cameras and lights of a world as MuJoCo's XML, with a keyframe "start". Arms and
/// grippers hold their positions by servos of about the stiffness of their controllers; gravity on arms is compensated.
/// The same description gives the same bytes. @return the model, or what World::create says of the description, or
/// that MuJoCo cannot write it. Thread: one at a time in the process. Realtime: setup.
[[nodiscard]] Result<PlainModel> plain_model(const WorldDescription& description, const PlainOptions& options);

}  // namespace takt::sim
