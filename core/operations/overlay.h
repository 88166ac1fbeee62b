#pragma once

#include <optional>
#include <string>

#include "core/command/actions/overlay_action.h"
#include "core/expression/cell.h"
#include "core/operations/parameter_table.h"

namespace takt::activity {

/// What a motion of a file has laid over it: keys "weave" and "force_offset" (docs/scenarios.md).
struct OverlayRequest {
  struct ForceOffset {
    ForceOffset();  ///< the defaults of files
    std::string sensor;
    command::ForceOffsetWish wish;
    /// With how much force the tool of an arm presses.
    [[nodiscard]] command::RealSensor pressing(const std::string& arm, const command::Cell& cell,
                                               const command::Biases& biases) const;
    bool operator==(const ForceOffset&) const = default;
  };
  std::optional<command::WeaveWish> weave;
  std::optional<ForceOffset> force;

  [[nodiscard]] bool any() const { return weave || force; }
};

/// The parameters of the two, as objects of a motion. Realtime: setup.
[[nodiscard]] const ParameterTable<command::WeaveWish>& weave_parameters();
[[nodiscard]] const ParameterTable<OverlayRequest::ForceOffset>& force_offset_parameters();

}  // namespace takt::activity
