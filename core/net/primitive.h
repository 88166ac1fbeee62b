#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/net/value.h"

namespace takt::net {

/// What a resource says of the one value that it carries: texts as in a PortSpec, but without variables.
struct Signal {
  std::string unit, frame;
};

/// Something outside the nets that primitives may use by name: a device, a channel. Owned by the control core.
class Resource {
 public:
  virtual ~Resource() = default;
  /// The canonical name of its kind, for messages: "arm", "force_torque_sensor".
  [[nodiscard]] virtual std::string_view kind() const = 0;
  /// A resource that carries one value fixes variables of every primitive that names it: its unit is "u" (the second
  /// of two units "v"), its frame is "A>B" or "A". nullptr: it fixes nothing.
  [[nodiscard]] virtual const Signal* signal() const { return nullptr; }
};

/// In which state a device has to be while a primitive drives it.
struct ClaimState {
  Resource* device = nullptr;
  std::string state;  ///< a word of the device's kind, such as a control mode; empty: any
};

/// Finds resources at load. Realtime: setup.
class Environment {
 public:
  virtual ~Environment() = default;
  /// @return the resource, or nullptr.
  [[nodiscard]] virtual Resource* find(std::string_view name) = 0;
  [[nodiscard]] virtual std::vector<std::string> names() const = 0;
};

/// Why a net ended or was stopped.
struct Cause {
  enum class Code : std::uint8_t {
    kNone,
    kTerminated,
    kCancelled,
    kAborted,
    kNullInput,
    kDevice,
    kGuard,
    kException,
    kOverrun,
    kConflict,
    kError,
    kTakenOver
  };
  Code code = Code::kNone;
  Text text;                ///< for people: what, where, number
  std::int64_t cycle = -1;  ///< core cycle in which it happened

  /// The net came to its end as it was meant to, whoever asked for it.
  [[nodiscard]] constexpr bool in_order() const {
    return code == Code::kTerminated || code == Code::kCancelled || code == Code::kTakenOver;
  }
};

[[nodiscard]] std::string_view name_of(Cause::Code code);

/// What one net tells the executor; written by primitives such as Termination and Error. Stays once set.
struct NetSignals {
  bool terminate = false;
  bool fail = false;
  Cause cause;

  /// Fails the net; the first cause stays. Realtime: cyclic.
  void fail_with(Cause::Code code, std::string_view text, std::int64_t cycle) {
    if (fail) return;
    fail = true;
    cause = {code, Text(text), cycle};
  }
};

/// The cycle as a primitive sees it.
struct Cycle {
  std::int64_t index = 0;         ///< core cycle
  std::int64_t index_in_net = 0;  ///< 0 in the first cycle of this net (or of the activation of its fragment)
  Nanoseconds time = 0;           ///< of this cycle, on the core's clock
  Nanoseconds period = kMillisecond;
  double dt = 1e-3;   ///< period in s
  bool first = true;  ///< index_in_net == 0
  bool cancel_requested = false;
  /// What moves comes to rest now, whatever its inputs say (row S1). Heeded by who has a Primitive::stop_time_bound().
  bool stop_requested = false;
  NetSignals* signals = nullptr;  ///< never null in update()
};

/// An input port: reads the slot that LOAD bound, without a copy. Null if nothing is bound.
template <class T>
class In {
 public:
  explicit In(const Slot<T>* slot = &kNullSlot<T>) : slot_(slot) {}
  [[nodiscard]] bool null() const { return slot_->null != 0; }
  [[nodiscard]] const T& operator*() const { return slot_->value; }
  [[nodiscard]] const T* operator->() const { return &slot_->value; }
  [[nodiscard]] T value_or(const T& other) const { return null() ? other : slot_->value; }
  /// Whether the net feeds this input, by a link or a constant.
  [[nodiscard]] bool bound() const { return slot_ != &kNullSlot<T>; }

 private:
  const Slot<T>* slot_;
};

/// An output port. What is set is canonical; what is not finite becomes null (rows N1, N5).
template <class T>
class Out {
 public:
  explicit Out(Slot<T>* slot = nullptr) : slot_(slot) {}
  void set(T value) {
    if (!canonicalise(value)) [[unlikely]]
      return set_null();
    slot_->value = value;
    slot_->null = 0;
  }
  void set_null() {
    slot_->value = null_payload<T>();
    slot_->null = 1;
  }

 private:
  Slot<T>* slot_;
};

/// A Boolean input at which null has a meaning of its own, true or false, which the net may declare otherwise
/// ("on_null", row N3). Made by Setup::flag().
class Flag {
 public:
  Flag(In<Boolean> in, bool null_counts_as) : in_(in), null_counts_as_(null_counts_as) {}
  [[nodiscard]] bool holds() const { return in_.value_or(null_counts_as_); }
  [[nodiscard]] bool null() const { return in_.null(); }

 private:
  In<Boolean> in_;
  bool null_counts_as_;
};

/// How an input meets null; LOAD's notes are made of it. kPropagate is the general rule: null in, null out. kHandled:
/// null here alone makes no output null (outputs with `may_be_null` aside). kMayPass: a rule of its own by which null
/// here can make an output null and need not (logic, a selection).
enum class OnNull : std::uint8_t { kPropagate, kCountsAsTrue, kCountsAsFalse, kStop, kHandled, kMayPass };

/// What a port says of itself. Texts must outlive the registry (string literals).
struct PortSpec {
  /// Unit text such as "m/s", "rad", "N", "1"; a lone lower-case letter ("u") is a variable, unified over the links and
  /// shared by all ports of the primitive that use it, also in products: "u/s", "u*v". Vector, Twist, Wrench: one unit
  /// for all components or "linear,angular". Empty = the type carries no unit (Boolean, Integer, String, Rotation,
  /// Frame).
  std::string_view unit = {};
  /// Frame- and geometry-valued ports: "A>B" = pose of B in A; upper-case letters are variables of the primitive, and
  /// "@name" takes the text of the String parameter `name`, anything else is a name as it stands. Vectors, twists and
  /// wrenches may name only the frame they are expressed in ("A"). Empty = not checked.
  std::string_view frame = {};
  std::string_view doc = {};
  OnNull on_null = OnNull::kPropagate;
  /// The input may stay unlinked and unset; it is then null.
  bool optional = false;
  /// Output: null may arise here although no input is null (a sensor, a division, a value that is not there yet). LOAD
  /// follows such nulls to actuators and stops.
  bool may_be_null = false;
};

/// What a parameter says of itself. A parameter is set once, when the net is loaded.
struct ParameterSpec {
  std::string_view unit = {};
  std::string_view doc = {};
  /// Interval text such as "(0,inf)", "[0,1]", "[1,1000000]", for each element of a vector or joint array; for a
  /// String the allowed words, "fast|slow". Checked at load; empty = any finite number, any text.
  std::string_view range = {};
  /// JSON text of a sensible value, for examples, tests and benchmarks (example.h); needed where there is no default.
  std::string_view example = {};
};

/// How late an output follows an input: 0 (same cycle), k cycles, or depending on data (rows O6, O7).
struct Latency {
  std::int64_t cycles = 0;
  bool data_dependent = false;
};

class Setup;

/// A realtime primitive: a function from input ports to output ports, with state, evaluated once per cycle.
///
/// One class in one place: members In<T>, Out<T> and plain members for parameters, a constructor that takes a Setup and
/// declares them, and update(). The constructor only declares (it also runs to describe the type, without a net);
/// heavy work that may fail stands in prepare(). The net owns primitives; the cycle thread calls update().
///
/// State begins where cycle.first is true: an update with it behaves as in a primitive just made, whatever went before.
/// That is how a fragment is reset without allocation (row O3); tests/support/primitive_harness.h checks it.
class Primitive {
 public:
  virtual ~Primitive() = default;
  Primitive(const Primitive&) = delete;
  Primitive& operator=(const Primitive&) = delete;

  /// Checks and precomputes. Pointers of the diagnostics are relative to the primitive's parameters. Realtime: setup.
  virtual Diagnostics prepare() { return {}; }
  /// One cycle: reads inputs, writes every output. Realtime: cyclic, no allocation, no lock, no throw.
  virtual void update(const Cycle& cycle) = 0;
  /// Longest time (s) from the cycle in which it is asked to stop, by its inputs or by Cycle::stop_requested, until it
  /// rests; 0: it has nothing to stop. Known after prepare(). The net's own bounds are made of these (rows L6, S1).
  /// Realtime: setup.
  [[nodiscard]] virtual double stop_time_bound() const { return 0.0; }

 protected:
  Primitive() = default;
};

}  // namespace takt::net
