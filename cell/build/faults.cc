#include "cell/build/faults.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cell/build/site_devices.h"
#include "core/base/diagnostics.h"

namespace takt::cell {
namespace {

using FaultKind = FaultEntry::Kind;

constexpr const char* kLatchName = "emergency_stop";
/// What a fault point can have, in the words of the file.
std::vector<std::string> words_of_point(const FaultPoint& point) {
  std::vector<std::string> words;
  for (const DeviceFault::Kind kind : point.kinds()) words.push_back(name_of(kind));
  return words;
}

/// Names of what can have wrong readings, or a connection that fails.
std::vector<std::string> names_of_points(FaultKind kind, const command::Cell& cell) {
  std::vector<std::string> names;
  const auto add = [&](const auto& devices) {
    for (const auto& [name, device] : devices) names.push_back(name);
  };
  if (kind == FaultKind::kSensor) {
    add(cell.sensors);
    add(cell.digital_inputs);
    add(cell.analog_inputs);
  } else {
    add(cell.arms);
    add(cell.grippers);
  }
  return names;
}

void check_fault_point(const FaultEntry& fault, const BuiltCell& built, Diagnostics& diagnostics) {
  if (fault.kind != FaultKind::kSensor && fault.kind != FaultKind::kDevice) return;
  const std::vector<std::string> names = names_of_points(fault.kind, built.cell);
  const auto point = built.fault_points.find(fault.device);
  if (point == built.fault_points.end() || std::ranges::find(names, fault.device) == names.end()) {
    const bool sensor = fault.kind == FaultKind::kSensor;
    return diagnostics.error(
        Code::kUnknownName, fault.pointer + (sensor ? "/sensor" : "/device"),
        fmt::format("there is no {} '{}'", sensor ? "sensor or input" : "arm, base or gripper", fault.device),
        nearest_choice(fault.device, names));
  }
  const auto kinds = point->second->kinds();
  if (std::ranges::find(kinds, fault.wrong.kind) != kinds.end()) return;
  diagnostics.error(Code::kInvalidValue, fault.pointer + "/fault",
                    fmt::format("'{}' cannot have the fault '{}'", fault.device, name_of(fault.wrong.kind)),
                    fmt::format("{}", fmt::join(words_of_point(*point->second), ", ")));
}

}  // namespace

void add_emergency_stop(const std::vector<FaultEntry>& faults, BuiltCell& built, Diagnostics& diagnostics) {
  std::vector<std::string> arms;
  for (const auto& [name, arm] : built.cell.arms) arms.push_back(name);
  for (const FaultEntry& fault : faults) {
    if (!fault.arm.empty() && std::ranges::find(arms, fault.arm) == arms.end())
      diagnostics.error(Code::kUnknownName, fault.pointer + "/arm", fmt::format("there is no arm '{}'", fault.arm),
                        nearest_choice(fault.arm, arms));
    if (fault.kind == FaultKind::kPush && built.world->body(fault.body) < 0)
      diagnostics.error(Code::kUnknownName, fault.pointer + "/body", fmt::format("there is no body '{}'", fault.body),
                        "Name DEVICE/LINK with a link of its model, or an object that moves");
    check_fault_point(fault, built, diagnostics);
    if (fault.kind == FaultKind::kToolChanger && !built.cell.changers.contains(fault.changer)) {
      std::vector<std::string> changers;
      for (const auto& [name, changer] : built.cell.changers) changers.push_back(name);
      diagnostics.error(Code::kUnknownName, fault.pointer + "/changer",
                        fmt::format("there is no tool changer '{}'", fault.changer),
                        nearest_choice(fault.changer, changers));
    }
  }
  const bool pressed =
      std::ranges::any_of(faults, [](const FaultEntry& fault) { return fault.kind == FaultKind::kEmergencyStop; });
  if (!pressed) return;
  if (built.core->environment().find(kLatchName) != nullptr)
    return diagnostics.error(Code::kDuplicate, "/faults", fmt::format("a device is called '{}'", kLatchName),
                             "Choose another name for it");
  built.emergency_stop = &built.core->add(std::make_unique<device::EmergencyStop>(kLatchName));
  built.emergency_stop->set_healthy(true);
}

bool Faults::latched() const { return built_.emergency_stop != nullptr && !opened_; }

void Faults::apply(Nanoseconds now, const Note& note) {
  if (built_.emergency_stop != nullptr) {
    opened_ = opened_ || !built_.emergency_stop->latched();
    // A button gives an edge: up in one cycle, down in the next.
    built_.emergency_stop->set_reset(reset_pending_ && built_.core->cycle() > 0);
    if (built_.core->cycle() > 0) reset_pending_ = false;
  }
  for (; next_ < entries_.size() && entries_[next_].at <= now; ++next_) happen(entries_[next_], now, note);
  end_pushes(now);
  end_wrong(now, note);
  end_lock_faults(now, note);
  if (!brakes_at_ || *brakes_at_ > now) return;
  brakes_at_.reset();
  for (const auto& [name, arm] : built_.cell.arms) built_.world->arm(name)->stop(device::StopCategory::kBrakes);
}

void Faults::happen(const FaultEntry& fault, Nanoseconds now, const Note& note) {
  if (fault.kind == FaultKind::kPush) {
    const Eigen::Vector3d& f = fault.force;
    note("push", fmt::format("{} with {:g}, {:g}, {:g} N", fault.body, f.x(), f.y(), f.z()));
    return begin_push(fault, now);
  }
  if (fault.kind == FaultKind::kSensor || fault.kind == FaultKind::kDevice) {
    note(name_of(fault.kind),
         fmt::format("{}: {} for {:g} s", fault.device, name_of(fault.wrong.kind), to_seconds(fault.duration)));
    built_.fault_points.at(fault.device)->begin(fault.wrong, seed_, fault.device);
    wrong_until_[fault.device] = {now + fault.duration, fault.kind};
    return;
  }
  if (fault.kind == FaultKind::kToolChanger) return begin_lock_fault(fault, now, note);
  const auto category = static_cast<int>(fault.category);
  const bool stops = fault.kind == FaultKind::kStop || fault.kind == FaultKind::kEmergencyStop;
  note(name_of(fault.kind), stops ? fmt::format("{} category {}", fault.arm, category) : fault.arm);
  if (fault.kind == FaultKind::kEmergencyStop) return press(fault, now);
  for (const auto& [name, arm] : built_.cell.arms) {
    if (!fault.arm.empty() && fault.arm != name) continue;
    sim::SimArm& machine = *built_.world->arm(name);
    stops ? machine.stop(fault.category) : machine.release_brakes();
    if (!stops && built_.site) built_.site->reset(name);
  }
  if (fault.kind != FaultKind::kReset || built_.emergency_stop == nullptr) return;
  brakes_at_.reset();
  built_.emergency_stop->set_healthy(true);
  reset_pending_ = true;
}

void Faults::begin_push(const FaultEntry& fault, Nanoseconds now) {
  const int body = built_.world->body(fault.body);
  pushes_.push_back({.body = body, .force = fault.force, .until = now + fault.duration});
  push(body);
}

void Faults::end_pushes(Nanoseconds now) {
  std::vector<Push> over;
  std::erase_if(pushes_, [&](const Push& one) {
    if (one.until > now) return false;
    over.push_back(one);
    return true;
  });
  for (const Push& one : over) push(one.body);
}

void Faults::end_wrong(Nanoseconds now, const Note& note) {
  std::erase_if(wrong_until_, [&](const auto& one) {
    const auto& [until, kind] = one.second;
    if (until > now) return false;
    built_.fault_points.at(one.first)->end();
    note(name_of(kind), fmt::format("{}: well again", one.first));
    return true;
  });
}

void Faults::begin_lock_fault(const FaultEntry& fault, Nanoseconds now, const Note& note) {
  note("tool_changer", fmt::format("{}: {} for {:g} s", fault.changer, fault.opens ? "its lock opens" : "no air",
                                   to_seconds(fault.duration)));
  lock_faults_.push_back({.changer = fault.changer, .opens = fault.opens, .until = now + fault.duration});
  set_lock_faults(fault.changer);
}

void Faults::end_lock_faults(Nanoseconds now, const Note& note) {
  std::vector<LockFault> over;
  std::erase_if(lock_faults_, [&](const LockFault& one) {
    if (one.until > now) return false;
    over.push_back(one);
    return true;
  });
  for (const LockFault& one : over) {
    set_lock_faults(one.changer);
    note("tool_changer", fmt::format("{}: {}", one.changer, one.opens ? "its lock works again" : "there is air again"));
  }
}

/// As all faults of this changer together have it.
void Faults::set_lock_faults(const std::string& changer) {
  const auto lasts = [&](bool opens) {
    return std::ranges::any_of(lock_faults_,
                               [&](const LockFault& one) { return one.changer == changer && one.opens == opens; });
  };
  sim::SimToolChanger& machine = *built_.world->tool_changer(changer);
  machine.set_air(!lasts(false));
  machine.set_broken(lasts(true));
}

void Faults::push(int body) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const Push& one : pushes_)
    if (one.body == body) force += one.force;
  built_.world->push(body, force);
}

/// The core leads the arms to rest; a circuit beside it sees to their brakes.
void Faults::press(const FaultEntry& fault, Nanoseconds now) {
  built_.emergency_stop->set_category(fault.category);
  built_.emergency_stop->set_healthy(false);
  if (fault.category == device::StopCategory::kBrakes) brakes_at_ = now;
  if (fault.category == device::StopCategory::kStopThenBrakes) brakes_at_ = now + fault.brakes_after;
}

}  // namespace takt::cell
