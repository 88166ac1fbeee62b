#include "hw/emulators/rtde/wired_terminals.h"

#include <cmath>

namespace takt::hw::rtde {

namespace {

using Kind = device::IoChannel::Kind;

}  // namespace

void WiredTerminals::read_inputs(Terminals& terminals) const {
  const auto& digital = map_.of(Kind::kDigitalInput);
  for (std::size_t i = 0; i < digital.size(); ++i) {
    device::SignalSample<bool> sample;
    if (!machine_.digital_inputs.at(digital[i].name)->read(sample)) continue;
    const std::uint32_t bit = 1U << i;
    terminals.digital_in = sample.value ? terminals.digital_in | bit : terminals.digital_in & ~bit;
  }
  const auto& analog = map_.of(Kind::kAnalogInput);
  for (std::size_t i = 0; i < analog.size(); ++i) {
    device::SignalSample<double> sample;
    if (machine_.analog_inputs.at(analog[i].name)->read(sample) && std::isfinite(sample.value))
      terminals.analog_in[i] = TerminalMap::volt_or_ampere(analog[i], sample.value);
  }
}

void WiredTerminals::write_outputs(const Terminals& terminals) const {
  const auto& digital = map_.of(Kind::kDigitalOutput);
  for (std::size_t i = 0; i < digital.size(); ++i)
    machine_.digital_outputs.at(digital[i].name)->write(terminals.digital_output(static_cast<int>(i)));
  const auto& analog = map_.of(Kind::kAnalogOutput);
  for (std::size_t i = 0; i < analog.size(); ++i)
    machine_.analog_outputs.at(analog[i].name)->write(TerminalMap::from_share(analog[i], terminals.analog_out[i]));
}

}  // namespace takt::hw::rtde
