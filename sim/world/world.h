#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "sim/contact/contact_reading.h"
#include "sim/contact/thread_law.h"
#include "sim/machines/arm.h"
#include "sim/machines/force_torque.h"
#include "sim/machines/gripper.h"
#include "sim/machines/signals.h"
#include "sim/machines/tool_changer.h"
#include "sim/model/world_description.h"

struct mjModel_;
struct mjData_;
struct mjSpec_;

namespace takt::sim {

class ContactLaw;

/// Adds what the description does not know (lights, floor, materials, visual options) to the specification before it
/// is compiled.
using SpecHook = std::function<void(mjSpec_&)>;

/// Wall time spent so far, only counted while profiling is on.
struct StepTimes {
  Nanoseconds physics = 0;
  Nanoseconds devices = 0;  ///< simulated controllers and sensors
};

/// The whole state of a world at the end of a cycle. Fits only worlds made from the same description.
using Snapshot = std::vector<std::uint64_t>;

/// A MuJoCo world with the simulated devices in it, stepped by one thread, one control cycle at a time. The same
/// description and the same calls give the same bits.
class World {
 public:
  /// Builds and compiles the model; the devices stand at the start positions, holding them.
  /// @return the world, or everything found wrong: names (empty, duplicate, unknown parent), figures out of range,
  /// chains, sensors, meshes, and what MuJoCo's compiler says. Realtime: setup.
  [[nodiscard]] static Result<World> create(const WorldDescription& description, const SpecHook& hook = {});

  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  /// Advances by one control cycle: in each physics step the controllers compute from what they measure at its begin,
  /// then the plant moves; at the end all devices take new samples.
  /// @return false if the physics diverged or MuJoCo gave up; the state is then worthless and must not be used on.
  /// Realtime: cyclic.
  [[nodiscard]] bool step();
  /// After step() returned false, for people: when, and the body ("ROBOT/LINK" or "OBJECT") whose state is beyond all
  /// bounds, if it is one. Realtime: setup.
  [[nodiscard]] std::string divergence() const;

  [[nodiscard]] Nanoseconds time() const;  ///< whole cycles since the start

  /// The device of that name, or null. Owned by the world, at a fixed address while the world lives.
  [[nodiscard]] SimArm* arm(std::string_view name);
  [[nodiscard]] SimForceTorque* force_torque(std::string_view name);
  [[nodiscard]] SimGripper* gripper(std::string_view name);
  [[nodiscard]] SimToolChanger* tool_changer(std::string_view name);
  [[nodiscard]] SimOutput* output(std::string_view name);
  /// Of an input terminal, a light barrier or a range finder.
  [[nodiscard]] SimReading* input(std::string_view name);
  /// Of any kind.
  [[nodiscard]] SimDevice* device(std::string_view name);

  /// Everything that the next step depends on, in a fixed order without gaps: for the digest. Valid until the next
  /// call of a function that is not const. Realtime: cyclic.
  [[nodiscard]] std::span<const std::byte> state_bytes() const;
  /// What word number `word` (8 bytes) of them is, for people: "position of 'arm/a1'", "device 2, value 5". Realtime:
  /// setup.
  [[nodiscard]] std::string state_word_name(std::size_t word) const;
  /// Realtime: setup.
  [[nodiscard]] Snapshot save() const;
  /// Continues bit for bit as the world did that `snapshot` was saved from, if it is given the same set points.
  /// @return false, and nothing changed, if the sizes differ. Realtime: setup.
  [[nodiscard]] bool restore(const Snapshot& snapshot);

  /// Positions of all joints of the plant (MuJoCo's qpos) at time(): what a recording keeps to draw the run again.
  /// Valid until the next step. Realtime: cyclic.
  [[nodiscard]] std::span<const double> positions() const;
  /// A name for each of them: "ROBOT/JOINT", for a free object "OBJECT/x" ... "OBJECT/qz". Realtime: setup.
  [[nodiscard]] std::vector<std::string> position_names() const;

  // The truth of the simulation: for expectations, pictures and tests, never for a controller (row D6).

  /// Number of the body of that name ("ROBOT/LINK" or "OBJECT"), or -1. Realtime: setup.
  [[nodiscard]] int body(std::string_view name) const;
  /// Pose in the world at time(). Realtime: cyclic.
  [[nodiscard]] Pose body_pose(int body) const;
  /// Somebody pushes a body from now on: force at its centre of mass, N, and torque, Nm, in the world, beside what
  /// devices do to it; zeros end it. An input of the next steps, like set points: no part of a snapshot.
  /// Realtime: cyclic.
  void push(int body, const Eigen::Vector3d& force, const Eigen::Vector3d& torque = Eigen::Vector3d::Zero());
  /// Kinetic and potential energy of the plant, J, at time(). Realtime: cyclic.
  [[nodiscard]] double energy() const;
  /// Begins to watch the contact between two sides, each a body ("ROBOT/LINK" or "OBJECT") or a whole robot ("ROBOT").
  /// @return the number to ask contact() with; or a diagnostic for an unknown name. Realtime: setup.
  [[nodiscard]] Result<std::size_t> watch_contact(const std::string& side_a, const std::string& side_b);
  [[nodiscard]] const ContactReading& contact(std::size_t watch) const;
  /// From now on contacts of these bodies (by number) with anything are listed. Realtime: setup.
  void list_contacts_of(std::vector<bool> bodies);
  /// What touched since the last call; empty where nothing is listed. No part of a snapshot. Valid until the next step.
  /// Realtime: cyclic.
  [[nodiscard]] std::span<const BodyContact> take_contacts();
  /// Names of all bodies by number: "ROBOT/LINK" or "OBJECT"; of the world empty. Realtime: setup.
  [[nodiscard]] std::vector<std::string> body_names() const;
  /// Screws that were caught, seated, released.
  [[nodiscard]] const ThreadLaw& threads() const;
  [[nodiscard]] const ContactLaw& contact_law() const;

  /// What pictures are drawn from: the model with all visual geometry, and a state with the positions of time(), which
  /// lamps burn, and nothing else; data() copies them. The physics runs on a model of its own without that geometry,
  /// which costs a seventh of a step; positions, bodies and their numbers are the same in both. Thread: the one that
  /// steps.
  [[nodiscard]] const mjModel_* model() const;
  [[nodiscard]] const mjData_* data() const;
  /// The wires that light something in the pictures, in the order of their values in the userdata of data().
  [[nodiscard]] const std::vector<std::string>& lamps() const;
  /// What the physics runs on.
  [[nodiscard]] const mjModel_* physics_model() const;
  [[nodiscard]] const mjData_* physics_data() const;

  void set_profiling(bool on);
  [[nodiscard]] StepTimes times() const;

 private:
  struct Impl;
  explicit World(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::sim
