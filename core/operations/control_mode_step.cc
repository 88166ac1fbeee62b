#include "core/operations/control_mode_step.h"

#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/activity/mode_change.h"
#include "core/base/object_reader.h"
#include "core/operations/parameter_table.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

struct ModeRequest : OperationHead {
  std::string arm;
  device::ControlMode mode = device::ControlMode::kPosition;
};

const ParameterTable<ModeRequest>& control_mode_parameters() {
  static const auto table = [] {
    std::vector<std::pair<std::string, device::ControlMode>> modes;
    for (const device::ControlMode mode : device::all_control_modes()) modes.emplace_back(name_of(mode), mode);
    ParameterTable<ModeRequest> change;
    change.name("arm", NameOf::kArm, &ModeRequest::arm, "Arm whose mode changes; nothing may hold it.")
        .choice("mode", &ModeRequest::mode, modes, "The new control mode.")
        .required();
    return change;
  }();
  return table;
}

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

  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    const device::Arm* arm = rehearsal.cell.arms.at(request_.arm).device;
    if (arm == nullptr) return;  // only names are known
    const auto is = rehearsal.modes.find(request_.arm);
    diagnostics.append(check_mode_change(*arm, is != rehearsal.modes.end() ? is->second : request_.mode, request_.mode),
                       pointer);
    rehearsal.modes[request_.arm] = request_.mode;
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<ControlModeRun>(request_); }

 private:
  ModeRequest request_;
};

}  // namespace

const std::vector<ParameterInfo>& control_mode_parameter_list() { return control_mode_parameters().list(); }

std::unique_ptr<Step> parse_control_mode(const Json& json, const std::string& pointer, const command::Cell& cell,
                                         Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<ControlModeStep>(control_mode_parameters().read(reader, cell));
}

}  // namespace takt::activity
