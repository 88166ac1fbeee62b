#include "core/operations/grip_step.h"

#include <nlohmann/json.hpp>

#include "core/operations/grip_request.h"
#include "core/operations/net_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

class GripRun final : public OneNetRun {
 public:
  explicit GripRun(const GripRequest& request) : request_(request) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    const auto& gripper = context.cell.grippers.find(request_.gripper)->second.device->description();
    const auto net = command::grip_net(command_of(request_, gripper), context.cell);
    if (net) return load(context, *net, findings);
    findings.append(net.error());
    return Progress::kFailed;
  }

  Progress finish(Context& context, Findings& findings) override {
    const std::string& arm = context.cell.grippers.find(request_.gripper)->second.arm;
    const GripOutcome outcome{.holding = value_of<net::Boolean>(command::grip_ports::kHolding),
                              .width = value_of<net::Real>(command::grip_ports::kWidth),
                              .q = context.cell.arms.find(arm)->second.device->set_point().q};
    return note_grip(request_, outcome, context, findings);
  }

  const GripRequest& request_;
};

class GripStep final : public Step {
 public:
  explicit GripStep(GripRequest request) : request_(std::move(request)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    const auto& gripper = rehearsal.cell.grippers.find(request_.gripper)->second.device->description();
    if (!check_figures(request_, gripper, pointer, findings)) return;
    const auto net = command::grip_net(command_of(request_, gripper), rehearsal.cell);
    if (!net) return findings.append(net.error(), pointer);
    rehearse_net(*net, rehearsal, pointer, findings);
    rehearse_grip(request_, rehearsal, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<GripRun>(request_); }

 private:
  GripRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_grip(const Json& json, const std::string& pointer, const command::Cell& cell,
                                 Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  GripRequest request = read_grip(reader, cell);
  return std::make_unique<GripStep>(std::move(request));
}

std::unique_ptr<Step> parse_release(const Json& json, const std::string& pointer, const command::Cell& cell,
                                    Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  GripRequest request = read_release(reader, cell);
  return std::make_unique<GripStep>(std::move(request));
}

}  // namespace takt::activity
