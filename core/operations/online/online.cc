#include "core/operations/online/online.h"

#include <fmt/format.h>

#include "core/expression/device_sensors.h"

namespace takt::operations {

/// A channel by its name. Its type can only be checked where channels are known.
void check_channel(const std::string& name, net::ValueType type, const ReadContext& from, const char* key) {
  const auto found = from.cell.channels.find(name);
  Diagnostics& diagnostics = from.reader.diagnostics();
  if (found == from.cell.channels.end()) {
    std::vector<std::string> names;
    for (const auto& [one, channel] : from.cell.channels) {
      if (channel == nullptr || channel->description().type == type) names.push_back(one);
    }
    diagnostics.error(
        Code::kUnknownName, from.reader.at(key), fmt::format("there is no channel '{}'", name),
        names.empty() ? fmt::format("the cell has none of type {}", net::name_of(type)) : nearest_choice(name, names));
  } else if (found->second != nullptr && found->second->description().type != type) {
    diagnostics.error(Code::kTypeMismatch, from.reader.at(key),
                      fmt::format("'{}' carries {}", name, net::name_of(found->second->description().type)),
                      fmt::format("Name a channel of type {}", net::name_of(type)));
  }
}

MadeCommand OnlineCommand::make(const BuildContext& context, const std::string& key) const {
  MadeCommand made = on_actuator(command::arm(context.cell, end_.arm), action_of(context));
  command::Command& moved = made.command;
  add_ends(made, context, key);
  if (end_.seconds) {
    moved.on_entered(moved.started(), cancel(moved), {.delay = *end_.seconds});
    made.handler_places.emplace_back("/seconds");
  }
  if (end_.until) {
    moved.on_entered(expression::state_of(*end_.until, context.cell, context.biases), cancel(moved));
    made.handler_places.emplace_back("/until");
  }
  return made;
}

OperationCommand::IntendedContact OnlineCommand::meant_touch() const {
  return compliance() ? IntendedContact{.devices = {end_.arm}} : IntendedContact{};
}

void OnlineCommand::rehearse(Rehearsal& rehearsal, Diagnostics&) const {
  rehearsal.duration += end_.seconds.value_or(0.0);
}

}  // namespace takt::operations
