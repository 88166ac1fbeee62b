#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/operations/table/parameter.h"

/// The types of parameters: how a value gets from a file into C++ and back, whichever operation has it. Realtime:
/// setup.
namespace takt::operations {

template <class Value>
struct ParameterType {
  ParameterInfo info = {};  ///< type, unit, range, choices
  /// @param fallback  the value if the key is not there; nothing: the key is required
  std::function<Value(const ParameterInfo&, ObjectReader&, const std::optional<Value>& fallback)> read = {};
  std::function<void(const ParameterInfo&, const Value&, ParameterWriter&)> write = {};
  std::function<std::string(const Value&)> text = {};  ///< as a default, for people
};

/// A number, a vector: SI in C++, in files in `unit`.
[[nodiscard]] ParameterType<double> number_type(std::string_view unit, const Range& range);
[[nodiscard]] ParameterType<Eigen::Vector3d> vector_type(std::string_view unit);
/// A vector of which only the direction counts, in files of any length but 0; in C++ as it was written.
[[nodiscard]] ParameterType<Eigen::Vector3d> direction_type();
[[nodiscard]] ParameterType<std::int64_t> integer_type(const Range& range);
[[nodiscard]] ParameterType<bool> boolean_type();
[[nodiscard]] ParameterType<std::string> text_type();
[[nodiscard]] ParameterType<std::vector<std::string>> texts_type();

/// One of some words, each of which means a value.
template <class Value>
[[nodiscard]] ParameterType<Value> choice_type(std::vector<std::pair<std::string, Value>> words) {
  ParameterType<Value> type{.info = {.type = ParameterInfo::Type::kChoice}};
  for (const auto& [word, value] : words) type.info.choices.push_back(word);
  type.text = [words](const Value& value) {
    for (const auto& [word, meant] : words)
      if (meant == value) return word;
    return std::string();
  };
  type.read = [words, text = type.text](const ParameterInfo& row, ObjectReader& reader,
                                        const std::optional<Value>& fallback) {
    const std::string given =
        reader.choice(row.key, row.choices, fallback ? std::optional(text(*fallback)) : std::nullopt);
    for (const auto& [word, value] : words)
      if (word == given) return value;
    return fallback.value_or(words.front().second);  // a word that is not known has been reported
  };
  type.write = [text = type.text](const ParameterInfo& row, const Value& value, ParameterWriter& to) {
    to.text(row.key, text(value));
  };
  return type;
}

}  // namespace takt::operations
