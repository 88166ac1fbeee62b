#include "core/net/value_json.h"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"

namespace takt::net {

namespace {

using Json = nlohmann::ordered_json;

/// Unit quaternions in files are written by hand ("0.7071"); what is further off is a mistake.
constexpr double kNormTolerance = 1e-3;

Diagnostics expected(const Json& json, std::string_view what) {
  Diagnostics diagnostics;
  diagnostics.error(Code::kSyntax, {}, fmt::format("{} is not {}", short_dump(json), what));
  return diagnostics;
}

/// Reads n numbers; n = 0 takes as many as there are, at most `capacity`.
Diagnostics numbers(const Json& json, std::size_t n, std::size_t capacity, std::string_view form, double* values) {
  if (!json.is_array()) return expected(json, form);
  if (n != 0 ? json.size() != n : json.size() > capacity) {
    Diagnostics diagnostics;
    diagnostics.error(Code::kWrongSize, {}, fmt::format("{} elements", json.size()), std::string(form));
    return diagnostics;
  }
  Diagnostics diagnostics;
  for (std::size_t i = 0; i < json.size(); ++i) {
    diagnostics.append(value_from_json(json[i], values[i]), pointer_segment(i));
  }
  return diagnostics;
}

/// Reads an object with two keys that hold three or four numbers each.
Diagnostics pair_of_arrays(const Json& json, std::string_view form, std::string_view first, double* first_values,
                           std::string_view second, double* second_values, std::size_t second_size) {
  if (!json.is_object()) return expected(json, form);
  Diagnostics diagnostics;
  for (const auto& [key, value] : json.items()) {
    if (key == first) {
      diagnostics.append(numbers(value, 3, 3, "[x,y,z]", first_values), pointer_segment(first));
    } else if (key == second) {
      diagnostics.append(
          numbers(value, second_size, second_size, second_size == 4 ? "[w,x,y,z]" : "[x,y,z]", second_values),
          pointer_segment(second));
    } else {
      diagnostics.error(Code::kUnknownKey, pointer_segment(key), fmt::format("unknown key '{}'", key),
                        nearest_choice(key.substr(0, 64), {std::string(first), std::string(second)}));
    }
  }
  return diagnostics;
}

Diagnostics unit_quaternion(const double (&wxyz)[4], Rotation& value) {
  const Rotation q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  const double norm = q.norm();
  Diagnostics diagnostics;
  if (!(std::abs(norm - 1.0) <= kNormTolerance)) {
    diagnostics.error(Code::kOutOfRange, {}, fmt::format("quaternion of norm {:.6g}", norm),
                      "Give [w,x,y,z] with norm 1 within 0.001");
    return diagnostics;
  }
  value = norm == 1.0 ? q : q.normalized();
  return diagnostics;
}

struct Interval {
  double low, high;
  bool low_open, high_open;
};

[[noreturn]] void malformed_range(std::string_view text) {
  std::fprintf(stderr, "takt: malformed range text '%.*s' in a primitive\n", static_cast<int>(text.size()),
               text.data());
  std::abort();
}

double bound(std::string_view text, std::string_view whole) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) malformed_range(whole);
  return value;
}

Interval parse_interval(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (text.size() < 5 || comma == std::string_view::npos) malformed_range(text);
  const char open = text.front(), close = text.back();
  if ((open != '(' && open != '[') || (close != ')' && close != ']')) malformed_range(text);
  return {bound(text.substr(1, comma - 1), text), bound(text.substr(comma + 1, text.size() - comma - 2), text),
          open == '(', close == ')'};
}

bool inside(double value, const Interval& interval) {
  const bool above = interval.low_open ? value > interval.low : value >= interval.low;
  const bool below = interval.high_open ? value < interval.high : value <= interval.high;
  return above && below;
}

Diagnostics check_numbers(std::span<const double> values, std::string_view range, bool indexed) {
  Diagnostics diagnostics;
  const Interval interval = parse_interval(range);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (inside(values[i], interval)) continue;
    diagnostics.error(Code::kOutOfRange, indexed ? pointer_segment(i) : "",
                      fmt::format("{} is out of range", values[i]), fmt::format("Choose from {}", range));
  }
  return diagnostics;
}

Diagnostics check_words(std::string_view value, std::string_view range) {
  std::vector<std::string> words;
  for (std::size_t start = 0; start <= range.size();) {
    const std::size_t end = std::min(range.find('|', start), range.size());
    words.emplace_back(range.substr(start, end - start));
    start = end + 1;
  }
  Diagnostics diagnostics;
  if (std::ranges::find(words, value) == words.end()) {
    diagnostics.error(Code::kUnknownName, {}, fmt::format("'{}' is not allowed", value.substr(0, 64)),
                      nearest_choice(value.substr(0, 64), words));
  }
  return diagnostics;
}

}  // namespace

template <>
Diagnostics value_from_json(const Json& json, Boolean& value) {
  if (!json.is_boolean()) return expected(json, "a Boolean (true or false)");
  value = json.get<bool>();
  return {};
}

template <>
Diagnostics value_from_json(const Json& json, Integer& value) {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<Integer>::max());
  if (json.is_number_unsigned() ? json.get<std::uint64_t>() > kMost : !json.is_number_integer()) {
    return expected(json, "an Integer of 64 bits");
  }
  value = json.get<Integer>();
  return {};
}

template <>
Diagnostics value_from_json(const Json& json, Real& value) {
  if (!json.is_number()) return expected(json, "a number");
  double read = json.get<double>();
  if (!canonicalise(read)) return expected(json, "finite");
  value = read;
  return {};
}

template <>
Diagnostics value_from_json(const Json& json, std::string& value) {
  if (!json.is_string()) return expected(json, "a text");
  value = json.get_ref<const std::string&>();
  return {};
}

template <>
Diagnostics value_from_json(const Json& json, Text& value) {
  if (!json.is_string()) return expected(json, "a text");
  const std::string& text = json.get_ref<const std::string&>();
  if (text.size() > value.bytes.size()) return expected(json, "at most 63 bytes long");
  value = Text(text);
  return {};
}

template <>
Diagnostics value_from_json(const Json& json, Vector& value) {
  Vector read;
  Diagnostics diagnostics = numbers(json, 3, 3, "a Vector [x,y,z]", read.data());
  if (diagnostics.empty()) value = read;
  return diagnostics;
}

template <>
Diagnostics value_from_json(const Json& json, Rotation& value) {
  double wxyz[4];
  Diagnostics diagnostics = numbers(json, 4, 4, "a Rotation [w,x,y,z]", wxyz);
  if (diagnostics.empty()) diagnostics = unit_quaternion(wxyz, value);
  return diagnostics;
}

template <>
Diagnostics value_from_json(const Json& json, Frame& value) {
  Vector position = Vector::Zero();
  double wxyz[4] = {1.0, 0.0, 0.0, 0.0};
  Diagnostics diagnostics = pair_of_arrays(json, R"(a Frame {"position":[x,y,z],"quaternion":[w,x,y,z]})", "position",
                                           position.data(), "quaternion", wxyz, 4);
  if (!diagnostics.empty()) return diagnostics;
  Rotation rotation;
  diagnostics.append(unit_quaternion(wxyz, rotation), "/quaternion");
  if (!diagnostics.empty()) return diagnostics;
  value.linear() = rotation.toRotationMatrix();
  value.translation() = position;
  canonicalise(value);
  return {};
}

template <>
Diagnostics value_from_json(const Json& json, Twist& value) {
  Twist read;
  Diagnostics diagnostics = pair_of_arrays(json, R"(a Twist {"linear":[x,y,z],"angular":[x,y,z]})", "linear",
                                           read.linear.data(), "angular", read.angular.data(), 3);
  if (diagnostics.empty()) value = read;
  return diagnostics;
}

template <>
Diagnostics value_from_json(const Json& json, Wrench& value) {
  Wrench read;
  Diagnostics diagnostics = pair_of_arrays(json, R"(a Wrench {"force":[x,y,z],"torque":[x,y,z]})", "force",
                                           read.force.data(), "torque", read.torque.data(), 3);
  if (diagnostics.empty()) value = read;
  return diagnostics;
}

template <>
Diagnostics value_from_json(const Json& json, JointArray& value) {
  JointArray read;
  Diagnostics diagnostics = numbers(json, 0, kJointCapacity, "a joint array of at most 12 numbers", read.value.data());
  if (!diagnostics.empty()) return diagnostics;
  read.size = static_cast<std::int64_t>(json.size());
  value = read;
  return {};
}

template <>
Json value_to_json(const Boolean& value) {
  return value;
}
template <>
Json value_to_json(const Integer& value) {
  return value;
}
template <>
Json value_to_json(const Real& value) {
  return value;
}
template <>
Json value_to_json(const std::string& value) {
  return value;
}
template <>
Json value_to_json(const Text& value) {
  return std::string(value.view());
}
template <>
Json value_to_json(const Vector& value) {
  return {value.x(), value.y(), value.z()};
}
template <>
Json value_to_json(const Rotation& value) {
  return {value.w(), value.x(), value.y(), value.z()};
}
template <>
Json value_to_json(const Frame& value) {
  return {{"position", value_to_json(Vector(value.translation()))},
          {"quaternion", value_to_json(Rotation(value.linear()))}};
}
template <>
Json value_to_json(const Twist& value) {
  return {{"linear", value_to_json(value.linear)}, {"angular", value_to_json(value.angular)}};
}
template <>
Json value_to_json(const Wrench& value) {
  return {{"force", value_to_json(value.force)}, {"torque", value_to_json(value.torque)}};
}
template <>
Json value_to_json(const JointArray& value) {
  Json json = Json::array();
  for (int i = 0; i < value.size; ++i) json.push_back(value.value[static_cast<std::size_t>(i)]);
  return json;
}

Json slot_to_json(ValueType type, const void* slot) {
  return visit_type(type, [slot]<class T>(std::type_identity<T>) -> Json {
    const auto& typed = *static_cast<const Slot<T>*>(slot);
    return typed.null != 0 ? Json(nullptr) : value_to_json(typed.value);
  });
}

template <class T>
Diagnostics check_range(const T& value, std::string_view range) {
  if (range.empty()) return {};
  if constexpr (std::is_same_v<T, Real>) {
    return check_numbers({&value, 1}, range, false);
  } else if constexpr (std::is_same_v<T, Integer>) {
    const double number = static_cast<double>(value);
    return check_numbers({&number, 1}, range, false);
  } else if constexpr (std::is_same_v<T, Vector>) {
    return check_numbers({value.data(), 3}, range, true);
  } else if constexpr (std::is_same_v<T, JointArray>) {
    return check_numbers({value.value.data(), static_cast<std::size_t>(value.size)}, range, true);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return check_words(value, range);
  } else if constexpr (std::is_same_v<T, Text>) {
    return check_words(value.view(), range);
  } else {
    return {};
  }
}

template Diagnostics check_range(const Boolean&, std::string_view);
template Diagnostics check_range(const Integer&, std::string_view);
template Diagnostics check_range(const Real&, std::string_view);
template Diagnostics check_range(const Text&, std::string_view);
template Diagnostics check_range(const std::string&, std::string_view);
template Diagnostics check_range(const Vector&, std::string_view);
template Diagnostics check_range(const Rotation&, std::string_view);
template Diagnostics check_range(const Frame&, std::string_view);
template Diagnostics check_range(const Twist&, std::string_view);
template Diagnostics check_range(const Wrench&, std::string_view);
template Diagnostics check_range(const JointArray&, std::string_view);

}  // namespace takt::net
