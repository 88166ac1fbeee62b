#include "serve/cell_json.h"

#include <array>
#include <string_view>

#include <nlohmann/json.hpp>

#include "core/device/channel_file.h"
#include "core/net/value_json.h"

namespace takt::serve {

using OutJson = nlohmann::ordered_json;

OutJson to_json(const std::optional<device::ChannelValue>& value) {
  if (!value) return nullptr;
  return std::visit([](const auto& one) { return net::value_to_json(one); }, *value);
}

OutJson to_json(const rcc::WatchedValue& value) { return {{"cycle", value.cycle}, {"value", to_json(value.value)}}; }

OutJson to_json(const LoggedEvent& event) {
  static constexpr std::array<std::string_view, 4> kKinds = {"state", "done", "refused", "stopped"};
  OutJson json = {{"sequence", event.sequence},
                  {"cycle", event.cycle},
                  {"kind", kKinds[static_cast<std::size_t>(event.event.kind)]},
                  {"net", event.event.net},
                  {"request", event.event.request},
                  {"cause", name_of(event.event.cause.code)},
                  {"text", event.event.cause.text.view()}};
  if (event.event.kind == rcc::Event::Kind::kState) json["state"] = name_of(event.event.state);
  return json;
}

OutJson to_json(const CellView& view) {
  return {{"cycle", view.cycle},
          {"time_s", to_seconds(view.time)},
          {"digest", to_string(view.digest)},
          {"connected", view.connected}};
}

Diagnostics read_value(const OutJson& json, net::ValueType type, std::optional<device::ChannelValue>& value) {
  Diagnostics wrong;
  if (!json.is_null()) value = device::channel_value_from_json(json, type, "", wrong);
  return wrong;
}

}  // namespace takt::serve
