#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/machines/signals.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjModel_;

namespace takt::sim {

/// The constraint that holds a tool side to a changer.
[[nodiscard]] std::string lock_name(const SimToolChangerDescription& changer, const SimToolSideDescription& side);

/// A pneumatic tool changer: a piston presses balls behind the rim of a tool side. On its way to the locked end it
/// catches the tool side that is within the tolerance then, and draws it onto its coupling face; where there is none it
/// locks empty, and nothing can be coupled until it is unlocked. On its way back it lets go. Without air the piston
/// stands: what is locked stays locked.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic but for the constructor.
class SimToolChanger final : public SimDevice {
 public:
  /// @param model  the physics; the poses that its locks hold are set here
  SimToolChanger(const SimToolChangerDescription& description, const WorldDescription& world, mjModel_& model);

  // What the core writes and reads (docs/devices/tool-changer.md).
  SimOutput lock;
  SimGauge locked, unlocked, ready_to_lock, coupled, tool_number;

  // Faults, from outside of the simulation; as pushes they are no part of a snapshot.
  void set_air(bool there) { air_ = there; }
  /// The lock opens by itself, worn out or overloaded, and stays open as long as that is so.
  void set_broken(bool broken) {
    broken_ = broken;
    if (broken) piston_ = 0.0;
  }

  void start(const mjData_& data) override;
  void actuate(mjData_& data, const Substep& step) override;
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;
  void resume(mjData_& data) override;

 private:
  static constexpr std::int64_t kNone = -1;

  /// A tool side that fits.
  struct Side {
    int body = 0;
    int lock = 0;             ///< number of the constraint
    std::vector<int> others;  ///< of the same tool side on other changers
    int number = 0;
  };
  [[nodiscard]] const Side& caught() const { return sides_[static_cast<std::size_t>(side_)]; }
  [[nodiscard]] Pose offset_of(const mjData_& data, const Side& side) const;
  /// The tool side that could be coupled now, or kNone.
  [[nodiscard]] std::int64_t side_in_reach(const mjData_& data) const;
  void move_piston(const mjData_& data, double duration);
  void set_locks(mjData_& data);
  void draw_in();

  SimToolChangerDescription figures_;
  mjModel_& model_;
  int body_;
  std::vector<Side> sides_;

  double piston_ = 0.0;           ///< 0: unlocked, 1: locked
  std::int64_t side_ = kNone;     ///< that it has caught, by its place in sides_
  Pose X_CS_ = Pose::Identity();  ///< where that one was then
  bool air_ = true, broken_ = false;
};

}  // namespace takt::sim
