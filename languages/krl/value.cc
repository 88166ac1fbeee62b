#include "languages/krl/value.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

namespace takt::languages::krl {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kMillimetres = 1000.0;

/// Angles as A, B, C in degrees; where B is +-90 degrees C is 0.
std::array<double, 3> angles_of(const Eigen::Matrix3d& R) {
  const double b = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const bool upright = std::hypot(R(0, 0), R(1, 0)) < 1e-9;
  const double a = upright ? std::atan2(-R(0, 1), R(1, 1)) : std::atan2(R(1, 0), R(0, 0));
  const double c = upright ? 0.0 : std::atan2(R(2, 1), R(2, 2));
  return {a * kDegrees, b * kDegrees, c * kDegrees};
}

std::string kind_of(const Value& value) {
  constexpr std::array kNames{"nothing", "BOOL", "INT", "REAL", "a text", "a constant", "a structure", "an array"};
  if (value.kind == Value::Kind::kStructure && value.structure != nullptr) return value.structure->name;
  return kNames.at(static_cast<std::size_t>(value.kind));
}

std::string assign_structure(Value& target, const Type& type, const Value& value) {
  if (value.kind != Value::Kind::kStructure) return "unexpected " + kind_of(value) + " for " + to_string(type);
  if (value.structure == type.structure) {
    target = value;
    return {};
  }
  for (std::size_t i = 0; i < value.parts.size(); ++i) {
    const std::string& name = value.structure->fields[i].name;
    const int at = type.structure->find(name);
    if (at < 0 && value.parts[i].nothing()) continue;
    if (at < 0) return fmt::format("{} has no component {}", type.structure->name, name);
    const Field& field = type.structure->fields[static_cast<std::size_t>(at)];
    Value& part = target.parts[static_cast<std::size_t>(at)];
    if (value.parts[i].nothing()) continue;
    if (std::string wrong = assign(part, field.type, value.parts[i]); !wrong.empty()) return wrong;
  }
  return {};
}

}  // namespace

int Structure::find(std::string_view field) const {
  const auto found = std::ranges::find(fields, field, &Field::name);
  return found == fields.end() ? -1 : static_cast<int>(found - fields.begin());
}

std::string to_string(const Type& type) {
  switch (type.kind) {
    case Type::Kind::kBool:
      return "BOOL";
    case Type::Kind::kInt:
      return "INT";
    case Type::Kind::kReal:
      return "REAL";
    case Type::Kind::kChar:
      return "CHAR";
    case Type::Kind::kEnum:
      return type.enumeration->name;
    case Type::Kind::kStructure:
      return type.structure->name;
    default:
      return "unknown";
  }
}

Value Value::of(bool truth) {
  Value value;
  value.kind = Kind::kBool;
  value.truth = truth;
  return value;
}

Value Value::of(std::int64_t integer) {
  Value value;
  value.kind = Kind::kInt;
  value.integer = integer;
  return value;
}

Value Value::of(double real) {
  Value value;
  value.kind = Kind::kReal;
  value.real = real;
  return value;
}

Value Value::constant(std::string name) {
  Value value;
  value.kind = Kind::kEnum;
  value.text = std::move(name);
  return value;
}

Value Value::string(std::string text) {
  Value value;
  value.kind = Kind::kText;
  value.text = std::move(text);
  return value;
}

double Value::number_at(std::string_view field, double fallback) const {
  const int at = structure != nullptr ? structure->find(field) : -1;
  if (at < 0 || !parts[static_cast<std::size_t>(at)].is_number()) return fallback;
  return parts[static_cast<std::size_t>(at)].number();
}

bool Value::has(std::string_view field) const {
  const int at = structure != nullptr ? structure->find(field) : -1;
  return at >= 0 && !parts[static_cast<std::size_t>(at)].nothing();
}

std::string to_string(const Value& value) {
  switch (value.kind) {
    case Value::Kind::kBool:
      return value.truth ? "TRUE" : "FALSE";
    case Value::Kind::kInt:
      return fmt::format("{}", value.integer);
    case Value::Kind::kReal: {
      std::string text = fmt::format("{:.10g}", value.real == 0.0 ? 0.0 : value.real);
      return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
    }
    case Value::Kind::kText:
      return "\"" + value.text + "\"";
    case Value::Kind::kEnum:
      return "#" + value.text;
    case Value::Kind::kStructure: {
      std::string text = "{";
      for (std::size_t i = 0; i < value.parts.size(); ++i) {
        if (value.parts[i].nothing()) continue;
        text += (text.size() > 1 ? ", " : "") + value.structure->fields[i].name + " " + to_string(value.parts[i]);
      }
      return text + "}";
    }
    case Value::Kind::kArray: {
      std::string text = "[";
      for (const Value& part : value.parts) text += (text.size() > 1 ? ", " : "") + to_string(part);
      return text + "]";
    }
    default:
      return "nothing";
  }
}

Value make_value(const Type& type, const std::vector<int>& size, std::int64_t& left) {
  Value value;
  if (!size.empty() && type.kind != Type::Kind::kChar) {
    value.kind = Value::Kind::kArray;
    value.size = size;
    std::int64_t count = 1;
    for (const int one : size) count *= std::max(one, 0);
    if (count > left) {
      left = -1;
      return value;
    }
    for (std::int64_t i = 0; i < count && left >= 0; ++i) value.parts.push_back(make_value(type, {}, left));
    return value;
  }
  if (--left < 0 || type.kind != Type::Kind::kStructure) return value;
  value.kind = Value::Kind::kStructure;
  value.structure = type.structure;
  for (const Field& field : type.structure->fields) value.parts.push_back(make_value(field.type, field.size, left));
  return value;
}

std::string assign(Value& target, const Type& type, const Value& value) {
  if (value.nothing()) return "the value was never set";
  switch (type.kind) {
    case Type::Kind::kUnknown:
      target = value;
      return {};
    case Type::Kind::kBool:
      if (value.kind == Value::Kind::kBool) return target = value, std::string();
      break;
    case Type::Kind::kInt:
      if (value.is_number()) {
        const double number = std::round(value.number());
        if (std::abs(number) > std::numeric_limits<std::int32_t>::max())
          return fmt::format("{:g} is out of the range of INT", number);
        return target = Value::of(static_cast<std::int64_t>(number)), std::string();
      }
      break;
    case Type::Kind::kReal:
      if (value.is_number()) return target = Value::of(value.number()), std::string();
      break;
    case Type::Kind::kChar:
      if (value.kind == Value::Kind::kText) return target = value, std::string();
      break;
    case Type::Kind::kEnum:
      if (value.kind == Value::Kind::kEnum) {
        const auto& all = type.enumeration->constants;
        if (std::ranges::find(all, value.text) == all.end())
          return fmt::format("#{} is no constant of {}", value.text, type.enumeration->name);
        return target = value, std::string();
      }
      break;
    case Type::Kind::kStructure:
      return assign_structure(target, type, value);
  }
  return "unexpected " + kind_of(value) + " for " + to_string(type);
}

Eigen::Isometry3d to_pose(const Value& frame, const Eigen::Isometry3d& fallback) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  constexpr std::array kAxes{"X", "Y", "Z"};
  for (int i = 0; i < 3; ++i)
    X.translation()[i] =
        frame.number_at(kAxes[static_cast<std::size_t>(i)], fallback.translation()[i] * kMillimetres) / kMillimetres;
  if (!frame.has("A") && !frame.has("B") && !frame.has("C")) {
    X.linear() = fallback.linear();
    return X;
  }
  const auto [a, b, c] = angles_of(fallback.linear());
  const auto turn = [&](const char* name, double before, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(frame.number_at(name, before) / kDegrees, axis);
  };
  X.linear() = (turn("A", a, Eigen::Vector3d::UnitZ()) * turn("B", b, Eigen::Vector3d::UnitY()) *
                turn("C", c, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return X;
}

void set_pose(Value& frame, const Eigen::Isometry3d& X) {
  const auto angles = angles_of(X.linear());
  const Eigen::Vector3d p = X.translation() * kMillimetres;
  const std::array<std::pair<const char*, double>, 6> all{std::pair{"X", p.x()}, {"Y", p.y()},     {"Z", p.z()},
                                                          {"A", angles[0]},      {"B", angles[1]}, {"C", angles[2]}};
  for (const auto& [name, number] : all) {
    const int at = frame.structure->find(name);
    if (at >= 0) frame.parts[static_cast<std::size_t>(at)] = Value::of(number);
  }
}

}  // namespace takt::languages::krl
