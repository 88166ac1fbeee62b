// Kind "io": a block of terminals. Each terminal is a canonical device of its own, "BLOCK/TERMINAL".
#include <algorithm>

#include <fmt/format.h>

#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "cell/build/signal_devices.h"
#include "cell/build/site_devices.h"
#include "core/base/form_of.h"
#include "core/device/device_file.h"
#include "core/device/signal.h"

namespace takt::cell {
namespace {

using device::IoChannel;
using device::IoDescription;
using Json = nlohmann::ordered_json;

/// A terminal as the scenario uses it: under what name, wired to what.
struct Terminal {
  const IoChannel* channel = nullptr;
  std::string name;  ///< of the canonical device
  std::string pointer;
  std::string source;
  std::vector<sim::SimInputDescription::Step> script;
};

using Step = sim::SimInputDescription::Step;

const FormOf<Step>& step_form(bool analog) {
  const auto form = [](bool reads_number) {
    return FormOf<Step>()
        .add(number_key("at_s", "s", kNotNegative, "Simulated time."), &Step::from)
        .add(any_of_key("value", {"number", "boolean"}, "Value from then on; of an analog input in its unit.")
                 .optional("false, of an analog input required"),
             [reads_number](FormReader& from, Step& step) {
               if (reads_number) step.value = from.object().number("value");
               if (!reads_number) step.value = from.object().boolean("value", false) ? 1.0 : 0.0;
             });
  };
  static const FormOf<Step> numbers = form(true), truths = form(false);
  return analog ? numbers : truths;
}

Key name_key() { return text_key("name", "Its name in this cell, without '/'.").optional("that of the model"); }

Form input_form() {
  return {.doc = "An input. With neither 'from' nor 'script' it is false or 0.",
          .keys = {name_key(),
                   text_key("from", "The output, light barrier or range finder to which it is wired.").optional(),
                   objects_key("script", 0, step_form(true).form(), "Values over time, ascending.").optional()},
          .rules = {at_most_one({"from", "script"}, "Give a wire, or a script")}};
}

std::vector<Step> read_script(FormReader& from, const IoChannel& channel) {
  std::vector<Step> script;
  from.elements("script", [&](const Json& json, const std::string& pointer) {
    script.push_back(step_form(channel.is_analog()).read(json, pointer, from.diagnostics()));
    if (script.size() > 1 && script.back().from < script[script.size() - 2].from) {
      from.diagnostics().error(Code::kOutOfRange, pointer + "/at_s",
                               fmt::format("{:g} s, before the step before it", to_seconds(script.back().from)),
                               "Give ascending times");
    }
  });
  return script;
}

void read_terminal(const Json& json, Diagnostics& diagnostics, Terminal& terminal) {
  static const Form input = input_form(), output{.doc = "An output.", .keys = {name_key()}};
  const bool is_output = terminal.channel->is_output();
  ObjectReader object(json, terminal.pointer, diagnostics);
  FormReader from(is_output ? output : input, object);
  if (from.has("name")) terminal.name = from.text("name");
  (void)object.child("name");
  if (terminal.name.empty() || terminal.name.find('/') != std::string::npos)
    diagnostics.error(Code::kInvalidName, from.at("name"), fmt::format("invalid name '{}'", terminal.name),
                      "Choose a name that is not empty and has no '/'");
  if (!is_output) {
    terminal.source = from.text("from");
    terminal.script = read_script(from, *terminal.channel);
  }
  from.check_rules();
  object.finish();
}

/// All terminals of the block; what the scenario says of some is in its settings.
std::vector<Terminal> terminals_of(const DeviceEntry& entry, const IoDescription& io, Diagnostics& diagnostics) {
  std::vector<Terminal> terminals;
  std::vector<std::string> known, used;
  const std::string settings = "/devices" + pointer_segment(entry.name) + "/settings";
  for (const IoChannel& channel : io.channels) {
    Terminal terminal{&channel, channel.name, settings + pointer_segment(channel.name), {}, {}};
    const auto given = entry.settings.find(channel.name);
    if (given != entry.settings.end()) read_terminal(*given, diagnostics, terminal);
    if (std::ranges::find(used, terminal.name) != used.end())
      diagnostics.error(Code::kDuplicate, terminal.pointer,
                        fmt::format("'{}' is the name of two terminals", terminal.name));
    known.push_back(channel.name);
    used.push_back(terminal.name);
    terminal.name = entry.name + "/" + terminal.name;
    terminals.push_back(std::move(terminal));
  }
  for (const auto& [name, value] : entry.settings.items()) {
    if (std::ranges::find(known, name) == known.end())
      diagnostics.error(Code::kUnknownName, settings + pointer_segment(name),
                        fmt::format("the block has no terminal '{}'", name), nearest_choice(name, known));
  }
  return terminals;
}

template <class T>
device::SignalOutputDescription<T> output_of(const IoChannel& channel) {
  device::SignalOutputDescription<T> output;
  output.unit = channel.unit;
  output.initial = static_cast<T>(channel.initial);
  if (channel.stop) output.stop = static_cast<T>(*channel.stop);
  output.lower = channel.lower;
  output.upper = channel.upper;
  output.rate_max = channel.rate_max;
  return output;
}

class IoKind final : public DeviceKind {
 public:
  IoKind()
      : DeviceKind("io", {.doc = "The terminals that are used, by their names in the model.",
                          .others = std::make_shared<const Key>(object_key("", input_form(), ""))}) {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override { return device::read_io(folder); }

  void declare(const DeviceEntry& entry, const device::ModelDescription* model, expression::Cell& cell) const override {
    const auto* io = dynamic_cast<const IoDescription*>(model);
    if (!io) return;
    Diagnostics ignored;
    for (const Terminal& terminal : terminals_of(entry, *io, ignored)) {
      switch (terminal.channel->kind) {
        case IoChannel::Kind::kDigitalInput:
          cell.digital_inputs[terminal.name];
          break;
        case IoChannel::Kind::kAnalogInput:
          cell.analog_inputs[terminal.name];
          break;
        case IoChannel::Kind::kDigitalOutput:
          cell.digital_outputs[terminal.name];
          break;
        case IoChannel::Kind::kAnalogOutput:
          cell.analog_outputs[terminal.name];
          break;
      }
    }
  }

  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override {
    DeviceKind::check(device, diagnostics);
    (void)terminals_of(*device.entry, *device.as<IoDescription>(), diagnostics);
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const auto io = device.as<IoDescription>();
    Diagnostics ignored;  // checked before
    for (const Terminal& terminal : terminals_of(*device.entry, *io, ignored)) {
      const IoChannel& channel = *terminal.channel;
      if (channel.is_output()) {
        world.outputs.push_back({.name = terminal.name,
                                 .pointer = terminal.pointer,
                                 .analog = channel.is_analog(),
                                 .initial = channel.initial});
        continue;
      }
      sim::SimInputDescription input;
      input.name = terminal.name;
      input.pointer = terminal.pointer;
      input.analog = channel.is_analog();
      input.lower = channel.lower;
      input.upper = channel.upper;
      input.resolution = channel.resolution;
      input.noise = channel.noise;
      input.source = terminal.source;
      input.script = terminal.script;
      input.period = io->cycle;
      world.inputs.push_back(std::move(input));
    }
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    Diagnostics ignored;  // checked before
    const auto terminals = terminals_of(*device.entry, *device.as<IoDescription>(), ignored);
    const auto wired = built.site->wire(device, simulated_terminals(*device.entry, *device.as<IoDescription>(), built));
    for (const Terminal& terminal : terminals) add(terminal, wired, device.entry->may_fail, built);
  }

 private:
  static void add(const Terminal& terminal, const SiteDevices::WiredIo& wired, bool may_fail, BuiltCell& built) {
    const std::string& name = terminal.name;
    const IoChannel& channel = *terminal.channel;
    switch (channel.kind) {
      case IoChannel::Kind::kDigitalInput:
        built.cell.digital_inputs[name] = &add_input(terminal, wired.terminals.digital_inputs, wired, may_fail, built);
        break;
      case IoChannel::Kind::kAnalogInput:
        built.cell.analog_inputs[name] = &add_input(terminal, wired.terminals.analog_inputs, wired, may_fail, built);
        break;
      case IoChannel::Kind::kDigitalOutput:
        built.cell.digital_outputs[name] = &add_output(terminal, wired.terminals.digital_outputs, built);
        break;
      case IoChannel::Kind::kAnalogOutput:
        built.cell.analog_outputs[name] = &add_output(terminal, wired.terminals.analog_outputs, built);
        break;
    }
  }

  template <class T>
  using Inputs = std::map<std::string, std::shared_ptr<device::SignalInputBackend<T>>, std::less<>>;
  template <class T>
  using Outputs = std::map<std::string, std::shared_ptr<device::SignalOutputBackend<T>>, std::less<>>;

  template <class T>
  static device::SignalInput<T>& add_input(const Terminal& terminal, const Inputs<T>& inputs,
                                           const SiteDevices::WiredIo& wired, bool may_fail, BuiltCell& built) {
    auto backend = inputs.at(terminal.channel->name);
    if (may_fail) backend = built.with_faults<FaultyInput<T>>(terminal.name, std::move(backend));
    backend = built.commands->samples().tap<T>(terminal.name, std::move(backend));
    device::SignalInputDescription<T> description{.unit = terminal.channel->is_analog() ? terminal.channel->unit : "",
                                                  .sample_age_max = wired.description->sample_age_max};
    return built.core->add(
        std::make_unique<device::SignalInput<T>>(terminal.name, std::move(description), std::move(backend)));
  }
  template <class T>
  static device::SignalOutput<T>& add_output(const Terminal& terminal, const Outputs<T>& outputs, BuiltCell& built) {
    auto backend = built.commands->tap(terminal.name, outputs.at(terminal.channel->name));
    return built.core->add(std::make_unique<device::SignalOutput<T>>(terminal.name, output_of<T>(*terminal.channel),
                                                                     std::move(backend), built.core->period()));
  }
};

}  // namespace

device::IoTerminals simulated_terminals(const DeviceEntry& entry, const IoDescription& io, BuiltCell& built) {
  Diagnostics ignored;  // checked before
  device::IoTerminals terminals;
  for (const Terminal& one : terminals_of(entry, io, ignored)) {
    const std::string& channel = one.channel->name;
    switch (one.channel->kind) {
      case IoChannel::Kind::kDigitalInput:
        terminals.digital_inputs[channel] =
            built.borrowed<device::SignalInputBackend<bool>>(built.world->input(one.name));
        break;
      case IoChannel::Kind::kAnalogInput:
        terminals.analog_inputs[channel] =
            built.borrowed<device::SignalInputBackend<double>>(built.world->input(one.name));
        break;
      case IoChannel::Kind::kDigitalOutput:
        terminals.digital_outputs[channel] =
            built.borrowed<device::SignalOutputBackend<bool>>(built.world->output(one.name));
        break;
      case IoChannel::Kind::kAnalogOutput:
        terminals.analog_outputs[channel] =
            built.borrowed<device::SignalOutputBackend<double>>(built.world->output(one.name));
        break;
    }
  }
  return terminals;
}

std::unique_ptr<DeviceKind> io_kind() { return std::make_unique<IoKind>(); }

}  // namespace takt::cell
