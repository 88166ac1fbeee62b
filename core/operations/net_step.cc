#include "core/operations/net_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/net_activity.h"
#include "core/base/object_reader.h"
#include "core/base/read_parts.h"
#include "core/net/value_json.h"
#include "core/operations/parameter_table.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

struct NetRequest : OperationHead {
  std::string net;
  std::optional<double> cancel_after_s;
  double within_s = 60.0;
};

std::int64_t cycles_in(double seconds, const Context& context) {
  return static_cast<std::int64_t>(std::llround(seconds / to_seconds(context.core.period())));
}

/// Cancels the net when it is due, and keeps the last values of its monitors.
class NetStepRun final : public ScheduledRun {
 public:
  explicit NetStepRun(const NetRequest& request) : request_(request) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    const std::int64_t start = context.core.cycle() + context.program_latency_cycles;
    if (request_.cancel_after_s) cancel_cycle_ = start + cycles_in(*request_.cancel_after_s, context);
    last_cycle_ = start + cycles_in(request_.within_s, context);
    return net_activity(request_.net, context.cell.nets.find(request_.net)->second, context.core.environment());
  }

  Progress watch(Context& context, Diagnostics& diagnostics) override {
    const std::int64_t cycle = context.core.cycle();
    if (cycle >= cancel_cycle_) run()->cancel();
    if (cycle < last_cycle_) return Progress::kRunning;
    run()->abort();
    diagnostics.error(Code::kTimeout, "/within_s",
                      fmt::format("the net '{}' still runs after {:g} s", request_.net, request_.within_s),
                      "a longer time, or a net that ends");
    return Progress::kFailed;
  }

  void ended(Context& context) override {
    const rcc::NetHandle net = run()->compiled_net();
    if (net == nullptr) return;
    for (const auto& monitor : net->monitors()) {
      const std::string text = net::slot_to_json(monitor.type, monitor.slot).dump();
      context.variables.monitors[request_.net][monitor.name] = text;
      context.event(request_.net, monitor.name, text);
    }
  }

  const NetRequest& request_;
  std::int64_t cancel_cycle_ = std::numeric_limits<std::int64_t>::max();
  std::int64_t last_cycle_ = 0;
};

class NetStep final : public Step {
 public:
  explicit NetStep(NetRequest request) : request_(std::move(request)) {}

  /// Where a net leaves its devices is not known before it runs: arms are taken to stay where they were.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearse_net(*rehearsal.cell.nets.find(request_.net)->second, rehearsal, pointer + "/net", diagnostics);
    // It may have changed control modes where START can do that.
    std::erase_if(rehearsal.modes, [&](const auto& known) {
      const auto& changes = rehearsal.cell.arms.find(known.first)->second.device->description().modes.changes;
      return std::ranges::any_of(changes,
                                 [](const auto& change) { return change.change != device::ChangeClass::kOutsideNet; });
    });
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<NetStepRun>(request_); }

 private:
  NetRequest request_;
};

const ParameterTable<NetRequest>& net_parameters() {
  static const auto table = [] {
    constexpr Range kTime{.low = 0.0, .high = 3600.0};
    ParameterTable<NetRequest> net;
    net.name("net", NameOf::kNet, &NetRequest::net, "Net of the cell that runs.")
        .required()
        .number("cancel_after_s", "s", &NetRequest::cancel_after_s, kTime, "The net is cancelled after this time.")
        .number("within_s", "s", &NetRequest::within_s, kTime, "The step fails if the net has not ended by then.");
    return net;
  }();
  return table;
}

}  // namespace

const std::vector<ParameterInfo>& net_parameter_list() { return net_parameters().list(); }

std::unique_ptr<Step> parse_net_step(const Json& json, const std::string& pointer, const command::Cell& cell,
                                     Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<NetStep>(net_parameters().read(reader, cell));
}

}  // namespace takt::activity
