// Family "device": digital and analog inputs and outputs.
#include "core/device/signal.h"
#include "core/net/format_text.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

class DigitalInput final : public Primitive {
 public:
  explicit DigitalInput(Setup& setup)
      : value_(setup.out<Boolean>("value", {.doc = "the newest level", .may_be_null = true})),
        age_(setup.out<Real>("age", {.unit = "s", .doc = "age of the sample", .may_be_null = true})),
        device_(setup.device<device::DigitalInput>("device", device::DigitalInput::kKind, "the input that is read")) {}

  void update(const Cycle&) override {
    if (!device_->has_sample()) {
      value_.set_null();
      return age_.set_null();
    }
    value_.set(device_->sample().value);
    age_.set(to_seconds(device_->sample_age()));
  }

 private:
  Out<Boolean> value_;
  Out<Real> age_;
  device::DigitalInput* device_;
};

class AnalogInput final : public Primitive {
 public:
  explicit AnalogInput(Setup& setup)
      : value_(setup.out<Real>("value", {.unit = "u", .doc = "the newest reading", .may_be_null = true})),
        age_(setup.out<Real>("age", {.unit = "s", .doc = "age of the sample", .may_be_null = true})),
        device_(setup.device<device::AnalogInput>("device", device::AnalogInput::kKind, "the input that is read")) {}

  void update(const Cycle&) override {
    if (!device_->has_sample()) {
      value_.set_null();
      return age_.set_null();
    }
    value_.set(device_->sample().value);
    age_.set(to_seconds(device_->sample_age()));
  }

 private:
  Out<Real> value_, age_;
  device::AnalogInput* device_;
};

/// What both outputs do: null at the input fails the net (row N4).
template <class Device, class T>
void propose(Device& device, const In<T>& value, const Cycle& cycle) {
  if (!value.null()) return device.propose(*value);
  const Text text = format_text("{}: the value is null", device.name());
  cycle.signals->fail_with(Cause::Code::kNullInput, text.view(), cycle.index);
}

class DigitalOutput final : public Primitive {
 public:
  explicit DigitalOutput(Setup& setup)
      : value_(setup.in<Boolean>("value", {.doc = "level of this cycle", .on_null = OnNull::kStop})),
        device_(setup.device<device::DigitalOutput>("device", device::DigitalOutput::kKind, "the output that is set")) {
    setup.claims("device");
  }
  void update(const Cycle& cycle) override { propose(*device_, value_, cycle); }

 private:
  In<Boolean> value_;
  device::DigitalOutput* device_;
};

class AnalogOutput final : public Primitive {
 public:
  explicit AnalogOutput(Setup& setup)
      : value_(setup.in<Real>("value", {.unit = "u", .doc = "value of this cycle", .on_null = OnNull::kStop})),
        device_(setup.device<device::AnalogOutput>("device", device::AnalogOutput::kKind, "the output that is set")) {
    setup.claims("device");
  }
  void update(const Cycle& cycle) override { propose(*device_, value_, cycle); }

 private:
  In<Real> value_;
  device::AnalogOutput* device_;
};

class DigitalOutputState final : public Primitive {
 public:
  explicit DigitalOutputState(Setup& setup)
      : sent_(setup.out<Boolean>("sent", {.doc = "what was sent in the last cycle"})),
        ready_(setup.out<Boolean>("ready", {.doc = "the output takes values"})),
        device_(setup.device<device::DigitalOutput>("device", device::DigitalOutput::kKind, "the output")) {}
  void update(const Cycle&) override {
    sent_.set(device_->value());
    ready_.set(device_->ready());
  }

 private:
  Out<Boolean> sent_, ready_;
  device::DigitalOutput* device_;
};

class AnalogOutputState final : public Primitive {
 public:
  explicit AnalogOutputState(Setup& setup)
      : sent_(setup.out<Real>("sent", {.unit = "u", .doc = "what was sent in the last cycle"})),
        ready_(setup.out<Boolean>("ready", {.doc = "the output takes values"})),
        device_(setup.device<device::AnalogOutput>("device", device::AnalogOutput::kKind, "the output")) {}
  void update(const Cycle&) override {
    sent_.set(device_->value());
    ready_.set(device_->ready());
  }

 private:
  Out<Real> sent_;
  Out<Boolean> ready_;
  device::AnalogOutput* device_;
};

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
