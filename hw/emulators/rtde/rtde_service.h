#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "hw/emulators/rtde/controller.h"
#include "hw/emulators/rtde/session.h"
#include "hw/rtde/message.h"

namespace takt::hw::rtde {

/// Port 30004: any number of clients, each with one output recipe and any number of input recipes. An input field
/// belongs to the client that has it in a recipe, until it leaves.
class RtdeService final : public Service {
 public:
  /// `controller` outlives the service and its sessions.
  explicit RtdeService(Controller& controller) : controller_(controller) {}
  std::unique_ptr<Session> open() override;

  /// What clients did that no client should; for reports.
  struct Counts {
    std::uint64_t sessions = 0;
    std::uint64_t broken = 0;     ///< connections that were closed: no stream of packages
    std::uint64_t refused = 0;    ///< requests that were answered with a refusal
    std::uint64_t misshapen = 0;  ///< data of the wrong length, or for a recipe that is not there
    std::uint64_t left_out = 0;   ///< output packages that a client did not read in time
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  class Client;

  Controller& controller_;
  std::map<FieldTable::Id, std::uint64_t> claims_;  // input field: session
  Counts counts_;
};

}  // namespace takt::hw::rtde
