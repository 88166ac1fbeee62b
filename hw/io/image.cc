#include "hw/io/image.h"

#include <algorithm>
#include <utility>

namespace takt::hw {

template <class T>
class CycleImage::Input final : public device::SignalInputBackend<T> {
 public:
  Input(CycleImage& image, std::size_t terminal, std::size_t index)
      : image_(image), terminal_(terminal), index_(index) {}
  bool read(device::SignalSample<T>& sample) override {
    image_.look(terminal_);
    const InputImage& inputs = image_.inputs();
    sample.sequence = inputs.sequence;
    sample.stamp = inputs.stamp;
    if constexpr (std::is_same_v<T, bool>) {
      sample.value = (inputs.digital >> index_ & 1) != 0;
    } else {
      sample.value = inputs.analog[index_];
    }
    return inputs.sequence > 0;
  }

 private:
  CycleImage& image_;
  std::size_t terminal_, index_;
};

template <class T>
class CycleImage::Output final : public device::SignalOutputBackend<T> {
 public:
  Output(CycleImage& image, std::size_t terminal, std::size_t index)
      : image_(image), terminal_(terminal), index_(index) {}
  [[nodiscard]] bool ready() const override {
    image_.look(terminal_);
    return image_.inputs().ready;
  }
  void write(T value) override {
    OutputImage& wanted = image_.wanted_;
    if constexpr (std::is_same_v<T, bool>) {
      const std::uint64_t bit = std::uint64_t{1} << index_;
      wanted.digital = value ? wanted.digital | bit : wanted.digital & ~bit;
    } else {
      wanted.analog[index_] = value;
    }
    image_.outputs_.publish(wanted);
  }

 private:
  CycleImage& image_;
  std::size_t terminal_, index_;
};

CycleImage::CycleImage(const device::IoDescription& io, std::function<void()> on_cycle)
    : on_cycle_(std::move(on_cycle)), seen_(io.channels.size(), true) {
  std::size_t counts[4] = {};
  for (std::size_t i = 0; i < io.channels.size(); ++i) {
    const device::IoChannel& channel = io.channels[i];
    const std::size_t index = counts[static_cast<std::size_t>(channel.kind)]++;
    switch (channel.kind) {
      case device::IoChannel::Kind::kDigitalInput:
        terminals_.digital_inputs[channel.name] = std::make_shared<Input<bool>>(*this, i, index);
        break;
      case device::IoChannel::Kind::kAnalogInput:
        terminals_.analog_inputs[channel.name] = std::make_shared<Input<double>>(*this, i, index);
        break;
      case device::IoChannel::Kind::kDigitalOutput:
        if (channel.initial != 0.0) initial_.digital |= std::uint64_t{1} << index;
        terminals_.digital_outputs[channel.name] = std::make_shared<Output<bool>>(*this, i, index);
        break;
      case device::IoChannel::Kind::kAnalogOutput:
        initial_.analog[index] = channel.initial;
        terminals_.analog_outputs[channel.name] = std::make_shared<Output<double>>(*this, i, index);
        break;
    }
  }
  wanted_ = initial_;
}

void CycleImage::look(std::size_t terminal) {
  if (seen_[terminal]) {
    std::fill(seen_.begin(), seen_.end(), false);
    if (on_cycle_) on_cycle_();
    (void)inputs_.take();
  }
  seen_[terminal] = true;
}

}  // namespace takt::hw
