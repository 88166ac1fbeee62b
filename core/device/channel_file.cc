#include "core/device/channel_file.h"

#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/net/value_json.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;
using net::ValueType;

table::Words<ValueType> value_types() {
  table::Words<ValueType> types;
  for (int t = 0; t <= static_cast<int>(ValueType::kJoints); ++t) {
    const auto type = static_cast<ValueType>(t);
    types.emplace_back(net::name_of(type), type);
  }
  return types;
}

void read_initial(const table::Field& row, const table::Context& from, ChannelDescription& channel) {
  const Json* initial = from.reader.child(row.key);
  if (initial != nullptr && !initial->is_null())
    channel.initial =
        channel_value_from_json(*initial, channel.type, from.reader.at(row.key), from.reader.diagnostics());
}

}  // namespace

std::optional<ChannelValue> channel_value_from_json(const Json& json, ValueType type, const std::string& pointer,
                                                    Diagnostics& diagnostics) {
  return net::visit_type(type, [&]<class T>(std::type_identity<T>) -> std::optional<ChannelValue> {
    T value = net::null_payload<T>();
    const Diagnostics found = net::value_from_json(json, value);
    diagnostics.append(found, pointer);
    if (found.has_errors()) return std::nullopt;
    return ChannelValue(value);
  });
}

const table::Table<ChannelDescription>& channel_table() {
  using C = ChannelDescription;
  static const auto table = [] {
    table::Field initial =
        table::field("initial", table::Field::Type::kAny, "Value until the first one is written, of that type.");
    initial.fallback = "null";
    table::Table<C> channel;
    channel.choice("type", &C::type, value_types(), "Type of the value.")
        .required()
        .choice("writer", &C::writer,
                table::Words<C::Writer>{{"outside", C::Writer::kOutside}, {"net", C::Writer::kNet}}, "Who writes it.")
        .text("unit", &C::unit, "Unit such as m/s; two for a Twist or Wrench: linear,angular.")
        .text("frame", &C::frame, "A>B: pose of B in A; for a vector: the frame in which it is expressed.")
        .object(std::move(initial), read_initial)
        .value("timeout_s", table::seconds_type({.low = 0.0, .high = 3600.0}), &C::timeout,
               "Age from which on the value is null; 0: never.");
    return channel;
  }();
  return table;
}

ChannelDescription channel_from_json(const std::string& name, const Json& json, const std::string& pointer,
                                     Diagnostics& diagnostics) {
  Diagnostics found;
  ObjectReader reader(json, pointer, found);
  ChannelDescription channel = channel_table().read_object(reader);
  channel.name = name;
  const auto made = Channel::make(channel);
  if (!made && !found.has_errors()) found.append(made.error(), pointer);
  diagnostics.append(found);
  return channel;
}

}  // namespace takt::device
