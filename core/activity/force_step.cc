#include "core/activity/force_step.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/force_request.h"
#include "core/activity/goal.h"
#include "core/activity/net_run.h"
#include "core/activity/touch.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

class ForceRun final : public OneNetRun {
 public:
  explicit ForceRun(const ForceRequest& request) : request_(request) {}

 private:
  Progress begin(Context& context, Findings& findings) override {
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    const JointVector& q = arm.device->set_point().q;
    if (q.size() == 0) return Progress::kRunning;
    const auto prepared = prepare_press(request_, context.cell, q);
    if (!prepared) {
      findings.append(prepared.error());
      return Progress::kFailed;
    }
    return load(context, command::press_net(prepared->command, context.cell, context.variables.biases), findings);
  }

  Progress finish(Context& context, Findings& findings) override {
    using namespace command::press_ports;
    const bool found = was_true(kHeld) || was_true(kFound) || was_true(kUntil);
    // Where the tool stands pressed counts as the touch of this arm.
    const command::MountedArm& arm = context.cell.arms.find(request_.arm)->second;
    const bool touched = found || was_true(kTouched);
    if (touched) findings.append(note_touch(context, request_.arm, tool_pose(arm, arm.device->sample().q)));
    if (found) return findings.has_errors() ? Progress::kFailed : Progress::kDone;
    if (was_true(kSilent)) {
      findings.error("/sensor", fmt::format("'{}' did not answer, so the arm stopped", request_.sensor),
                     "its power and its wires");
    } else if (was_true(kTooFar)) {
      findings.error("/travel_m", was_true(kTouched) ? "the travel was used up after the touch" : "nothing was touched",
                     "a longer travel, another beginning or direction");
    } else if (request_.must_find) {
      findings.error({}, "the pattern has come to its end and nothing was found",
                     "a larger radius, a smaller pitch, or \"on_end\": \"continue\"");
    }
    return findings.has_errors() ? Progress::kFailed : Progress::kDone;
  }

  const ForceRequest& request_;
};

class ForceStep final : public Step {
 public:
  explicit ForceStep(ForceRequest request) : request_(std::move(request)) {}

  /// Where the surface is shows only in the run: the arm is taken to stay where it begins.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    rehearsal.touched[request_.arm] = true;
    const auto prepared = prepare_press(request_, rehearsal.cell, rehearsal.q[request_.arm]);
    if (!prepared) {
      findings.append(prepared.error(), pointer);
      return;
    }
    rehearsal.duration += request_.hold.value_or(0.0);
    if (prepared->path) rehearsal.duration += prepared->path->duration();
    rehearse_net(command::press_net(prepared->command, rehearsal.cell, {}), rehearsal, pointer, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<ForceRun>(request_); }

 private:
  ForceRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_press(const Json& json, const std::string& pointer, const command::Cell& cell,
                                  Findings& findings) {
  constexpr double kHold_s = 0.5;
  ObjectReader reader(json, pointer, findings);
  ForceRequest request = read_press(reader, cell, kHold_s);
  reader.finish();
  return std::make_unique<ForceStep>(std::move(request));
}

std::unique_ptr<Step> parse_search(const Json& json, const std::string& pointer, const command::Cell& cell,
                                   Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  ForceRequest request = read_search(reader, cell);
  reader.finish();
  return std::make_unique<ForceStep>(std::move(request));
}

}  // namespace takt::activity
