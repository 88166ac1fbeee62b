#pragma once

#include <cstdint>

#include "hw/emulators/rtde/controller.h"
#include "hw/emulators/rtde/script_intake.h"
#include "hw/emulators/rtde/session.h"

namespace takt::hw::rtde {

/// The ports on which a controller sends its state and accepts scripts: primary (30001: states at 10 Hz and messages),
/// secondary (30002: states at 10 Hz), realtime (30003: its own package in each control cycle).
class ScriptService final : public Service {
 public:
  enum class Stream : std::uint8_t { kPrimary, kSecondary, kRealtime };

  /// `controller` outlives the service and its sessions. @param accepts_scripts  false: 30011 to 30013
  ScriptService(Controller& controller, Stream stream, bool accepts_scripts)
      : controller_(controller), stream_(stream), accepts_scripts_(accepts_scripts) {}
  std::unique_ptr<Session> open() override;

 private:
  class Client;

  Controller& controller_;
  Stream stream_;
  bool accepts_scripts_;
};

/// A program or a line, as a client sends it: some lines are commands of the controller itself.
void run_piece(Controller& controller, const ScriptIntake::Piece& piece);

}  // namespace takt::hw::rtde
