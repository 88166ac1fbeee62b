#include "core/operations/grip_step.h"

#include <nlohmann/json.hpp>

#include "core/activity/command_activity.h"
#include "core/operations/grip_request.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

command::RuntimeCommand gripping(const GripRequest& request, const command::Cell& cell) {
  const auto& gripper = cell.grippers.find(request.gripper)->second.device->description();
  return command::grip_command(command_of(request, gripper), cell);
}

class GripRun final : public ScheduledRun {
 public:
  explicit GripRun(const GripRequest& request) : request_(request) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context&) override {
    return command_activity(
        "grip " + request_.gripper, {request_.gripper},
        [request = request_](const PlanningContext& planning) { return gripping(request, planning.cell); });
  }

  Progress finish(Context& context, Diagnostics& diagnostics) override {
    if (cancelled()) return Progress::kDone;
    const std::string& arm = context.cell.grippers.find(request_.gripper)->second.arm;
    const GripOutcome outcome{.holding = run()->value<net::Boolean>(command::observed::kHolding),
                              .width = run()->value<net::Real>(command::observed::kWidth),
                              .q = context.cell.arms.find(arm)->second.device->set_point().q};
    return note_grip(request_, outcome, context, diagnostics);
  }

  const GripRequest& request_;
};

class GripStep final : public Step {
 public:
  explicit GripStep(GripRequest request) : request_(std::move(request)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const auto& gripper = rehearsal.cell.grippers.find(request_.gripper)->second.device->description();
    if (!check_figures(request_, gripper, pointer, diagnostics)) return;
    rehearse_command(gripping(request_, rehearsal.cell), "grip " + request_.gripper, rehearsal, pointer, diagnostics);
    rehearse_grip(request_, rehearsal, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<GripRun>(request_); }

 private:
  GripRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_grip(const Json& json, const std::string& pointer, const command::Cell& cell,
                                 Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  GripRequest request = read_grip(reader, cell);
  return std::make_unique<GripStep>(std::move(request));
}

std::unique_ptr<Step> parse_release(const Json& json, const std::string& pointer, const command::Cell& cell,
                                    Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  GripRequest request = read_release(reader, cell);
  return std::make_unique<GripStep>(std::move(request));
}

}  // namespace takt::activity
