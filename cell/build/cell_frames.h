#pragma once

#include <string>
#include <vector>

#include "cell/build/device_kind.h"
#include "cell/file/description.h"
#include "core/world/frame_graph.h"

namespace takt::cell {

/// The frames of a cell, as the application believes them and as they are at the start: those that the file places, and
/// those that devices and objects bring: "ARM/flange", "TOOL" and "TOOL/TCP", "OBJECT/GRASP". Entries may name each
/// other in any order. Of the true ones none moves: they say where the machines and objects are put. Realtime: setup.
class CellFrames {
 public:
  /// @param diagnostics  frames in unknown frames, and frames that depend on each other in a circle
  CellFrames(const Description& description, LoadedDevices devices, Diagnostics& diagnostics);

  world::FrameGraph believed, truth;

  /// What is placed in this frame depends on: of a base the frame of its body.
  [[nodiscard]] std::string standing_frame(const std::string& name) const;

 private:
  /// A frame that is to be placed, once the frame that it depends on is there.
  struct Wanted {
    std::string pointer, name, in_pointer;
    world::Relation believed, truth;
    bool placed = false;
  };

  void want_devices(const Description& description, LoadedDevices devices);
  void want_arm(const LoadedDevice& arm);
  void want_belt(const LoadedDevice& conveyor);
  void want_mounted(const LoadedDevice& device);
  void want_objects(const Description& description);
  void want(std::string pointer, const std::string& name, const Placement& at, const Eigen::Isometry3d& drawn);
  void place_all(Diagnostics& diagnostics);
  void report_unplaced(Diagnostics& diagnostics) const;

  std::vector<Wanted> wanted_;
  std::map<std::string, Eigen::Isometry3d, std::less<>> bases_;  ///< X_BF at the start, by name of the base
};

/// Tool centre points of a device in its mount frame by name: its model's, and those of the file. Empty: it is no tool.
[[nodiscard]] std::map<std::string, Eigen::Isometry3d, std::less<>> tcps_of(const LoadedDevice& device);

}  // namespace takt::cell
