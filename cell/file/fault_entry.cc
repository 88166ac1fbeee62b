#include "cell/file/fault_entry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <nlohmann/json.hpp>

namespace takt::cell {
namespace {

using Json = nlohmann::ordered_json;
using FaultKind = FaultEntry::Kind;

const std::vector<std::string> kWords = {"stop", "release", "emergency_stop", "reset",
                                         "push", "sensor",  "tool_changer",   "device"};  // in the order of FaultKind
const std::vector<std::string> kLockFaults = {"no_air", "opens"};
const std::vector<std::string> kWrong = {"silent", "nan",   "stuck", "bias", "noise",
                                         "delay",  "value", "gone",  "loss", "jammed"};  // of DeviceFault::Kind
const std::vector<std::string> kOfReadings = {"silent", "nan", "stuck", "bias", "noise", "delay", "value", "loss"};
const std::vector<std::string> kOfConnections = {"gone", "loss", "jammed"};

Nanoseconds nanoseconds(double seconds) { return static_cast<Nanoseconds>(std::llround(1e9 * seconds)); }

void read_push(ObjectReader& reader, FaultEntry& fault) {
  fault.body = reader.text("body");
  fault.force = reader.vector("force_N");
  fault.duration = nanoseconds(reader.number("seconds", 1.0, {.low = 0.0, .high = 3600.0, .low_open = true}));
}

/// "fault": one of these words.
DeviceFault::Kind read_wrong(ObjectReader& reader, const std::vector<std::string>& words) {
  const std::string chosen = reader.choice("fault", words);
  const auto word = std::ranges::find(kWrong, chosen);
  return word == kWrong.end() ? DeviceFault::Kind::kSilent : static_cast<DeviceFault::Kind>(word - kWrong.begin());
}

/// In N and Nm of a force/torque sensor, else in the unit of the input.
void read_added(ObjectReader& reader, DeviceFault& wrong) {
  wrong.wrench.force = reader.vector("force_N", Eigen::Vector3d(Eigen::Vector3d::Zero()));
  wrong.wrench.torque = reader.vector("torque_Nm", Eigen::Vector3d(Eigen::Vector3d::Zero()));
  wrong.value = reader.number("value", 0.0);
  if (!reader.has("force_N") && !reader.has("torque_Nm") && !reader.has("value"))
    reader.diagnostics().error(Code::kMissing, reader.pointer(), "nothing is added to the readings",
                               "Give \"force_N\" or \"torque_Nm\"; of an input \"value\"");
}

double read_input_value(ObjectReader& reader) {
  const Json* value = reader.child("value");
  return value != nullptr && value->is_boolean() ? (value->get<bool>() ? 1.0 : 0.0) : reader.number("value");
}

void read_wrong_while(ObjectReader& reader, FaultEntry& fault) {
  if (fault.wrong.kind == DeviceFault::Kind::kLoss)
    fault.wrong.share = reader.number("share", {}, {.low = 0.0, .high = 1.0, .low_open = true});
  fault.duration = nanoseconds(reader.number("seconds", 3600.0, {.low = 0.0, .high = 3600.0, .low_open = true}));
}

void read_sensor(ObjectReader& reader, FaultEntry& fault) {
  using Kind = DeviceFault::Kind;
  constexpr double kLongest = 1e-3 * DeviceFault::kMaxDelayCycles;  // s, of readings once a cycle
  fault.device = reader.text("sensor");
  fault.wrong.kind = read_wrong(reader, kOfReadings);
  if (fault.wrong.kind == Kind::kBias || fault.wrong.kind == Kind::kNoise) read_added(reader, fault.wrong);
  if (fault.wrong.kind == Kind::kValue) fault.wrong.value = read_input_value(reader);
  if (fault.wrong.kind == Kind::kDelay)
    fault.wrong.delay = nanoseconds(reader.number("delay_s", {}, {.low = 0.0, .high = kLongest, .low_open = true}));
  read_wrong_while(reader, fault);
}

void read_connection(ObjectReader& reader, FaultEntry& fault) {
  fault.device = reader.text("device");
  fault.wrong.kind = read_wrong(reader, kOfConnections);
  read_wrong_while(reader, fault);
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
                               "Remove it, or set \"do\": \"emergency_stop\" and category 1");
  const bool of_the_cell = fault.kind == FaultKind::kEmergencyStop || fault.kind == FaultKind::kReset;
  if (of_the_cell && !fault.arm.empty())
    reader.diagnostics().error(Code::kConflict, reader.at("arm"), "an emergency stop concerns all arms",
                               "Remove the arm, or set \"do\": \"stop\"");
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
  } else if (fault.kind == FaultKind::kDevice) {
    read_connection(reader, fault);
  } else {
    read_stop(reader, fault);
  }
  reader.finish();
  return fault;
}

}  // namespace

const std::string& name_of(FaultEntry::Kind kind) { return kWords[static_cast<std::size_t>(kind)]; }
const std::string& name_of(DeviceFault::Kind kind) { return kWrong[static_cast<std::size_t>(kind)]; }

void read_faults(ObjectReader& reader, std::vector<FaultEntry>& faults) {
  const Json* list = reader.array("faults", /*required=*/false);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i)
    faults.push_back(read_fault((*list)[i], reader.at("faults") + pointer_segment(i), reader.diagnostics()));
  std::ranges::stable_sort(faults, {}, &FaultEntry::at);
}

}  // namespace takt::cell
