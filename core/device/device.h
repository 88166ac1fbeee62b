#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/time.h"
#include "core/device/seam.h"
#include "core/device/state_words.h"
#include "core/net/primitive.h"

namespace takt::device {

/// A device as the control core sees it: it takes a sample each cycle and is part of the digest. Owned by the core;
/// only the cycle thread touches it once the core runs. Realtime: cyclic.
class Device : public net::Resource {
 public:
  /// @param name  unique in the cell
  explicit Device(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] const std::string& name() const { return name_; }

  /// Takes the newest sample. `cycle` is the core cycle that begins, `time` its time.
  virtual void begin_cycle(std::int64_t cycle, Nanoseconds time) = 0;
  /// Adds all that nets and people can see of the device: sample and, if it is driven, what was sent.
  virtual void add_state(StateWords& words) const = 0;

 protected:
  /// Calls the back end: code of a driver. An exception out of it ends here, so that neither the cycle nor other
  /// devices know of it, and failed_before() and exception() tell. @return what `call` returns, or false.
  template <class Call>
  bool at_border(Call&& call) noexcept {
    try {
      return std::forward<Call>(call)();
    } catch (...) {
      keep_exception();
      return false;
    }
  }
  /// The same for a call without an answer.
  template <class Call>
  void call_border(Call&& call) noexcept {
    (void)at_border([&call] { return std::forward<Call>(call)(), true; });
  }
  /// Once at the beginning of a cycle: @return true if the back end threw since the cycle before began. The device then
  /// counts as lost for this cycle, so that no net outlives it.
  [[nodiscard]] bool failed_before() {
    if (!fresh_exception_) exception_.reset();
    return std::exchange(fresh_exception_, false);
  }
  /// "NAME: its driver failed: WORDS", of the newest exception of this cycle and the one before; or nothing.
  [[nodiscard]] const std::optional<net::Text>& exception() const { return exception_; }

 private:
  void keep_exception() noexcept;

  std::string name_;
  std::optional<net::Text> exception_;
  bool fresh_exception_ = false;
};

/// What a device answers a net that needs it in some state, such as a control mode (row L4).
struct StateAnswer {
  enum class Kind : std::uint8_t {
    kThere,   ///< it is, or the net does not mind
    kAtOnce,  ///< enter() brings it there in this cycle
    kLater,   ///< enter() begins to; ask again
    kRefused  ///< it cannot, for the reason given
  };
  Kind kind = Kind::kThere;
  net::Text why = {};
};

/// A device that is driven: held by one net at a time, with a guard and a stop reaction of its own (docs/devices.md,
/// "What every actuator owes"). A primitive proposes; the core calls the functions below, each cycle in their order.
class Actuator : public Device {
 public:
  using Device::Device;

  /// The device cannot be driven now: not powered, faulted, no sample. The net that holds it ends.
  [[nodiscard]] virtual bool lost() const = 0;
  /// Why it is lost, short, for people.
  [[nodiscard]] virtual net::Text fault() const = 0;
  /// Why no net can take it now, or nothing (row S5).
  [[nodiscard]] virtual std::optional<net::Text> refusal() const = 0;
  /// How a net that is started now would take it over: what is sent last before that net's first cycle (row L3).
  [[nodiscard]] virtual Seam seam() const { return {}; }
  /// Why a net that begins like `begin` cannot follow at once where one ended like `end`: axis and numbers; or nothing.
  /// What one of the two does not say is not compared. Any thread.
  [[nodiscard]] virtual std::optional<net::Text> seam_mismatch(const Seam& /*end*/, const Seam& /*begin*/) const {
    return std::nullopt;
  }
  /// May a net be started that needs the device in this state? Empty: in any.
  [[nodiscard]] virtual StateAnswer answer(std::string_view /*state*/) const { return {}; }
  /// Goes there, or begins to; answer() was not a refusal.
  virtual void enter(std::string_view /*state*/) {}
  /// Why one net cannot drive the device in all of these states by turns, or nothing. Realtime: setup.
  [[nodiscard]] virtual std::optional<std::string> conflict(std::span<const std::string> /*states*/) const {
    return std::nullopt;
  }
  /// A net holds it from the next cycle on.
  virtual void hold() = 0;
  /// The net ended in order: what it proposed in this cycle is still sent; then the device stands, or stops (row L5).
  virtual void release() = 0;
  /// Stop reaction now: what was proposed in this cycle is not sent (row L2).
  virtual void stop() = 0;
  /// The guard looks at what was proposed in this cycle.
  /// @return why it tripped, if it did; the device then stops.
  [[nodiscard]] virtual std::optional<net::Text> check() = 0;
  /// Sends what is due in this cycle.
  virtual void hand_over() = 0;

  /// True if a net holds it.
  [[nodiscard]] virtual bool held() const = 0;
  /// True if what was sent last neither moves nor is about to.
  [[nodiscard]] virtual bool at_rest() const = 0;
  /// True if what was proposed in this cycle leaves it at rest, should the guard let it pass: a net may let go of it.
  [[nodiscard]] virtual bool will_rest() const { return at_rest(); }
  /// True if it moves along what a net plans, and should come to rest on it: the net may stop it (row S1).
  [[nodiscard]] virtual bool follows_paths() const { return false; }
  /// Category 0 (row S3): the device's own brakes, if it has any.
  virtual void brake() {}
  /// True if an emergency stop ends the nets that hold it. A gripper may say no: it keeps its grip.
  [[nodiscard]] virtual bool stops_in_emergency() const { return true; }
};

}  // namespace takt::device
