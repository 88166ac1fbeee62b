#include "core/activity/signal_step.h"

#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/net_run.h"
#include "core/base/object_reader.h"
#include "core/command/device_net.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

// -- set -----------------------------------------------------------------------------------------------------------

struct SetRequest {
  std::string output;
  command::SignalValue value = false;
};

class SetRun final : public OneNetRun {
 public:
  explicit SetRun(const SetRequest& request) : request_(request) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    const double period = to_seconds(context.core.period());
    return load(context, command::set_net(request_.output, request_.value, context.cell, period), findings);
  }

  const SetRequest& request_;
};

class SetStep final : public Step {
 public:
  explicit SetStep(SetRequest request) : request_(std::move(request)) {}
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    if (const double* value = std::get_if<double>(&request_.value)) {
      const auto& output = rehearsal.cell.analog_outputs.find(request_.output)->second->description();
      if (*value < output.lower || *value > output.upper) {
        return findings.error(pointer + "/value",
                              fmt::format("{:g} {} is not for '{}'", *value, output.unit, request_.output),
                              fmt::format("{:g} to {:g} {}", output.lower, output.upper, output.unit));
      }
    }
    // The form of the net does not depend on the period.
    rehearse_net(command::set_net(request_.output, request_.value, rehearsal.cell, to_seconds(kMillisecond)), rehearsal,
                 pointer, findings);
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
  void rehearse(Rehearsal& rehearsal, const std::string&, Findings&) const override { rehearsal.duration += seconds_; }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override {
    class Run final : public StepRun {
     public:
      explicit Run(double seconds) : seconds_(seconds) {}
      Progress advance(Context& context, Findings&) override {
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

struct WaitRequest {
  command::Condition until;
  std::optional<double> timeout;
};

class WaitRun final : public OneNetRun {
 public:
  explicit WaitRun(const WaitRequest& request) : request_(request) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    const auto wait = command::wait_net(request_.until, request_.timeout, context.cell, context.variables.biases);
    condition_port_ = wait.condition_port;
    return load(context, wait.net, findings);
  }

  Progress finish(Context&, Findings& findings) override {
    const auto held = value_of<net::Boolean>(condition_port_);
    if (held && *held) return Progress::kDone;
    if (!held) {
      findings.error("/until", "a sensor of the condition did not answer", "its power and its wires");
    } else {
      findings.error("/until", fmt::format("the condition did not hold within {:g} s", request_.timeout.value_or(0.0)),
                     "a longer \"timeout_s\", or \"try\" around it");
    }
    return Progress::kFailed;
  }

  const WaitRequest& request_;
  std::string condition_port_;
};

class WaitStep final : public Step {
 public:
  explicit WaitStep(WaitRequest request) : request_(std::move(request)) {}
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    rehearse_net(command::wait_net(request_.until, request_.timeout, rehearsal.cell, {}).net, rehearsal, pointer,
                 findings);
  }
  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<WaitRun>(request_); }

 private:
  WaitRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_set(const Json& json, const std::string& pointer, const command::Cell& cell,
                                Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  (void)reader.text("do");
  (void)reader.text("name", "");
  std::vector<std::string> names;
  for (const auto& [name, output] : cell.digital_outputs) names.push_back(name);
  for (const auto& [name, output] : cell.analog_outputs) names.push_back(name);
  SetRequest request;
  request.output = reader.choice("output", names, names.size() == 1 ? std::optional(names.front()) : std::nullopt);
  if (cell.analog_outputs.contains(request.output)) {
    request.value = reader.number("value");
  } else if (cell.digital_outputs.contains(request.output)) {
    request.value = reader.boolean("value");
  } else {
    (void)reader.child("value");
  }
  reader.finish();
  return std::make_unique<SetStep>(std::move(request));
}

std::unique_ptr<Step> parse_wait(const Json& json, const std::string& pointer, const command::Cell& cell,
                                 Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  (void)reader.text("do");
  (void)reader.text("name", "");
  const Json* until = reader.object("until", false);
  if (!until) {
    const double seconds = reader.number("seconds", {}, {.low = 0, .high = 3600});
    reader.finish();
    return std::make_unique<PauseStep>(seconds);
  }
  WaitRequest request;
  auto condition = command::parse_condition(*until, reader.at("until"), cell);
  if (condition) {
    request.until = std::move(*condition);
  } else {
    findings.append(condition.error());
  }
  if (reader.has("timeout_s")) request.timeout = reader.number("timeout_s", {}, {.low = 0, .high = 3600});
  reader.finish();
  return std::make_unique<WaitStep>(std::move(request));
}

}  // namespace takt::activity
