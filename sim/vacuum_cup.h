#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/device/vacuum_cup.h"
#include "sim/device.h"
#include "sim/signals.h"
#include "sim/world_description.h"

struct mjModel_;

namespace takt::sim {

/// A suction cup with its ejector in MuJoCo. The lip is a ring of spheres; each stands for its share of the
/// circumference, tight while it touches the part and open while it does not. With the valve open
///   dp/dt = (p_max - p)/T - leak * open * p/T,
/// so a lip that is tight all around reaches p_max and an open one nearly nothing. The pressure presses cup and part
/// against each other with p * area, as two opposite forces at the mouth, along its axis: the part is held by that
/// force and the friction of the lip alone. What pulls more, or pushes sideways more, takes it away. Owned by its
/// World. Thread: the one that steps the world. Realtime: cyclic but for make().
class SimVacuumCup final : public SimDevice {
 public:
  /// @param robot  in the world, with the links of the model
  [[nodiscard]] static Result<std::unique_ptr<SimDevice>> make(const mjModel_& model, const std::string& robot,
                                                               const device::VacuumCupDescription& cup);

  // What the core writes and reads: the valve; the vacuum switch, and the vacuum, Pa.
  SimOutput suction;
  SimGauge holding, vacuum;

  void start(const mjData_& data) override;
  void actuate(mjData_& data, const Substep& step) override;
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  struct Plant {
    int lip = 0;                     ///< body
    std::vector<int> point_of_geom;  ///< by number of the geom: which point of the lip it is; -1: none
    std::vector<int> body_of_geom;   ///< likewise
    std::vector<bool> own;           ///< by number of the body: a body of the cup
    int points = 0;                  ///< of the lip
  };
  SimVacuumCup(const device::VacuumCupDescription& cup, Plant plant);
  void find_part(const mjData_& data);
  void change_pressure(double duration);

  device::VacuumCupDescription figures_;
  Plant plant_;
  std::vector<int> touched_;  ///< per point: body that it touches; 0: none that moves, -1: nothing
  std::int64_t part_ = -1;    ///< body that most points touch; -1: none
  double tight_ = 0.0;        ///< share of the lip that touches it
  double pressure_ = 0.0;     ///< Pa below ambient
  bool switched_ = false;
};

}  // namespace takt::sim
