#include "scenario/faults.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::scenario {
namespace {

using Json = nlohmann::ordered_json;
using FaultKind = FaultEntry::Kind;

constexpr const char* kLatchName = "emergency_stop";
const std::vector<std::string> kWords = {"stop", "release", "emergency_stop", "reset",
                                         "push", "sensor",  "tool_changer"};  // in the order of FaultKind
const std::vector<std::string> kLockFaults = {"no_air", "opens"};
const std::vector<std::string> kReadings = {"silent", "nan",   "stuck",
                                            "bias",   "noise", "delay"};  // in the order of SensorFault::Kind

Nanoseconds nanoseconds(double seconds) { return static_cast<Nanoseconds>(std::llround(1e9 * seconds)); }

void read_push(ObjectReader& reader, FaultEntry& fault) {
  fault.body = reader.text("body");
  fault.force = reader.vector("force_N");
  fault.duration = nanoseconds(reader.number("seconds", 1.0, {.low = 0.0, .high = 3600.0, .low_open = true}));
}

void read_sensor(ObjectReader& reader, FaultEntry& fault) {
  using Kind = SensorFault::Kind;
  constexpr double kLongest = 1e-3 * FaultySensor::kKept;  // s, of readings once a cycle
  fault.sensor = reader.text("sensor");
  const auto word = std::ranges::find(kReadings, reader.choice("fault", kReadings));
  if (word != kReadings.end()) fault.readings.kind = static_cast<Kind>(word - kReadings.begin());
  const bool adds = fault.readings.kind == Kind::kBias || fault.readings.kind == Kind::kNoise;
  if (adds) {
    fault.readings.wrench.force = reader.vector("force_N", Eigen::Vector3d(Eigen::Vector3d::Zero()));
    fault.readings.wrench.torque = reader.vector("torque_Nm", Eigen::Vector3d(Eigen::Vector3d::Zero()));
    if (!reader.has("force_N") && !reader.has("torque_Nm"))
      reader.diagnostics().error(Code::kMissing, reader.pointer(), "nothing is added to the readings",
                                 "\"force_N\" or \"torque_Nm\"");
  }
  if (fault.readings.kind == Kind::kDelay)
    fault.readings.delay = nanoseconds(reader.number("delay_s", {}, {.low = 0.0, .high = kLongest, .low_open = true}));
  fault.duration = nanoseconds(reader.number("seconds", 3600.0, {.low = 0.0, .high = 3600.0, .low_open = true}));
}

void read_lock(ObjectReader& reader, FaultEntry& fault) {
  fault.changer = reader.text("changer");
  fault.opens = reader.choice("fault", kLockFaults) == "opens";
  fault.duration = nanoseconds(reader.number("seconds", 3600.0, {.low = 0.0, .high = 3600.0, .low_open = true}));
}

void read_stop(ObjectReader& reader, FaultEntry& fault) {
  fault.arm = reader.text("arm", "");
  fault.category = static_cast<device::StopCategory>(reader.integer("category", 1, {.low = 0, .high = 2}));
  fault.brakes_after = nanoseconds(reader.number("brakes_after_s", 1.0, {.low = 0.0, .high = 60.0}));
  const bool delays =
      fault.kind == FaultKind::kEmergencyStop && fault.category == device::StopCategory::kStopThenBrakes;
  if (reader.has("brakes_after_s") && !delays)
    reader.diagnostics().error(Code::kConflict, reader.at("brakes_after_s"), "nothing waits here",
                               "only with \"do\": \"emergency_stop\" of category 1");
  const bool of_the_cell = fault.kind == FaultKind::kEmergencyStop || fault.kind == FaultKind::kReset;
  if (of_the_cell && !fault.arm.empty())
    reader.diagnostics().error(Code::kConflict, reader.at("arm"), "an emergency stop concerns all arms",
                               "no arm, or \"do\": \"stop\"");
}

FaultEntry read_fault(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  FaultEntry fault;
  fault.pointer = pointer;
  fault.at = nanoseconds(reader.number("at_s", {}, {.low = 0.0, .high = 3600.0}));
  const auto word = std::ranges::find(kWords, reader.choice("do", kWords, "stop"));
  if (word != kWords.end()) fault.kind = static_cast<FaultKind>(word - kWords.begin());
  if (fault.kind == FaultKind::kPush) {
    read_push(reader, fault);
  } else if (fault.kind == FaultKind::kSensor) {
    read_sensor(reader, fault);
  } else if (fault.kind == FaultKind::kToolChanger) {
    read_lock(reader, fault);
  } else {
    read_stop(reader, fault);
  }
  reader.finish();
  return fault;
}

}  // namespace

void read_faults(ObjectReader& reader, std::vector<FaultEntry>& faults) {
  const Json* list = reader.array("faults", /*required=*/false);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i)
    faults.push_back(read_fault((*list)[i], reader.at("faults") + pointer_segment(i), reader.diagnostics()));
  std::ranges::stable_sort(faults, {}, &FaultEntry::at);
}

void add_emergency_stop(const Description& description, BuiltCell& built, Diagnostics& diagnostics) {
  std::vector<std::string> arms;
  for (const auto& [name, arm] : built.cell.arms) arms.push_back(name);
  for (const FaultEntry& fault : description.faults) {
    if (!fault.arm.empty() && std::ranges::find(arms, fault.arm) == arms.end())
      diagnostics.error(Code::kUnknownName, fault.pointer + "/arm", fmt::format("there is no arm '{}'", fault.arm),
                        nearest_choice(fault.arm, arms));
    if (fault.kind == FaultKind::kPush && built.world->body(fault.body) < 0)
      diagnostics.error(Code::kUnknownName, fault.pointer + "/body", fmt::format("there is no body '{}'", fault.body),
                        "DEVICE/LINK with a link of its model, or an object that moves");
    if (fault.kind == FaultKind::kSensor && !built.faulty_sensors.contains(fault.sensor)) {
      std::vector<std::string> sensors;
      for (const auto& [name, sensor] : built.cell.sensors) sensors.push_back(name);
      diagnostics.error(Code::kUnknownName, fault.pointer + "/sensor",
                        fmt::format("there is no force/torque sensor '{}'", fault.sensor),
                        nearest_choice(fault.sensor, sensors));
    }
    if (fault.kind == FaultKind::kToolChanger && !built.cell.changers.contains(fault.changer)) {
      std::vector<std::string> changers;
      for (const auto& [name, changer] : built.cell.changers) changers.push_back(name);
      diagnostics.error(Code::kUnknownName, fault.pointer + "/changer",
                        fmt::format("there is no tool changer '{}'", fault.changer),
                        nearest_choice(fault.changer, changers));
    }
  }
  const bool pressed = std::ranges::any_of(
      description.faults, [](const FaultEntry& fault) { return fault.kind == FaultKind::kEmergencyStop; });
  if (!pressed) return;
  if (built.core->environment().find(kLatchName) != nullptr)
    return diagnostics.error(Code::kDuplicate, "/faults", fmt::format("a device is called '{}'", kLatchName),
                             "another name for it");
  built.emergency_stop = &built.core->add(std::make_unique<device::EmergencyStop>(kLatchName));
  built.emergency_stop->set_healthy(true);
}

bool Faults::latched() const { return built_.emergency_stop != nullptr && !opened_; }

void Faults::apply(const Note& note) {
  if (built_.emergency_stop != nullptr) {
    opened_ = opened_ || !built_.emergency_stop->latched();
    // A button gives an edge: up in one cycle, down in the next.
    built_.emergency_stop->set_reset(reset_pending_ && built_.core->cycle() > 0);
    if (built_.core->cycle() > 0) reset_pending_ = false;
  }
  const Nanoseconds now = built_.core->time();
  for (; next_ < entries_.size() && entries_[next_].at <= now; ++next_) happen(entries_[next_], now, note);
  end_pushes(now);
  end_readings(now, note);
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
  if (fault.kind == FaultKind::kSensor) {
    note("sensor", fmt::format("{}: {} for {:g} s", fault.sensor,
                               kReadings[static_cast<std::size_t>(fault.readings.kind)], to_seconds(fault.duration)));
    built_.faulty_sensors.at(fault.sensor)->begin(fault.readings, seed_, fault.sensor);
    readings_until_[fault.sensor] = now + fault.duration;
    return;
  }
  if (fault.kind == FaultKind::kToolChanger) return begin_lock_fault(fault, now, note);
  const auto category = static_cast<int>(fault.category);
  const bool stops = fault.kind == FaultKind::kStop || fault.kind == FaultKind::kEmergencyStop;
  note(kWords[static_cast<std::size_t>(fault.kind)],
       stops ? fmt::format("{} category {}", fault.arm, category) : fault.arm);
  if (fault.kind == FaultKind::kEmergencyStop) return press(fault, now);
  for (const auto& [name, arm] : built_.cell.arms) {
    if (!fault.arm.empty() && fault.arm != name) continue;
    sim::SimArm& machine = *built_.world->arm(name);
    stops ? machine.stop(fault.category) : machine.release_brakes();
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

void Faults::end_readings(Nanoseconds now, const Note& note) {
  std::erase_if(readings_until_, [&](const auto& one) {
    if (one.second > now) return false;
    built_.faulty_sensors.at(one.first)->end();
    note("sensor", fmt::format("{}: well again", one.first));
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

}  // namespace takt::scenario
