#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/time.h"
#include "core/device/device.h"

/// The four canonical signals: digital and analog, in and out (docs/devices.md, "Signals"). `bool` is a digital value,
/// `double` an analog one in the unit of its description. An I/O block is a set of such devices, each of its own name.
namespace takt::device {

/// What an input reports: the newest sample its driver has.
template <class T>
struct SignalSample {
  std::uint64_t sequence = 0;  ///< counts samples; 0 = none yet
  Nanoseconds stamp = 0;       ///< when it was taken, on the core's clock
  T value{};                   ///< an analog value that is not finite means: nothing to measure
};

/// The machine behind an input. Called by the cycle thread only; never blocks, never allocates.
template <class T>
class SignalInputBackend {
 public:
  virtual ~SignalInputBackend() = default;
  /// Copies the newest sample. @return false if there has never been one.
  virtual bool read(SignalSample<T>& sample) = 0;
};

/// The machine behind an output.
template <class T>
class SignalOutputBackend {
 public:
  virtual ~SignalOutputBackend() = default;
  /// Takes values: powered, on the bus.
  [[nodiscard]] virtual bool ready() const = 0;
  /// The value of this cycle; without one in a cycle the output keeps the last.
  virtual void write(T value) = 0;
};

/// What is known of an input.
template <class T>
struct SignalInputDescription {
  std::string unit = {};                           ///< of an analog value, a unit text as ports have them; else empty
  Nanoseconds sample_age_max = 20 * kMillisecond;  ///< older samples count as absent (row T2)
};

/// What is known of an output. Analog figures in its unit.
template <class T>
struct SignalOutputDescription {
  std::string unit = {};
  T initial{};                                              ///< before a net has set it
  std::optional<T> stop = {};                               ///< stop reaction: goes to this value; nothing: holds
  double lower = -std::numeric_limits<double>::infinity();  ///< of an analog value
  double upper = std::numeric_limits<double>::infinity();
  double rate_max = std::numeric_limits<double>::infinity();  ///< of an analog value, unit/s; the stop keeps it too
};

/// The canonical input. Only the cycle thread touches it once the core runs. Realtime: cyclic.
template <class T>
class SignalInput final : public Device {
 public:
  static constexpr std::string_view kKind = std::is_same_v<T, bool> ? "digital_input" : "analog_input";

  SignalInput(std::string name, SignalInputDescription<T> description, std::shared_ptr<SignalInputBackend<T>> backend)
      : Device(std::move(name)),
        description_(std::move(description)),
        signal_{.unit = description_.unit, .frame = {}},
        backend_(std::move(backend)) {}

  [[nodiscard]] std::string_view kind() const override { return kKind; }
  /// Its unit is that of the ports of every primitive that names it (row U1).
  [[nodiscard]] const net::Signal* signal() const override { return &signal_; }
  [[nodiscard]] const SignalInputDescription<T>& description() const { return description_; }

  void begin_cycle(std::int64_t cycle, Nanoseconds time) override;
  void add_state(StateWords& words) const override;

  /// False before the first sample, past sample_age_max, and while there is nothing to measure.
  [[nodiscard]] bool has_sample() const { return has_sample_; }
  [[nodiscard]] const SignalSample<T>& sample() const { return sample_; }
  [[nodiscard]] Nanoseconds sample_age() const { return sample_age_; }

 private:
  SignalInputDescription<T> description_;
  net::Signal signal_;
  std::shared_ptr<SignalInputBackend<T>> backend_;
  SignalSample<T> sample_;
  bool has_sample_ = false;
  Nanoseconds sample_age_ = 0;
};

/// The canonical output: held by one net at a time. What a net left behind stays, bit for bit, when the net ends in
/// order; when it is stopped the stop reaction runs. The guard trips on values that are not finite, out of range or too
/// fast; it never clamps. Only the cycle thread touches it once the core runs. Realtime: cyclic.
template <class T>
class SignalOutput final : public Actuator {
 public:
  static constexpr std::string_view kKind = std::is_same_v<T, bool> ? "digital_output" : "analog_output";

  SignalOutput(std::string name, SignalOutputDescription<T> description,
               std::shared_ptr<SignalOutputBackend<T>> backend, Nanoseconds period);

  [[nodiscard]] std::string_view kind() const override { return kKind; }
  /// As of an input.
  [[nodiscard]] const net::Signal* signal() const override { return &signal_; }
  [[nodiscard]] const SignalOutputDescription<T>& description() const { return description_; }

  // -- For primitives ------------------------------------------------------------------------------------------------
  /// What was sent last.
  [[nodiscard]] T value() const { return sent_; }
  [[nodiscard]] bool ready() const { return ready_; }
  /// The value of this cycle; the last one given counts. Without one the output keeps its value. Of no effect while no
  /// net holds it.
  void propose(T value) {
    if (!held_) return;
    proposal_ = value;
    proposed_ = true;
  }

  // -- For the control core ------------------------------------------------------------------------------------------
  void begin_cycle(std::int64_t cycle, Nanoseconds time) override;
  void add_state(StateWords& words) const override;
  [[nodiscard]] bool lost() const override { return !ready_; }
  [[nodiscard]] net::Text fault() const override;
  [[nodiscard]] std::optional<net::Text> refusal() const override;
  void hold() override {
    held_ = true;
    stopping_ = false;
  }
  void release() override { held_ = false; }
  void stop() override;
  [[nodiscard]] std::optional<net::Text> check() override;
  void hand_over() override;
  [[nodiscard]] bool held() const override { return held_; }
  /// A value that stays does not move; only an analog stop reaction on its way does.
  [[nodiscard]] bool at_rest() const override { return !stopping_; }
  /// An output whose stop reaction is to hold goes on in an emergency.
  [[nodiscard]] bool stops_in_emergency() const override { return description_.stop.has_value(); }

 private:
  void approach_stop_value();

  SignalOutputDescription<T> description_;
  net::Signal signal_;
  std::shared_ptr<SignalOutputBackend<T>> backend_;
  double step_max_;  ///< of an analog value per cycle
  T sent_;
  T proposal_{};
  bool ready_ = false, held_ = false, proposed_ = false, stopping_ = false;
};

using DigitalInput = SignalInput<bool>;
using AnalogInput = SignalInput<double>;
using DigitalOutput = SignalOutput<bool>;
using AnalogOutput = SignalOutput<double>;

extern template class SignalInput<bool>;
extern template class SignalInput<double>;
extern template class SignalOutput<bool>;
extern template class SignalOutput<double>;

}  // namespace takt::device
