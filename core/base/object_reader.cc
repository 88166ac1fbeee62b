#include "core/base/object_reader.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/angles.h"
#include "core/base/utf8.h"

namespace takt {
namespace {

using Json = nlohmann::ordered_json;

std::string range_text(const Range& range) {
  const bool low = std::isfinite(range.low);
  const bool high = std::isfinite(range.high);
  if (low && high && range.low_open) return fmt::format("Give a number above {}, at most {}", range.low, range.high);
  if (low && high) return fmt::format("Give a number from {} to {}", range.low, range.high);
  if (low) return fmt::format("Give a number {} {}", range.low_open ? "above" : "of at least", range.low);
  if (high) return fmt::format("Give a number of at most {}", range.high);
  return "Give a number";
}

bool inside(double value, const Range& range) {
  return (range.low_open ? value > range.low : value >= range.low) && value <= range.high;
}

/// More unknown keys than this are counted, not listed.
constexpr std::size_t kMostUnknown = 100;

/// A key in a message, and in the search for the nearest one, whose cost is the product of two lengths.
std::string short_key(std::string_view key) {
  constexpr std::size_t kMost = 100;
  return key.size() <= kMost ? std::string(key) : std::string(cut_utf8(key, kMost)) + "...";
}

constexpr const char* kObject = "Give an object {...}";
constexpr const char* kArray = "Give an array [...]";

}  // namespace

std::string short_dump(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = std::string(cut_utf8(text, 57)) + "...";
  return text;
}

ObjectReader::ObjectReader(const Json& json, std::string pointer, Diagnostics& diagnostics)
    : json_(json), pointer_(std::move(pointer)), diagnostics_(diagnostics) {
  if (!json_.is_object())
    diagnostics_.error(Code::kWrongType, pointer_, fmt::format("unexpected value {}", short_dump(json_)), kObject);
}

bool ObjectReader::has(std::string_view key) const { return json_.is_object() && json_.contains(key); }

std::string ObjectReader::at(std::string_view key) const { return pointer_ + pointer_segment(key); }

const Json* ObjectReader::find(std::string_view key, const std::string& wanted) {
  if (std::ranges::find(asked_, key) == asked_.end()) asked_.emplace_back(key);
  if (!json_.is_object()) return nullptr;
  const auto found = json_.find(key);
  if (found != json_.end()) return &*found;
  if (!wanted.empty()) diagnostics_.error(Code::kMissing, pointer_, fmt::format("key '{}' is missing", key), wanted);
  return nullptr;
}

double ObjectReader::number(std::string_view key, std::optional<double> fallback, const Range& range) {
  const Json* value = find(key, fallback ? "" : range_text(range));
  if (!value) return fallback.value_or(0.0);
  if (value->is_number() && inside(value->get<double>(), range)) return value->get<double>();
  diagnostics_.error(Code::kOutOfRange, at(key), "unexpected value " + short_dump(*value), range_text(range));
  return fallback.value_or(inside(0.0, range) ? 0.0 : (std::isfinite(range.low) ? range.low + 1.0 : range.high));
}

std::int64_t ObjectReader::integer(std::string_view key, std::optional<std::int64_t> fallback, const Range& range) {
  const std::string wanted = range_text(range) + ", whole";
  const Json* value = find(key, fallback ? "" : wanted);
  if (!value) return fallback.value_or(0);
  const bool whole =
      value->is_number_integer() && (!value->is_number_unsigned() || value->get<std::uint64_t>() <= INT64_MAX);
  if (whole && inside(static_cast<double>(value->get<std::int64_t>()), range)) return value->get<std::int64_t>();
  diagnostics_.error(Code::kOutOfRange, at(key), "unexpected value " + short_dump(*value), wanted);
  return fallback.value_or(0);
}

bool ObjectReader::boolean(std::string_view key, std::optional<bool> fallback) {
  const Json* value = find(key, fallback ? "" : "true or false");
  if (!value) return fallback.value_or(false);
  if (value->is_boolean()) return value->get<bool>();
  diagnostics_.error(Code::kWrongType, at(key), "unexpected value " + short_dump(*value), "Give true or false");
  return fallback.value_or(false);
}

std::string ObjectReader::text(std::string_view key, std::optional<std::string> fallback) {
  const Json* value = find(key, fallback ? "" : "Give a text");
  if (!value) return fallback.value_or("");
  const bool empty = value->is_string() && value->get_ref<const std::string&>().empty();
  if (value->is_string() && (fallback || !empty)) return value->get<std::string>();
  diagnostics_.error(Code::kWrongType, at(key), "unexpected value " + short_dump(*value),
                     empty ? "Give a text that is not empty" : "Give a text");
  return fallback.value_or("");
}

std::string ObjectReader::choice(std::string_view key, const std::vector<std::string>& choices,
                                 std::optional<std::string> fallback) {
  if (!fallback && !find(key, nearest_choice("", choices))) return "";
  const std::size_t before = diagnostics_.list().size();
  const std::string value = text(key, fallback);
  if (diagnostics_.list().size() != before || std::ranges::find(choices, value) != choices.end()) return value;
  if (!has(key)) return value;
  diagnostics_.error(Code::kUnknownName, at(key), fmt::format("unknown value '{}'", value),
                     nearest_choice(value, choices));
  return fallback.value_or("");
}

std::vector<double> ObjectReader::numbers(std::string_view key, std::size_t size,
                                          std::optional<std::vector<double>> fallback, const Range& range) {
  const std::vector<double> placeholder = fallback.value_or(std::vector<double>(size, 0.0));
  const std::string expected = size ? fmt::format("Give an array of {} numbers", size) : "Give an array of numbers";
  const Json* value = find(key, fallback ? "" : expected);
  if (!value) return placeholder;
  if (!value->is_array() || (size && value->size() != size)) {
    diagnostics_.error(Code::kWrongType, at(key), "unexpected value " + short_dump(*value), expected);
    return placeholder;
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < value->size(); ++i) {
    const Json& item = (*value)[i];
    const bool good = item.is_number() && inside(item.get<double>(), range);
    if (!good)
      diagnostics_.error(Code::kWrongType, at(key) + pointer_segment(i), "unexpected value " + short_dump(item),
                         range_text(range));
    result.push_back(good ? item.get<double>() : (inside(0.0, range) ? 0.0 : 1.0));
  }
  return result;
}

Eigen::Vector3d ObjectReader::vector(std::string_view key, std::optional<Eigen::Vector3d> fallback) {
  std::optional<std::vector<double>> values;
  if (fallback) values = {fallback->x(), fallback->y(), fallback->z()};
  return Eigen::Vector3d(numbers(key, 3, values).data());
}

std::vector<std::string> ObjectReader::texts(std::string_view key, std::optional<std::vector<std::string>> fallback) {
  const Json* value = find(key, fallback ? "" : "Give an array of texts");
  if (!value) return fallback.value_or(std::vector<std::string>{});
  if (!value->is_array()) {
    diagnostics_.error(Code::kWrongType, at(key), "unexpected value " + short_dump(*value), "Give an array of texts");
    return {};
  }
  std::vector<std::string> result;
  for (std::size_t i = 0; i < value->size(); ++i) {
    if ((*value)[i].is_string()) {
      result.push_back((*value)[i].get<std::string>());
    } else {
      diagnostics_.error(Code::kWrongType, at(key) + pointer_segment(i), "unexpected value " + short_dump((*value)[i]),
                         "Give a text");
    }
  }
  return result;
}

const Json* ObjectReader::child(std::string_view key) { return find(key); }

const Json* ObjectReader::object(std::string_view key, bool required) {
  const Json* value = find(key, required ? kObject : "");
  if (!value || value->is_object()) return value;
  diagnostics_.error(Code::kWrongType, at(key), "unexpected value " + short_dump(*value), kObject);
  return nullptr;
}

const Json* ObjectReader::array(std::string_view key, bool required) {
  const Json* value = find(key, required ? kArray : "");
  if (!value || value->is_array()) return value;
  diagnostics_.error(Code::kWrongType, at(key), "unexpected value " + short_dump(*value), kArray);
  return nullptr;
}

Eigen::Quaterniond ObjectReader::rotation() {
  if (has("quaternion") && has("rpy_deg")) {
    diagnostics_.error(Code::kConflict, pointer_, "both 'quaternion' and 'rpy_deg' are given", "Remove one of the two");
  }
  if (has("quaternion")) {
    const auto values = numbers("quaternion", 4, std::vector<double>{1, 0, 0, 0});
    const Eigen::Quaterniond q(values[0], values[1], values[2], values[3]);
    if (std::abs(q.norm() - 1.0) > 1e-3) {
      diagnostics_.error(Code::kOutOfRange, at("quaternion"), fmt::format("the norm is {:.6g}", q.norm()),
                         "Give a unit quaternion [w, x, y, z]");
      return Eigen::Quaterniond::Identity();
    }
    return q.normalized();
  }
  const auto rpy = numbers("rpy_deg", 3, std::vector<double>{0, 0, 0});
  warn_of_radians(rpy, at("rpy_deg"), diagnostics_);
  constexpr double kRadians = std::numbers::pi / 180.0;
  return Eigen::AngleAxisd(rpy[2] * kRadians, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(rpy[1] * kRadians, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(rpy[0] * kRadians, Eigen::Vector3d::UnitX());
}

Eigen::Isometry3d ObjectReader::pose() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = vector("position_m", Eigen::Vector3d(Eigen::Vector3d::Zero()));
  X.linear() = rotation().toRotationMatrix();
  return X;
}

void ObjectReader::finish() {
  if (!json_.is_object()) return;
  std::size_t unknown = 0;
  for (const auto& [key, value] : json_.get_ref<const Json::object_t&>()) {
    if (key.starts_with("$") || key == "comment" || std::ranges::find(asked_, key) != asked_.end()) continue;
    if (++unknown > kMostUnknown) continue;
    diagnostics_.error(Code::kUnknownKey, at(key), fmt::format("unknown key '{}'", short_key(key)),
                       nearest_choice(short_key(key), asked_, 30));
  }
  if (unknown > kMostUnknown) {
    diagnostics_.error(Code::kUnknownKey, pointer_, fmt::format("{} more unknown keys", unknown - kMostUnknown),
                       nearest_choice("", asked_, 30));
  }
}

}  // namespace takt
