#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/time.h"
#include "core/table/field.h"

/// How a value gets from a file into C++ and back, whichever table has it. Realtime:
/// setup.
namespace takt::table {

template <class Value>
struct ValueType {
  Field info = {};  ///< type, unit, range, choices
  /// @param fallback  the value if the key is not there; nothing: the key is required
  std::function<Value(const Field&, ObjectReader&, const std::optional<Value>& fallback)> read = {};
  std::function<void(const Field&, const Value&, Writer&)> write = {};
  std::function<std::string(const Value&)> text = {};  ///< as a default, for people
};

/// A number, a vector: SI in C++, in files in `unit`.
[[nodiscard]] ValueType<double> number_type(std::string_view unit, const Range& range);
[[nodiscard]] ValueType<Eigen::Vector3d> vector_type(std::string_view unit, const Range& range = kAnyNumber);
/// A vector of which only the direction counts, in files of any length but 0; in C++ as it was written.
[[nodiscard]] ValueType<Eigen::Vector3d> direction_type();
[[nodiscard]] ValueType<std::int64_t> integer_type(const Range& range);
[[nodiscard]] ValueType<bool> boolean_type();
[[nodiscard]] ValueType<std::string> text_type();
[[nodiscard]] ValueType<std::vector<std::string>> texts_type(const Count& count = {});
/// A time span in seconds.
[[nodiscard]] ValueType<Nanoseconds> seconds_type(const Range& range);
/// Numbers; `count` is checked only where it says an exact one.
[[nodiscard]] ValueType<std::vector<double>> numbers_type(std::string_view unit, const Count& count,
                                                          const Range& range = kAnyNumber);
/// A fixed number of numbers in a vector of Eigen; SI in C++, in files in `unit`.
template <class Vector>
[[nodiscard]] ValueType<Vector> fixed_type(std::string_view unit, const Range& range) {
  constexpr auto kSize = static_cast<std::size_t>(Vector::SizeAtCompileTime);
  const ValueType<std::vector<double>> numbers = numbers_type(unit, {.min = kSize, .max = kSize}, range);
  const auto list = [](const Vector& value) { return std::vector<double>(value.data(), value.data() + kSize); };
  return {.info = numbers.info,
          .read =
              [=](const Field& row, ObjectReader& reader, const std::optional<Vector>& fallback) {
                const auto values = fallback ? std::optional(list(*fallback)) : std::nullopt;
                return Vector(numbers.read(row, reader, values).data());
              },
          .write = [=](const Field& row, const Vector& value, Writer& to) { numbers.write(row, list(value), to); },
          .text = [=](const Vector& value) { return numbers.text(list(value)); }};
}
/// A type whose values stay in the unit of files in C++, too.
template <class Value>
[[nodiscard]] ValueType<Value> kept(ValueType<Value> type, std::string_view unit) {
  type.info.unit = unit;
  return type;
}
/// Any JSON, kept as it is. @param info  what the schema says of it
[[nodiscard]] ValueType<nlohmann::ordered_json> json_type(Field info);

/// Words of files, and what each means.
template <class Value>
using Words = std::vector<std::pair<std::string, Value>>;

/// One of some words, each of which means a value.
template <class Value>
[[nodiscard]] ValueType<Value> choice_type(Words<Value> words) {
  ValueType<Value> type{.info = {.type = Field::Type::kChoice}};
  for (const auto& [word, value] : words) type.info.choices.push_back(word);
  type.text = [words](const Value& value) {
    for (const auto& [word, meant] : words)
      if (meant == value) return word;
    return std::string();
  };
  type.read = [words, text = type.text](const Field& row, ObjectReader& reader, const std::optional<Value>& fallback) {
    const std::string given =
        reader.choice(row.key, row.choices, fallback ? std::optional(text(*fallback)) : std::nullopt);
    for (const auto& [word, value] : words)
      if (word == given) return value;
    return fallback.value_or(words.front().second);  // a word that is not known has been reported
  };
  type.write = [text = type.text](const Field& row, const Value& value, Writer& to) { to.text(row.key, text(value)); };
  return type;
}

}  // namespace takt::table
