#include "serve/follow_log.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "cell/build/command_tape.h"
#include "core/net/format_text.h"

namespace takt::serve {

using cell::ByteWriter;
using cell::FollowRecord;

std::vector<std::string> FollowLog::missing() const {
  const std::vector<std::string> known = built_.commands->samples().devices();
  std::vector<std::string> missing;
  net::Environment& environment = built_.core->environment();
  for (const std::string& name : environment.names()) {
    const auto* device = dynamic_cast<const device::Device*>(environment.find(name));
    const bool is_channel = dynamic_cast<const device::Channel*>(device) != nullptr;
    if (device != nullptr && !is_channel && std::ranges::find(known, name) == known.end()) missing.push_back(name);
  }
  return missing;
}

bool FollowLog::begin(std::uint32_t fence) {
  if (state_ != State::kOff) return false;
  records_ = std::make_unique<boost::lockfree::spsc_queue<Record>>(kRecords);
  FollowCommand old;
  while (commands_.pop(old)) {
  }
  fence_ = fence;
  lost_ = false;
  state_ = State::kWanted;
  return true;
}

void FollowLog::end() {
  State wanted = State::kWanted;
  if (state_.compare_exchange_strong(wanted, State::kOff)) return;
  State on = State::kOn;
  (void)state_.compare_exchange_strong(on, State::kEnding);  // whoever runs the cell lets go
}

std::optional<std::string> FollowLog::pop() {
  std::optional<std::string> bytes;
  if (records_ == nullptr) return bytes;
  records_->consume_one([&bytes](const Record& record) {
    bytes.emplace(reinterpret_cast<const char*>(record.bytes.data()), record.size);
  });
  return bytes;
}

std::string FollowLog::refusal() const {
  for (const auto& [name, arm] : built_.cell.arms) {
    if (arm.device->held()) return fmt::format("a net holds '{}'", name);
    if (!arm.device->at_rest()) return fmt::format("'{}' moves", name);
    if (arm.device->set_point().q.size() == 0) return fmt::format("'{}' is not ready", name);
  }
  for (const auto& [name, gripper] : built_.cell.grippers)
    if (gripper.device->held() || !gripper.device->at_rest()) return fmt::format("'{}' moves", name);
  return {};
}

void FollowLog::look() {
  if (state_ == State::kEnding) state_ = State::kOff;
  if (state_ != State::kWanted) return;
  if (const std::string why = refusal(); !why.empty()) {
    tell(FollowRecord::kRefused, why);
    state_ = State::kOff;
    return;
  }
  scratch_.size = 0;
  ByteWriter out(scratch_.bytes);
  out.put(static_cast<std::uint8_t>(FollowRecord::kBegin));
  out.put(built_.core->cycle() - 1);
  cell::write_state(built_, out);
  built_.commands->samples().write(out);
  if (out.overflowed()) {
    tell(FollowRecord::kRefused, "the cell has more devices than one record has room for");
    state_ = State::kOff;
    return;
  }
  scratch_.size = out.size();
  push(scratch_);
  State wanted = State::kWanted;
  (void)state_.compare_exchange_strong(wanted, State::kOn);
}

void FollowLog::carry_out(const FollowCommand& command) {
  rcc::ControlCore& core = *built_.core;
  bool posted = true;
  switch (command.kind) {
    case FollowCommand::Kind::kRule:
      posted = core.post(command.rule) != 0;
      break;
    case FollowCommand::Kind::kAbort:
      (void)core.abort(command.net);
      break;
    case FollowCommand::Kind::kUnload:
      (void)core.unload(command.net);
      break;
    case FollowCommand::Kind::kMode:
      posted = core.change_mode(command.arm->name(), command.mode) != 0;
      break;
    case FollowCommand::Kind::kStop:
      core.stop_all(net::Cause::Code::kAborted, command.text.view());
      break;
    case FollowCommand::Kind::kChannel:
      (void)(command.value ? command.channel->write(*command.value) : command.channel->write_null());
      break;
    case FollowCommand::Kind::kTool:
      if (!command.arm->held()) command.arm->set_tool(command.tool);
      break;
  }
  taken_[taken_count_++] = {.tag = command.tag, .posted = posted};
}

void FollowLog::before_cycle() {
  taken_count_ = 0;
  stopped_ = false;
  if (state_ != State::kOn) return;
  FollowCommand command;
  while (taken_count_ < kCommands && commands_.pop(command)) carry_out(command);
}

void FollowLog::stopped(const net::Text& why) {
  stopped_ = true;
  stop_ = why;
}

void FollowLog::after_cycle() {
  if (state_ != State::kOn) return;
  if (!lease_.holds(fence_)) {
    tell(FollowRecord::kLost, "the lease is over");
    state_ = State::kEnding;
    return;
  }
  ByteWriter out(scratch_.bytes);
  out.put(static_cast<std::uint8_t>(FollowRecord::kCycle));
  out.put(built_.core->cycle() - 1);
  out.put(cell::hash_of_actuators(built_.cell));
  out.put(static_cast<std::uint16_t>(taken_count_));
  for (std::size_t i = 0; i < taken_count_; ++i) {
    out.put(taken_[i].tag);
    out.put(std::uint8_t{taken_[i].posted});
  }
  out.put(std::uint8_t{stopped_});
  if (stopped_) cell::put_text(stop_.view(), out);
  cell::write_latched(built_, out);
  built_.commands->samples().write(out);
  scratch_.size = out.size();
  if (out.overflowed()) return tell(FollowRecord::kLost, "more has happened in a cycle than one record has room for");
  push(scratch_);
}

void FollowLog::tell(FollowRecord kind, std::string_view text) {
  ByteWriter out(scratch_.bytes);
  out.put(static_cast<std::uint8_t>(kind));
  cell::put_text(text, out);
  scratch_.size = out.size();
  push(scratch_);
}

/// One place stays free for the last word.
void FollowLog::push(const Record& record) {
  if (lost_) return;
  if (records_->write_available() > 1) {
    (void)records_->push(record);
    return;
  }
  lost_ = true;
  ByteWriter out(scratch_.bytes);
  out.put(static_cast<std::uint8_t>(FollowRecord::kLost));
  cell::put_text("the follower takes too long", out);
  scratch_.size = out.size();
  (void)records_->push(scratch_);
  state_ = State::kEnding;
}

}  // namespace takt::serve
