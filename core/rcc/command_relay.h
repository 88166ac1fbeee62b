#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/device/control_mode.h"
#include "core/net/description.h"
#include "core/rcc/control_core.h"
#include "core/rcc/rules.h"

namespace takt::rcc {

/// The way into a core whose commands are relayed: what its relay says counts from the next step on, as if it were
/// asked for just now. For the thread that steps the core. Realtime: setup.
class CommandInlet {
 public:
  virtual ~CommandInlet() = default;
  /// Before the first step: it will be that of this cycle.
  virtual void begin_at(std::int64_t cycle) = 0;
  /// @return false: there is no room
  [[nodiscard]] virtual bool post(RequestId id, const Rule& rule) = 0;
  [[nodiscard]] virtual bool change_mode(RequestId id, std::string_view arm, device::ControlMode mode) = 0;
  virtual void abort(NetId net) = 0;
  virtual void unload(NetId net) = 0;
  virtual void stop_all(net::Cause::Code code, std::string_view text) = 0;
};

/// Hears what a program asks of a core, in place of the core (docs/remote.md, "A program in another process"): the core
/// is a follower, and another core, which has the devices, decides in which cycle a command counts. A follower gets the
/// samples of that core's devices, and its commands through the inlet; so both are in the same state after the same
/// cycle. Added to the core like any resource, before the first step. All functions: any thread. Realtime: setup.
class CommandRelay : public net::Resource {
 public:
  [[nodiscard]] std::string_view kind() const final { return "command_relay"; }

  /// A net is about to be loaded under this number. @return why the other core rejects it: so does this one
  [[nodiscard]] virtual Diagnostics load(NetId net, const net::NetDescription& description,
                                         const LoadOptions& options) = 0;
  /// @return false: there is no room, nothing will come of it
  [[nodiscard]] virtual bool post(RequestId id, const Rule& rule) = 0;
  [[nodiscard]] virtual bool change_mode(RequestId id, std::string_view arm, device::ControlMode mode) = 0;
  virtual void abort(NetId net) = 0;
  virtual void unload(NetId net) = 0;
  virtual void stop_all(net::Cause::Code code, std::string_view text) = 0;

  /// By the core, once.
  void attach(CommandInlet& inlet) { inlet_ = &inlet; }

 protected:
  [[nodiscard]] CommandInlet& inlet() { return *inlet_; }

 private:
  CommandInlet* inlet_ = nullptr;
};

}  // namespace takt::rcc
