#include "core/activity/freedrive_step.h"

#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/activity/freedrive_activity.h"
#include "core/activity/rehearsed_net.h"
#include "core/activity/scheduled_run.h"
#include "core/base/object_reader.h"
#include "core/command/condition_state.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

struct FreedriveRequest {
  std::string arm;
  std::optional<command::Condition> enabled, until;
  std::optional<double> seconds;
  command::FreedriveWish wish;
};

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
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    rehearsal.touched[request_.arm] = false;
    rehearsal.duration += request_.seconds.value_or(0.0);
    if (rehearsal.cell.arms.at(request_.arm).device == nullptr) return;  // only names are known
    const Guiding guiding(request_, rehearsal.cell, {});
    const auto mapped = command::map(freedrive_command(rehearsal.cell, request_.arm, guiding.wish, guiding.end, {}));
    if (!mapped) {
      for (const Finding& one : mapped.error().list()) findings.error(pointer, one.message, one.hint);
      return;
    }
    rehearse_net(mapped->net, rehearsal, pointer, findings);
  }

  [[nodiscard]] std::unique_ptr<StepRun> begin() const override { return std::make_unique<FreedriveRun>(request_); }

 private:
  FreedriveRequest request_;
};

}  // namespace

std::unique_ptr<Step> parse_freedrive(const Json& json, const std::string& pointer, const command::Cell& cell,
                                      Findings& findings) {
  ObjectReader reader(json, pointer, findings);
  (void)reader.text("do");
  (void)reader.text("name", "");
  std::vector<std::string> arms;
  for (const auto& [name, arm] : cell.arms) arms.push_back(name);
  FreedriveRequest request;
  request.arm = reader.choice("arm", arms, arms.size() == 1 ? std::optional(arms.front()) : std::nullopt);
  request.enabled = command::read_condition(reader, "enabled", cell);
  request.until = command::read_condition(reader, "until", cell);
  if (reader.has("seconds")) request.seconds = reader.number("seconds", {}, {.low = 0.0, .high = 3600.0});
  if (!reader.has("until") && !reader.has("seconds"))
    findings.error(pointer, "nothing says when it ends", "'until' or 'seconds'");
  constexpr double kDegree = std::numbers::pi / 180.0;
  request.wish.linear_max =
      reader.number("velocity_m_s", request.wish.linear_max, {.low = 0.0, .high = 1.0, .low_open = true});
  request.wish.angular_max = kDegree * reader.number("turn_deg_s", request.wish.angular_max / kDegree,
                                                     {.low = 0.0, .high = 180.0, .low_open = true});
  reader.finish();
  return std::make_unique<FreedriveStep>(std::move(request));
}

}  // namespace takt::activity
