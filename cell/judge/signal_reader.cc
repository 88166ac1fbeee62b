#include "cell/judge/signal_reader.h"

namespace takt::cell {
namespace {

template <class Inputs>
void add_inputs(const Inputs& inputs, bool digital, std::vector<NamedSignal>& signals) {
  for (const auto& [name, input] : inputs) {
    signals.push_back({name, input->description().unit, digital, [device = input] {
                         return device->has_sample() ? std::optional<double>(device->sample().value) : std::nullopt;
                       }});
  }
}

template <class Outputs>
void add_outputs(const Outputs& outputs, bool digital, std::vector<NamedSignal>& signals) {
  for (const auto& [name, output] : outputs) {
    signals.push_back({name, output->description().unit, digital,
                       [device = output] { return std::optional<double>(device->value()); }});
  }
}

}  // namespace

std::vector<NamedSignal> signals_of(const expression::Cell& cell) {
  std::vector<NamedSignal> signals;
  add_inputs(cell.digital_inputs, true, signals);
  add_outputs(cell.digital_outputs, true, signals);
  add_inputs(cell.analog_inputs, false, signals);
  add_outputs(cell.analog_outputs, false, signals);
  return signals;
}

}  // namespace takt::cell
