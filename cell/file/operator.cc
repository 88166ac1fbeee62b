#include "cell/file/operator.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/channel_file.h"

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;
using ActionKind = OperatorAction::Kind;
/// What the cell begins with: hardware moves slowly at first.
double initial_override(rcc::ControlCore& core) {
  const device::Channel* channel = core.find_channel(Operator::kOverride);
  if (channel == nullptr || !channel->description().initial) return 1.0;
  const auto* share = std::get_if<net::Real>(&*channel->description().initial);
  return share != nullptr ? *share : 1.0;
}

}  // namespace

const FormOf<OperatorAction>& operator_form() {
  using Kind = OperatorAction::Kind;
  using Form = FormOf<OperatorAction>;
  constexpr Range kTime{.low = 0.0, .high = 3600.0};
  static const auto form =
      Form("operator_action")
          .add(number_key("at_s", "s", kTime, "When: simulated time. This or 'at_step'.").optional("'at_step' says it"),
               &OperatorAction::after_s)
          .add(text_key("at_step", "When: at the first start of a step of this name.", 1).optional(),
               &OperatorAction::step)
          .rule(exactly_one({"at_s", "at_step"}))
          .add(number_key("after_s", "s", kTime, "Delay after 'at_step'.").optional("0"), &OperatorAction::after_s)
          .rule(needs("after_s", "at_step"))
          .kinds(
              choice_key("do", {}, "What the operator does."), &OperatorAction::kind,
              Form::KindList<Kind>{
                  {"pause", Kind::kPause, Form("", "All planned motions stop on their paths and no step begins.")},
                  {"resume", Kind::kResume, Form("", "They continue.")},
                  {"override", Kind::kOverride,
                   Form("", "Sets the speed of all planned motions.")
                       .add(number_key("value", "", {.low = 0.0, .high = 1.0}, "Share of the planned speed."),
                            &OperatorAction::override_)},
                  {"cancel", Kind::kCancel, Form("", "Like Ctrl-C: motions brake on their paths and nothing follows.")},
                  {"abort", Kind::kAbort, Form("", "All devices stop at once and the run ends with an error.")},
                  {"write", Kind::kWrite,
                   Form("", "Writes a channel.")
                       .add(text_key("channel", "A channel that is written from outside."), &OperatorAction::channel)
                       .add(any_key("value", "", "The value, or null."),
                            [](FormReader& from, OperatorAction& action) {
                              if (const Json* value = from.json("value")) action.value = value->dump();
                            })
                       .add(number_key("held_s", "s", kTime,
                                       "Writes it again and again for this time, as a hand on a stick does.")
                                .optional("once"),
                            &OperatorAction::held_s)}})
          .then([](FormReader& from, OperatorAction& action) { action.pointer = from.pointer(); });
  return form;
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
                        fmt::format("there is no channel '{}'", action.channel), "Name one of 'channels'");
    } else if (channel->description().writer != device::ChannelDescription::Writer::kOutside) {
      diagnostics.error(Code::kInvalidValue, action.pointer + "/channel",
                        fmt::format("'{}' is written by nets", action.channel),
                        "Declare the channel with \"writer\": \"outside\"");
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
  for (PendingCommand& due : due_) {
    if (due.cycle < 0 || due.cycle > now || due.action == nullptr) continue;
    act(*std::exchange(due.action, nullptr));
  }
  write_held(now);
}

void Operator::step_begun(std::string_view step) {
  for (PendingCommand& due : due_) {
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

void Operator::write_held(std::int64_t now) {
  constexpr double kHeldEvery_s = 0.02;
  for (HeldValue& held : held_) {
    if (now < held.next) continue;
    held.next = std::min(now + cycles(kHeldEvery_s), held.last);
    (void)(held.value ? held.channel->write(*held.value) : held.channel->write_null());
  }
  std::erase_if(held_, [now](const HeldValue& held) { return now >= held.last; });
}

void Operator::write(const OperatorAction& action) {
  device::Channel* channel = core_.find_channel(action.channel);
  Diagnostics none;
  const auto value = device::channel_value_from_json(Json::parse(action.value), channel->description().type, {}, none);
  (void)(value ? channel->write(*value) : channel->write_null());
  std::erase_if(held_, [channel](const HeldValue& held) { return held.channel == channel; });
  if (action.held_s > 0.0)
    held_.push_back(
        {.channel = channel, .value = value, .next = core_.cycle() + 1, .last = core_.cycle() + cycles(action.held_s)});
  note_("write", fmt::format("{} = {}", action.channel, action.value));
}

}  // namespace takt::cell
