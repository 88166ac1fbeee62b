#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/device/description.h"
#include "core/device/device.h"

namespace fan {

/// What the model's folder says of a fan.
struct FanDescription : takt::device::ModelDescription {
  double speed_max = 0.0;      ///< rad/s
  double time_constant = 0.0;  ///< s, of the speed behind its set point
};

/// The machine behind a fan: simulated, or a driver. Realtime: cyclic.
class FanBackend {
 public:
  virtual ~FanBackend() = default;
  /// Measured speed, rad/s; nothing before the first sample.
  virtual std::optional<double> read() = 0;
  /// Wanted speed for the coming cycle, rad/s.
  virtual void write(double speed) = 0;
};

/// The canonical fan: measured speed in, one checked speed out a cycle. Its stop reaction is to stand: 0 rad/s.
/// Owned by the core, used by the cycle thread. Realtime: cyclic.
class Fan final : public takt::device::Actuator {
 public:
  static constexpr std::string_view kKind = "fan";

  Fan(std::string name, std::shared_ptr<const FanDescription> description, std::shared_ptr<FanBackend> backend);

  // -- For primitives
  [[nodiscard]] std::optional<double> speed() const { return measured_; }
  [[nodiscard]] const FanDescription& description() const { return *description_; }
  void propose(double speed) { proposed_ = speed; }

  // -- For the core
  [[nodiscard]] std::string_view kind() const override { return kKind; }
  void begin_cycle(std::int64_t cycle, takt::Nanoseconds time) override;
  void add_state(takt::device::StateWords& words) const override;
  [[nodiscard]] bool lost() const override { return !measured_; }
  [[nodiscard]] takt::net::Text fault() const override;
  [[nodiscard]] std::optional<takt::net::Text> refusal() const override;
  void hold() override { held_ = true; }
  void release() override { held_ = false; }
  void stop() override;
  [[nodiscard]] std::optional<takt::net::Text> check() override;
  void hand_over() override;
  [[nodiscard]] bool held() const override { return held_; }
  [[nodiscard]] bool at_rest() const override { return sent_ == 0.0; }

 private:
  std::shared_ptr<const FanDescription> description_;
  std::shared_ptr<FanBackend> backend_;
  std::optional<double> measured_, proposed_;
  double sent_ = 0.0;
  bool held_ = false;
};

}  // namespace fan
