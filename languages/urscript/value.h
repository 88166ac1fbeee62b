#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace takt::languages::urscript {

/// x, y, z in m and a rotation vector in rad.
using Pose = std::array<double, 6>;
/// What `run` gives; 0 is no thread.
struct ThreadHandle {
  int id = 0;
  bool operator==(const ThreadHandle&) const = default;
};

class Value;
using List = std::vector<Value>;

/// A value of a script. Lists and poses are values: an assignment copies.
class Value {
 public:
  using Data = std::variant<std::monostate, bool, std::int32_t, double, std::string, Pose, List, ThreadHandle>;

  Value() = default;
  Value(bool value) : data_(value) {}
  Value(std::int32_t value) : data_(value) {}
  Value(double value) : data_(value) {}
  Value(std::string value) : data_(std::move(value)) {}
  Value(const char* value) : data_(std::string(value)) {}
  Value(const Pose& value) : data_(value) {}
  Value(List value) : data_(std::move(value)) {}
  Value(ThreadHandle value) : data_(value) {}

  template <class T>
  [[nodiscard]] const T* get() const {
    return std::get_if<T>(&data_);
  }
  template <class T>
  [[nodiscard]] T* get() {
    return std::get_if<T>(&data_);
  }
  [[nodiscard]] bool is_none() const { return std::holds_alternative<std::monostate>(data_); }
  /// An integer or a real.
  [[nodiscard]] std::optional<double> number() const;
  /// A list of `count` numbers, or with `count` 6 a pose.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::size_t count) const;
  [[nodiscard]] std::optional<Pose> pose() const;
  /// What a condition makes of it: false is False, 0, and no thread; nothing is no condition.
  [[nodiscard]] std::optional<bool> truth() const;
  /// As textmsg() and to_str() write it.
  [[nodiscard]] std::string text() const;
  /// "an integer", "a list", ... for messages.
  [[nodiscard]] std::string_view kind() const;
  bool operator==(const Value&) const = default;

 private:
  Data data_;
};

[[nodiscard]] Value to_list(const std::vector<double>& numbers);

/// Operators of the language.
enum class Operator : std::uint8_t {
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kModulo,
  kEqual,
  kNotEqual,
  kLess,
  kGreater,
  kLessEqual,
  kGreaterEqual,
  kAnd,
  kOr,
  kXor
};
[[nodiscard]] std::string_view name_of(Operator op);
/// Lists element by element, also with a number. @return nothing if the operator has no meaning for the two.
[[nodiscard]] std::optional<Value> apply(Operator op, const Value& a, const Value& b);
[[nodiscard]] std::optional<Value> negated(const Value& a);

}  // namespace takt::languages::urscript
