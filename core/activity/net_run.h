#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

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
  [[nodiscard]] bool cancelled() const { return cancelled_; }
  /// Ends it at once; its devices stop (row L6).
  void abort() {
    if (core_ != nullptr) core_->abort(id_);
  }
  [[nodiscard]] rcc::NetId id() const { return id_; }
  /// The net, to read ports after it has ended; null before begin().
  [[nodiscard]] rcc::NetHandle net() const { return core_ ? core_->net(id_) : nullptr; }

 private:
  rcc::ControlCore* core_ = nullptr;
  rcc::NetId id_ = 0;
  std::int64_t start_cycle_ = 0;
  rcc::RequestId start_request_ = 0;
  bool cancelled_ = false;
};

/// The execution of a step that is one net: made when the step begins, followed to its end.
class OneNetRun : public StepRun {
 public:
  Progress advance(Context& context, Findings& findings) final;
  void cancel(Context&) final { net_.cancel(); }

 protected:
  /// Makes the net and gives it to load(). Called again as long as it answers kRunning without having loaded.
  virtual Progress begin(Context& context, Findings& findings) = 0;
  /// Called after each cycle since the net was loaded, before its end is looked at.
  virtual void after_cycle(Context&) {}
  /// The net ended in order, by itself.
  virtual Progress finish(Context&, Findings&) { return Progress::kDone; }
  /// The net ended in order, and somebody had cancelled it.
  virtual Progress finish_cancelled(Context&, Findings&) { return Progress::kDone; }

  Progress load(Context& context, const net::NetDescription& description, Findings& findings,
                const rcc::LoadOptions& options = {}) {
    return net_.begin(context, description, options, findings);
  }
  [[nodiscard]] bool loaded() const { return net_.begun(); }
  [[nodiscard]] rcc::NetId net_id() const { return net_.id(); }
  [[nodiscard]] rcc::NetHandle net() const { return net_.net(); }
  /// Last value of a port of the loaded net; nothing if it is null or the net has no such port.
  template <class T>
  [[nodiscard]] std::optional<T> value_of(std::string_view port) const {
    const rcc::NetHandle net = net_.net();
    const auto* slot = net->template find<T>(port);
    return slot && !slot->null ? std::optional(slot->value) : std::nullopt;
  }
  [[nodiscard]] bool was_true(std::string_view port) const { return value_of<net::Boolean>(port).value_or(false); }

 private:
  NetRun net_;
};

}  // namespace takt::activity
