#include "core/operations/force_step.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "core/activity/dual_entry_motion.h"
#include "core/command/single_net.h"
#include "core/operations/press_command.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

/// From rest, to nobody knows where.
class PressActivity final : public ActivityModel {
 public:
  PressActivity(const ForceRequest& request, command::Biases biases)
      : ActivityModel(request.name), request_(request), biases_(std::move(biases)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return {request_.arm}; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext& planning) const override {
    const command::Cell& cell = planning.cell;
    const kinematics::JointVector& q = *planning.predecessors.find(request_.arm)->second.at_end.q;
    if (request_.compliance) {
      Diagnostics wrong = check_compliance(*request_.compliance, cell, actuators());
      if (wrong.has_errors()) return std::unexpected(std::move(wrong));
    }
    const auto pressing = prepare_press(request_, cell, q);
    if (!pressing) return std::unexpected(pressing.error());
    PlannedActivity prepared;
    prepared.command = command_of(request_, *pressing, cell, biases_);
    prepared.end_states[request_.arm] = {};
    prepared.begins[request_.arm].push_back(seam_at_rest(q));
    return prepared;
  }

  [[nodiscard]] static command::RuntimeCommand command_of(const ForceRequest& request, const PreparedPress& pressing,
                                                          const command::Cell& cell, const command::Biases& biases) {
    const command::Action action = press_action(request, pressing, cell, biases);
    return pressing_command(request, request.name, action, cell, biases, {}).command;
  }

 private:
  ForceRequest request_;
  command::Biases biases_;
};

class ForceRun final : public ScheduledRun {
 public:
  explicit ForceRun(const ForceRequest& request) : request_(request) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    return std::make_shared<const PressActivity>(request_, context.variables.biases);
  }

  Progress finish(Context& context, Diagnostics& diagnostics) override {
    const auto kept = [this](const std::string& what) { return run()->value<net::Frame>(what); };
    const Diagnostics failed = end_pressing(request_, kept, {}, cancelled(), context);
    diagnostics.append(failed);
    return failed.has_errors() ? Progress::kFailed : Progress::kDone;
  }

  const ForceRequest& request_;
};

class ForceStep final : public Step {
 public:
  explicit ForceStep(ForceRequest request) : request_(std::move(request)) {}

  /// Where the surface is shows only in the run: the arm is taken to stay where it begins.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearsal.touched[request_.arm] = true;
    if (request_.compliance &&
        !rehearse_compliance(*request_.compliance, rehearsal, {request_.arm}, pointer, diagnostics))
      return;
    const auto prepared = prepare_press(request_, rehearsal.cell, rehearsal.q[request_.arm]);
    if (!prepared) {
      diagnostics.append(prepared.error(), pointer);
      return;
    }
    rehearsal.duration += request_.hold.value_or(0.0);
    if (prepared->wish.path) rehearsal.duration += prepared->wish.path->duration();
    const auto command = PressActivity::command_of(request_, *prepared, rehearsal.cell, {});
    const auto mapped = command::single_net(command, request_.name);
    if (!mapped) return diagnostics.append(mapped.error(), pointer);
    rehearse_net(mapped->net, rehearsal, pointer, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<ForceRun>(request_); }

 private:
  ForceRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_press(const Json& json, const std::string& pointer, const command::Cell& cell,
                                  Diagnostics& diagnostics) {
  constexpr double kHold_s = 0.5;
  ObjectReader reader(json, pointer, diagnostics);
  ForceRequest request = read_press(reader, cell, kHold_s);
  return std::make_unique<ForceStep>(std::move(request));
}

std::unique_ptr<Step> parse_search(const Json& json, const std::string& pointer, const command::Cell& cell,
                                   Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  ForceRequest request = read_search(reader, cell);
  return std::make_unique<ForceStep>(std::move(request));
}

}  // namespace takt::activity
