#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/screw_thread.h"
#include "core/world/object.h"

namespace takt::cell {

/// A screw as the file says it.
struct ScrewEntry {
  std::string thread;                               ///< "M6"
  double length_m = 0.0;                            ///< of the shank, below the head
  std::optional<device::ScrewThread> figures = {};  ///< of models/threads.json, once they have been looked up
};

/// In Bore::thread until the size is known: a clearance for a screw of that size, not a thread.
inline constexpr const char* kClearance = "clearance ";

/// Gives the bores with a thread or a clearance the radius of their size. Realtime: setup.
/// @param pointers  of the parts
void set_threads(std::vector<world::Object::Part>& parts, const std::vector<std::string>& pointers,
                 const device::ScrewThreadTable& threads, Diagnostics& diagnostics);

/// A screw as an object: shank and head with its socket; origin O at the end of the shank, z towards the head.
struct ScrewShapes {
  std::vector<world::Object::Part> parts;                  ///< the shank first
  double mass = 0.0;                                       ///< kg, of steel
  Eigen::Isometry3d X_OS = Eigen::Isometry3d::Identity();  ///< bottom of the socket, z into the screw, m
};
[[nodiscard]] ScrewShapes shapes_of(const ScrewEntry& screw, const device::ScrewThread& thread);
/// @return null with a diagnostic that names the nearest size
[[nodiscard]] const device::ScrewThread* find_thread(const device::ScrewThreadTable& threads, const std::string& size,
                                                     const std::string& pointer, Diagnostics& diagnostics);

}  // namespace takt::cell
