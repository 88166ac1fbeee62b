// Grippers, outputs, waits and an arm that is held, as commands of a transaction.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/command/actions/device_action.h"
#include "core/expression/condition_state.h"
#include "core/expression/device_sensors.h"
#include "core/operations/command_request.h"
#include "core/operations/grip_request.h"
#include "core/operations/signal_request.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using command::BooleanSensor;

class GripperCommand final : public CommandRequest {
 public:
  GripRequest request;

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    const command::MountedGripper& mounted = making.cell.grippers.find(request.gripper)->second;
    const command::GripCommand figures = command_of(request, mounted.device->description());
    const command::GripWish wish{.width = figures.width, .speed = figures.speed, .force = figures.force};
    const command::Actuator actuator = command::gripper(making.cell, request.gripper);
    const command::Action action = request.opens ? command::release(wish) : command::grip(wish);
    command::RuntimeCommand gripped(name, actuator, action);
    // Later commands may move on before anybody looks.
    const command::State stands = gripped.completed() && !gripped.cancelled();
    gripped.observe(key + " stands", BooleanSensor(stands.node()));
    gripped.capture(key + " holding",
                    BooleanSensor(command::gripper_state(making.cell, request.gripper, "holding").node()), stands);
    gripped.capture(key + " width", command::gripper_width(making.cell, request.gripper), stands);
    gripped.capture(key + " q", command::commanded_joints(making.cell, mounted.arm), stands);
    return {.command = gripped, .action = action, .actuator = actuator};
  }

  void check(const command::Cell& cell, Diagnostics& diagnostics) const override {
    (void)check_figures(request, cell.grippers.find(request.gripper)->second.device->description(), pointer,
                        diagnostics);
  }
  void rehearse(Rehearsal& rehearsal, Diagnostics& diagnostics) const override {
    rehearse_grip(request, rehearsal, diagnostics);
  }

  void finish(const ActivityRun& ended, const std::string& key, bool, Context& context,
              Diagnostics& diagnostics) const override {
    if (!ended.was_true(key + " stands")) return;
    const auto q = ended.value<net::JointArray>(key + " q");
    GripOutcome outcome{.holding = ended.value<net::Boolean>(key + " holding"),
                        .width = ended.value<net::Real>(key + " width"),
                        .q = {}};
    if (q) outcome.q = q->map();
    Diagnostics own;
    (void)note_grip(request, outcome, context, own);
    diagnostics.append(own, pointer);
  }
};

class OutputCommand final : public CommandRequest {
 public:
  SetRequest request;

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    if (request.source) return make_following(making, key);
    const bool* level = std::get_if<bool>(&request.value);
    const command::Action action =
        level != nullptr ? command::set_value(*level) : command::set_value(std::get<double>(request.value));
    const command::Actuator actuator = command::output(making.cell, request.output);
    return {.command = command::RuntimeCommand(name, actuator, action), .action = action, .actuator = actuator};
  }
  void check(const command::Cell& cell, Diagnostics& diagnostics) const override {
    (void)check_range(request, cell, pointer, diagnostics);
  }
  [[nodiscard]] std::string follows() const override {
    const bool progress = request.source && request.source->kind == ValueRequest::Kind::kProgress;
    return progress ? request.source->of : std::string();
  }
  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    if (request.source) rehearsal.duration += request.seconds.value_or(0.0);
  }
  void finish(const ActivityRun& ended, const std::string& key, bool, Context&,
              Diagnostics& diagnostics) const override {
    if (!ended.was_true(key + " silent")) return;
    diagnostics.error(Code::kSensorSilent, pointer + "/value",
                      "what the output follows did not answer, so it stayed where it was",
                      "check its power and its wiring");
  }

 private:
  [[nodiscard]] MadeCommand make_following(const BuildContext& making, const std::string& key) const {
    command::RealSensor value = value_of(*request.source, making);
    if (request.factor) value = value * *request.factor;
    if (request.offset) value = value + *request.offset;
    const command::Action action = command::track_value(value);
    const command::Actuator actuator = command::output(making.cell, request.output);
    command::RuntimeCommand set(name, actuator, action);
    MadeCommand made{.command = set, .action = action, .actuator = actuator};
    if (request.seconds) {
      set.on_entered(set.started(), cancel(set), {.delay = *request.seconds});
      made.handler_places.emplace_back("/seconds");
    }
    if (request.until) {
      set.on_entered(command::state_of(*request.until, making.cell, making.biases), cancel(set));
      made.handler_places.emplace_back("/until");
    }
    // A motion that does not run has no progress; that is no fault.
    if (request.source->kind == ValueRequest::Kind::kProgress) return made;
    set.on_entered(action.error(), cancel(set));
    made.handler_places.emplace_back("/value");
    set.capture(key + " silent", BooleanSensor(action.error().node()), action.error());
    return made;
  }

  [[nodiscard]] static command::RealSensor value_of(const ValueRequest& value, const BuildContext& making) {
    if (value.kind != ValueRequest::Kind::kProgress) return number_of(value, making.cell, making.biases);
    return *making.progress;
  }
};

class TimeCommand final : public CommandRequest {
 public:
  WaitRequest request;

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    if (!request.until) return {.command = command::WaitCommand(name, request.seconds.value_or(0.0))};
    const command::State until = command::state_of(*request.until, making.cell, making.biases);
    command::WaitCommand wait(name, until, request.timeout);
    if (!request.timeout) return {.command = wait};
    wait.observe(key + " timed out", BooleanSensor(wait.timed_out().node()));
    wait.capture(key + " held", BooleanSensor(until.node()), wait.timed_out());
    return {.command = wait};
  }

  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.duration += request.seconds.value_or(0.0);
  }

  void finish(const ActivityRun& ended, const std::string& key, bool, Context&,
              Diagnostics& diagnostics) const override {
    if (!ended.was_true(key + " timed out")) return;
    if (ended.value<net::Boolean>(key + " held")) {
      diagnostics.error(Code::kTimeout, pointer + "/until",
                        fmt::format("the condition did not hold within {:g} s", request.timeout.value_or(0.0)),
                        "a longer \"timeout_s\"");
    } else {
      diagnostics.error(Code::kSensorSilent, pointer + "/until", "a sensor of the condition did not answer",
                        "check its power and its wiring");
    }
  }
};

}  // namespace

std::unique_ptr<CommandRequest> read_grip_command(const Json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics) {
  auto command = std::make_unique<GripperCommand>();
  ObjectReader reader(json, pointer, diagnostics);
  command->request = read_grip(reader, cell);
  return command;
}

std::unique_ptr<CommandRequest> read_release_command(const Json& json, const std::string& pointer,
                                                     const command::Cell& cell, Diagnostics& diagnostics) {
  auto command = std::make_unique<GripperCommand>();
  ObjectReader reader(json, pointer, diagnostics);
  command->request = read_release(reader, cell);
  return command;
}

std::unique_ptr<CommandRequest> read_set_command(const Json& json, const std::string& pointer,
                                                 const command::Cell& cell, Diagnostics& diagnostics) {
  auto command = std::make_unique<OutputCommand>();
  ObjectReader reader(json, pointer, diagnostics);
  command->request = read_set(reader, cell);
  return command;
}

std::unique_ptr<CommandRequest> read_wait_command(const Json& json, const std::string& pointer,
                                                  const command::Cell& cell, Diagnostics& diagnostics) {
  auto command = std::make_unique<TimeCommand>();
  ObjectReader reader(json, pointer, diagnostics);
  command->request = read_wait(reader, cell);
  return command;
}

}  // namespace takt::activity
