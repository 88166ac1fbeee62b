#include "core/operations/basic/run_net.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/net_activity.h"
#include "core/net/value_json.h"
#include "core/operations/table/rehearsed_net.h"
#include "core/operations/table/scheduled_run.h"

namespace takt::operations {
namespace {

std::int64_t cycles_in(double seconds, const activity::Context& context) {
  return static_cast<std::int64_t>(std::llround(seconds / to_seconds(context.core.period())));
}

/// Cancels the net when it is due, and shows the values of its monitors.
class NetStepRun final : public ScheduledRun {
 public:
  explicit NetStepRun(const NetParameters& parameters) : parameters_(parameters) {}

 private:
  [[nodiscard]] activity::ActivityPtr activity(activity::Context& context) override {
    const std::int64_t start = context.core.cycle() + context.program_latency_cycles;
    if (parameters_.cancel_after) cancel_cycle_ = start + cycles_in(*parameters_.cancel_after, context);
    last_cycle_ = start + cycles_in(parameters_.within, context);
    return activity::net_activity(parameters_.net, context.cell.nets.find(parameters_.net)->second,
                                  context.core.environment());
  }

  Progress watch(activity::Context& context, Diagnostics& diagnostics) override {
    const std::int64_t cycle = context.core.cycle();
    if (cycle >= cancel_cycle_) run()->cancel();
    if (parameters_.monitor_rate && run()->started() && is_due(*parameters_.monitor_rate, context))
      show_monitors(context);
    if (cycle < last_cycle_) return Progress::kRunning;
    run()->abort();
    diagnostics.error(Code::kTimeout, "/within_s",
                      fmt::format("the net '{}' still runs after {:g} s", parameters_.net, parameters_.within),
                      "Give it more time, or a net that ends");
    return Progress::kFailed;
  }

  void ended(activity::Context& context) override { show_monitors(context); }

  void show_monitors(activity::Context& context) const {
    const rcc::NetHandle net = run()->compiled_net();
    if (net == nullptr) return;
    for (const auto& monitor : net->monitors()) {
      const std::string text = net::slot_to_json(monitor.type, monitor.slot).dump();
      context.variables.monitors[parameters_.net][monitor.name] = text;
      context.event(parameters_.net, monitor.name, text);
    }
  }

  const NetParameters& parameters_;
  std::int64_t cancel_cycle_ = std::numeric_limits<std::int64_t>::max();
  std::int64_t last_cycle_ = 0;
};

class NetStep final : public Step {
 public:
  explicit NetStep(NetParameters parameters) : parameters_(std::move(parameters)) {}

  /// Where a net leaves its devices is not known before it runs: the rehearsal goes on from where arms were.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearse_net(*rehearsal.cell.nets.find(parameters_.net)->second, rehearsal, pointer + "/net", diagnostics);
    // It may have changed control modes where START can do that.
    std::erase_if(rehearsal.modes, [&](const auto& known) {
      const auto& changes = rehearsal.cell.arms.find(known.first)->second.device->description().modes.changes;
      return std::ranges::any_of(changes,
                                 [](const auto& change) { return change.change != device::ChangeClass::kOutsideNet; });
    });
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<NetStepRun>(parameters_); }

 private:
  NetParameters parameters_;
};

}  // namespace

const ParameterTable<NetParameters>& net_parameters() {
  static const auto table = [] {
    constexpr Range kTime{.low = 0.0, .high = 3600.0};
    ParameterTable<NetParameters> net;
    net.name("net", NameOf::kNet, &NetParameters::net, "Net of the cell that runs.")
        .required()
        .number("cancel_after_s", "s", &NetParameters::cancel_after, kTime, "The net is cancelled after this time.")
        .number("monitor_rate_Hz", "Hz", &NetParameters::monitor_rate, {.low = 0.0, .high = 1000.0, .low_open = true},
                "How often its monitors are shown while it runs; they are at its end in any case.")
        .number("within_s", "s", &NetParameters::within, kTime, "The step fails if the net has not ended by then.");
    return net;
  }();
  return table;
}

Operation net_operation() {
  return {.name = "net",
          .doc = "Runs a net of the cell to its end.",
          .parameters = rows_of<net_parameters>,
          .read_step = read_step<NetStep, net_parameters>};
}

}  // namespace takt::operations
