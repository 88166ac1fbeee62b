#include "core/operations/signal_step.h"

#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/command_activity.h"
#include "core/operations/command_step.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"
#include "core/operations/signal_request.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

// -- set -----------------------------------------------------------------------------------------------------------

class SetRun final : public ScheduledRun {
 public:
  explicit SetRun(const SetRequest& request) : request_(request) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context&) override {
    return command_activity("set " + request_.output, {request_.output},
                            [request = request_](const PlanningContext& planning) {
                              return command::set_command(request.output, request.value, planning.cell);
                            });
  }

  const SetRequest& request_;
};

class SetStep final : public Step {
 public:
  explicit SetStep(SetRequest request) : request_(std::move(request)) {}
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    if (!check_range(request_, rehearsal.cell, pointer, diagnostics)) return;
    // The form of the net does not depend on the period.
    const auto command = command::set_command(request_.output, request_.value, rehearsal.cell);
    rehearse_command(command, "set " + request_.output, rehearsal, pointer, diagnostics);
  }
  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<SetRun>(request_); }

 private:
  SetRequest request_;
};

// -- wait ----------------------------------------------------------------------------------------------------------

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
  explicit WaitRun(const WaitRequest& request) : request_(request) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    const auto make = [request = request_, biases = context.variables.biases](const PlanningContext& planning) {
      return command::wait_command(*request.until, request.timeout, planning.cell, biases);
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
                        fmt::format("the condition did not hold within {:g} s", request_.timeout.value_or(0.0)),
                        "a longer \"timeout_s\", or \"try\" around it");
    }
    return Progress::kFailed;
  }

  const WaitRequest& request_;
};

class WaitStep final : public Step {
 public:
  explicit WaitStep(WaitRequest request) : request_(std::move(request)) {}
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const auto command = command::wait_command(*request_.until, request_.timeout, rehearsal.cell, {});
    rehearse_command(command, "wait", rehearsal, pointer, diagnostics);
  }
  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<WaitRun>(request_); }

 private:
  WaitRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_set(const Json& json, const std::string& pointer, const command::Cell& cell,
                                Diagnostics& diagnostics) {
  if (sets_by_following(json)) return parse_command_step(json, pointer, cell, diagnostics);
  ObjectReader reader(json, pointer, diagnostics);
  SetRequest request = read_set(reader, cell);
  return std::make_unique<SetStep>(std::move(request));
}

std::unique_ptr<Step> parse_wait(const Json& json, const std::string& pointer, const command::Cell& cell,
                                 Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  WaitRequest request = read_wait(reader, cell);
  if (request.until) return std::make_unique<WaitStep>(std::move(request));
  return std::make_unique<PauseStep>(request.seconds.value_or(0.0));
}

}  // namespace takt::activity
