#include "core/operations/wait.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/activity/command_activity.h"
#include "core/command/actions/device_commands.h"
#include "core/operations/operation_command.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

using command::BooleanSensor;

constexpr Range kWaitingTime{.low = 0, .high = 3600};

void check_wait(WaitParameters& parameters, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  const bool until = reader.has("until");
  if (until && parameters.seconds)
    reader.diagnostics().error(Code::kConflict, reader.at("seconds"), "both a time and a condition are given",
                               "'timeout_s' for the longest wait");
  if (!until && parameters.timeout)
    reader.diagnostics().error(Code::kConflict, reader.at("timeout_s"), "a timeout without a condition",
                               "'until', or 'seconds' alone");
  if (!until && !reader.has("seconds"))
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "neither a duration nor a condition is given",
                               "'seconds' or 'until'");
}

// -- As a step ----

/// Lets `seconds` pass without a net.
class PauseStep final : public Step {
 public:
  explicit PauseStep(double seconds) : seconds_(seconds) {}
  void rehearse(Rehearsal& rehearsal, const std::string&, Diagnostics&) const override {
    rehearsal.duration += seconds_;
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    class Run final : public StepRun {
     public:
      explicit Run(double seconds) : seconds_(seconds) {}
      Progress advance(Context& context, Diagnostics&) override {
        const auto period = static_cast<double>(context.core.period());
        if (end_ < 0) end_ = context.core.cycle() + static_cast<std::int64_t>(std::llround(seconds_ * 1e9 / period));
        return cancelled_ || context.core.cycle() >= end_ ? Progress::kDone : Progress::kRunning;
      }
      void cancel(Context&) override { cancelled_ = true; }

     private:
      double seconds_;
      std::int64_t end_ = -1;
      bool cancelled_ = false;
    };
    return std::make_unique<Run>(seconds_);
  }

 private:
  double seconds_;
};

class WaitRun final : public ScheduledRun {
 public:
  explicit WaitRun(const WaitParameters& parameters) : parameters_(parameters) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    const auto make = [parameters = parameters_, biases = context.variables.biases](const PlanningContext& planning) {
      return command::wait_command(*parameters.until, parameters.timeout, planning.cell, biases);
    };
    return command_activity("wait", {}, make);
  }

  Progress finish(Context&, Diagnostics& diagnostics) override {
    if (cancelled()) return Progress::kDone;
    const auto held = run()->value<net::Boolean>(command::observed::kCondition);
    if (held && *held) return Progress::kDone;
    if (!held) {
      diagnostics.error(Code::kSensorSilent, "/until", "a sensor of the condition did not answer",
                        "check its power and its wiring");
    } else {
      diagnostics.error(Code::kTimeout, "/until",
                        fmt::format("the condition did not hold within {:g} s", parameters_.timeout.value_or(0.0)),
                        "a longer \"timeout_s\", or \"try\" around it");
    }
    return Progress::kFailed;
  }

  const WaitParameters& parameters_;
};

class WaitStep final : public Step {
 public:
  explicit WaitStep(WaitParameters parameters) : parameters_(std::move(parameters)) {}
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const auto command = command::wait_command(*parameters_.until, parameters_.timeout, rehearsal.cell, {});
    rehearse_command(command, "wait", rehearsal, pointer, diagnostics);
  }
  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<WaitRun>(parameters_); }

 private:
  WaitParameters parameters_;
};

// -- As a command ----

class TimeCommand final : public OperationCommand {
 public:
  explicit TimeCommand(WaitParameters parameters) : parameters_(std::move(parameters)) {}

  [[nodiscard]] MadeCommand make(const BuildContext& making, const std::string& key) const override {
    if (!parameters_.until) return {.command = command::WaitCommand(name, parameters_.seconds.value_or(0.0))};
    const command::State until = command::state_of(*parameters_.until, making.cell, making.biases);
    command::WaitCommand wait(name, until, parameters_.timeout);
    if (!parameters_.timeout) return {.command = wait};
    wait.observe(key + " timed out", BooleanSensor(wait.timed_out().node()));
    wait.capture(key + " held", BooleanSensor(until.node()), wait.timed_out());
    return {.command = wait};
  }

  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.duration += parameters_.seconds.value_or(0.0);
  }

  void finish(const ActivityRun& ended, const std::string& key, bool, Context&,
              Diagnostics& diagnostics) const override {
    if (!ended.was_true(key + " timed out")) return;
    if (ended.value<net::Boolean>(key + " held")) {
      diagnostics.error(Code::kTimeout, pointer + "/until",
                        fmt::format("the condition did not hold within {:g} s", parameters_.timeout.value_or(0.0)),
                        "a longer \"timeout_s\"");
    } else {
      diagnostics.error(Code::kSensorSilent, pointer + "/until", "a sensor of the condition did not answer",
                        "check its power and its wiring");
    }
  }

 private:
  WaitParameters parameters_;
};

std::unique_ptr<Step> read_wait_step(const OperationSource& source) {
  WaitParameters parameters = read_parameters<wait_parameters>(source);
  if (parameters.until) return std::make_unique<WaitStep>(std::move(parameters));
  return std::make_unique<PauseStep>(parameters.seconds.value_or(0.0));
}

/// For the schema: as a step of a program it waits for an expression, too.
const std::vector<ParameterInfo>& wait_rows() {
  static const auto rows = [] {
    std::vector<ParameterInfo> all = wait_parameters().list();
    std::ranges::find(all, "until", &ParameterInfo::key)->definition = "wait_condition";
    return all;
  }();
  return rows;
}

}  // namespace

const ParameterTable<WaitParameters>& wait_parameters() {
  static const auto table = [] {
    ParameterTable<WaitParameters> wait;
    wait.number("seconds", "s", &WaitParameters::seconds, kWaitingTime, "Time that passes.")
        .condition("until", &WaitParameters::until, "Waits until this becomes true.")
        .number("timeout_s", "s", &WaitParameters::timeout, kWaitingTime,
                "The step fails if 'until' is not true by then.")
        .rule(check_wait);
    return wait;
  }();
  return table;
}

Operation wait_operation() {
  return {.name = "wait",
          .doc = "Lets time pass, or waits until a condition becomes true.",
          .parameters = wait_rows,
          .read_step = read_wait_step,
          .read_command = read_command<TimeCommand, wait_parameters>};
}

}  // namespace takt::activity
