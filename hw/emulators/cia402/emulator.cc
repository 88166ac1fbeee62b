#include "hw/emulators/cia402/emulator.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::hw::cia402 {
namespace {

/// A motor that has the joint's effort as its rated torque, behind the gear. Without one: 1 Nm.
std::uint32_t rated_torque(const device::ArmDescription& arm, Eigen::Index joint, std::uint32_t gear) {
  if (joint >= arm.effort.size() || arm.effort[joint] <= 0.0) return 1000;
  return static_cast<std::uint32_t>(std::max(1.0, 1e3 * arm.effort[joint] / gear));
}

}  // namespace

Emulator::Emulator(const device::DriverRequest& request, const EmulatorOptions& options, std::unique_ptr<CanLink> link,
                   std::shared_ptr<device::ArmBackend> machine)
    : options_(options), link_(std::move(link)), machine_(std::move(machine)) {
  const device::ArmDescription& arm = *request.description;
  const auto send = [this](const CanFrame& frame) { (void)link_->send(frame); };
  for (Eigen::Index i = 0; i < arm.limits.velocity.size(); ++i) {
    DriveOptions drive{.lower = arm.limits.lower[i],
                       .upper = arm.limits.upper[i],
                       .velocity = arm.limits.velocity[i],
                       .bridged = options.bridged};
    drive.rated_torque_mNm = rated_torque(arm, i, drive.gear);
    nodes_.push_back(std::make_unique<Node>(static_cast<NodeId>(options.first_node + i), drive, send));
  }
  told_.resize(nodes_.size(), DriveState::kNotReadyToSwitchOn);
  const auto rest = device::JointVector::Zero(arm.limits.velocity.size());
  set_point_.q = set_point_.dq = set_point_.ddq = rest;
}

void Emulator::advance(Nanoseconds now) {
  look();
  receive(now);
  drive(now);
}

void Emulator::look() { has_sample_ = machine_->read(sample_); }

/// The arm is known once in each cycle of its own; drives measure at SYNC.
void Emulator::measure(Nanoseconds now) {
  const double late = to_seconds(now - sample_.stamp);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i]->set_measurable(has_sample_);
    if (!has_sample_) continue;
    const auto j = static_cast<Eigen::Index>(i);
    const AxisPoint measured{sample_.q[j] + late * sample_.dq[j], sample_.dq[j], 0.0};
    nodes_[i]->drive().measure(measured, sample_.tau.size() > j ? sample_.tau[j] : 0.0, sample_.ready);
  }
}

void Emulator::receive(Nanoseconds now) {
  measure(now);
  for (const auto& node : nodes_) node->pass(now);
  while (const auto frame = link_->receive())
    for (const auto& node : nodes_) node->take(*frame, now);
}

void Emulator::drive(Nanoseconds now) {
  bool brakes = false;
  for (const auto& node : nodes_) brakes = node->take_brakes() || brakes;
  if (brakes) machine_->brake();
  closed_ = closed_ || brakes;
  const bool wanted = std::ranges::any_of(nodes_, [](const auto& node) {
    return node->state() == NmtState::kOperational && node->drive().waits_for_power();
  });
  if (closed_ && !brakes && wanted && open_) {
    closed_ = false;
    open_();
  }
  if (brakes || !has_sample_ || !sample_.ready) return;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const AxisPoint told = nodes_[i]->drive().at(now);
    const auto j = static_cast<Eigen::Index>(i);
    set_point_.q[j] = told.q;
    set_point_.dq[j] = told.dq;
    set_point_.ddq[j] = told.ddq;
  }
  set_point_.stamp = now;
  machine_->write(set_point_);
  ++set_point_.cycle;
}

std::vector<std::string> Emulator::news() {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const DriveState state = nodes_[i]->drive().state();
    if (state == told_[i]) continue;
    told_[i] = state;
    const auto code = static_cast<std::uint16_t>(nodes_[i]->objects().value(kErrorCode));
    lines.push_back(fmt::format("drive {}: {}{}", options_.first_node + i, name_of(state),
                                code == 0 ? "" : fmt::format(", {}", text_of_error(code))));
  }
  return lines;
}

}  // namespace takt::hw::cia402
