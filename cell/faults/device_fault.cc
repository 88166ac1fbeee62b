// Faults "sensor" and "device": wrong readings, and connections that fail, for a while.
#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "cell/faults/fault_kinds.h"
#include "cell/file/description.h"
#include "cell/file/fault_point.h"

namespace takt::cell {
namespace {

using Wrong = DeviceFault::Kind;
using Json = nlohmann::ordered_json;

struct WrongName {
  Wrong kind;
  const char* name;
};
constexpr std::array<WrongName, 10> kWrong{{{Wrong::kSilent, "silent"},
                                            {Wrong::kNan, "nan"},
                                            {Wrong::kStuck, "stuck"},
                                            {Wrong::kBias, "bias"},
                                            {Wrong::kNoise, "noise"},
                                            {Wrong::kDelay, "delay"},
                                            {Wrong::kValue, "value"},
                                            {Wrong::kGone, "gone"},
                                            {Wrong::kLoss, "loss"},
                                            {Wrong::kJammed, "jammed"}}};

std::string name_of(Wrong kind) { return std::ranges::find(kWrong, kind, &WrongName::kind)->name; }

/// Of key "fault"; after a diagnostic the first.
Wrong read_wrong(FaultReader& from) {
  const auto found =
      std::ranges::find(kWrong, from.choice("fault"), [](const WrongName& one) { return std::string(one.name); });
  return found == kWrong.end() ? Wrong::kSilent : found->kind;
}

/// What is wrong with one device for a while; of two such faults the newer one holds.
class OneDeviceFault : public Fault {
 public:
  void begin(FaultScene& scene) override {
    scene.note(word_, fmt::format("{}: {} for {:g} s", device_, name_of(wrong_.kind), to_seconds(*duration)));
    scene.newest_of_device[device_] = this;
    scene.built.fault_points.at(device_)->begin(wrong_, scene.seed, device_);
  }
  void end(FaultScene& scene) override {
    const auto newest = scene.newest_of_device.find(device_);
    if (newest == scene.newest_of_device.end() || newest->second != this) return;
    scene.newest_of_device.erase(newest);
    scene.built.fault_points.at(device_)->end();
    scene.note(word_, fmt::format("{}: well again", device_));
  }

 protected:
  /// @param word  the kind, and the key that names the device; @param names  that it may have
  OneDeviceFault(FaultReader& from, std::string word, std::string_view what, const std::vector<std::string>& names)
      : word_(std::move(word)), device_(from.device(word_, what, names)) {
    wrong_.kind = read_wrong(from);
    const auto point = from.built.fault_points.find(device_);
    if (point == from.built.fault_points.end() || std::ranges::find(names, device_) == names.end()) return;
    const auto kinds = point->second->kinds();
    if (std::ranges::find(kinds, wrong_.kind) != kinds.end()) return;
    std::vector<std::string> possible;
    for (const Wrong kind : kinds) possible.push_back(name_of(kind));
    from.diagnostics().error(Code::kInvalidValue, from.at("fault"),
                             fmt::format("'{}' cannot have the fault '{}'", device_, name_of(wrong_.kind)),
                             fmt::format("Choose one of {}", fmt::join(possible, ", ")));
  }
  void read_how_long(FaultReader& from) {
    if (wrong_.kind == Wrong::kLoss) wrong_.share = from.number("share");
    duration = from.duration(kLongestRun);
  }
  [[nodiscard]] DeviceFault& wrong() { return wrong_; }

 private:
  std::string word_, device_;
  DeviceFault wrong_;
};

std::vector<std::string> names_of_readings(const expression::Cell& cell) {
  std::vector<std::string> names;
  const auto add = [&](const auto& devices) {
    for (const auto& [name, device] : devices) names.push_back(name);
  };
  add(cell.sensors);
  add(cell.digital_inputs);
  add(cell.analog_inputs);
  return names;
}

class SensorFault final : public OneDeviceFault {
 public:
  explicit SensorFault(FaultReader& from)
      : OneDeviceFault(from, "sensor", "sensor or input", names_of_readings(from.built.cell)) {
    if (wrong().kind == Wrong::kBias || wrong().kind == Wrong::kNoise) read_added(from);
    if (wrong().kind == Wrong::kValue) wrong().value = read_value(from);
    if (wrong().kind == Wrong::kDelay) wrong().delay = from.time("delay_s");
    read_how_long(from);
  }

 private:
  /// In N and Nm of a force/torque sensor, else in the unit of the input.
  void read_added(FaultReader& from) {
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    wrong().wrench.force = from.vector("force_N", none);
    wrong().wrench.torque = from.vector("torque_Nm", none);
    wrong().value = from.has("value") ? from.object().number("value") : 0.0;
    if (!from.has("force_N") && !from.has("torque_Nm") && !from.has("value"))
      from.diagnostics().error(Code::kMissing, from.pointer(), "nothing is added to the readings",
                               "Give \"force_N\" or \"torque_Nm\"; of an input \"value\"");
  }
  static double read_value(FaultReader& from) {
    const Json* value = from.has("value") ? from.object().child("value") : nullptr;
    if (value != nullptr && value->is_boolean()) return value->get<bool>() ? 1.0 : 0.0;
    return from.object().number("value");
  }
};

std::vector<std::string> names_of_connections(const expression::Cell& cell) {
  std::vector<std::string> names;
  for (const auto& [name, arm] : cell.arms) names.push_back(name);
  for (const auto& [name, gripper] : cell.grippers) names.push_back(name);
  return names;
}

class ConnectionFault final : public OneDeviceFault {
 public:
  explicit ConnectionFault(FaultReader& from)
      : OneDeviceFault(from, "device", "arm, base or gripper", names_of_connections(from.built.cell)) {
    read_how_long(from);
  }
};

Key share_key() {
  return number_key("share", "", {.low = 0.0, .high = 1.0, .low_open = true},
                    "With loss, required: share that does not arrive, drawn from the scenario's seed.")
      .optional();
}

}  // namespace

FaultKind sensor_fault() {
  constexpr double kLongestDelay = 1e-3 * DeviceFault::kMaxDelayCycles;  // s, of readings once a cycle
  return fault_kind<SensorFault>(
      "sensor", Concerns::kCore,
      {"The readings of a sensor or an input are wrong.",
       {text_key("sensor", "A force/torque sensor, a light barrier, a range finder, or an input BLOCK/TERMINAL.", 1),
        choice_key("fault", {"silent", "nan", "stuck", "bias", "noise", "delay", "value", "loss"},
                   "silent: no reading; nan: not a number; stuck: the last reading again and again; bias: an offset; "
                   "noise; delay: readings that come late; value, of an input: whatever is there; loss: a share of the "
                   "readings does not arrive. nan, bias and noise are not for digital inputs, value not for "
                   "force/torque sensors."),
        vector_key("force_N", "N", "With bias what it adds in the axes of the sensor, with noise its sigma per axis.")
            .optional("zero"),
        vector_key("torque_Nm", "Nm", "With bias what it adds, with noise its sigma per axis.").optional("zero"),
        any_of_key("value", {"number", "boolean"},
                   "Of an input: what bias adds, or the sigma of noise, or with value what it reads, in its unit; of a "
                   "digital one true or false.")
            .optional(),
        number_key("delay_s", "s", {.low = 0.0, .high = kLongestDelay, .low_open = true},
                   "With delay, required: by how much readings are late.")
            .optional(),
        share_key(), duration_key("to the end")}});
}

FaultKind device_fault() {
  return fault_kind<ConnectionFault>(
      "device", Concerns::kCore,
      {"The connection to an arm, a base or a gripper fails, or the fingers are jammed.",
       {text_key("device", "An arm, a base or a gripper.", 1),
        choice_key("fault", {"gone", "loss", "jammed"},
                   "gone: nothing comes and nothing arrives; loss: a share of the samples and of the set points does "
                   "not arrive; jammed: what a gripper is told has no effect."),
        share_key(), duration_key("to the end")}});
}

}  // namespace takt::cell
