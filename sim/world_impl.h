#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/contact_law.h"
#include "sim/contact_watch.h"
#include "sim/free_motion.h"
#include "sim/model_compiler.h"
#include "sim/rest.h"
#include "sim/solids.h"
#include "sim/thread_law.h"
#include "sim/world.h"

namespace takt::sim {

/// The inside of a World: sim/world.cc steps it, sim/world_build.cc fills it.
struct World::Impl {
  Owned<mjModel_> model;  // of the physics
  Owned<mjData_> data;
  Owned<mjModel_> picture_model;
  Owned<mjData_> picture_data;
  std::optional<ContactLaw> contacts;
  Solids solids;
  ThreadLaw threads;
  Rest rest;
  FreeMotion free_motion;
  Physics physics;
  Nanoseconds now = 0;
  // In the order of the description, kind after kind: inputs after what they read; last the devices of
  // other kinds.
  struct NamedDevice {
    std::string name;
    std::unique_ptr<SimDevice> device;
  };
  std::vector<NamedDevice> named;
  std::vector<SimDevice*> devices;  // the same
  std::vector<ContactWatch> watches;
  std::vector<TouchingBodies> touching;  // of the last physics step
  std::optional<ContactList> contact_list;
  std::vector<std::string> lamps;         // the wires that light something, by name
  std::vector<const double*> lamp_wires;  // the same
  std::vector<double> plant_state;
  std::vector<std::uint64_t> words;  // the state as a digest sees it
  struct Push {
    int body = 0;
    Eigen::Vector3d force, torque;
  };
  std::vector<Push> pushes;  // one of a body
  bool profiling = false;
  StepTimes times;

  [[nodiscard]] Diagnostics add_arms(const WorldDescription& description);
  [[nodiscard]] Result<ArmPlant> arm_plant(const WorldDescription& description, const SimArmDescription& arm);
  void add_sensors(const WorldDescription& description);
  void add_grippers(const WorldDescription& description);
  void add_tool_changers(const WorldDescription& description);
  void add_signals(const WorldDescription& description);
  void add(std::string name, std::unique_ptr<SimDevice> device) {
    devices.push_back(device.get());
    named.push_back({std::move(name), std::move(device)});
  }
  template <class Device>
  [[nodiscard]] Device* find(std::string_view name) const {
    for (const auto& one : named) {
      if (one.name != name) continue;
      if (auto* device = dynamic_cast<Device*>(one.device.get())) return device;
    }
    return nullptr;
  }
  [[nodiscard]] Diagnostics add_others(const WorldDescription& description);
  void set_start(const WorldDescription& description);
  void step();
  /// What is applied to bodies begins with what push() says; devices add to it.
  void begin_forces();
  void physics_step(Nanoseconds end);
  void look();
  void forward();
  /// @return the number of words
  std::size_t stream(StateStream::Mode mode, std::span<std::uint64_t> state);
  [[nodiscard]] bool diverged() const;
  /// Number of the body whose state MuJoCo has warned of; -1: none.
  [[nodiscard]] int diverged_body() const;
};

}  // namespace takt::sim
