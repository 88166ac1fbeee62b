#pragma once

#include <cstdint>

#include "core/activity/step.h"
#include "core/net/description.h"

namespace takt::activity {

/// Verifies a net as LOAD will, so that what is wrong with it is known before anything moves.
void rehearse_net(const net::NetDescription& description, const Rehearsal& rehearsal, const std::string& pointer,
                  Findings& findings);

/// A net from LOAD to its end, as a step that is advanced between cycles: load at once, start `program_latency_cycles`
/// later (row D2), wait for Terminated, unload when destroyed; the core must live until then. Used by steps that act on
/// devices. Thread: the one that steps the core. Realtime: setup.
class NetRun {
 public:
  NetRun() = default;
  ~NetRun();
  NetRun(const NetRun&) = delete;
  NetRun& operator=(const NetRun&) = delete;

  [[nodiscard]] bool begun() const { return id_ != 0; }
  /// Loads. Findings: why the net was rejected. Once.
  Progress begin(Context& context, const net::NetDescription& description, const rcc::LoadOptions& options,
                 Findings& findings);
  /// Findings: the start was refused (row S5 and others), or the net ended by a failure.
  Progress advance(Context& context, Findings& findings);
  /// Asks for the end, which advance() brings about: at once before the start, by CANCEL while the net runs (row L6).
  void cancel() { cancelled_ = true; }
  /// Ends it at once; its devices stop (row L6).
  void abort() {
    if (core_ != nullptr) core_->abort(id_);
  }
  /// The net, to read ports after it has ended; null before begin().
  [[nodiscard]] const net::CompiledNet* net() const { return core_ ? core_->net(id_) : nullptr; }

 private:
  rcc::ControlCore* core_ = nullptr;
  rcc::NetId id_ = 0;
  std::int64_t start_cycle_ = 0;
  rcc::RequestId start_request_ = 0;
  bool cancelled_ = false;
};

}  // namespace takt::activity
