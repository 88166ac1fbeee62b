#include "hw/cia402/drive_setup.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace takt::hw::cia402 {
namespace {

using Kind = SdoMessage::Kind;

constexpr Nanoseconds kAnswerTime = 200 * kMillisecond;  // CiA 301 names none; a node answers in some milliseconds
constexpr int kTries = 3;
constexpr int kMissedHeartbeats = 3;

/// What is read of a drive, in this order.
constexpr ObjectId kReads[] = {kDeviceType,   kVendor,         kProduct,        kSupportedModes, kEncoderIncrements,
                               kEncoderTurns, kGearMotorTurns, kGearShaftTurns, kRatedTorque};

std::uint32_t milliseconds(Nanoseconds time) { return static_cast<std::uint32_t>(time / kMillisecond); }

}  // namespace

DriveSetup::DriveSetup(const device::ArmDescription& arm, std::size_t joint, const BusOptions& options)
    : node_(static_cast<NodeId>(options.first_node + joint)),
      name_(fmt::format("drive {} ({})", options.first_node + joint, arm.joint_names[joint])),
      options_(options) {
  const auto j = static_cast<Eigen::Index>(joint);
  range_ = std::max(std::abs(arm.limits.lower[j]), std::abs(arm.limits.upper[j]));
  acceleration_ = arm.limits.acceleration[j];
  search();
}

/// The last step of the set-up writes what has to be computed from what was read, so it is planned anew each time.
void DriveSetup::search() {
  phase_ = Phase::kSearching;
  transfers_.clear();
  for (const ObjectId& id : kReads) transfers_.push_back({id});
  reads_ = transfers_.size();
  read_.clear();
  at_ = 0;
  asked_ = false;
  tries_ = 0;
}

/// Which drive it is, and whether it can do what is needed.
void DriveSetup::look_at_drive() {
  const std::uint32_t type = value(kDeviceType);
  if ((type & 0xFFFF) != kProfileOfDrives)
    return refuse(fmt::format("a device of profile {}, not a drive of CiA 402", type & 0xFFFF));
  if ((value(kSupportedModes) & kHasCyclicPosition) == 0) return refuse("it has no mode CSP (bit 7 of 6502h)");
  const double motor = static_cast<double>(value(kEncoderTurns)), shaft = static_cast<double>(value(kGearShaftTurns));
  const double increments = value(kEncoderIncrements), gear = value(kGearMotorTurns);
  if (motor <= 0.0 || shaft <= 0.0 || increments <= 0.0 || gear <= 0.0)
    return refuse("encoder resolution (608Fh) or gear ratio (6091h) is 0: enter them at the drive");
  data_.increments_per_rad = increments / motor * gear / shaft / (2.0 * std::numbers::pi);
  data_.torque_unit = 1e-6 * value(kRatedTorque) * gear / shaft;
  if (range_ * data_.increments_per_rad > INT32_MAX)
    return refuse(fmt::format("the joint's range of {:.2f} rad is more than 32 bits of {:.0f} increments a rad", range_,
                              data_.increments_per_rad));
  plan_transfers(options_);
}

void DriveSetup::plan_transfers(const BusOptions& options) {
  const std::uint32_t lost = milliseconds(kMissedHeartbeats * options.heartbeat);
  write(kSyncPeriod, 4, static_cast<std::uint32_t>(options.cycle / 1000));
  write(kConsumedHeartbeat, 4, static_cast<std::uint32_t>(kMasterNode) << 16 | lost);
  write(kProducedHeartbeat, 2, milliseconds(options.heartbeat));
  write(kCycleExponent, 1, 0xFD);  // milliseconds
  write(kCyclePeriod, 1, milliseconds(options.cycle));
  write(kAbortOption, 2, 3);          // quick stop
  write(kQuickStopOption, 2, 2);      // brake by the quick stop's ramp, then switch off
  write(kFaultReactionOption, 2, 2);  // the same
  write(kQuickStopRamp, 4,
        static_cast<std::uint32_t>(std::min(4.2e9, std::max(1.0, acceleration_ * data_.increments_per_rad))));
  write(kMode, 1, static_cast<std::uint32_t>(kCyclicPosition));
  plan_message(0x1400, 0x1600, kOutputs1Id, kOutputs1);
  plan_message(0x1401, 0x1601, kOutputs2Id, kOutputs2);
  plan_message(0x1800, 0x1A00, kInputs1Id, kInputs1);
  plan_message(0x1801, 0x1A01, kInputs2Id, kInputs2);
}

/// A message is changed while it does not exist (CiA 301, 7.5.2.36).
template <std::size_t N>
void DriveSetup::plan_message(std::uint16_t parameters, std::uint16_t mapping, std::uint32_t id,
                              const std::array<MappedObject, N>& objects) {
  constexpr std::uint32_t kOff = 1u << 31;
  constexpr std::uint8_t kEachSync = 1;
  write({parameters, 1}, 4, kOff | id | node_);
  write({parameters, 2}, 1, kEachSync);
  write({mapping, 0}, 1, 0);
  std::uint8_t sub = 0;
  for (const MappedObject& object : objects) write({mapping, ++sub}, 4, object.word());
  write({mapping, 0}, 1, sub);
  write({parameters, 1}, 4, id | node_);
}

void DriveSetup::refuse(std::string why) {
  phase_ = Phase::kRefused;
  line_ = fmt::format("{}: {}", name_, why);
}

std::optional<CanFrame> DriveSetup::next(Nanoseconds now) {
  const Nanoseconds most = kMissedHeartbeats * options_.heartbeat;
  if (phase_ == Phase::kRefused) return std::nullopt;
  if (phase_ == Phase::kRunning) {
    if (now - heard_ <= most) return std::nullopt;
    line_ = fmt::format("{}: no heartbeat for {} ms", name_, milliseconds(most));
    search();
  }
  if (asked_ && now < deadline_) return std::nullopt;
  if (asked_ && ++tries_ >= kTries && phase_ == Phase::kSettingUp) search();
  asked_ = true;
  deadline_ = now + kAnswerTime;
  if (at_ == transfers_.size()) return nmt_frame(NmtCommand::kStart, node_);
  // A drive that another program left in operation refuses to be set up.
  const bool first_write = at_ == reads_;
  if (first_write && tries_ == 0) {
    asked_ = false;
    tries_ = 1;
    return nmt_frame(NmtCommand::kEnterPreOperational, node_);
  }
  const Transfer& transfer = transfers_[at_];
  const Kind kind = transfer.size == 0 ? Kind::kRead : Kind::kWrite;
  return sdo_frame(kSdoRequestId | node_, {kind, transfer.id, transfer.size, transfer.value});
}

void DriveSetup::take(const SdoMessage& answer, Nanoseconds now) {
  if (!asked_ || at_ >= transfers_.size() || answer.id != transfers_[at_].id) return;
  const ObjectId& id = answer.id;
  if (answer.kind == Kind::kAbort)
    return refuse(fmt::format("{:04X}h:{}: {}", id.index, id.sub, text_of_abort(answer.value)));
  if (answer.kind != (transfers_[at_].size == 0 ? Kind::kReadAnswer : Kind::kWriteAnswer)) return;
  if (answer.kind == Kind::kReadAnswer) read_[id] = answer.value;
  if (phase_ == Phase::kSearching) line_ = name_ + ": found";
  phase_ = Phase::kSettingUp;
  heard_ = now;
  asked_ = false;
  tries_ = 0;
  if (++at_ == reads_) look_at_drive();
}

/// The drive runs once it says so; one that starts anew has forgotten all.
void DriveSetup::hear(NmtState state, Nanoseconds now) {
  heard_ = now;
  const bool whole = phase_ == Phase::kSettingUp && at_ == transfers_.size() && at_ > reads_;
  if (whole && state == NmtState::kOperational) {
    phase_ = Phase::kRunning;
    line_ = name_ + ": in operation";
  } else if (phase_ == Phase::kRunning && state != NmtState::kOperational) {
    line_ = name_ + ": has left operation";
    search();
  }
}

}  // namespace takt::hw::cia402
