#include "core/device/control_mode.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/net/format_text.h"

namespace takt::device {

namespace {

constexpr std::array kModes = {ControlMode::kPosition, ControlMode::kJointImpedance, ControlMode::kCartesianImpedance};

/// One kind of value: what it is called and where it lies.
struct Field {
  std::string_view name;
  JointVector Compliance::*per_axis = nullptr;
  double Compliance::*single = nullptr;

  [[nodiscard]] Eigen::Index size(const Compliance& c) const { return per_axis != nullptr ? (c.*per_axis).size() : 1; }
  [[nodiscard]] double get(const Compliance& c, Eigen::Index i) const {
    return per_axis != nullptr ? (c.*per_axis)[i] : c.*single;
  }
  void set(Compliance& c, Eigen::Index i, double value) const {
    (per_axis != nullptr ? (c.*per_axis)[i] : c.*single) = value;
  }
};

constexpr std::array<Field, 5> kFields = {{{"stiffness", &Compliance::stiffness, nullptr},
                                           {"damping ratio", &Compliance::damping_ratio, nullptr},
                                           {"feed-forward", &Compliance::feed_forward, nullptr},
                                           {"nullspace stiffness", nullptr, &Compliance::nullspace_stiffness},
                                           {"nullspace damping ratio", nullptr, &Compliance::nullspace_damping_ratio}}};

/// Against rounding where a value stands exactly on a limit.
constexpr double kShare = 1e-3;

std::optional<net::Text> fault_at(const Field& field, Eigen::Index i, const Compliance& next, const Compliance& last,
                                  const ComplianceRange& range, double share) {
  const double value = field.get(next, i), lower = field.get(range.lower, i), upper = field.get(range.upper, i);
  const double width = upper - lower, step = value - field.get(last, i);
  if (!std::isfinite(value)) return net::format_text("{} of axis {} is not finite", field.name, i + 1);
  if (value < lower - kShare * width || value > upper + kShare * width)
    return net::format_text("{} of axis {}: {:.5g} outside [{:.5g}, {:.5g}]", field.name, i + 1, value, lower, upper);
  if (std::abs(step) > share * width * (1.0 + kShare))
    return net::format_text("{} of axis {}: step {:.4g} beyond {:.4g}", field.name, i + 1, step, share * width);
  return std::nullopt;
}

}  // namespace

std::span<const ControlMode> all_control_modes() { return kModes; }

std::string_view name_of(ControlMode mode) {
  switch (mode) {
    case ControlMode::kPosition:
      return "position";
    case ControlMode::kJointImpedance:
      return "joint_impedance";
    case ControlMode::kCartesianImpedance:
      return "cartesian_impedance";
  }
  return "";
}

std::optional<ControlMode> control_mode_of(std::string_view name) {
  for (const ControlMode mode : kModes)
    if (name_of(mode) == name) return mode;
  return std::nullopt;
}

std::string_view name_of(ChangeClass change) {
  switch (change) {
    case ChangeClass::kSeamless:
      return "seamless";
    case ChangeClass::kAtStandstill:
      return "at_standstill";
    case ChangeClass::kOutsideNet:
      return "outside_net";
  }
  return "";
}

bool Compliance::operator==(const Compliance& other) const {
  if (mode != other.mode || in_tool_axes != other.in_tool_axes) return false;
  return std::ranges::all_of(kFields, [&](const Field& field) {
    if (field.size(*this) != field.size(other)) return false;
    for (Eigen::Index i = 0; i < field.size(*this); ++i)
      if (field.get(*this, i) != field.get(other, i)) return false;
    return true;
  });
}

bool ControlModes::has(ControlMode mode) const { return std::ranges::find(modes, mode) != modes.end(); }

const ModeChange* ControlModes::find(ControlMode from, ControlMode to) const {
  for (const ModeChange& change : changes)
    if (change.from == from && change.to == to) return &change;
  return nullptr;
}

std::string ControlModes::list() const {
  std::string text;
  for (const ControlMode mode : modes) {
    if (!text.empty()) text += ", ";
    text += name_of(mode);
  }
  return text;
}

std::optional<net::Text> find_fault(const Compliance& next, const Compliance& last, const ComplianceRange& range,
                                    double share) {
  for (const Field& field : kFields) {
    const Eigen::Index size = field.size(range.upper);
    if (field.size(next) != size || field.size(last) != size)
      return net::format_text("{} has {} axes, not {}", field.name, field.size(next), size);
    for (Eigen::Index i = 0; i < size; ++i)
      if (const auto fault = fault_at(field, i, next, last, range, share)) return fault;
  }
  return std::nullopt;
}

Compliance approach(const Compliance& from, const Compliance& to, const ComplianceRange& range, double share) {
  Compliance next = to;
  for (const Field& field : kFields) {
    for (Eigen::Index i = 0; i < field.size(range.upper); ++i) {
      const double step = share * (field.get(range.upper, i) - field.get(range.lower, i));
      const double was = field.get(from, i);
      field.set(next, i, std::clamp(field.get(to, i), was - step, was + step));
    }
  }
  return next;
}

Compliance stopped(const Compliance& compliance, const ComplianceRange& range) {
  Compliance target = compliance;
  target.feed_forward.setZero();
  if (range.stiff_on_stop) target.stiffness = range.upper.stiffness;
  return target;
}

}  // namespace takt::device
