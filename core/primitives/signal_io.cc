// Family "device": digital and analog inputs and outputs.
#include "core/device/signal.h"
#include "core/net/format_text.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;

template <class T, class Device>
class SignalInput : public Primitive {
 public:
  explicit SignalInput(Setup& setup)
      : value_(setup.out<T>("value", free_spec_may_be_null<T>("the newest sample"))),
        age_(setup.out<Real>("age", {.unit = "s", .doc = "age of the sample", .may_be_null = true})),
        device_(setup.device<Device>("device", Device::kKind, "the input that is read")) {}

  void update(const Cycle&) override {
    if (!device_->has_sample()) {
      value_.set_null();
      return age_.set_null();
    }
    value_.set(device_->sample().value);
    age_.set(to_seconds(device_->sample_age()));
  }

 private:
  Out<T> value_;
  Out<Real> age_;
  Device* device_;
};

template <class T, class Device>
class SignalOutput : public Primitive {
 public:
  explicit SignalOutput(Setup& setup)
      : value_(setup.in<T>("value", free_spec<T>("value to send in this cycle", OnNull::kStop))),
        device_(setup.device<Device>("device", Device::kKind, "the output that is set")) {
    setup.claims("device");
  }

  /// Null at the input fails the net (row N4).
  void update(const Cycle& cycle) override {
    if (!value_.null()) return device_->propose(*value_);
    const Text text = format_text("{}: the value is null", device_->name());
    cycle.signals->fail_with(Cause::Code::kNullInput, text.view(), cycle.index);
  }

 private:
  In<T> value_;
  Device* device_;
};

template <class T, class Device>
class SignalOutputState : public Primitive {
 public:
  explicit SignalOutputState(Setup& setup)
      : sent_(setup.out<T>("sent", free_spec<T>("what was sent in the last cycle"))),
        ready_(setup.out<Boolean>("ready", {.doc = "the output accepts values"})),
        device_(setup.device<Device>("device", Device::kKind, "the output")) {}

  void update(const Cycle&) override {
    sent_.set(device_->value());
    ready_.set(device_->ready());
  }

 private:
  Out<T> sent_;
  Out<Boolean> ready_;
  Device* device_;
};

using DigitalInput = SignalInput<Boolean, device::DigitalInput>;
using AnalogInput = SignalInput<Real, device::AnalogInput>;
using DigitalOutput = SignalOutput<Boolean, device::DigitalOutput>;
using AnalogOutput = SignalOutput<Real, device::AnalogOutput>;
using DigitalOutputState = SignalOutputState<Boolean, device::DigitalOutput>;
using AnalogOutputState = SignalOutputState<Real, device::AnalogOutput>;

TAKT_PRIMITIVE(DigitalInput, "device",
               "The newest level of a digital input. Null until the first sample and when the newest is older than the "
               "device allows.");
TAKT_PRIMITIVE(AnalogInput, "device",
               "The newest reading of an analog input. Null until the first sample, when the newest is older than the "
               "device allows, and while there is nothing to measure.");
TAKT_PRIMITIVE(
    DigitalOutput, "device",
    "Sets a digital output, which the net then holds alone. What the net leaves stays when it ends; stopped, "
    "the output does what its description says. Null fails the net.");
TAKT_PRIMITIVE(AnalogOutput, "device",
               "Sets an analog output, which the net then holds alone; the guard refuses what is out of range or too "
               "fast. What the net leaves stays when it ends; stopped, the output does what its description says. Null "
               "fails the net.");
TAKT_PRIMITIVE(
    DigitalOutputState, "device",
    "What a digital output was sent last, by whatever net; before the first, its initial level. Never null.");
TAKT_PRIMITIVE(
    AnalogOutputState, "device",
    "What an analog output was sent last, by whatever net; before the first, its initial value. Never null.");

}  // namespace
}  // namespace takt::primitives
