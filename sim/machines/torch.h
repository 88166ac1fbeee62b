#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include "core/device/torch.h"
#include "sim/machines/signals.h"
#include "sim/model/device.h"

struct mjModel_;

namespace takt::sim {

/// A welding torch with its source. While the arc is wanted and metal is within its range along the wire, the arc burns
/// after the time of ignition; out of that range, or without its request, it goes out. What it leaves behind (beads)
/// is for expectations and pictures: it has neither shape nor mass in the world.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic but for make().
class SimTorch final : public SimDevice {
 public:
  /// @param body  number of the link with the tool centre point
  SimTorch(const device::TorchDescription& torch, const mjModel_& model, int body, const Eigen::Isometry3d& X_LT);

  // What the core writes and reads.
  SimOutput gas, arc, wire;
  SimGauge established;

  /// What is wrong with it, for as long as nobody says otherwise: it does not light, or goes out.
  enum class Fault : std::uint8_t { kNone, kNoIgnition, kLost };
  void set_fault(Fault fault) { fault_ = fault; }

  /// Where metal is along the wire, and what is done to it: the truth, for expectations and pictures (row D6).
  struct Spot {
    int body = -1;                                  ///< -1: nothing in reach
    Eigen::Vector3d p_B = Eigen::Vector3d::Zero();  ///< m, in the axes of that body
    double distance = 0.0;                          ///< m, from the contact tube
    bool burns = false, gas = false, wire = false;
  };
  [[nodiscard]] const Spot& spot() const { return spot_; }
  /// Cross-section of the wire times its speed: m^3/s that it leaves behind.
  [[nodiscard]] double deposit_rate() const;

  /// The link that carries the tool centre point, and that point in it, z along the wire.
  [[nodiscard]] int body() const { return body_; }
  [[nodiscard]] const Eigen::Isometry3d& X_LT() const { return X_LT_; }

  void start(const mjData_&) override {}
  void actuate(mjData_&, const Substep&) override {}
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  void find_metal(const mjData_& data);
  void change_arc(double duration);

  device::TorchDescription figures_;
  const mjModel_& model_;
  int body_;
  Eigen::Isometry3d X_LT_;
  Spot spot_;
  double waited_ = 0.0, missing_ = 0.0;  ///< s: since the arc could burn; since it could not
  bool burns_ = false;
  Fault fault_ = Fault::kNone;
  std::int64_t last_ = 0;  ///< ns
};

}  // namespace takt::sim
