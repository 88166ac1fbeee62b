#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/device/vacuum_cup.h"
#include "sim/machines/signals.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjModel_;

namespace takt::sim {

/// Suction cups on one ejector in MuJoCo. A lip is a ring of spheres; each stands for its share of the circumference,
/// tight while it touches the part and open while it does not. With the valve open
///   dp/dt = (p_max - p)/T - leak * open * p/T,
/// `open` being the sum over the lips, so lips that are tight all around reach p_max and an open one nearly nothing.
/// The pressure presses cup and part against each other with p * area, as two opposite forces at the mouth, along its
/// axis: the part is held by that force and the friction of the lip alone. What pulls more, or pushes sideways more,
/// takes it away. Owned by its World. Thread: the one that steps the world. Realtime: cyclic but for make().
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
  struct Lip {
    int body = 0;
    std::size_t first = 0, points = 0;  ///< of touched_
    std::int64_t part = -1;             ///< body that most points touch; -1: none
    double tight = 0.0;                 ///< share of the lip that touches it
  };
  struct Plant {
    std::vector<Lip> lips;
    std::vector<int> point_of_geom;  ///< by number of the geom: which point of the lips it is; -1: none
    std::vector<int> body_of_geom;   ///< likewise
    std::vector<bool> own;           ///< by number of the body: a body of the cup
  };
  SimVacuumCup(const device::VacuumCupDescription& cup, Plant plant);
  void find_parts(const mjData_& data);
  void find_part(Lip& lip) const;
  void change_pressure(double duration);

  device::VacuumCupDescription figures_;
  Plant plant_;
  std::vector<int> touched_;  ///< per point: body that it touches; 0: none that moves, -1: nothing
  double pressure_ = 0.0;     ///< Pa below ambient
  bool switched_ = false;
};

}  // namespace takt::sim
