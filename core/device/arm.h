#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/brake_ramp.h"
#include "core/device/description.h"
#include "core/device/device.h"
#include "core/device/following_monitor.h"
#include "core/device/guard.h"
#include "core/net/primitive.h"

namespace takt::device {

/// The canonical arm: newest sample in, one guarded set point a cycle out (docs/devices.md, "Arm").
///
/// Primitives read the sample and propose set points; the control core calls the rest, in the order of the members
/// below, each cycle. Only the cycle thread touches an arm once the core runs. Realtime: cyclic unless said otherwise.
class Arm final : public Actuator {
 public:
  static constexpr std::string_view kKind = "arm";

  /// Who decides what is sent.
  enum class Phase : std::uint8_t {
    kNotReady,   ///< no sample yet, not powered, faulted: nothing is sent
    kFrozen,     ///< the last set point, bit for bit, every cycle (row L5)
    kFollowing,  ///< what the net proposes, if the guard lets it pass
    kBraking,    ///< the stop reaction: a ramp within the limits, then kFrozen
    kChanging    ///< the last set point, while the device goes into another control mode, then kFrozen
  };

  /// @param backend  shared: the simulation may own it too. Realtime: setup.
  Arm(std::string name, std::shared_ptr<const ArmDescription> description, std::shared_ptr<ArmBackend> backend,
      Nanoseconds period);

  [[nodiscard]] std::string_view kind() const override { return kKind; }
  [[nodiscard]] const ArmDescription& description() const { return *description_; }
  [[nodiscard]] int joint_count() const { return static_cast<int>(description_->limits.velocity.size()); }

  // -- For primitives ------------------------------------------------------------------------------------------------
  /// The newest sample; has_sample() is false before the first and past the description's sample_age_max.
  [[nodiscard]] const ArmSample& sample() const { return sample_; }
  [[nodiscard]] bool has_sample() const { return has_sample_; }
  /// Age of the sample at the beginning of this cycle.
  [[nodiscard]] Nanoseconds sample_age() const { return sample_age_; }
  [[nodiscard]] bool ready() const { return has_sample_ && sample_.ready; }
  /// What was sent last: q, dq, ddq. Of size 0 before the arm was ready for the first time.
  [[nodiscard]] const ArmSetPoint& set_point() const { return guard_.last(); }
  /// The set point of this cycle; the last one given counts. The arm gives way as before.
  void propose(const JointVector& q, const JointVector& dq, const JointVector& ddq);
  /// The same, and the control mode that it is meant for with all that belongs to it.
  void propose(const JointVector& q, const JointVector& dq, const JointVector& ddq, const Compliance& compliance);
  /// In which set points are followed, from this cycle on.
  [[nodiscard]] ControlMode mode() const { return mode_; }
  /// What was sent last beside the set point; empty in mode position.
  [[nodiscard]] const Compliance& compliance() const { return compliance_; }
  /// Share of its range that a value of the compliance may change by in a cycle.
  [[nodiscard]] double compliance_share() const { return compliance_share_; }
  [[nodiscard]] const ToolSetting& tool() const { return tool_; }

  // -- For the control core ------------------------------------------------------------------------------------------
  /// An arm that becomes ready is taken over where it is told to be, or, if it does not say so, where it stands.
  void begin_cycle(std::int64_t cycle, Nanoseconds time) override;
  void add_state(StateWords& words) const override;
  [[nodiscard]] bool lost() const override { return phase_ == Phase::kNotReady; }
  [[nodiscard]] net::Text fault() const override;
  /// Not ready, braking, or away from its set point.
  [[nodiscard]] std::optional<net::Text> refusal() const override;
  /// What this cycle sends if the guard lets it pass, else what was sent last.
  [[nodiscard]] Seam seam() const override;
  /// Positions, velocities and accelerations may differ by what one step of the largest jerk does in a period.
  [[nodiscard]] std::optional<net::Text> seam_mismatch(const Seam& end, const Seam& begin) const override;
  /// States are control modes (docs/control-modes.md).
  [[nodiscard]] StateAnswer answer(std::string_view mode) const override;
  void enter(std::string_view mode) override;
  [[nodiscard]] std::optional<std::string> conflict(std::span<const std::string> modes) const override;
  void hold() override;
  void release() override;
  void stop() override;
  [[nodiscard]] std::optional<net::Text> check() override;
  void hand_over() override;
  [[nodiscard]] bool held() const override { return held_; }
  /// The last set point sent neither moves nor accelerates, and nothing pushes beside the springs. An arm that
  /// follows none, with closed brakes or after a stop of its own, is at rest once it stands.
  [[nodiscard]] bool at_rest() const override {
    return (guard_.at_rest() && compliance_.neutral()) || stands_by_itself();
  }
  [[nodiscard]] bool will_rest() const override;

  [[nodiscard]] Phase phase() const { return phase_; }
  /// Words for the sample's fault, and for any. Realtime: setup (makes a string).
  [[nodiscard]] std::string fault_text() const;
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const;
  /// Declared times of its back end.
  [[nodiscard]] BackendTiming timing() const { return backend_->timing(); }
  [[nodiscard]] bool follows_paths() const override { return true; }
  void brake() override;

  /// Why the mode cannot be changed now by somebody who is no net, or nothing; the classes of change decide (row L4).
  [[nodiscard]] std::optional<net::Text> refuse_change(ControlMode mode) const;
  /// Begins; refuse_change() has found nothing. phase() is kChanging until the device is there, or gave up.
  void change_mode(ControlMode mode);

  /// Changes tool and payload; only while no net holds the arm. Realtime: setup.
  void set_tool(const ToolSetting& tool);

 private:
  void send(const motion::JointSample& state);
  void begin_braking();
  [[nodiscard]] std::optional<Violation> find_violation() const;
  [[nodiscard]] std::optional<net::Text> find_wrong_mode() const;
  [[nodiscard]] std::optional<net::Text> find_following_error();
  [[nodiscard]] bool away_from_set_point() const;
  [[nodiscard]] bool stands_by_itself() const;
  /// Where the device says that it is told to be, else where it is measured.
  [[nodiscard]] const JointVector& start_positions() const {
    return sample_.commanded.size() > 0 ? sample_.commanded : sample_.q;
  }
  void stand_in(ControlMode mode);
  void switch_to(ControlMode mode);
  void look_at_change();
  void follow();
  void freeze();
  void continue_braking();

  std::shared_ptr<const ArmDescription> description_;
  std::shared_ptr<ArmBackend> backend_;
  Nanoseconds period_;
  Guard guard_;
  FollowingMonitor following_;
  int cycles_off_ = 0;  ///< in a row in which the arm did not follow
  ToolSetting tool_;

  std::int64_t cycle_ = 0;
  Nanoseconds time_ = 0;
  ArmSample sample_;
  bool has_sample_ = false;
  Nanoseconds sample_age_ = 0;

  Phase phase_ = Phase::kNotReady;
  bool held_ = false;
  bool releasing_ = false;
  bool proposed_ = false;
  bool started_ = false;  ///< the net has sent its first set point
  ArmSetPoint proposal_;
  Compliance proposed_compliance_;  ///< valid with compliance_proposed_
  bool compliance_proposed_ = false;

  ControlMode mode_ = ControlMode::kPosition;
  Compliance compliance_;
  double compliance_share_;
  ControlMode target_mode_ = ControlMode::kPosition;  ///< of kChanging
  std::int64_t change_ends_ = 0;                      ///< cycle in which the declared time is over
  std::int64_t mode_due_ = 0;                         ///< cycle from which on samples must show mode_
  BrakeRamp ramp_;
  std::int64_t brake_cycles_ = 0;
};

[[nodiscard]] std::string_view name_of(Arm::Phase phase);

}  // namespace takt::device
