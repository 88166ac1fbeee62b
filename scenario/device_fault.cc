// Faults "sensor" and "device": readings that are wrong, a connection that fails, for a while.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/cell_builder.h"
#include "scenario/fault.h"
#include "scenario/faulty_readings.h"

namespace takt::scenario {
namespace {

using WrongKind = DeviceFault::Kind;

/// What can be wrong, in the words of files.
const table::Words<WrongKind> kWrongWords{{"silent", WrongKind::kSilent}, {"nan", WrongKind::kNan},
                                          {"stuck", WrongKind::kStuck},   {"bias", WrongKind::kBias},
                                          {"noise", WrongKind::kNoise},   {"delay", WrongKind::kDelay},
                                          {"value", WrongKind::kValue},   {"loss", WrongKind::kLoss},
                                          {"gone", WrongKind::kGone},     {"jammed", WrongKind::kJammed}};

const std::string& word_of(WrongKind kind) {
  return std::ranges::find(kWrongWords, kind, &std::pair<std::string, WrongKind>::second)->first;
}

/// A fault of a device: the one that acts at its fault point.
class DeviceEntryFault : public Fault {
 public:
  DeviceEntryFault() { duration = 3600 * kSecond; }

  void add_to(BuiltCell& built, Diagnostics& diagnostics) const override;
  void begin(FaultContext& context) const override {
    note(context, fmt::format("{}: {} for {:g} s", device, word_of(wrong.kind), to_seconds(*duration)));
    context.built.fault_points.at(device)->begin(wrong, context.seed, device);
  }
  void end(FaultContext& context) const override {
    context.built.fault_points.at(device)->end();
    note(context, fmt::format("{}: well again", device));
  }
  [[nodiscard]] bool replaces(const Fault& other) const override { return other.failing_device() == device; }
  [[nodiscard]] std::string_view failing_device() const override { return device; }

  std::string device = {};
  DeviceFault wrong = {};

 private:
  /// Names of what can have such a fault.
  [[nodiscard]] virtual std::vector<std::string> names(const command::Cell& cell) const = 0;
  [[nodiscard]] virtual std::string_view key() const = 0;
  [[nodiscard]] virtual std::string_view what() const = 0;
};

template <class... Maps>
std::vector<std::string> names_of_all(const Maps&... maps) {
  std::vector<std::string> names;
  const auto add = [&](const auto& devices) {
    for (const auto& [name, device] : devices) names.push_back(name);
  };
  (add(maps), ...);
  return names;
}

class SensorFault final : public DeviceEntryFault {
 private:
  [[nodiscard]] std::vector<std::string> names(const command::Cell& cell) const override {
    return names_of_all(cell.sensors, cell.digital_inputs, cell.analog_inputs);
  }
  [[nodiscard]] std::string_view key() const override { return "sensor"; }
  [[nodiscard]] std::string_view what() const override { return "sensor or input"; }
};

class ConnectionFault final : public DeviceEntryFault {
 private:
  [[nodiscard]] std::vector<std::string> names(const command::Cell& cell) const override {
    return names_of_all(cell.arms, cell.grippers);
  }
  [[nodiscard]] std::string_view key() const override { return "device"; }
  [[nodiscard]] std::string_view what() const override { return "arm, base or gripper"; }
};

template <class F>
table::Table<F> share_table() {
  table::Table<F> loss;
  loss.number(
          "share", "", [](F & fault) -> auto& { return fault.wrong.share; },
          {.low = 0.0, .high = 1.0, .low_open = true}, "Share that does not arrive, drawn from the scenario's seed.")
      .required();
  return loss;
}

/// In N and Nm of a force/torque sensor, else in the unit of the input.
table::Table<SensorFault> added_table() {
  using F = SensorFault;
  constexpr const char* kOfSensor = "Offset, or standard deviation on each axis, in the axes of a force/torque sensor.";
  table::Table<F> added;
  added
      .vector(
          "force_N", "N", [](F & fault) -> auto& { return fault.wrong.wrench.force; }, kOfSensor)
      .fallback({})
      .vector(
          "torque_Nm", "Nm", [](F & fault) -> auto& { return fault.wrong.wrench.torque; }, kOfSensor)
      .fallback({})
      .device_number(
          "value", [](F & fault) -> auto& { return fault.wrong.value; },
          "Offset, or standard deviation, of an input in its unit.")
      .fallback({})
      .rule({.kind = table::Rule::Kind::kAnyOf,
             .groups = {{"force_N"}, {"torque_Nm"}, {"value"}},
             .hint = "Give 'force_N' or 'torque_Nm', of an input 'value'"});
  return added;
}

/// "value" of an input; a digital one has true or false.
table::Table<SensorFault> value_table() {
  table::Field value = table::field("value", table::Field::Type::kEither,
                                    "With 'value' what the input reads, in its unit; a digital one true or false.");
  value.items = {table::field({}, table::Field::Type::kNumber, {}), table::field({}, table::Field::Type::kBoolean, {})};
  value.required = true;
  table::Table<SensorFault> read;
  read.object(std::move(value), [](const table::Field& row, const table::Context& from, SensorFault& fault) {
    fault.wrong.value = table::number_or_boolean(row.key, from.reader);
  });
  return read;
}

table::Table<SensorFault> delay_table() {
  constexpr double kLongest = 1e-3 * ReadingFaults<device::WrenchSample>::kKept;  // s, of readings once a cycle
  table::Table<SensorFault> late;
  late.value(
          "delay_s", table::seconds_type({.low = 0.0, .high = kLongest, .low_open = true}),
          [](SensorFault & fault) -> auto& { return fault.wrong.delay; }, "By how much readings are late.")
      .required();
  return late;
}

/// The key "fault": these of the words, each with keys of its own.
template <class F>
void add_wrong(table::Table<F>& table, const std::vector<std::pair<WrongKind, const table::Table<F>*>>& kinds,
               std::string_view doc) {
  std::vector<typename table::Table<F>::template Variant<WrongKind>> variants;
  for (const auto& [kind, keys] : kinds) variants.push_back({word_of(kind), kind, {}, keys});
  table
      .choose(
          "fault", [](F & fault) -> auto& { return fault.wrong.kind; }, std::move(variants), doc)
      .required()
      .value("seconds", table::seconds_type(kFaultDuration), &F::duration, "Duration.")
      .fallback("to the end");
}

const table::Table<SensorFault>& sensor_table() {
  static const auto share = share_table<SensorFault>(), added = added_table(), value = value_table(),
                    delay = delay_table();
  static const auto table = [] {
    table::Table<SensorFault> sensor;
    sensor
        .named("sensor", table::NameOf::kDevice, &SensorFault::device,
               "A force/torque sensor, a light barrier, a range finder, or an input BLOCK/TERMINAL.")
        .required();
    add_wrong<SensorFault>(sensor,
                           {{WrongKind::kSilent, nullptr},
                            {WrongKind::kNan, nullptr},
                            {WrongKind::kStuck, nullptr},
                            {WrongKind::kBias, &added},
                            {WrongKind::kNoise, &added},
                            {WrongKind::kDelay, &delay},
                            {WrongKind::kValue, &value},
                            {WrongKind::kLoss, &share}},
                           "silent: no reading; nan: not a number; stuck: the last reading again and again; bias: an "
                           "offset; noise; delay: readings that come late; value: an input reads this, whatever is "
                           "there; loss: a share of the readings does not arrive. nan, bias and noise are not for "
                           "digital inputs, value not for force/torque sensors.");
    return sensor;
  }();
  return table;
}

const table::Table<ConnectionFault>& connection_table() {
  static const auto share = share_table<ConnectionFault>();
  static const auto table = [] {
    table::Table<ConnectionFault> connection;
    connection.named("device", table::NameOf::kDevice, &ConnectionFault::device, "An arm, a base or a gripper.")
        .required();
    add_wrong<ConnectionFault>(
        connection, {{WrongKind::kGone, nullptr}, {WrongKind::kLoss, &share}, {WrongKind::kJammed, nullptr}},
        "gone: nothing comes and nothing arrives; loss: a share of the samples and of the set points does not arrive; "
        "jammed: what a gripper is told has no effect.");
    return connection;
  }();
  return table;
}

void DeviceEntryFault::add_to(BuiltCell& built, Diagnostics& diagnostics) const {
  const std::vector<std::string> known = names(built.cell);
  const auto point = built.fault_points.find(device);
  if (point == built.fault_points.end() || std::ranges::find(known, device) == known.end()) {
    return diagnostics.error(Code::kUnknownName, fmt::format("{}/{}", pointer, key()),
                             fmt::format("there is no {} '{}'", what(), device), nearest_choice(device, known));
  }
  std::vector<std::string> words;
  for (const WrongKind one : point->second->kinds()) words.push_back(word_of(one));
  if (std::ranges::find(words, word_of(wrong.kind)) != words.end()) return;
  diagnostics.error(Code::kInvalidValue, pointer + "/fault",
                    fmt::format("'{}' cannot have the fault '{}'", device, word_of(wrong.kind)),
                    fmt::format("Choose one of {}", fmt::join(words, ", ")));
}

}  // namespace

FaultKind sensor_fault() {
  return fault_kind<SensorFault, sensor_table>("sensor", "The readings of a sensor or an input are wrong for a while.");
}
FaultKind device_fault() {
  return fault_kind<ConnectionFault, connection_table>(
      "device", "The connection to an arm, a base or a gripper fails for a while, or its fingers are jammed.");
}

}  // namespace takt::scenario
