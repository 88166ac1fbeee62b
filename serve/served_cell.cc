#include "serve/served_cell.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace takt::serve {
namespace {

/// Calls `visit(name, signal)` for each signal of a cell, in the order of CellView::signals.
template <class Visit>
void for_each_signal(const expression::Cell& cell, const Visit& visit) {
  for (const auto& [name, signal] : cell.digital_inputs) visit(name, *signal);
  for (const auto& [name, signal] : cell.analog_inputs) visit(name, *signal);
  for (const auto& [name, signal] : cell.digital_outputs) visit(name, *signal);
  for (const auto& [name, signal] : cell.analog_outputs) visit(name, *signal);
}

template <class T>
void look_at(const device::SignalInput<T>& input, SignalView& view) {
  view.value.reset();
  if (input.has_sample()) view.value = input.sample().value;
}

template <class T>
void look_at(const device::SignalOutput<T>& output, SignalView& view) {
  view.value = output.value();
  view.held = output.held();
}

}  // namespace

ServedCell::~ServedCell() = default;

void ServedCell::begin(const cell::Description& description, const cell::BuiltCell& built) {
  description_ = &description;
  built_ = &built;
  holders_.emplace(*built.core);
  for (const auto& [name, arm] : built.cell.arms) fresh_.arms.push_back({.name = name});
  for (const auto& [name, sensor] : built.cell.sensors) fresh_.sensors.push_back({.name = name});
  for (const auto& [name, gripper] : built.cell.grippers) fresh_.grippers.push_back({.name = name});
  for_each_signal(built.cell,
                  [this](const std::string& name, const auto&) { fresh_.signals.push_back({.name = name}); });
  for (const auto& [name, channel] : built.cell.channels) fresh_.channels.push_back({.name = name});
  copy({});
  publish();
}

bool ServedCell::steps(std::int64_t, std::function<void(const CellView& view)>) { return false; }

void ServedCell::stop_all(const std::string& by) {
  core().stop_all(net::Cause::Code::kAborted, fmt::format("STOP by '{}'", by));
}

void ServedCell::add_jog_channels() {
  const auto add = [this](const std::string& name, net::ValueType type, std::string unit) {
    auto made = device::Channel::make({.name = name, .type = type, .unit = std::move(unit)});
    if (!made) throw std::logic_error(made.error().to_string());
    device::Channel* channel = made->get();
    built_->core->add(name, std::unique_ptr<net::Resource>(std::move(*made)));
    return channel;
  };
  for (const auto& [name, arm] : built_->cell.arms)
    jog_channels_[name] = {.tool = add("jog/" + name + "/tool", net::ValueType::kTwist, "m/s,rad/s"),
                           .joints = add("jog/" + name + "/joints", net::ValueType::kJoints, "rad/s")};
}

void ServedCell::begin_jog_channels() {
  const rcc::ControlCore& core = *built_->core;
  for (const auto& [name, channels] : jog_channels_) {
    channels.tool->begin_cycle(core.cycle(), core.time());
    channels.joints->begin_cycle(core.cycle(), core.time());
  }
}

CellView ServedCell::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

ServedCell::Events ServedCell::events_from(std::int64_t sequence, std::size_t most) const {
  const std::lock_guard lock(mutex_);
  Events found;
  const std::int64_t first = next_sequence_ - static_cast<std::int64_t>(log_.size());
  found.lost = sequence < first;
  const std::int64_t from = std::max(sequence, first);
  for (std::int64_t one = from; one < next_sequence_ && found.events.size() < most; ++one)
    found.events.push_back(log_[static_cast<std::size_t>(one - first)]);
  found.next = from + static_cast<std::int64_t>(found.events.size());
  return found;
}

std::int64_t ServedCell::next_event() const {
  const std::lock_guard lock(mutex_);
  return next_sequence_;
}

void ServedCell::on_news(std::function<void()> listener) {
  const std::lock_guard lock(listener_mutex_);
  listener_ = std::move(listener);
}

/// Between two cycles. Realtime loop: under its lock, so that it only copies.
void ServedCell::copy(std::span<const rcc::Event> events) {
  rcc::ControlCore& core = *built_->core;
  fresh_.cycle = core.cycle();
  fresh_.time = core.time();
  fresh_.digest = core.digest().value();
  fresh_.connected = connected_;
  for (ArmView& view : fresh_.arms) {
    const device::Arm& arm = *built_->cell.arms.at(view.name).device;
    if (arm.has_sample()) {
      const device::ArmSample& sample = arm.sample();
      view.q_measured = sample.q;
      view.dq_measured = sample.dq;
      view.tau_measured = sample.tau;
      if (sample.fault != 0 && view.fault == 0) view.fault_cycle = fresh_.cycle;
      view.fault = sample.fault;
    }
    view.q_commanded = arm.set_point().q;
    view.mode = arm.mode();
    view.ready = arm.ready();
    view.at_rest = arm.at_rest();
    view.held = arm.held();
  }
  for (SensorView& view : fresh_.sensors) {
    const device::ForceTorqueSensor& sensor = *built_->cell.sensors.at(view.name).device;
    view.wrench = sensor.has_sample() ? std::optional(sensor.sample().wrench) : std::nullopt;
  }
  for (GripperView& view : fresh_.grippers) {
    const device::Gripper& gripper = *built_->cell.grippers.at(view.name).device;
    view.sample = gripper.has_sample() ? std::optional(gripper.sample()) : std::nullopt;
    view.held = gripper.held();
  }
  auto signal = fresh_.signals.begin();
  for_each_signal(built_->cell, [&signal](const std::string&, const auto& device) { look_at(device, *signal++); });
  for (CellView::Channel& view : fresh_.channels) {
    const device::Channel& channel = *built_->cell.channels.at(view.name);
    view.value = device::value_in(channel.description().type, channel.raw_slot());
    view.age = channel.age();
  }
  const rcc::Statistics& statistics = core.statistics();
  fresh_.overruns = statistics.overruns + late_;
  fresh_.worst_cycle = statistics.max_ns;
  const bool pressed = built_->emergency_stop != nullptr && built_->emergency_stop->pressed();
  if (pressed && !fresh_.emergency_stop) fresh_.emergency_cycle = fresh_.cycle;
  fresh_.emergency_stop = pressed;
  cell::copy_picture_state(*built_->world, fresh_.picture);
  for (const rcc::Event& event : events) fresh_events_.push_back({.sequence = 0, .cycle = event.cycle, .event = event});
}

/// Outside of the loop's lock.
void ServedCell::publish() {
  {
    const std::lock_guard lock(mutex_);
    view_ = fresh_;
    for (LoggedEvent& event : fresh_events_) {
      event.sequence = next_sequence_++;
      log_.push_back(std::move(event));
      if (log_.size() > kEvents) log_.pop_front();
    }
    fresh_events_.clear();
  }
  tell_listener();
}

void ServedCell::tell_listener() {
  const std::lock_guard lock(listener_mutex_);
  if (listener_) listener_();
}

}  // namespace takt::serve
