#include "core/operations/force/tare.h"

#include <utility>

#include <fmt/format.h>

#include "core/activity/command_activity.h"
#include "core/command/actions/device_commands.h"
#include "core/command/actions/tare.h"
#include "core/operations/table/rehearsed_net.h"
#include "core/operations/table/scheduled_run.h"

namespace takt::operations {
namespace {

class TareRun final : public ScheduledRun {
 public:
  TareRun(std::string sensor, std::int64_t cycles) : sensor_(std::move(sensor)), cycles_(cycles) {}

 private:
  [[nodiscard]] activity::ActivityPtr activity(activity::Context&) override {
    return activity::command_activity("tare " + sensor_, {},
                                      [sensor = sensor_, cycles = cycles_](const activity::PlanningContext& planning) {
                                        return command::tare_command(sensor, cycles, planning.cell);
                                      });
  }

  Progress finish(activity::Context& context, Diagnostics& diagnostics) override {
    if (cancelled()) return Progress::kDone;
    const auto bias = run()->value<net::Wrench>(command::observed::kBias);
    if (!bias) {
      diagnostics.error(Code::kSensorSilent, "/sensor", fmt::format("'{}' did not answer while it was tared", sensor_),
                        "Check its power and its wiring; \"try\" with \"retry\" tares again");
      return Progress::kFailed;
    }
    context.variables.biases[sensor_] = *bias;
    return Progress::kDone;
  }

  std::string sensor_;
  std::int64_t cycles_;
};

class TareStep final : public Step {
 public:
  explicit TareStep(const TareParameters& tare) : sensor_(tare.sensor), cycles_(tare.cycles) {}
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearsal.duration += 1e-3 * static_cast<double>(cycles_);
    const auto command = command::tare_command(sensor_, cycles_, rehearsal.cell);
    rehearse_command(command, "tare " + sensor_, rehearsal, pointer, diagnostics);
  }
  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<TareRun>(sensor_, cycles_); }

 private:
  std::string sensor_;
  std::int64_t cycles_;
};

}  // namespace

const ParameterTable<TareParameters>& tare_parameters() {
  static const auto table = [] {
    ParameterTable<TareParameters> tare;
    tare.name("sensor", NameOf::kSensor, &TareParameters::sensor, "Force/torque sensor, at rest and without contact.")
        .integer("cycles", &TareParameters::cycles, {.low = 1, .high = 100'000}, "Samples that are averaged.");
    return tare;
  }();
  return table;
}

Operation tare_operation() {
  return {.name = "tare",
          .doc = "Averages a force/torque sensor at rest and removes that offset from its later readings.",
          .parameters = rows_of<tare_parameters>,
          .read_step = read_step<TareStep, tare_parameters>};
}

}  // namespace takt::operations
