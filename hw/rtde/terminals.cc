#include "hw/rtde/terminals.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

using device::IoChannel;
using Kind = IoChannel::Kind;

constexpr double kVolts = 10.0;                       // upper end of a voltage; its lower end is 0
constexpr double kLeastAmpere = 4e-3, kSpan = 16e-3;  // of a current loop

/// A group of digital outputs with a mask of its own.
struct OutputGroup {
  std::size_t first, count;
  const char *mask, *values;
};
constexpr OutputGroup kOutputGroups[] = {
    {0, 8, "standard_digital_output_mask", "standard_digital_output"},
    {8, 8, "configurable_digital_output_mask", "configurable_digital_output"},
    {16, 2, "tool_digital_output_mask", "tool_digital_output"},
};

/// A in the unit of a current; 0: it is none.
double ampere_of(const std::string& unit) { return unit == "A" ? 1.0 : unit == "mA" ? 1e-3 : 0.0; }

std::string refuse_analog(const IoChannel& channel) {
  const bool voltage = TerminalMap::is_voltage(channel);
  const double ampere = ampere_of(channel.unit);
  if (!voltage && ampere == 0.0)
    return fmt::format("'{}' is in '{}', the controller's analog terminals are in V, mA or A", channel.name,
                       channel.unit);
  if (channel.kind == Kind::kAnalogInput) return {};
  const double low = TerminalMap::share_of(channel, channel.lower),
               high = TerminalMap::share_of(channel, channel.upper);
  if (low < -1e-9 || high > 1.0 + 1e-9)
    return fmt::format("'{}' goes from {:g} to {:g} {}, the controller's outputs from {}", channel.name, channel.lower,
                       channel.upper, channel.unit, voltage ? "0 to 10 V" : "4 to 20 mA");
  return {};
}

}  // namespace

std::string refuse_terminals(const device::IoDescription& io) {
  const auto count = [&](Kind kind) {
    return static_cast<std::size_t>(std::ranges::count(io.channels, kind, &IoChannel::kind));
  };
  for (const auto& [kind, most, name] : {std::tuple{Kind::kDigitalInput, kDigitalTerminals, "digital inputs"},
                                         {Kind::kDigitalOutput, kDigitalTerminals, "digital outputs"},
                                         {Kind::kAnalogInput, kAnalogTerminals, "analog inputs"},
                                         {Kind::kAnalogOutput, kAnalogTerminals, "analog outputs"}})
    if (count(kind) > most) return fmt::format("it has {} {}, a UR controller has {}", count(kind), name, most);
  for (const IoChannel& channel : io.channels) {
    if (!channel.is_analog()) continue;
    if (std::string why = refuse_analog(channel); !why.empty()) return why;
  }
  return io.channels.empty() ? "it has no terminals" : "";
}

// -- The map
// -----------------------------------------------------------------------------------------------------------

TerminalMap::TerminalMap(const device::IoDescription& io) {
  for (const IoChannel& channel : io.channels) channels_[static_cast<std::size_t>(channel.kind)].push_back(channel);
}

double TerminalMap::in_unit(const IoChannel& channel, double volt_or_ampere) {
  return is_voltage(channel) ? volt_or_ampere : volt_or_ampere / ampere_of(channel.unit);
}

double TerminalMap::volt_or_ampere(const IoChannel& channel, double value) {
  return is_voltage(channel) ? value : value * ampere_of(channel.unit);
}

double TerminalMap::share_of(const IoChannel& channel, double value) {
  return is_voltage(channel) ? value / kVolts : (value * ampere_of(channel.unit) - kLeastAmpere) / kSpan;
}

double TerminalMap::from_share(const IoChannel& channel, double share) {
  return is_voltage(channel) ? share * kVolts : (kLeastAmpere + share * kSpan) / ampere_of(channel.unit);
}

// -- The block
// ---------------------------------------------------------------------------------------------------------

TerminalBlock::TerminalBlock(const device::IoDescription& io, std::function<std::string(std::uint32_t)> fault_text)
    : map_(io), image_(io), fault_text_(std::move(fault_text)) {
  const std::size_t digital = map_.of(Kind::kDigitalOutput).size();
  for (const OutputGroup& group : kOutputGroups)
    if (digital > group.first) fields_.insert(fields_.end(), {group.mask, group.values});
  if (!map_.of(Kind::kAnalogOutput).empty())
    fields_.insert(fields_.end(), {"standard_analog_output_mask", "standard_analog_output_type",
                                   "standard_analog_output_0", "standard_analog_output_1"});
  values_.assign(fields_.size(), FieldValue{});
  told_ = values_;
}

std::string TerminalBlock::fault_text() const { return ready() ? std::string() : fault_text_(image_.inputs().fault); }

void TerminalBlock::take(std::uint64_t digital, const std::array<double, kAnalogTerminals>& analog, Nanoseconds stamp) {
  if (const int resets = resets_.load(); resets != resets_seen_) {
    resets_seen_ = resets;
    armed_ = true;
  }
  ++inputs_.sequence;
  inputs_.stamp = stamp;
  inputs_.digital = digital;
  const auto& channels = map_.of(Kind::kAnalogInput);
  for (std::size_t i = 0; i < channels.size(); ++i) inputs_.analog[i] = TerminalMap::in_unit(channels[i], analog[i]);
  inputs_.ready = armed_;
  inputs_.fault = 0;
  image_.publish(inputs_);
}

void TerminalBlock::lose(std::uint32_t fault) {
  const bool known = inputs_.sequence > 0;
  if (known) armed_ = false;
  written_ = false;
  inputs_.ready = false;
  inputs_.fault = fault;
  if (known) image_.publish(inputs_);
}

bool TerminalBlock::take_outputs() {
  if (!armed_ || fields_.empty()) return false;
  fill_outputs(image_.outputs());
  const bool due = !std::exchange(written_, true) || values_ != told_;
  told_ = values_;
  return due;
}

void TerminalBlock::fill_outputs(const hw::OutputImage& wanted) {
  const std::size_t digital = map_.of(Kind::kDigitalOutput).size();
  std::size_t at = 0;
  for (const OutputGroup& group : kOutputGroups) {
    if (digital <= group.first) continue;
    const std::uint64_t mask = (std::uint64_t{1} << std::min(group.count, digital - group.first)) - 1;
    values_[at++][0] = static_cast<double>(mask);
    values_[at++][0] = static_cast<double>(wanted.digital >> group.first & mask);
  }
  const auto& analog = map_.of(Kind::kAnalogOutput);
  if (analog.empty()) return;
  double &mask = values_[at][0], &types = values_[at + 1][0];
  mask = types = 0.0;
  for (std::size_t i = 0; i < analog.size(); ++i) {
    const double bit = static_cast<double>(1U << i);
    mask += bit;
    if (TerminalMap::is_voltage(analog[i])) types += bit;
    values_[at + 2 + i][0] = std::clamp(TerminalMap::share_of(analog[i], wanted.analog[i]), 0.0, 1.0);
  }
}

void TerminalBlock::add_to(emulation::StateHash& hash) const {
  hash.add(inputs_.sequence);
  hash.add(inputs_.digital);
  for (const FieldValue& value : values_) hash.add(value[0]);
}

}  // namespace takt::hw::rtde
