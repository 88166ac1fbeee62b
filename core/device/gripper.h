#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/description.h"
#include "core/device/device.h"

namespace takt::device {

/// What a gripper is told. Stays in force until another one comes.
struct GripperSetPoint {
  std::uint64_t sequence = 0;  ///< counts the commands that differ; 0 = none yet
  double width = 0.0;          ///< where the fingers go, m between the pads
  double speed = 0.0;          ///< at most, of the width, m/s
  double force = 0.0;          ///< at most, N: sum over the fingers, as the data sheets count
};

/// What a gripper does with its newest command.
enum class GripperState : std::uint8_t {
  kIdle,     ///< at the wanted width, with nothing between the fingers that stopped them
  kMoving,   ///< on the way
  kHolding,  ///< a part stopped the fingers, and they press on it with the wanted force
  kLost      ///< what it held is gone; stays until the next command
};

/// What a gripper reports: the newest sample its driver has.
struct GripperSample {
  std::uint64_t sequence = 0;  ///< counts samples; 0 = none yet
  Nanoseconds stamp = 0;       ///< when it was measured, on the core's clock
  double width = 0.0;          ///< m
  double speed = 0.0;          ///< of the width, m/s; positive opens
  double force = 0.0;          ///< N, sum over the fingers; positive closes
  GripperState state = GripperState::kIdle;
  std::uint64_t command = 0;  ///< sequence of the command that `state` speaks of
  bool ready = false;         ///< takes commands: powered, referenced, no fault
  std::uint32_t fault = 0;    ///< device-specific cause, 0 = none
};

/// The machine behind a canonical gripper. Called by the cycle thread only; never blocks, never allocates.
class GripperBackend {
 public:
  virtual ~GripperBackend() = default;
  /// Copies the newest sample. @return false if there has never been one.
  virtual bool read(GripperSample& sample) = 0;
  /// The command in force; the same one again and again while nothing changes.
  virtual void write(const GripperSetPoint& set_point) = 0;
};

/// What is known of a gripper model.
struct GripperDescription : ModelDescription {
  std::string mount_link;
  std::string tcp_link;
  Eigen::Isometry3d X_MT = Eigen::Isometry3d::Identity();  ///< tool centre point in the mount frame, m
  PayloadSetting payload;                                  ///< from the URDF, fingers closed, in mount axes
  std::vector<std::string> fingers;                        ///< joints that move together, each half the width
  double stroke = 0.0;                                     ///< largest width, m
  double speed_min = 0.0, speed_max = 0.0;                 ///< of the width, m/s
  double acceleration = 0.0;                               ///< of the width, m/s^2
  double force_min = 0.0, force_max = 0.0;                 ///< N, sum over the fingers
  double width_resolution = 0.0;                           ///< m
  double finger_inertia = 0.0;                             ///< kg: what the drive adds to each finger
  double pad_friction = 0.0;                               ///< Coulomb, of the pads on a part
  Nanoseconds cycle = kMillisecond;
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2): 20 device cycles
};

/// The canonical gripper: width, speed and force in, width, force and part-held state out (docs/devices.md, "Gripper").
/// Its stop reaction keeps the grip: a part that is held stays held with the force last commanded, fingers on the way
/// stop where they are. Only the cycle thread touches it once the core runs. Realtime: cyclic.
class Gripper final : public Actuator {
 public:
  static constexpr std::string_view kKind = "gripper";

  /// @param backend  shared: the simulation may own it too. Realtime: setup.
  Gripper(std::string name, std::shared_ptr<const GripperDescription> description,
          std::shared_ptr<GripperBackend> backend)
      : Actuator(std::move(name)), description_(std::move(description)), backend_(std::move(backend)) {}

  [[nodiscard]] std::string_view kind() const override { return kKind; }
  [[nodiscard]] const GripperDescription& description() const { return *description_; }

  // -- For primitives ------------------------------------------------------------------------------------------------
  [[nodiscard]] bool has_sample() const { return has_sample_; }
  [[nodiscard]] const GripperSample& sample() const { return sample_; }
  [[nodiscard]] Nanoseconds sample_age() const { return sample_age_; }
  [[nodiscard]] bool ready() const { return has_sample_ && sample_.ready; }
  /// What was sent last; sequence 0 before the first command.
  [[nodiscard]] const GripperSetPoint& set_point() const { return sent_; }
  /// The newest sample speaks of the last command, not of one before.
  [[nodiscard]] bool answered() const { return has_sample_ && sample_.command == sent_.sequence; }
  /// The command of this cycle; the last one given counts. Without one the command before stays in force. Of no effect
  /// while no net holds it: one that is coming to rest may have been taken the gripper away already (row S1).
  void propose(double width, double speed, double force);

  // -- For the control core ------------------------------------------------------------------------------------------
  void begin_cycle(std::int64_t cycle, Nanoseconds time) override;
  void add_state(StateWords& words) const override;
  [[nodiscard]] bool lost() const override { return !ready(); }
  [[nodiscard]] net::Text fault() const override;
  [[nodiscard]] std::optional<net::Text> refusal() const override;
  void hold() override { held_ = true; }
  void release() override;
  void stop() override;
  [[nodiscard]] std::optional<net::Text> check() override;
  void hand_over() override;
  [[nodiscard]] bool held() const override { return held_; }
  /// The fingers stand and know of no other command.
  [[nodiscard]] bool at_rest() const override {
    return sent_.sequence == 0 || (answered() && sample_.state != GripperState::kMoving);
  }
  /// Opening in an emergency would drop the part.
  [[nodiscard]] bool stops_in_emergency() const override { return false; }

 private:
  void keep_grip();
  void send(double width, double speed, double force);

  std::shared_ptr<const GripperDescription> description_;
  std::shared_ptr<GripperBackend> backend_;
  GripperSample sample_;
  bool has_sample_ = false;
  Nanoseconds sample_age_ = 0;
  GripperSetPoint sent_, proposal_;
  GripperSetPoint grip_;     ///< the command with which a part is held, or was until the newest command; else none
  double grip_width_ = 0.0;  ///< where it was held, m
  bool held_ = false, proposed_ = false, releasing_ = false, stopping_ = false;
};

[[nodiscard]] std::string_view name_of(GripperState state);

}  // namespace takt::device
