#include "core/device/channel_file.h"

#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/net/value_json.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;
using net::ValueType;

std::vector<std::string> type_names() {
  std::vector<std::string> names;
  for (int t = 0; t <= static_cast<int>(ValueType::kJoints); ++t)
    names.emplace_back(net::name_of(static_cast<ValueType>(t)));
  return names;
}

ValueType type_named(const std::string& name) {
  for (int t = 0; t <= static_cast<int>(ValueType::kJoints); ++t)
    if (net::name_of(static_cast<ValueType>(t)) == name) return static_cast<ValueType>(t);
  return ValueType::kReal;  // reported
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

ChannelDescription channel_from_json(const std::string& name, const Json& json, const std::string& pointer,
                                     Diagnostics& diagnostics) {
  Diagnostics found;
  ObjectReader reader(json, pointer, found);
  ChannelDescription channel{.name = name};
  channel.type = type_named(reader.choice("type", type_names()));
  const bool by_net = reader.choice("writer", {"outside", "net"}, "outside") == "net";
  channel.writer = by_net ? ChannelDescription::Writer::kNet : ChannelDescription::Writer::kOutside;
  channel.unit = reader.text("unit", "");
  channel.frame = reader.text("frame", "");
  channel.timeout = static_cast<Nanoseconds>(reader.number("timeout_s", 0.0, {.low = 0.0, .high = 3600.0}) * 1e9 + 0.5);
  const Json* initial = reader.child("initial");
  if (initial != nullptr && !initial->is_null())
    channel.initial = channel_value_from_json(*initial, channel.type, reader.at("initial"), found);
  reader.finish();
  const auto made = Channel::make(channel);
  if (!made && !found.has_errors()) found.append(made.error(), pointer);
  diagnostics.append(found);
  return channel;
}

}  // namespace takt::device
