#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cell/build/cell_frames.h"
#include "cell/build/device_kind.h"
#include "cell/file/description.h"
#include "core/device/device_file.h"
#include "core/world/object.h"
#include "sim/model/world_description.h"

/// The stages of a cell before anything of it runs; the last one is in cell_builder.h. Realtime: setup.
namespace takt::cell {

/// First stage: the file with its models, and where everything is at the start. Devices refer to the description, so
/// it stays where it is.
struct LoadedCell {
  /// Diagnostics: unknown models, mounts and frames.
  LoadedCell(const Description& file, const device::ModelLibrary& models, Diagnostics& diagnostics);
  LoadedCell(const LoadedCell&) = delete;
  LoadedCell& operator=(const LoadedCell&) = delete;

  const Description description;  ///< with the threads of its screws
  const std::vector<std::unique_ptr<LoadedDevice>> devices;
  CellFrames frames;
};

/// Second stage: what the simulated world is to be made of, and what is known of its objects.
struct SimulatedCell {
  sim::WorldDescription world;
  std::map<std::string, world::Object, std::less<>> objects;      ///< as the program knows them
  std::map<std::string, Eigen::Isometry3d, std::less<>> truth_W;  ///< BuiltCell::truth_W
  std::map<std::string, std::string, std::less<>> true_body;      ///< BuiltCell::true_body
  std::map<std::string, sim::Mount, std::less<>> frames_on;       ///< BuiltCell::frames_on
};

/// Diagnostics: what devices, objects, surfaces and cameras of the file do not fit.
[[nodiscard]] SimulatedCell simulate(const LoadedCell& loaded, const device::ModelLibrary& models,
                                     Diagnostics& diagnostics);

/// Every frame of the cell with a place at the start: the body that it rides on, and where in it.
[[nodiscard]] std::map<std::string, sim::Mount, std::less<>> mounted_frames(const LoadedCell& loaded);

}  // namespace takt::cell
