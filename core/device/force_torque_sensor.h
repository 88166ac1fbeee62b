#pragma once

#include <memory>
#include <string>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/description.h"
#include "core/device/device.h"

namespace takt::device {

/// The canonical force/torque sensor: the newest raw reading in its measuring frame S, tool weight and bias included
/// (docs/devices.md, "Force/torque sensor"). A reading older than sample_age_max or not finite counts as absent.
/// Only the cycle thread touches it once the core runs.
class ForceTorqueSensor final : public Device {
 public:
  static constexpr std::string_view kKind = "force_torque_sensor";

  ForceTorqueSensor(std::string name, std::shared_ptr<const ForceTorqueDescription> description,
                    std::shared_ptr<ForceTorqueBackend> backend);

  [[nodiscard]] std::string_view kind() const override { return kKind; }
  [[nodiscard]] const ForceTorqueDescription& description() const { return *description_; }

  void begin_cycle(std::int64_t cycle, Nanoseconds time) override;
  void add_state(StateWords& words) const override;

  [[nodiscard]] bool has_sample() const { return has_sample_; }
  [[nodiscard]] const WrenchSample& sample() const { return sample_; }
  [[nodiscard]] Nanoseconds sample_age() const { return sample_age_; }
  /// Declared times of its back end.
  [[nodiscard]] BackendTiming timing() const { return backend_->timing(); }

 private:
  std::shared_ptr<const ForceTorqueDescription> description_;
  std::shared_ptr<ForceTorqueBackend> backend_;
  WrenchSample sample_;
  bool has_sample_ = false;
  Nanoseconds sample_age_ = 0;
};

}  // namespace takt::device
