#include "core/operations/basic/wait.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/activity/command_activity.h"
#include "core/operations/command/command_step.h"
#include "core/operations/command/operation_command.h"

namespace takt::operations {
namespace {

using expression::BooleanSensor;

constexpr Range kWaitingTime{.low = 0, .high = 3600};

void check_wait(WaitParameters& parameters, const ReadContext& from) {
  ObjectReader& reader = from.reader;
  const bool until = reader.has("until");
  if (until && parameters.seconds)
    reader.diagnostics().error(Code::kConflict, reader.at("seconds"), "both a time and a condition are given",
                               "Use 'timeout_s' for the longest wait");
  if (!until && parameters.timeout)
    reader.diagnostics().error(Code::kConflict, reader.at("timeout_s"), "a timeout without a condition",
                               "Give 'until', or 'seconds' alone");
  if (!until && !reader.has("seconds"))
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "neither a duration nor a condition is given",
                               "Give 'seconds' or 'until'");
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
      Progress advance(activity::Context& context, Diagnostics&) override {
        const auto period = static_cast<double>(context.core.period());
        if (end_ < 0) end_ = context.core.cycle() + static_cast<std::int64_t>(std::llround(seconds_ * 1e9 / period));
        return cancelled_ || context.core.cycle() >= end_ ? Progress::kDone : Progress::kRunning;
      }
      void cancel(activity::Context&) override { cancelled_ = true; }

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

// -- As a command -----------------------------------------------------------------------------------------------------

class TimeCommand final : public OperationCommand {
 public:
  explicit TimeCommand(WaitParameters parameters) : parameters_(std::move(parameters)) {}

  [[nodiscard]] MadeCommand make(const BuildContext& build, const std::string& key) const override {
    if (!parameters_.until) return {.command = command::WaitCommand(name, parameters_.seconds.value_or(0.0))};
    const expression::State until = expression::state_of(*parameters_.until, build.cell, build.biases);
    command::WaitCommand wait(name, until, parameters_.timeout);
    if (is_alone(build)) {
      // Nothing comes after it: what the condition is when it has ended is what counts.
      wait.observe(key + " held", BooleanSensor(until.node()));
    } else if (parameters_.timeout) {
      wait.observe(key + " timed out", BooleanSensor(wait.timed_out().node()));
      wait.capture(key + " held", BooleanSensor(until.node()), wait.timed_out());
    }
    return {.command = wait};
  }

  [[nodiscard]] bool is_called_by_type() const override { return true; }
  void rehearse(Rehearsal& rehearsal, Diagnostics&) const override {
    rehearsal.duration += parameters_.seconds.value_or(0.0);
  }

  void finish(const activity::RunView& ended, const std::string& key, bool cancelled, activity::Context&,
              Diagnostics& diagnostics) const override {
    const bool has_ended = is_alone(ended) ? !cancelled : ended.was_true(key + " timed out");
    if (!parameters_.until || !has_ended) return;
    diagnostics.append(
        activity::failure_of_wait(ended.value<net::Boolean>(key + " held"), parameters_.timeout.value_or(0.0)),
        pointer);
  }

 private:
  WaitParameters parameters_;
};

std::unique_ptr<Step> read_wait_step(const OperationSource& source) {
  if (source.json.contains("until")) return step_of_command(source);
  return std::make_unique<PauseStep>(read_parameters<wait_parameters>(source).seconds.value_or(0.0));
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

}  // namespace takt::operations
