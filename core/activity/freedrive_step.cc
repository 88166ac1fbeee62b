#include "core/activity/freedrive_step.h"

#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/freedrive_activity.h"
#include "core/activity/mode_change.h"
#include "core/activity/net_run.h"
#include "core/base/object_reader.h"
#include "core/command/condition_state.h"
#include "core/command/single_net.h"

namespace takt::activity {
namespace {

using Json = nlohmann::ordered_json;

struct FreedriveRequest {
  std::string arm;
  std::optional<command::Condition> enabled, until;
  std::optional<double> seconds;
  command::FreedriveWish wish;
};

command::RuntimeCommand command_of(const FreedriveRequest& request, const command::Cell& cell,
                                   const command::Biases& biases) {
  command::FreedriveWish wish = request.wish;
  if (request.enabled) wish.enabled = command::state_of(*request.enabled, cell, biases);
  FreedriveEnd end{.until = {}, .seconds = request.seconds};
  if (request.until) end.until = command::state_of(*request.until, cell, biases);
  return freedrive_command(cell, request.arm, wish, end, biases);
}

/// Into the control mode, the net, and back into the mode before.
class FreedriveRun final : public StepRun {
 public:
  explicit FreedriveRun(const FreedriveRequest& request) : request_(request) {}

  Progress advance(Context& context, Findings& findings) override {
    if (begins_at_ < 0) begins_at_ = context.core.cycle() + context.program_latency_cycles;
    switch (stage_) {
      case Stage::kWaits:
        if (cancelled_) return Progress::kDone;
        if (context.core.cycle() < begins_at_) return Progress::kRunning;
        change_.emplace(context.core, freedrive_modes(context.cell, request_.arm));
        stage_ = Stage::kEnters;
        return Progress::kRunning;
      case Stage::kEnters:
        return enter(context, findings);
      case Stage::kGuided:
        return guide(context, findings);
      case Stage::kLeaves:
        return leave(context, findings);
    }
    return Progress::kFailed;
  }

  void cancel(Context&) override {
    cancelled_ = true;
    net_.cancel();
  }

 private:
  enum class Stage : std::uint8_t { kWaits, kEnters, kGuided, kLeaves };

  Progress enter(Context& context, Findings& findings) {
    if (!change_->poll(context.core)) return Progress::kRunning;
    if (change_->findings().has_errors()) return fail(findings);
    before_ = change_->before();
    if (cancelled_) return go_back(context);
    stage_ = Stage::kGuided;
    const auto mapped = command::single_net(command_of(request_, context.cell, context.variables.biases), "freedrive",
                                            context.core.period());
    return soft_still(net_.begin(context, mapped.net, mapped.options, findings), findings);
  }

  /// After a failure nothing changes the mode behind anybody's back; but it is said.
  Progress soft_still(Progress progress, Findings& findings) const {
    if (progress != Progress::kFailed) return progress;
    for (const auto& [arm, mode] : before_)
      findings.note({}, fmt::format("'{}' stays in the control mode of freedrive", arm),
                    fmt::format("\"control_mode\" to {} once it stands", name_of(mode)));
    return progress;
  }

  Progress guide(Context& context, Findings& findings) {
    const Progress progress = net_.advance(context, findings);
    return progress == Progress::kDone ? go_back(context) : soft_still(progress, findings);
  }

  Progress go_back(Context& context) {
    stage_ = Stage::kLeaves;
    change_.emplace(context.core, before_);
    return Progress::kRunning;
  }

  Progress leave(Context& context, Findings& findings) {
    if (!change_->poll(context.core)) return Progress::kRunning;
    return change_->findings().has_errors() ? fail(findings) : Progress::kDone;
  }

  /// The mode is not among the keys of this step.
  Progress fail(Findings& findings) const {
    for (const Finding& one : change_->findings().list()) findings.error({}, one.message, one.hint);
    return Progress::kFailed;
  }

  const FreedriveRequest& request_;
  Stage stage_ = Stage::kWaits;
  std::int64_t begins_at_ = -1;
  bool cancelled_ = false;
  std::optional<ModeChange> change_;
  ControlModes before_;
  NetRun net_;
};

class FreedriveStep final : public Step {
 public:
  explicit FreedriveStep(FreedriveRequest request) : request_(std::move(request)) {}

  /// Where a hand leads the arm shows only in the run: it is taken to stay.
  void rehearse(Rehearsal& rehearsal, const std::string& pointer, Findings& findings) const override {
    rehearsal.touched[request_.arm] = false;
    rehearsal.duration += request_.seconds.value_or(0.0);
    if (rehearsal.cell.arms.at(request_.arm).device == nullptr) return;  // only names are known
    const auto mapped = command::map(command_of(request_, rehearsal.cell, {}));
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

std::optional<command::Condition> read_condition(ObjectReader& reader, const char* key, const command::Cell& cell) {
  const Json* json = reader.object(key, false);
  if (json == nullptr) return std::nullopt;
  auto condition = command::parse_condition(*json, reader.at(key), cell);
  if (condition) return std::move(*condition);
  reader.findings().append(condition.error());
  return std::nullopt;
}

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
  request.enabled = read_condition(reader, "enabled", cell);
  request.until = read_condition(reader, "until", cell);
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
