// Channels of a cell, which programs write and nets and states read (docs/channels.md).
#include <optional>
#include <string>

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nlohmann/json.hpp>

#include "core/base/diagnostics.h"
#include "core/base/keys_of.h"
#include "core/device/channel_file.h"
#include "core/expression/device_sensors.h"
#include "core/expression/state.h"
#include "core/net/value_json.h"
#include "python/bindings.h"
#include "python/cell_handle.h"
#include "python/errors.h"
#include "python/expressions.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Json = nlohmann::ordered_json;
using C = const CellPtr&;
using Name = const std::string&;

/// Raises OperationError with the nearest name.
const device::Channel& channel_of(C cell, Name name) {
  const auto& channels = cell->get().model().channels;
  if (const auto found = channels.find(name); found != channels.end()) return *found->second;
  raise_error("OperationError", Code::kUnknownName, "", "the cell has no channel '" + name + "'",
              nearest_choice(name, keys_of(channels)));
}

/// @param json  as files have a value of its type; null: none
void write_channel(C cell, Name name, Name json) {
  const Json value = Json::parse(json);
  std::optional<device::ChannelValue> read;
  if (!value.is_null()) {
    Diagnostics wrong;
    read = device::channel_value_from_json(value, channel_of(cell, name).description().type, "/value", wrong);
    if (wrong.has_errors()) raise_error("OperationError", std::move(wrong));
  }
  cell->get().write_channel(name, read);
}

/// The value of this cycle as JSON; null: there is none.
std::string channel_value(C cell, Name name) {
  const device::Channel& channel = channel_of(cell, name);
  const auto value = device::value_in(channel.description().type, channel.raw_slot());
  if (!value) return "null";
  return std::visit([](const auto& one) { return net::value_to_json(one); }, *value).dump();
}

/// As a state or a sensor, for conditions and formulas.
nb::object channel_sensor(C cell, Name name) {
  const expression::Cell& model = cell->get().model();
  const auto sensor = [&]<class T>(std::type_identity<T>) {
    return nb::cast(Owned<expression::Sensor<T>>{cell, expression::channel<T>(model, name)});
  };
  switch (const net::ValueType type = channel_of(cell, name).description().type) {
    case net::ValueType::kBoolean:
      return nb::cast(State{cell, expression::holds(expression::channel<net::Boolean>(model, name))});
    case net::ValueType::kReal:
      return sensor(std::type_identity<net::Real>{});
    case net::ValueType::kVector:
      return sensor(std::type_identity<net::Vector>{});
    case net::ValueType::kFrame:
      return sensor(std::type_identity<net::Frame>{});
    case net::ValueType::kTwist:
      return sensor(std::type_identity<net::Twist>{});
    case net::ValueType::kWrench:
      return sensor(std::type_identity<net::Wrench>{});
    case net::ValueType::kJoints:
      return sensor(std::type_identity<net::JointArray>{});
    default:
      raise_error("UsageError", Code::kUnsupported, "",
                  "'" + name + "' carries a " + std::string(net::name_of(type)) + ", which formulas do not have",
                  "Use its value");
  }
}

}  // namespace

void bind_channels(nb::class_<CellHandle>& cell) {
  cell.def("write_channel", write_channel).def("channel_value", channel_value).def("channel_sensor", channel_sensor);
  cell.def("channel_description", [](C c, Name name) {
    const device::ChannelDescription& is = channel_of(c, name).description();
    return Json({{"type", net::name_of(is.type)},
                 {"unit", is.unit},
                 {"frame", is.frame},
                 {"writer", is.writer == device::ChannelDescription::Writer::kNet ? "net" : "outside"}})
        .dump();
  });
}

}  // namespace takt::python
