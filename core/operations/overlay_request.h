#pragma once

#include <optional>
#include <string>

#include "core/base/findings.h"
#include "core/base/object_reader.h"
#include "core/command/actions/overlay_action.h"
#include "core/expression/cell.h"

namespace takt::activity {

/// What a motion of a file has laid over it: keys "weave" and "force_offset" (docs/scenarios.md).
struct OverlayRequest {
  struct ForceOffset {
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

/// @param reader  of the motion. Findings: all that is wrong with the form of these two keys. Realtime: setup.
[[nodiscard]] OverlayRequest read_overlay(ObjectReader& reader, const std::string& arm, const command::Cell& cell);

}  // namespace takt::activity
