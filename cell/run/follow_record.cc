#include "cell/run/follow_record.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "cell/build/command_tape.h"

namespace takt::cell {
namespace {

constexpr std::uint64_t kFnvStart = 14695981039346656037ull, kFnvPrime = 1099511628211ull;

/// As the file of the cell says it, whoever writes it.
bool from_outside(const device::Channel& channel) {
  return channel.description().writer == device::ChannelDescription::Writer::kOutside;
}

void put_channel(const device::Channel& channel, ByteWriter& out) {
  out.put(static_cast<std::uint16_t>(channel.slot_size()));
  out.put_bytes(std::span(static_cast<const std::byte*>(channel.raw_slot()), channel.slot_size()));
}

bool get_channel(ByteReader& in, device::Channel& channel) {
  alignas(64) std::array<std::byte, 192> slot{};
  const std::size_t size = in.get<std::uint16_t>();
  if (size != channel.slot_size() || size > slot.size()) return false;
  in.get_bytes(std::span(slot).first(size));
  const auto value = device::value_in(channel.description().type, slot.data());
  (void)(value ? channel.write(*value) : channel.write_null());
  return true;
}

/// Brings an actuator of a core that has run no cycle to what was sent last, by what a net would do.
template <class Device, class Propose>
void send_once(Device& device, std::int64_t cycle, Nanoseconds time, const Propose& propose) {
  device.begin_cycle(cycle, time);
  device.hold();
  propose();
  device.hand_over();
  device.release();
  device.hand_over();
}

void restore_gripper(ByteReader& in, device::Gripper& gripper, std::int64_t cycle, Nanoseconds time) {
  const auto sequence = in.get<std::uint64_t>();
  const double width = in.get<double>(), speed = in.get<double>(), force = in.get<double>();
  constexpr std::uint64_t kMost = 1'000'000;
  if (sequence == 0) return;
  gripper.begin_cycle(cycle, time);
  gripper.hold();
  // What counts commands counts those that differ.
  for (std::uint64_t i = 1; i <= std::min(sequence, kMost); ++i) {
    gripper.propose((sequence - i) % 2 == 1 ? width + 1e-6 : width, speed, force);
    gripper.hand_over();
  }
  gripper.begin_cycle(cycle, time);
  gripper.release();
  gripper.hand_over();
}

}  // namespace

void put_text(std::string_view text, ByteWriter& out) {
  const std::size_t size = std::min<std::size_t>(text.size(), 255);
  out.put(static_cast<std::uint8_t>(size));
  out.put_bytes(std::as_bytes(std::span(text.data(), size)));
}

std::string get_text(ByteReader& in) {
  std::string text(in.get<std::uint8_t>(), '\0');
  in.get_bytes(std::as_writable_bytes(std::span(text)));
  return text;
}

void write_state(const BuiltCell& built, ByteWriter& out) {
  for (const auto& [name, arm] : built.cell.arms) {
    out.put(arm.device->set_point().q);
    for (const double value : values_of(arm.device->tool())) out.put(value);
  }
  for (const auto& [name, gripper] : built.cell.grippers) {
    const device::GripperSetPoint& sent = gripper.device->set_point();
    out.put(sent.sequence);
    for (const double value : {sent.width, sent.speed, sent.force}) out.put(value);
  }
  for (const auto& [name, output] : built.cell.digital_outputs) out.put(std::uint8_t{output->value()});
  for (const auto& [name, output] : built.cell.analog_outputs) out.put(output->value());
  for (const auto& [name, channel] : built.cell.channels)
    if (from_outside(*channel)) put_channel(*channel, out);
}

bool restore_state(ByteReader& in, BuiltCell& built, std::int64_t cycle,
                   std::map<std::string, device::ToolSetting, std::less<>>& tools) {
  const Nanoseconds time = cycle * built.core->period();
  SampleTape& samples = built.commands->samples();
  // The state comes before the readings, which devices need first: what they are driven to is done when both are there.
  ByteReader state = in;
  std::map<std::string, kinematics::JointVector, std::less<>> set_points;
  for (const auto& [name, arm] : built.cell.arms) {
    in.get(set_points[name]);
    ToolValues tool{};
    for (double& value : tool) value = in.get<double>();
    tools[name] = tool_of(tool);
  }
  for (std::size_t i = 0; i < 4 * built.cell.grippers.size(); ++i) (void)in.get<std::uint64_t>();
  for (std::size_t i = 0; i < built.cell.digital_outputs.size(); ++i) (void)in.get<std::uint8_t>();
  for (std::size_t i = 0; i < built.cell.analog_outputs.size(); ++i) (void)in.get<double>();
  for (const auto& [name, channel] : built.cell.channels)
    if (from_outside(*channel) && !get_channel(in, *channel)) return false;
  samples.read(in);
  if (in.ended_early() || in.left() != 0) return false;

  for (const auto& [name, arm] : built.cell.arms) {
    kinematics::JointVector unused;
    state.get(unused);
    for (std::size_t i = 0; i < kToolValues; ++i) (void)state.get<double>();
    samples.set_commanded(name, set_points.at(name));
  }
  for (const auto& [name, gripper] : built.cell.grippers) restore_gripper(state, *gripper.device, cycle, time);
  for (const auto& [name, output] : built.cell.digital_outputs)
    send_once(*output, cycle, time, [&, value = state.get<std::uint8_t>() != 0] { output->propose(value); });
  for (const auto& [name, output] : built.cell.analog_outputs)
    send_once(*output, cycle, time, [&, value = state.get<double>()] { output->propose(value); });
  return true;
}

void write_latched(const BuiltCell& built, ByteWriter& out) {
  std::uint16_t count = 0;
  for (const auto& [name, channel] : built.cell.channels) count += from_outside(*channel) && channel->latched() ? 1 : 0;
  out.put(count);
  std::uint16_t index = 0;
  for (const auto& [name, channel] : built.cell.channels) {
    if (from_outside(*channel) && channel->latched()) {
      out.put(index);
      put_channel(*channel, out);
    }
    ++index;
  }
}

bool read_latched(ByteReader& in, BuiltCell& built) {
  for (std::uint16_t left = in.get<std::uint16_t>(); left > 0; --left) {
    const auto index = in.get<std::uint16_t>();
    if (index >= built.cell.channels.size()) return false;
    if (!get_channel(in, *std::next(built.cell.channels.begin(), index)->second)) return false;
  }
  return true;
}

std::uint64_t hash_of_actuators(const expression::Cell& cell) {
  std::uint64_t hash = kFnvStart;
  const auto add = [&hash](const device::Device& device) {
    device::StateWords words;
    device.add_state(words);
    const auto bytes = words.bytes();
    for (std::size_t at = 0; at + sizeof(std::uint64_t) <= bytes.size(); at += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + at, sizeof(word));
      hash = (hash ^ word) * kFnvPrime;
    }
  };
  for (const auto& [name, arm] : cell.arms) add(*arm.device);
  for (const auto& [name, gripper] : cell.grippers) add(*gripper.device);
  for (const auto& [name, output] : cell.digital_outputs) add(*output);
  for (const auto& [name, output] : cell.analog_outputs) add(*output);
  return hash;
}

}  // namespace takt::cell
