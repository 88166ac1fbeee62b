#include "hw/cia402/canopen_bus.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace takt::hw::cia402 {
namespace {

constexpr unsigned kFirst = 1, kOther = 2, kBoth = kFirst | kOther;  // messages with inputs

}  // namespace

CanopenBus::CanopenBus(const device::ArmDescription& arm, const BusOptions& options, std::unique_ptr<CanLink> link)
    : options_(options), link_(std::move(link)) {
  for (std::size_t i = 0; i < arm.joint_names.size(); ++i)
    drives_.push_back({.setup = DriveSetup(arm, i, options), .inputs = {}});
}

FieldBus::Phase CanopenBus::phase() const {
  if (other_master_) return Phase::kRefused;
  const auto any = [this](Phase phase) {
    return std::ranges::any_of(drives_, [phase](const Drive& drive) { return drive.setup.phase() == phase; });
  };
  for (const Phase phase : {Phase::kRefused, Phase::kSearching, Phase::kSettingUp})
    if (any(phase)) return phase;
  return Phase::kRunning;
}

void CanopenBus::begin_cycle(Nanoseconds now) {
  for (Drive& drive : drives_) drive.fresh = 0;
  awaited_ = true;
  (void)link_->send(sync_frame());
  if (now < next_heartbeat_) return;
  next_heartbeat_ = now + options_.heartbeat;
  (void)link_->send(heartbeat_frame(kMasterNode, NmtState::kOperational));
}

bool CanopenBus::poll(Nanoseconds now) {
  while (const auto frame = link_->receive()) take(*frame, now);
  if (other_master_) return false;
  for (Drive& drive : drives_) {
    const auto request = drive.setup.next(now);
    if (request) (void)link_->send(*request);
    std::string line = drive.setup.take_line();
    if (line.empty()) continue;
    if (drive.setup.phase() == DriveSetup::Phase::kRefused && refusal_.empty()) refusal_ = line;
    lines_.push_back(std::move(line));
  }
  return awaited_ && complete() && std::exchange(awaited_, false);
}

bool CanopenBus::complete() const {
  return phase() == Phase::kRunning &&
         std::ranges::all_of(drives_, [](const Drive& drive) { return drive.fresh == kBoth; });
}

void CanopenBus::send(std::span<const DriveOutputs> outputs) {
  for (std::size_t i = 0; i < drives_.size() && i < outputs.size(); ++i) {
    const NodeId node = drives_[i].setup.node();
    CanFrame first{.id = kOutputs1Id | node, .size = 7}, second{.id = kOutputs2Id | node, .size = 4};
    put(outputs[i].control, 2, first.data, 0);
    put(static_cast<std::uint32_t>(outputs[i].target), 4, first.data, 2);
    put(static_cast<std::uint32_t>(kCyclicPosition), 1, first.data, 6);
    put(static_cast<std::uint32_t>(outputs[i].velocity), 4, second.data, 0);
    (void)link_->send(first);
    (void)link_->send(second);
  }
}

CanopenBus::Drive* CanopenBus::drive_of(NodeId node) {
  const std::size_t joint = static_cast<std::size_t>(node) - options_.first_node;
  return node >= options_.first_node && joint < drives_.size() ? &drives_[joint] : nullptr;
}

void CanopenBus::take(const CanFrame& frame, Nanoseconds now) {
  const bool masters = frame.id == kSyncId || frame.id == kNmtId || frame.id == (kHeartbeatId | kMasterNode);
  if (masters) return meet_other_master();
  if (Drive* drive = drive_of(node_in(frame.id, kSdoAnswerId))) {
    if (const auto answer = sdo_answer(frame)) drive->setup.take(*answer, now);
  } else if (node_in(frame.id, kHeartbeatId) != 0) {
    take_heartbeat(frame, now);
  } else if (node_in(frame.id, kEmergencyId) != 0) {
    take_emergency(frame);
  } else {
    take_inputs(frame);
  }
}

void CanopenBus::meet_other_master() {
  if (std::exchange(other_master_, true)) return;
  refusal_ = "another master is on the bus: end it, then start again";
  lines_.push_back(refusal_);
}

void CanopenBus::take_heartbeat(const CanFrame& frame, Nanoseconds now) {
  Drive* drive = drive_of(node_in(frame.id, kHeartbeatId));
  const auto state = heartbeat_state(frame);
  if (drive != nullptr && state) drive->setup.hear(*state, now);
}

void CanopenBus::take_emergency(const CanFrame& frame) {
  Drive* drive = drive_of(node_in(frame.id, kEmergencyId));
  const auto code = emergency_code(frame);
  if (drive == nullptr || !code) return;
  drive->error = *code;
  const std::string text = *code == 0 ? "no error any more" : fmt::format("{} ({:04X}h)", text_of_error(*code), *code);
  lines_.push_back(fmt::format("{}: {}", drive->setup.name(), text));
}

void CanopenBus::take_inputs(const CanFrame& frame) {
  if (Drive* drive = drive_of(node_in(frame.id, kInputs1Id)); drive != nullptr && frame.size >= 7) {
    drive->inputs.status = static_cast<std::uint16_t>(get(frame.data, 0, 2));
    drive->inputs.position = static_cast<std::int32_t>(get(frame.data, 2, 4));
    drive->inputs.mode = static_cast<std::int8_t>(get(frame.data, 6, 1));
    drive->fresh |= kFirst;
  } else if (Drive* other = drive_of(node_in(frame.id, kInputs2Id)); other != nullptr && frame.size >= 6) {
    other->inputs.velocity = static_cast<std::int32_t>(get(frame.data, 0, 4));
    other->inputs.torque = static_cast<std::int16_t>(get(frame.data, 4, 2));
    other->fresh |= kOther;
  }
}

std::vector<std::string> CanopenBus::lines() { return std::exchange(lines_, {}); }

}  // namespace takt::hw::cia402
