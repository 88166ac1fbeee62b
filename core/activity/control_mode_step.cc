#include "core/activity/control_mode_step.h"

#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/activity/mode_change.h"
#include "core/activity/scheduled_run.h"
#include "core/base/object_reader.h"
#include "core/base/read_parts.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

struct ModeRequest {
  std::string arm;
  device::ControlMode mode = device::ControlMode::kPosition;
};

class ControlModeRun final : public ScheduledRun {
 public:
  explicit ControlModeRun(const ModeRequest& request) : request_(request) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context&) override { return mode_activity(request_.arm, request_.mode); }

  const ModeRequest& request_;
};

class ControlModeStep final : public Step {
 public:
  explicit ControlModeStep(ModeRequest request) : request_(std::move(request)) {}

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    const device::Arm* arm = rehearsal.cell.arms.at(request_.arm).device;
    if (arm == nullptr) return;  // only names are known
    const auto is = rehearsal.modes.find(request_.arm);
    findings.append(check_mode_change(*arm, is != rehearsal.modes.end() ? is->second : request_.mode, request_.mode),
                    pointer);
    rehearsal.modes[request_.arm] = request_.mode;
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<ControlModeRun>(request_); }

 private:
  ModeRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_control_mode(const Json& json, const std::string& pointer, const command::Cell& cell,
                                         Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  (void)reader.text("do");
  (void)read_name(reader, "");
  std::vector<std::string> arms, modes;
  for (const auto& [name, arm] : cell.arms) arms.push_back(name);
  for (const device::ControlMode mode : device::all_control_modes()) modes.emplace_back(name_of(mode));
  ModeRequest request;
  request.arm = reader.choice("arm", arms, arms.size() == 1 ? std::optional(arms.front()) : std::nullopt);
  const auto mode = device::control_mode_of(reader.choice("mode", modes));
  reader.finish();
  request.mode = mode.value_or(device::ControlMode::kPosition);  // with a finding: such a program is never run
  return std::make_unique<ControlModeStep>(std::move(request));
}

}  // namespace takt::activity
