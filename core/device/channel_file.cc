#include "core/device/channel_file.h"

#include <vector>

#include <nlohmann/json.hpp>

#include "core/net/value_json.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;
using net::ValueType;

std::vector<std::pair<std::string, ValueType>> types() {
  std::vector<std::pair<std::string, ValueType>> types;
  for (int t = 0; t <= static_cast<int>(ValueType::kJoints); ++t)
    types.emplace_back(net::name_of(static_cast<ValueType>(t)), static_cast<ValueType>(t));
  return types;
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

const FormOf<ChannelDescription>& channel_form() {
  using Entry = ChannelDescription;
  static const auto form =
      FormOf<Entry>("channel")
          .choice(choice_key("type", {}, "Type of the value."), &Entry::type, types())
          .choice(choice_key("writer", {}, "Who writes it.").optional(), &Entry::writer,
                  std::vector<std::pair<std::string, Entry::Writer>>{{"outside", Entry::Writer::kOutside},
                                                                     {"net", Entry::Writer::kNet}})
          .add(text_key("unit", "Unit such as m/s; two for a Twist or Wrench: linear,angular.").optional(),
               &Entry::unit)
          .add(text_key("frame", "A>B: pose of B in A; for a vector: the frame in which it is expressed.").optional(),
               &Entry::frame)
          .add(number_key("timeout_s", "s", {.low = 0.0, .high = 3600.0},
                          "Age from which on the value is null; 0: never.")
                   .optional(),
               &Entry::timeout)
          .add(any_key("initial", "", "Value until the first one is written.").optional("null"), [](FormReader& from,
                                                                                                    Entry& channel) {
            const Json* initial = from.json("initial");
            if (initial != nullptr && !initial->is_null())
              channel.initial = channel_value_from_json(*initial, channel.type, from.at("initial"), from.diagnostics());
          });
  return form;
}

ChannelDescription channel_from_json(const std::string& name, const Json& json, const std::string& pointer,
                                     Diagnostics& diagnostics) {
  Diagnostics found;
  ChannelDescription channel = channel_form().read(json, pointer, found);
  channel.name = name;
  const auto made = Channel::make(channel);
  if (!made && !found.has_errors()) found.append(made.error(), pointer);
  diagnostics.append(found);
  return channel;
}

}  // namespace takt::device
