#include "scenario/operator.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/channel_file.h"
#include "core/table/table.h"

namespace takt::scenario {
namespace {

using Json = nlohmann::ordered_json;
using ActionKind = OperatorAction::Kind;

using ActionTable = table::Table<OperatorAction>;

void read_written(const table::Field& row, const table::Context& from, OperatorAction& action) {
  if (const Json* value = from.reader.child(row.key)) {
    action.value = value->dump();
  } else {
    from.reader.diagnostics().error(Code::kMissing, from.reader.pointer(), "key 'value' is missing",
                                    "Give what is written, or null");
  }
}

const ActionTable& override_table() {
  static const auto table = [] {
    ActionTable override_;
    override_.number("value", "", &OperatorAction::override_, {.low = 0.0, .high = 1.0}, "Share of the planned speed.")
        .required();
    return override_;
  }();
  return table;
}

const ActionTable& write_table() {
  static const auto table = [] {
    table::Field value = table::field("value", table::Field::Type::kAny, "The value that is written, or null.");
    value.required = true;
    ActionTable write;
    write.named("channel", table::NameOf::kChannel, &OperatorAction::channel, "A channel that is written from outside.")
        .required()
        .object(std::move(value), read_written);
    return write;
  }();
  return table;
}

constexpr Range kActionTime{.low = 0.0, .high = 3600.0};

void read_time(const table::Field& row, const table::Context& from, OperatorAction& action) {
  if (from.reader.has(row.key)) action.after_s = from.reader.number(row.key, {}, row.range);
}

table::Field time_field(std::string_view key, std::string_view doc) {
  table::Field time = table::field(key, table::Field::Type::kNumber, doc);
  time.unit = "s";
  time.range = kActionTime;
  return time;
}

/// What the cell begins with: hardware moves slowly at first.
double initial_override(rcc::ControlCore& core) {
  const device::Channel* channel = core.find_channel(Operator::kOverride);
  if (channel == nullptr || !channel->description().initial) return 1.0;
  const auto* share = std::get_if<net::Real>(&*channel->description().initial);
  return share != nullptr ? *share : 1.0;
}

}  // namespace

const ActionTable& operator_table() {
  static const auto table = [] {
    ActionTable action;
    action
        .choose<ActionKind>("do", &OperatorAction::kind,
                            {{"pause", ActionKind::kPause},
                             {"resume", ActionKind::kResume},
                             {"override", ActionKind::kOverride, {}, &override_table()},
                             {"cancel", ActionKind::kCancel},
                             {"abort", ActionKind::kAbort},
                             {"write", ActionKind::kWrite, {}, &write_table()}},
                            "pause: all planned motions stop on their paths and no step begins; resume: they continue; "
                            "override: speed of all planned motions; cancel: like Ctrl-C, motions brake on their paths "
                            "and nothing follows; abort: all devices stop at once and the run ends with an error; "
                            "write: writes a channel.")
        .required()
        .object(time_field("at_s", "When: simulated time. This or 'at_step'."), read_time)
        .named("at_step", table::NameOf::kStep, &OperatorAction::step,
               "When: at the first start of a step of this name.")
        .not_empty()
        .object(time_field("after_s", "Delay after 'at_step'; without it none."), read_time)
        .rule(
            {.kind = table::Rule::Kind::kOneOf, .groups = {{"at_s"}, {"at_step"}}, .hint = "Give 'at_s' or 'at_step'"})
        .rule({.kind = table::Rule::Kind::kNeeds,
               .groups = {{"after_s"}, {"at_step"}},
               .hint = "Add 'at_step', or use 'at_s'",
               .at = "after_s",
               .code = Code::kUnknownKey})
        .rule([](OperatorAction& entry, const table::Context& from) { entry.pointer = from.reader.pointer(); });
    return action;
  }();
  return table;
}

Diagnostics check_operator(const std::vector<OperatorAction>& actions, rcc::ControlCore& core,
                           const std::optional<std::vector<std::string>>& steps) {
  Diagnostics diagnostics;
  for (const OperatorAction& action : actions) {
    if (steps && !action.step.empty() && std::ranges::find(*steps, action.step) == steps->end()) {
      diagnostics.error(Code::kUnknownName, action.pointer + "/at_step",
                        fmt::format("there is no step '{}'", action.step), nearest_choice(action.step, *steps));
    }
    if (action.kind != ActionKind::kWrite) continue;
    const device::Channel* channel = core.find_channel(action.channel);
    if (!channel) {
      diagnostics.error(Code::kUnknownName, action.pointer + "/channel",
                        fmt::format("there is no channel '{}'", action.channel), "one of 'channels'");
    } else if (channel->description().writer != device::ChannelDescription::Writer::kOutside) {
      diagnostics.error(Code::kInvalidValue, action.pointer + "/channel",
                        fmt::format("'{}' is written by nets", action.channel), "\"writer\": \"outside\"");
    } else if (const Json value = Json::parse(action.value); !value.is_null()) {
      (void)device::channel_value_from_json(value, channel->description().type, action.pointer + "/value", diagnostics);
    }
  }
  return diagnostics;
}

Operator::Operator(const std::vector<OperatorAction>& script, rcc::ControlCore& core,
                   const device::EmergencyStop* button, OperatedProgram program, Note note)
    : core_(core),
      button_(button),
      program_(std::move(program)),
      note_(std::move(note)),
      override_(initial_override(core)) {
  for (const OperatorAction& action : script) {
    due_.push_back({&action, action.step.empty() ? cycles(action.after_s) : -1});
  }
}

std::int64_t Operator::cycles(double seconds) const {
  return static_cast<std::int64_t>(std::llround(seconds / to_seconds(core_.period())));
}

void Operator::before_cycle() {
  if (button_ != nullptr && button_->pressed() && broken_off_.empty())
    break_off(fmt::format("'{}' was pressed", button_->name()));
  const std::int64_t now = core_.cycle();
  // What is due in one cycle is done in the order of the file.
  for (Due& due : due_) {
    if (due.cycle < 0 || due.cycle > now || due.action == nullptr) continue;
    act(*std::exchange(due.action, nullptr));
  }
}

void Operator::step_begun(std::string_view step) {
  for (Due& due : due_) {
    if (due.action == nullptr || due.cycle >= 0 || due.action->step != step) continue;
    due.cycle = core_.cycle() + cycles(due.action->after_s);
  }
}

void Operator::act(const OperatorAction& action) {
  switch (action.kind) {
    case ActionKind::kPause:
      return pause();
    case ActionKind::kResume:
      return resume();
    case ActionKind::kOverride:
      return set_override(action.override_);
    case ActionKind::kCancel:
      return cancel();
    case ActionKind::kAbort:
      return abort();
    case ActionKind::kWrite:
      return write(action);
  }
}

void Operator::pause() {
  paused_ = true;
  program_.hold(true);
  send();
  note_("pause", "");
}

void Operator::resume() {
  paused_ = false;
  program_.hold(false);
  send();
  note_("resume", "");
}

void Operator::set_override(double share) {
  override_ = std::clamp(share, 0.0, 1.0);
  send();
  note_("override", fmt::format("{:g}", override_));
}

void Operator::send() {
  if (device::Channel* channel = core_.find_channel(kOverride)) (void)channel->write(paused_ ? 0.0 : override_);
}

void Operator::cancel() {
  cancelled_ = true;
  program_.hold(false);
  program_.cancel();
  note_("cancel", "");
}

/// The program is cancelled too: what it does about failures is not for this.
void Operator::break_off(const std::string& why) {
  broken_off_ = why;
  program_.cancel();
}

void Operator::abort() {
  constexpr const char* kWhy = "the operator stopped everything";
  core_.stop_all(net::Cause::Code::kAborted, kWhy);
  note_("abort", "");
  break_off(kWhy);
}

void Operator::write(const OperatorAction& action) {
  device::Channel* channel = core_.find_channel(action.channel);
  Diagnostics none;
  const auto value = device::channel_value_from_json(Json::parse(action.value), channel->description().type, {}, none);
  (void)(value ? channel->write(*value) : channel->write_null());
  note_("write", fmt::format("{} = {}", action.channel, action.value));
}

}  // namespace takt::scenario
