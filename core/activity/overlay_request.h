#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/base/findings.h"
#include "core/command/cell.h"
#include "core/command/overlay_action.h"

namespace takt::activity {

/// What a motion of a file has laid over it: keys "weave" and "force_offset" (docs/scenarios.md).
struct OverlayRequest {
  struct ForceOffset {
    std::string sensor;
    command::ForceOffsetWish wish;
    [[nodiscard]] command::Action laid_over(const command::Action& motion, const std::string& arm,
                                            const command::Cell& cell, const command::Biases& biases) const;
  };
  std::optional<command::WeaveWish> weave;
  std::optional<ForceOffset> force;
};

/// @param json  the motion. Findings: all that is wrong with the form of these two keys. Realtime: setup.
[[nodiscard]] OverlayRequest read_overlay(const nlohmann::ordered_json& json, const std::string& pointer,
                                          const std::string& arm, const command::Cell& cell, Findings& findings);

}  // namespace takt::activity
