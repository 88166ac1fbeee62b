#include "core/operations/freedrive_step.h"

#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/activity/freedrive_activity.h"
#include "core/base/object_reader.h"
#include "core/expression/condition_state.h"
#include "core/operations/parameter_table.h"
#include "core/operations/rehearsed_net.h"
#include "core/operations/scheduled_run.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

struct FreedriveRequest : OperationHead {
  std::string arm;
  std::optional<command::Condition> enabled, until;
  std::optional<double> seconds;
  command::FreedriveWish wish;
};

const ParameterTable<FreedriveRequest>& freedrive_parameters() {
  static const auto table = [] {
    ParameterTable<FreedriveRequest> freedrive;
    freedrive.name("arm", NameOf::kArm, &FreedriveRequest::arm, "Arm that a person guides.")
        .condition("enabled", &FreedriveRequest::enabled, "Dead-man switch: the arm yields only while this is true.")
        .condition("until", &FreedriveRequest::until, "Ends when this becomes true.")
        .number("seconds", "s", &FreedriveRequest::seconds, {.low = 0.0, .high = 3600.0}, "Ends after this time.")
        .number(
            "velocity_m_s", "m/s", [](FreedriveRequest & p) -> auto& { return p.wish.linear_max; },
            {.low = 0.0, .high = 1.0, .low_open = true}, "Largest speed of the tool.")
        .number(
            "turn_deg_s", "deg/s", [](FreedriveRequest & p) -> auto& { return p.wish.angular_max; },
            {.low = 0.0, .high = 180.0, .low_open = true}, "Largest angular speed of the tool.")
        .rule([](FreedriveRequest&, const ReadContext& from) {
          if (from.reader.has("until") || from.reader.has("seconds")) return;
          from.reader.diagnostics().error(Code::kMissing, from.reader.pointer(), "no end condition is given",
                                          "'until' or 'seconds'");
        });
    return freedrive;
  }();
  return table;
}

/// What the request says, with the sensors of a cell.
struct Guiding {
  Guiding(const FreedriveRequest& request, const command::Cell& cell, const command::Biases& biases)
      : wish(request.wish), end{.until = {}, .seconds = request.seconds} {
    if (request.enabled) wish.enabled = command::state_of(*request.enabled, cell, biases);
    if (request.until) end.until = command::state_of(*request.until, cell, biases);
  }
  command::FreedriveWish wish;
  FreedriveEnd end;
};

class FreedriveRun final : public ScheduledRun {
 public:
  explicit FreedriveRun(const FreedriveRequest& request) : request_(request) {}

 private:
  [[nodiscard]] ActivityPtr activity(Context& context) override {
    const command::Biases& biases = context.variables.biases;
    const Guiding guiding(request_, context.cell, biases);
    return freedrive_activity(context.cell, request_.arm, guiding.wish, guiding.end, biases);
  }
  /// The control mode, and what the activity is made of, are not among the keys of this step.
  [[nodiscard]] std::string location_of(std::string) const override { return {}; }

  const FreedriveRequest& request_;
};

class FreedriveStep final : public Step {
 public:
  explicit FreedriveStep(FreedriveRequest request) : request_(std::move(request)) {}

  /// Where a hand leads the arm shows only in the run: it is taken to stay.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Diagnostics& diagnostics) const override {
    rehearsal.touched[request_.arm] = false;
    rehearsal.duration += request_.seconds.value_or(0.0);
    if (rehearsal.cell.arms.at(request_.arm).device == nullptr) return;  // only names are known
    const Guiding guiding(request_, rehearsal.cell, {});
    const auto mapped = command::map(freedrive_command(rehearsal.cell, request_.arm, guiding.wish, guiding.end, {}));
    if (!mapped) {
      for (const Diagnostic& one : mapped.error().list()) diagnostics.error(one.code, pointer, one.message, one.hint);
      return;
    }
    rehearse_net(mapped->net, rehearsal, pointer, diagnostics);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<FreedriveRun>(request_); }

 private:
  FreedriveRequest request_;
};

}  // namespace

const std::vector<ParameterInfo>& freedrive_parameter_list() { return freedrive_parameters().list(); }

std::unique_ptr<Step> parse_freedrive(const Json& json, const std::string& pointer, const command::Cell& cell,
                                      Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  return std::make_unique<FreedriveStep>(freedrive_parameters().read(reader, cell));
}

}  // namespace takt::activity
