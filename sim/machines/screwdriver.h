#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/device/screwdriver.h"
#include "sim/contact/drive_law.h"
#include "sim/machines/signals.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjModel_;

namespace takt::sim {

/// The motor, clutch and transducer of an electric screwdriver. The motor keeps a speed; the torque is never more than
/// the clutch is set to. Where that does not turn the spindle any more the clutch lets go, until `turn` is taken back.
/// A magnet pulls the screw in whose socket the bit is.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic but for make().
class SimScrewdriver final : public SimDevice {
 public:
  /// @param robot  in the world, with the joints and links of the model
  [[nodiscard]] static Result<std::unique_ptr<SimDevice>> make(const mjModel_& model,
                                                               const WorldDescription& description,
                                                               const std::string& robot,
                                                               const device::ScrewdriverDescription& driver);

  // What the core writes and reads. Digital: turn, reverse; clutch (it has let go), turning, screw (one is at the bit).
  // Analog: speed, rad/s, and torque_limit, Nm; torque on the bit and its largest since the start, Nm, angle since the
  // start, rad, and speed.
  SimOutput turn, reverse, speed, torque_limit;
  SimGauge clutch, turning, screw_present, torque, peak_torque, angle, measured_speed;

  void start(const mjData_& data) override;
  void actuate(mjData_& data, const Substep& step) override;
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  struct Plant {
    int position = 0, velocity = 0;  ///< of the spindle
    int bit = 0;                     ///< body
    double inertia = 0.0;            ///< kg m^2, of all that turns
    double reach = 0.0;              ///< m, of the bit from the origin of its body
  };

  SimScrewdriver(const device::ScrewdriverDescription& driver, Plant plant, std::vector<ScrewSocket> screws,
                 std::uint64_t seed, const std::string& name);
  void start_or_stop();
  [[nodiscard]] double motor_torque(double rate, double duration);
  void watch_clutch(double rate, double duration);
  [[nodiscard]] double pull_at(double gap, double approach, double mass, double duration) const;
  void hold_screw(mjData_& data, double duration);

  device::ScrewdriverDescription figures_;
  Plant plant_;
  std::vector<ScrewSocket> screws_;
  Random noise_;
  double reference_ = 0.0, integral_ = 0.0;  ///< rad/s; Nm
  double applied_ = 0.0, rate_before_ = 0.0, transmitted_ = 0.0, peak_ = 0.0;
  double begin_ = 0.0;    ///< rad, of the spindle when `turn` was set
  double stalled_ = 0.0;  ///< s
  double position_ = 0.0;
  bool running_ = false, let_go_ = false;
  std::int64_t pulled_ = -1;  ///< screw at the magnet in the last step
  double gap_ = 0.0;          ///< m, of that screw to the end of the bit
};

}  // namespace takt::sim
