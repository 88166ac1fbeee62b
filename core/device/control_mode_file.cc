#include "core/device/control_mode_file.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::device {

namespace {

using Json = nlohmann::ordered_json;

constexpr Eigen::Index kCartesianAxes = 6;

std::vector<std::string> mode_names() {
  std::vector<std::string> names;
  for (const ControlMode mode : all_control_modes()) names.emplace_back(name_of(mode));
  return names;
}

ControlMode mode_at(ObjectReader& reader, const char* key) {
  return control_mode_of(reader.choice(key, mode_names())).value_or(ControlMode::kPosition);
}

void read_modes(ObjectReader& control, ControlModes& modes) {
  const auto names = control.texts("modes");
  modes.modes.clear();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (const auto mode = control_mode_of(names[i])) {
      modes.modes.push_back(*mode);
    } else {
      control.diagnostics().error(Code::kUnknownName, control.at("modes") + pointer_segment(i),
                                  fmt::format("unknown control mode '{}'", names[i]),
                                  nearest_choice(names[i], mode_names()));
    }
  }
}

void read_change(const Json& json, const std::string& pointer, Diagnostics& diagnostics, ControlModes& modes) {
  ObjectReader reader(json, pointer, diagnostics);
  ModeChange change{.from = mode_at(reader, "from"), .to = mode_at(reader, "to")};
  const std::string name = reader.choice("class", {"seamless", "at_standstill", "outside_net"});
  for (const ChangeClass one : {ChangeClass::kSeamless, ChangeClass::kAtStandstill, ChangeClass::kOutsideNet})
    if (name_of(one) == name) change.change = one;
  const bool takes_time = change.change != ChangeClass::kSeamless;
  if (takes_time || reader.has("duration_ms"))
    change.duration = static_cast<Nanoseconds>(reader.number("duration_ms", {}, kNotNegative) * kMillisecond);
  if (!takes_time && change.duration > 0)
    diagnostics.error(Code::kConflict, reader.at("duration_ms"), "a seamless change takes no time",
                      "Remove the duration, or choose another class");
  for (const ControlMode mode : {change.from, change.to})
    if (!modes.has(mode))
      diagnostics.error(Code::kUnknownName, pointer, fmt::format("it has no mode '{}'", name_of(mode)), modes.list());
  if (change.from == change.to || modes.find(change.from, change.to) != nullptr)
    diagnostics.error(Code::kDuplicate, pointer,
                      fmt::format("from '{}' to '{}' again", name_of(change.from), name_of(change.to)),
                      "Give each pair of two modes once");
  reader.finish();
  modes.changes.push_back(change);
}

void read_changes(ObjectReader& control, ControlModes& modes) {
  const Json* list = control.array("mode_changes", /*required=*/false);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i)
    read_change((*list)[i], control.at("mode_changes") + pointer_segment(i), control.diagnostics(), modes);
}

/// Reads the ranges of one mode. Keys end in the unit, so they differ between the modes.
class RangeReader {
 public:
  RangeReader(ObjectReader& reader, ComplianceRange& range, Eigen::Index axes)
      : reader_(reader), range_(range), axes_(axes) {
    for (Compliance* part : {&range.lower, &range.upper, &range.standard})
      part->stiffness = part->damping_ratio = part->feed_forward = JointVector::Zero(axes);
  }

  void read_joint() {
    set(range_.upper.stiffness, 0, reader_.numbers("stiffness_max_Nm_rad", count(), {}, kNotNegative));
    set(range_.standard.stiffness, 0, reader_.numbers("stiffness_Nm_rad", count(), {}, kNotNegative));
    set(range_.upper.feed_forward, 0, reader_.numbers("torque_max_Nm", count(), {}, kNotNegative));
    read_rest();
  }

  void read_cartesian() {
    fill(range_.upper.stiffness, "stiffness_max_N_m", "rotational_stiffness_max_Nm_rad");
    fill(range_.standard.stiffness, "stiffness_N_m", "rotational_stiffness_Nm_rad");
    fill(range_.upper.feed_forward, "force_max_N", "torque_max_Nm");
    range_.upper.nullspace_stiffness = reader_.number("nullspace_stiffness_max_Nm_rad", {}, kNotNegative);
    range_.standard.nullspace_stiffness = reader_.number("nullspace_stiffness_Nm_rad", {}, kNotNegative);
    check_below(range_.standard.nullspace_stiffness, range_.upper.nullspace_stiffness, "nullspace_stiffness_Nm_rad");
    read_rest();
    range_.lower.nullspace_damping_ratio = range_.lower.damping_ratio[0];
    range_.upper.nullspace_damping_ratio = range_.upper.damping_ratio[0];
    range_.standard.nullspace_damping_ratio = range_.standard.damping_ratio[0];
  }

 private:
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(axes_); }

  static void set(JointVector& values, Eigen::Index from, const std::vector<double>& read) {
    for (std::size_t i = 0; i < read.size() && from + static_cast<Eigen::Index>(i) < values.size(); ++i)
      values[from + static_cast<Eigen::Index>(i)] = read[i];
  }
  void fill(JointVector& values, const char* linear, const char* angular) {
    set(values, 0, std::vector<double>(3, reader_.number(linear, {}, kNotNegative)));
    set(values, 3, std::vector<double>(3, reader_.number(angular, {}, kNotNegative)));
  }
  void check_below(double value, double most, const char* key) {
    if (value > most)
      reader_.diagnostics().error(Code::kOutOfRange, reader_.at(key), fmt::format("{} is above the largest", value),
                                  fmt::format("Keep it to at most {}", most));
  }

  void read_rest() {
    const auto ratio = reader_.numbers("damping_ratio_range", 2, std::vector{0.1, 1.0}, kPositive);
    const double low = ratio.size() == 2 ? ratio[0] : 0.1, high = ratio.size() == 2 ? ratio[1] : 1.0;
    if (low > high)
      reader_.diagnostics().error(Code::kOutOfRange, reader_.at("damping_ratio_range"),
                                  "the first is above the second");
    const double standard = reader_.number("damping_ratio", 0.7, {.low = low, .high = std::max(low, high)});
    range_.lower.damping_ratio.setConstant(low);
    range_.upper.damping_ratio.setConstant(high);
    range_.standard.damping_ratio.setConstant(standard);
    range_.lower.feed_forward = -range_.upper.feed_forward;
    for (Eigen::Index i = 0; i < axes_; ++i)
      check_below(range_.standard.stiffness[i], range_.upper.stiffness[i],
                  axes_ == kCartesianAxes && i >= 3 ? "rotational_stiffness_Nm_rad" : standard_key());
    range_.stiff_on_stop = reader_.choice("on_stop", {"compliant", "stiff"}, "compliant") == "stiff";
  }
  [[nodiscard]] const char* standard_key() const {
    return reader_.has("stiffness_N_m") ? "stiffness_N_m" : "stiffness_Nm_rad";
  }

  ObjectReader& reader_;
  ComplianceRange& range_;
  Eigen::Index axes_;
};

void read_range(ObjectReader& impedance, const ControlModes& modes, ControlMode mode, Eigen::Index axes,
                ComplianceRange& range) {
  const std::string key(name_of(mode));
  const Json* json = impedance.object(key, modes.has(mode));
  if (json == nullptr) return;
  if (!modes.has(mode))
    impedance.diagnostics().error(Code::kUnknownName, impedance.at(key), fmt::format("it has no mode '{}'", key),
                                  modes.list());
  ObjectReader reader(*json, impedance.at(key), impedance.diagnostics());
  RangeReader read(reader, range, axes);
  mode == ControlMode::kCartesianImpedance ? read.read_cartesian() : read.read_joint();
  for (Compliance* part : {&range.lower, &range.upper, &range.standard}) part->mode = mode;
  reader.finish();
}

}  // namespace

void read_control_modes(ObjectReader& control, int joint_count, ControlModes& modes, ImpedanceDescription& impedance) {
  read_modes(control, modes);
  read_changes(control, modes);
  const bool needed = modes.has(ControlMode::kJointImpedance) || modes.has(ControlMode::kCartesianImpedance);
  const Json* json = control.object("impedance", needed);
  if (json == nullptr) return;
  ObjectReader reader(*json, control.at("impedance"), control.diagnostics());
  impedance.ramp =
      static_cast<Nanoseconds>(reader.number("ramp_ms", 500.0, {.low = 10.0, .high = 60e3}) * kMillisecond);
  read_range(reader, modes, ControlMode::kJointImpedance, joint_count, impedance.joint);
  read_range(reader, modes, ControlMode::kCartesianImpedance, kCartesianAxes, impedance.cartesian);
  reader.finish();
}

}  // namespace takt::device
