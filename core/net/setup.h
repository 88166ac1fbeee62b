#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "core/net/primitive.h"

namespace takt::net {

/// Through this a primitive's constructor declares its ports and parameters and gets them bound.
///
/// The same constructor runs in two ways: to *describe* the type (no net, parameters have their defaults, ports are
/// bound to nothing) and to *build* an instance in a net. A wrong or missing parameter is recorded as a diagnostic and
/// a usable placeholder is returned, so constructors have no error paths. Realtime: setup.
class Setup {
 public:
  template <class T>
  [[nodiscard]] In<T> in(std::string_view name, const PortSpec& spec = {});
  template <class T>
  [[nodiscard]] Out<T> out(std::string_view name, const PortSpec& spec = {});

  /// A Boolean input at which null counts as `spec.on_null` says (kCountsAsTrue or kCountsAsFalse), unless the net
  /// declares true or false for it: {"on_null": {NAME: false}}.
  [[nodiscard]] Flag flag(std::string_view name, const PortSpec& spec);
  /// Cycles of null that are to be bridged before the net fails, at an input declared with OnNull::kStop: 0 unless the
  /// net says {"on_null": {NAME: {"bridge_cycles": N}}}. A primitive that asks must know how to bridge.
  [[nodiscard]] Integer bridge_cycles(std::string_view name);

  /// A parameter that must be given. T: Boolean, Integer, Real, Text, std::string or a composed value type; in JSON a
  /// Vector is [x,y,z], a Rotation [w,x,y,z], a Frame {"position":[x,y,z],"quaternion":[w,x,y,z]}, a Twist
  /// {"linear":[..],"angular":[..]}, a Wrench {"force":[..],"torque":[..]}, a joint array [..].
  template <class T>
  [[nodiscard]] T parameter(std::string_view name, const ParameterSpec& spec = {});
  /// A parameter with a default.
  template <class T>
  [[nodiscard]] T parameter(std::string_view name, const T& fallback, const ParameterSpec& spec = {});
  /// A parameter with structure of its own (a time law, a list of points), as JSON; the primitive checks it in
  /// prepare().
  [[nodiscard]] const nlohmann::ordered_json& json(std::string_view name, const ParameterSpec& spec = {});
  [[nodiscard]] const nlohmann::ordered_json* optional_json(std::string_view name, const ParameterSpec& spec = {});

  /// The device named by the String parameter `name`; nullptr while describing, or (with a diagnostic that lists what
  /// there is) if it is absent or of another kind.
  template <class D>
  [[nodiscard]] D* device(std::string_view name, std::string_view kind, std::string_view doc) {
    return dynamic_cast<D*>(resource(name, kind, doc));
  }
  [[nodiscard]] Resource* resource(std::string_view name, std::string_view kind, std::string_view doc);
  /// Says that this net drives the device named by parameter `name`: a unique resource (rows O4, L).
  /// @param state  in which the device has to be while this primitive drives it, such as a control mode; empty: any
  void claims(std::string_view name, std::string_view state = {});

  /// Declares a latency other than 0 between an input and an output (rows O6).
  void latency(std::string_view in, std::string_view out, Latency latency);
  /// The same, where an Integer parameter of each instance says how many cycles.
  void latency_by(std::string_view in, std::string_view out, std::string_view cycles_parameter);
  /// A link into this input is a delayed link even where the net does not mark it, so it may close a loop: the input
  /// reads what its source gave one cycle before (first cycle: null, or the link's `initial`). So the value never
  /// depends on the order of evaluation. The certificate counts that cycle; do not declare it with latency().
  void breaks_loop(std::string_view in);
  /// Marks the one primitive kind whose presence ends a net (LOAD demands at least one).
  void is_termination();
  /// Marks the primitive kind through which a net hears of a request to cancel; its Real parameter `bound` (s) declares
  /// how long the net then takes, 0: that follows from the net.
  void is_cancel(std::string_view bound);
  /// What an update costs on the reference machine, ns, where it is not the few of plain arithmetic (row T5).
  void costs(double ns);
  /// Says that the outputs come from outside the net: the certificate begins here. Known by itself of a primitive with
  /// a device and outputs.
  void is_source();
  /// Marks an input whose value leaves the core with the monitors: name for people = the primitive's id.
  void is_monitor();

  /// Says that at most one of these Boolean outputs is true in any cycle: the phases of a sequence, a one-hot code.
  void exclusive(std::initializer_list<std::string_view> outputs);
  /// Says what a Boolean output means, so that LOAD can prove that fragments exclude each other (row O4). `formula`:
  /// names of inputs, ! & | ^ and parentheses in Kleene's logic; `a ?? b` (b where a is null); `null(a)`; `a = b`,
  /// `a < b`, `a <= b` between numbers, null if one is; `?` is a condition that stays unknown ("input & ?": true only
  /// while the input is). The output may be null where the formula is not.
  void means(std::string_view output, std::string_view formula);
  /// Says that the only output hands on the one input that is not null; two at a time are a failure while running, and
  /// LOAD tries to prove that it cannot happen.
  void is_merge();

  [[nodiscard]] bool describing() const;
  /// Full id of the primitive in its net, for causes; empty while describing.
  [[nodiscard]] const std::string& id() const;

  // The rest is for core/net itself.
  struct Impl;
  explicit Setup(Impl& impl) : impl_(impl) {}

 private:
  Impl& impl_;
};

}  // namespace takt::net
