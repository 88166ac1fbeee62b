#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/rcc/control_core.h"

namespace takt::serve {

/// A value of the core that any number of monitors look at, each at a rate of its own: it is watched once, at the
/// highest of them. One thread.
class SharedWatch {
 public:
  SharedWatch(rcc::ControlCore& core, std::shared_ptr<rcc::Watch> watch) : core_(core), watch_(std::move(watch)) {}
  ~SharedWatch() { core_.unwatch(watch_); }
  SharedWatch(const SharedWatch&) = delete;
  SharedWatch& operator=(const SharedWatch&) = delete;

  [[nodiscard]] net::ValueType type() const { return watch_->type(); }
  [[nodiscard]] std::optional<rcc::WatchedValue> newest() { return watch_->newest(); }
  [[nodiscard]] bool ended() const { return watch_->ended(); }
  /// @param every  cycles between two values; 0: none for now
  void set_every(const void* user, int every);
  void leave(const void* user) { set_every(user, 0); }

 private:
  rcc::ControlCore& core_;
  std::shared_ptr<rcc::Watch> watch_;
  std::map<const void*, int> users_;  ///< those that want values
};

/// Finds the watch of a value that others look at already. One thread.
class WatchPool {
 public:
  static constexpr std::size_t kMost = 192;  ///< of those that the core has room for
  explicit WatchPool(rcc::ControlCore& core) : core_(core) {}

  /// @param net  0: a channel. @return the watch, or what is wrong
  [[nodiscard]] Result<std::shared_ptr<SharedWatch>> open(rcc::NetId net, const std::string& port);

 private:
  rcc::ControlCore& core_;
  std::map<std::pair<rcc::NetId, std::string>, std::weak_ptr<SharedWatch>> watches_;
};

}  // namespace takt::serve
