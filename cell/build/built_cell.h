#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cell/file/fault_point.h"
#include "core/device/device_file.h"
#include "core/device/emergency_stop.h"
#include "core/expression/cell.h"
#include "core/rcc/control_core.h"
#include "sim/world/world.h"

namespace takt::cell {

class CommandTape;
class SiteDevices;

/// Everything that a scenario's cell is made of, ready to run: the simulated world, the control core with the canonical
/// devices on simulated back ends, and what the program knows.
struct BuiltCell {
  std::shared_ptr<sim::World> world;      ///< outlives the core: devices borrow their back ends from it
  std::shared_ptr<SiteDevices> site;      ///< what stands between the machines of the world and the devices of the core
  std::shared_ptr<CommandTape> commands;  ///< what the core hands over; outlives it
  std::unique_ptr<rcc::ControlCore> core;
  expression::Cell cell;
  device::EmergencyStop* emergency_stop = nullptr;  ///< null: the scenario never presses one
  std::map<std::string, Eigen::Isometry3d, std::less<>>
      truth_W;              ///< drawn pose of every fixed object: expectations only
  world::FrameGraph start;  ///< every frame as it truly is at the start
  /// Of devices whose mount was drawn: where they truly are in the flange, or in the tool side, that carries them.
  std::map<std::string, Eigen::Isometry3d, std::less<>> true_mounts;
  std::map<std::string, std::string, std::less<>> true_body;  ///< of objects that move: name of the body
  std::map<std::string, std::shared_ptr<FaultPoint>, std::less<>> fault_points;  ///< of devices that may fail
  std::map<std::string, sim::Mount, std::less<>> frames_on;  ///< frames of the file: the bodies they ride on, for films
  std::vector<sim::SimBeamDescription> beams;                ///< for films
  int triangles = 0;                                         ///< of the scene, for the visual budget
  std::optional<device::ModelLibrary> library = {};          ///< where its models come from

  /// Where a frame truly is at the start, in the world; identity if it is not there, which is reported elsewhere.
  [[nodiscard]] Eigen::Isometry3d true_start(std::string_view frame) const {
    return start.pose(frame).value_or(Eigen::Isometry3d::Identity());
  }
  /// What can be wrong with a device comes between it and the core.
  /// @param Point  a FaultPoint that is a Backend, too
  template <class Point, class Backend>
  [[nodiscard]] std::shared_ptr<Backend> with_faults(const std::string& name, std::shared_ptr<Backend> backend) {
    auto point = std::make_shared<Point>(std::move(backend));
    fault_points[name] = point;
    return point;
  }
  /// The back end of a simulated device, borrowed from the world and keeping it alive.
  template <class Backend, class Device>
  [[nodiscard]] std::shared_ptr<Backend> borrowed(Device* device) const {
    return {world, device};
  }
};

}  // namespace takt::cell
