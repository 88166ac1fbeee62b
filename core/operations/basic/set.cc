#include "core/operations/basic/set.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/device_action.h"
#include "core/expression/device_sensors.h"
#include "core/operations/command/command_step.h"
#include "core/operations/command/operation_command.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;
using expression::BooleanSensor;

constexpr Range kFollowingTime{.low = 0, .high = 3600};

/// It follows a value.
bool sets_by_following(const Json& json) {
  return json.is_object() && json.contains("value") && json.at("value").is_object();
}

/// The value of an output: a level, a number in the output's own unit, or something that the output follows.
void read_output_value(const ParameterInfo& row, const ReadContext& from, SetParameters& parameters) {
  ObjectReader& reader = from.reader;
  const bool analog = from.cell.analog_outputs.contains(parameters.output);
  if (analog && sets_by_following(reader.json())) {
    parameters.source = read_value(*reader.object(row.key), reader.at(row.key), from.cell, reader.diagnostics());
    (void)check_number(*parameters.source, from.cell, reader.at(row.key), reader.diagnostics());
  } else if (analog) {
    parameters.value = reader.number(row.key);
  } else if (from.cell.digital_outputs.contains(parameters.output)) {
    parameters.value = reader.boolean(row.key);
  } else {
    (void)reader.child(row.key);
  }
}

void check_following(SetParameters& parameters, const ReadContext& from) {
  if (parameters.source) return;
  for (const char* key : {"factor", "offset", "seconds", "until"}) {
    if (from.reader.has(key)) {
      from.reader.diagnostics().error(Code::kConflict, from.reader.at(key),
                                      fmt::format("'{}' without a value to follow", key),
                                      "Name an analog output whose 'value' is an object, such as {\"input\": ...}");
    }
  }
}

/// Without a factor the value is sent as it is.
bool check_unit(const SetParameters& parameters, const expression::Cell& cell, const std::string& pointer,
                Diagnostics& diagnostics) {
  const auto unit = unit_of(*parameters.source, cell);
  const std::string& own = cell.analog_outputs.find(parameters.output)->second->description().unit;
  if (parameters.factor || !unit || *unit == own) return true;
  diagnostics.error(Code::kUnitMismatch, pointer + "/value",
                    fmt::format("a value in {} is not for '{}', which is in {}", *unit, parameters.output, own),
                    fmt::format("Give 'factor', in {} for each {}", own, *unit));
  return false;
}

/// @return false with a diagnostic: a value outside of the range of the output, or in another unit.
bool check_range(const SetParameters& parameters, const expression::Cell& cell, const std::string& pointer,
                 Diagnostics& diagnostics) {
  if (parameters.source) return check_unit(parameters, cell, pointer, diagnostics);
  const double* value = std::get_if<double>(&parameters.value);
  // That a value is of another kind than the output is up to the command layer.
  if (value == nullptr || !cell.analog_outputs.contains(parameters.output)) return true;
  const auto& output = cell.analog_outputs.find(parameters.output)->second->description();
  if (*value >= output.lower && *value <= output.upper) return true;
  diagnostics.error(Code::kOutOfRange, pointer + "/value",
                    fmt::format("{:g} {} is not for '{}'", *value, output.unit, parameters.output),
                    fmt::format("Choose {:g} to {:g} {}", output.lower, output.upper, output.unit));
  return false;
}

class OutputCommand final : public OperationCommand {
 public:
  explicit OutputCommand(SetParameters parameters) : parameters_(std::move(parameters)) {}

  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    if (parameters_.source) return make_following(build, key);
    const bool* level = std::get_if<bool>(&parameters_.value);
    const command::Action action =
        level != nullptr ? command::set_value(*level) : command::set_value(std::get<double>(parameters_.value));
    const command::Actuator actuator = command::output(build.cell, parameters_.output);
    return {.command = command::RuntimeCommand(name, actuator, action), .action = action, .actuator = actuator};
  }
  [[nodiscard]] bool is_called_by_type() const override { return !parameters_.source; }
  void check(const expression::Cell& cell, Diagnostics& diagnostics) const override {
    (void)check_range(parameters_, cell, pointer, diagnostics);
  }
  [[nodiscard]] std::string follows() const override {
    const bool progress = parameters_.source && parameters_.source->kind == ValueParameters::Kind::kProgress;
    return progress ? parameters_.source->of : std::string();
  }
  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    if (parameters_.source) rehearsal.duration += parameters_.seconds.value_or(0.0);
  }
  void finish(const activity::RunView& ended, const std::string& key, bool, activity::Context&,
              Diagnostics& diagnostics) const override {
    if (!ended.was_true(key + " silent")) return;
    diagnostics.error(Code::kSensorSilent, pointer + "/value",
                      "what the output follows did not answer, so it stayed where it was",
                      "Check its power and its wiring");
  }

 private:
  [[nodiscard]] MadeCommand make_following(const BuildContext& build, const std::string& key) const {
    expression::RealSensor value = value_of(*parameters_.source, build);
    if (parameters_.factor) value = value * *parameters_.factor;
    if (parameters_.offset) value = value + *parameters_.offset;
    const command::Action action = command::track_value(value);
    const command::Actuator actuator = command::output(build.cell, parameters_.output);
    command::RuntimeCommand set(name, actuator, action);
    MadeCommand made{.command = set, .action = action, .actuator = actuator};
    if (parameters_.seconds) {
      set.on_entered(set.started(), cancel(set), {.delay = *parameters_.seconds});
      made.handler_places.emplace_back("/seconds");
    }
    if (parameters_.until) {
      set.on_entered(expression::state_of(*parameters_.until, build.cell, build.biases), cancel(set));
      made.handler_places.emplace_back("/until");
    }
    // A motion that does not run has no progress; that is no fault.
    if (parameters_.source->kind == ValueParameters::Kind::kProgress) return made;
    set.on_entered(action.error(), cancel(set));
    made.handler_places.emplace_back("/value");
    set.fails_if(action.error().once());
    set.capture(key + " silent", BooleanSensor(action.error().node()), action.error());
    return made;
  }

  [[nodiscard]] static expression::RealSensor value_of(const ValueParameters& value, const BuildContext& build) {
    if (value.kind != ValueParameters::Kind::kProgress) return number_of(value, build.cell, build.biases);
    return *build.progress;
  }

  SetParameters parameters_;
};

}  // namespace

const ParameterTable<SetParameters>& set_parameters() {
  static const auto table = [] {
    ParameterInfo value{.key = "value", .type = ParameterInfo::Type::kObject, .definition = "output_value"};
    value.required = true;
    value.doc = "Level, number in the unit of the output, or what an analog output follows.";
    ParameterTable<SetParameters> set;
    set.name("output", NameOf::kOutput, &SetParameters::output, "Digital or analog output.")
        .object(std::move(value), read_output_value)
        .device_number("factor", &SetParameters::factor,
                       "Of an output that follows: its value for each unit of the source.")
        .device_number("offset", &SetParameters::offset, "Of an output that follows: added, in the unit of the output.")
        .number("seconds", "s", &SetParameters::seconds, kFollowingTime, "How long the output follows.")
        .condition("until", &SetParameters::until, "The output follows until this becomes true.")
        .rule(check_following);
    return set;
  }();
  return table;
}

std::unique_ptr<OperationCommand> set_command(const SetParameters& parameters) {
  return std::make_unique<OutputCommand>(parameters);
}

Operation set_operation() {
  return {.name = "set",
          .doc = "Sets a digital or analog output, which keeps its value; or lets an analog output follow a value.",
          .parameters = rows_of<set_parameters>,
          .read_step = step_of_command,
          .read_command = read_command<OutputCommand, set_parameters>};
}

}  // namespace takt::operations
