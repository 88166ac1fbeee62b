#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"

namespace takt {

/// Closed interval of numbers that a key may have.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< `low` itself is not allowed
};

inline constexpr Range kAnyNumber{};
inline constexpr Range kPositive{.low = 0.0, .low_open = true};
inline constexpr Range kNotNegative{.low = 0.0};

/// Reads one JSON object strictly: each key is asked for once, wrong types and ranges become diagnostics with pointer,
/// value and what is allowed, and finish() reports keys that nobody asked for with the nearest one that exists.
/// After a diagnostic the fallback is returned, so that reading goes on and all errors are seen at once.
/// Keeps references to the JSON and the diagnostics: they must outlive it. Realtime: setup.
class ObjectReader {
 public:
  ObjectReader(const nlohmann::ordered_json& json, std::string pointer, Diagnostics& diagnostics);

  [[nodiscard]] bool has(std::string_view key) const;
  /// JSON pointer of a key of this object.
  [[nodiscard]] std::string at(std::string_view key) const;

  /// A diagnostic if the key is missing and no fallback is given.
  double number(std::string_view key, std::optional<double> fallback = {}, const Range& range = kAnyNumber);
  std::int64_t integer(std::string_view key, std::optional<std::int64_t> fallback = {},
                       const Range& range = kAnyNumber);
  bool boolean(std::string_view key, std::optional<bool> fallback = {});
  /// A text without a fallback names something: the empty one is a diagnostic too.
  std::string text(std::string_view key, std::optional<std::string> fallback = {});
  /// A text that must be one of `choices`.
  std::string choice(std::string_view key, const std::vector<std::string>& choices,
                     std::optional<std::string> fallback = {});
  /// An array of numbers; `size` 0 = any length.
  std::vector<double> numbers(std::string_view key, std::size_t size, std::optional<std::vector<double>> fallback = {},
                              const Range& range = kAnyNumber);
  Eigen::Vector3d vector(std::string_view key, std::optional<Eigen::Vector3d> fallback = {});
  std::vector<std::string> texts(std::string_view key, std::optional<std::vector<std::string>> fallback = {});
  /// The value of a key as it is; nullptr if absent.
  const nlohmann::ordered_json* child(std::string_view key);
  /// child(), with a diagnostic if it is absent or not of the kind "object" or "array".
  const nlohmann::ordered_json* object(std::string_view key, bool required = true);
  const nlohmann::ordered_json* array(std::string_view key, bool required = true);

  /// Orientation from "rpy_deg" [roll, pitch, yaw] (about fixed x, y, z) or "quaternion" [w, x, y, z]; identity if
  /// neither.
  Eigen::Quaterniond rotation();
  /// "position_m" (default zero) and rotation().
  Eigen::Isometry3d pose();

  /// Reports every key that was never asked for. Keys starting with "$" and "comment" are always allowed.
  void finish();

  Diagnostics& diagnostics() { return diagnostics_; }
  [[nodiscard]] const std::string& pointer() const { return pointer_; }
  [[nodiscard]] const nlohmann::ordered_json& json() const { return json_; }

 private:
  /// @param wanted  what should stand there if the key is required; empty: it is not
  const nlohmann::ordered_json* find(std::string_view key, const std::string& wanted = {});

  const nlohmann::ordered_json& json_;
  std::string pointer_;
  Diagnostics& diagnostics_;
  std::vector<std::string> asked_;
};

/// Short JSON text of a value for messages, cut after 60 characters.
[[nodiscard]] std::string short_dump(const nlohmann::ordered_json& json);

}  // namespace takt
