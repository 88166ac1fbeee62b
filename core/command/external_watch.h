#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/command/mapping.h"
#include "core/rcc/control_core.h"

namespace takt::command {

/// Sees the external effects of a loaded net: each is counted in the net, and the count is compared with what has been
/// told. So none is lost in silence: if the program looked too late, only the cycle is not known any more. Used by who
/// loads commands; thread: that one's. Realtime: setup.
class ExternalWatch {
 public:
  ExternalWatch() = default;
  ~ExternalWatch() { detach(); }
  ExternalWatch(const ExternalWatch&) = delete;
  ExternalWatch& operator=(const ExternalWatch&) = delete;

  /// Once, after LOAD and before START. The core outlives it. @return diagnostics: it has no room for so many watches.
  [[nodiscard]] Diagnostics attach(rcc::ControlCore& core, rcc::NetId net, const std::vector<ExternalPort>& ports);
  /// Looks no more. Before the net is unloaded.
  void detach();
  /// Reports what has happened since the last call: to `tell` and to the handler of the effect.
  void poll(const std::function<void(const ExternalEvent&)>& tell = {});
  /// Events whose cycle was lost because the program looked too late.
  [[nodiscard]] std::int64_t times_lost() const { return times_lost_; }

 private:
  struct External {
    std::string name;
    ExternalHandler handler;
    std::shared_ptr<rcc::Watch> watch;
    std::int64_t seen = 0;
    std::int64_t dropped = 0;
  };
  void poll(External& external, const std::function<void(const ExternalEvent&)>& tell);
  void report(External& external, std::int64_t count, std::optional<std::int64_t> cycle,
              const std::function<void(const ExternalEvent&)>& tell);

  rcc::ControlCore* core_ = nullptr;
  std::vector<External> externals_;
  std::int64_t times_lost_ = 0;
};

}  // namespace takt::command
