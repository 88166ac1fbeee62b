#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/device/channel.h"
#include "core/device/conveyor.h"
#include "sim/machines/signals.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjModel_;

namespace takt::sim {

/// A belt in MuJoCo. Its shapes stand still; where something touches them the surface moves: contacts are given the
/// speed of the belt along it, so that friction takes parts along, and holds and slips by the contact law as
/// everywhere. What sleeps on it wakes when it starts. Owned by its World. Thread: the one that steps the world.
/// Realtime: cyclic but for make().
class SimConveyor final : public SimDevice {
 public:
  /// @param robot  in the world, with the links of the model
  [[nodiscard]] static Result<std::unique_ptr<SimDevice>> make(const mjModel_& model, const std::string& robot,
                                                               const device::ConveyorDescription& conveyor,
                                                               std::uint64_t seed);

  // What the core writes and reads: the drive, its speed; whether it moves, and how far it has, m.
  SimOutput run, speed;
  SimGauge running, position;

  /// Where the belt frame is in that of the device, by the encoder: given to the channel in each of its cycles.
  void publish(device::Channel* pose) { pose_ = pose; }

  void start(const mjData_& data) override;
  void actuate(mjData_& data, const Substep& step) override;
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  SimConveyor(const mjModel_& model, int body, const device::ConveyorDescription& conveyor, std::uint64_t seed,
              const std::string& name);
  void change_speed(double duration);
  void move_surfaces(mjData_& data);
  void wake_parts(mjData_& data) const;
  void read_encoder();

  device::ConveyorDescription figures_;
  const mjModel_& model_;
  int body_;
  Random noise_;
  device::Channel* pose_ = nullptr;
  std::vector<std::int64_t> carries_;     ///< by number of the body: 1: lies on the belt
  double velocity_ = 0.0, travel_ = 0.0;  ///< m/s, m
  double count_ = 0.0;                    ///< m, as the encoder says
  double believed_ = 0.0, rate_ = 0.0;    ///< m, m/s: what the counts tell of the belt
};

}  // namespace takt::sim
