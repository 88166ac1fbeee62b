#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/kinematics/types.h"
#include "core/kinematics/wheel_drive.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjData_;

namespace takt::sim {

/// What lies between the joints x, y, yaw of a simulated base and its controller: odometry that counts wrong, forces
/// that act where the body really points, and wheels that turn with the motion. The body slides in its plane; what its
/// wheels carry is known from the joints: they push no more than their friction on the floor, and where the load is
/// beyond them the base tips (docs/devices/base.md). Two wheels on an axle (differential drive) push ahead
/// and turn only; sideways their tyres hold like springs until they slip, and the odometry sees nothing of it. Such a
/// base is steered back to its line while it drives. Thread: one. Realtime: cyclic but for the constructor.
class BaseDrive {
 public:
  struct Wheel {
    int velocity_address = 0;
    double inertia = 0.0;  ///< about its axle, kg m^2
  };
  using Wheels = std::vector<Wheel>;
  /// Addresses of the sensor of that name.
  struct Support {
    int force_address = 0, torque_address = 0;
  };

  /// @param name  of the device: its stream of random numbers
  BaseDrive(const SimDriveDescription& description, Wheels wheels, const Support& support, std::uint64_t seed,
            const std::string& name);

  /// The odometry counts from here, and is right.
  void start(const JointVector& q_true);
  /// Counts the way since the last call. @param[out] q, dq  what the odometry says (x, y, yaw)
  void count(const JointVector& q_true, const JointVector& dq_true, JointVector& q, JointVector& dq);
  /// At the end of a cycle: what the floor does to the wheels. @param duration  of the cycle, s
  void weigh(const mjData_& data, double duration);
  /// The load has been beyond the wheels, or the base without any, for so long that it falls over.
  [[nodiscard]] bool tips() const { return beyond_for_ > kTips_s; }
  /// By how far the centre of the load is beyond the line between two wheels; < 0: between the wheels, m.
  [[nodiscard]] double beyond() const { return beyond_; }
  /// What the floor takes of the forces of drives, friction and brakes: where it is more than the wheels' friction they
  /// slip, and the odometry, which counts what wheels turn, does not see it.
  [[nodiscard]] JointVector gripped(const JointVector& force, const JointVector& dq_true);
  /// Turns the wanted heading towards a line beside which the base drives; nothing for a base that goes sideways.
  /// @param q  where it believes to be   @param dq_r  wanted speed   @param[in,out] q_r  wanted place
  void steer(const JointVector& q, const JointVector& dq_r, JointVector& q_r) const;
  /// Forces that the controller wants in the axes of its odometry, as they act on the plant in this physics step.
  [[nodiscard]] JointVector on_plant(const JointVector& force, const JointVector& q_true, const JointVector& dq_true,
                                     double duration);
  /// What acts on a base that is held by such forces on the joints of the plant: sideways its tyres hold it, if it has
  /// any.
  [[nodiscard]] JointVector held(const JointVector& force, const JointVector& q_true, const JointVector& dq_true,
                                 double duration);
  /// The wheels turn as the body moves, without slip.
  void turn_wheels(mjData_& data, const JointVector& q_true, const JointVector& dq_true, double duration) const;

  void stream(StateStream& state);

 private:
  [[nodiscard]] bool exact() const;
  [[nodiscard]] const kinematics::DifferentialDrive* differential() const;
  /// Of the tyres against the body's left, N; a spring from where they last slipped to.
  [[nodiscard]] double tyre_force(const kinematics::DifferentialDrive& drive, double speed_left, double duration);

  static constexpr double kTips_s = 0.1;  ///< shorter, and it falls back onto its wheels

  SimDriveDescription description_;
  Wheels wheels_;
  Support support_;
  Random noise_;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();         ///< true place at the last count
  Eigen::Vector3d counted_ = Eigen::Vector3d::Zero();      ///< what the odometry made of it
  double deflection_ = 0.0;                                ///< of the tyres to the left, m
  double load_ = std::numeric_limits<double>::infinity();  ///< N, on all wheels; not known before the first step
  double beyond_ = 0.0;                                    ///< m
  double beyond_for_ = 0.0;                                ///< s
  bool slips_ = false, has_slipped_ = false;
};

}  // namespace takt::sim
