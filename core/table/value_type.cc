#include "core/table/value_type.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/angles.h"
#include "core/base/read_parts.h"
#include "core/table/file_unit.h"
#include "core/table/schema.h"

namespace takt::table {
namespace {

using Type = Field::Type;

template <class Value>
std::optional<Value> divided(const std::optional<Value>& value, double by) {
  return value ? std::optional<Value>(*value / by) : std::nullopt;
}

std::vector<std::string> read_texts(const Field& row, ObjectReader& reader,
                                    const std::optional<std::vector<std::string>>& fallback) {
  std::vector<std::string> texts = reader.texts(row.key, fallback);
  if (!reader.has(row.key) || !reader.json().at(row.key).is_array()) return texts;
  const Count& count = row.count;
  if (texts.size() >= count.min && texts.size() <= count.max) return texts;
  reader.diagnostics().error(
      texts.empty() ? Code::kMissing : Code::kWrongSize, reader.at(row.key), fmt::format("{} texts", texts.size()),
      count.min == count.max ? fmt::format("Give {} texts", count.min) : fmt::format("Give at least {}", count.min));
  return texts;
}

std::string numbers_text(const std::vector<double>& values, double si) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(to_text(value / si));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

/// An object or an array where the row says so.
nlohmann::ordered_json read_json(const Field& row, ObjectReader& reader,
                                 const std::optional<nlohmann::ordered_json>& fallback) {
  const bool required = !fallback.has_value();
  const nlohmann::ordered_json* json = row.type == Type::kList  ? reader.array(row.key, required)
                                       : row.type == Type::kAny ? reader.child(row.key)
                                                                : reader.object(row.key, required);
  return json != nullptr ? *json : fallback.value_or(nlohmann::ordered_json());
}

}  // namespace

ValueType<double> number_type(std::string_view unit, const Range& range) {
  const double si = file_unit(unit).si_per_unit;
  return {.info = {.type = Type::kNumber, .unit = std::string(unit), .range = range},
          .read =
              [si](const Field& row, ObjectReader& reader, const std::optional<double>& fallback) {
                return si * reader.number(row.key, divided(fallback, si), row.range);
              },
          .write = [si](const Field& row, const double& value, Writer& to) { to.number(row.key, value / si); },
          .text = [si](const double& value) { return to_text(value / si); }};
}

ValueType<Eigen::Vector3d> vector_type(std::string_view unit, const Range& range) {
  using Vector = Eigen::Vector3d;
  const double si = file_unit(unit).si_per_unit;
  return {.info = {.type = Type::kVector, .unit = std::string(unit), .range = range},
          .read = [si](const Field& row, ObjectReader& reader, const std::optional<Vector>& fallback) -> Vector {
            std::optional<std::vector<double>> values;
            if (const auto value = divided(fallback, si)) values = {value->x(), value->y(), value->z()};
            return si * Vector(reader.numbers(row.key, 3, values, row.range).data());
          },
          .write = [si](const Field& row, const Vector& value, Writer& to) { to.vector(row.key, value / si); },
          .text = [si](const Vector& value) { return to_text(Vector(value / si)); }};
}

ValueType<Eigen::Vector3d> direction_type() {
  using Vector = Eigen::Vector3d;
  return {.info = {.type = Type::kVector},
          .read =
              [](const Field& row, ObjectReader& reader, const std::optional<Vector>& fallback) {
                return read_direction(reader, row.key, fallback.value_or(Vector::UnitZ()));
              },
          .write = [](const Field& row, const Vector& value, Writer& to) { to.vector(row.key, value); },
          .text = [](const Vector& value) { return to_text(value); }};
}

ValueType<std::int64_t> integer_type(const Range& range) {
  return {
      .info = {.type = Type::kInteger, .range = range},
      .read = [](const Field& row, ObjectReader& reader,
                 const std::optional<std::int64_t>& fallback) { return reader.integer(row.key, fallback, row.range); },
      .write = [](const Field& row, const std::int64_t& value, Writer& to) { to.integer(row.key, value); },
      .text = [](const std::int64_t& value) { return std::to_string(value); }};
}

ValueType<bool> boolean_type() {
  return {.info = {.type = Type::kBoolean},
          .read = [](const Field& row, ObjectReader& reader,
                     const std::optional<bool>& fallback) { return reader.boolean(row.key, fallback); },
          .write = [](const Field& row, const bool& value, Writer& to) { to.boolean(row.key, value); },
          .text = [](const bool& value) { return std::string(value ? "true" : "false"); }};
}

ValueType<std::string> text_type() {
  return {.info = {.type = Type::kText},
          .read =
              [](const Field& row, ObjectReader& reader, const std::optional<std::string>& fallback) {
                const bool named = row.count.min > 0 && reader.has(row.key);
                return reader.text(row.key, named ? std::nullopt : fallback);
              },
          .write = [](const Field& row, const std::string& value, Writer& to) { to.text(row.key, value); },
          .text = [](const std::string& value) { return value; }};
}

ValueType<std::vector<std::string>> texts_type(const Count& count) {
  using Texts = std::vector<std::string>;
  return {.info = {.type = Type::kTexts, .count = count},
          .read = [](const Field& row, ObjectReader& reader,
                     const std::optional<Texts>& fallback) { return read_texts(row, reader, fallback); },
          .write = [](const Field& row, const Texts& value, Writer& to) { to.texts(row.key, value); },
          .text = [](const Texts&) { return std::string(); }};
}

ValueType<Nanoseconds> seconds_type(const Range& range) {
  return {
      .info = {.type = Type::kNumber, .unit = "s", .range = range},
      .read =
          [](const Field& row, ObjectReader& reader, const std::optional<Nanoseconds>& fallback) {
            const auto seconds = fallback ? std::optional(to_seconds(*fallback)) : std::nullopt;
            return static_cast<Nanoseconds>(std::llround(1e9 * reader.number(row.key, seconds, row.range)));
          },
      .write = [](const Field& row, const Nanoseconds& value, Writer& to) { to.number(row.key, to_seconds(value)); },
      .text = [](const Nanoseconds& value) { return to_text(to_seconds(value)); }};
}

ValueType<std::vector<double>> numbers_type(std::string_view unit, const Count& count, const Range& range) {
  using Numbers = std::vector<double>;
  const double si = file_unit(unit).si_per_unit;
  const std::size_t size = count.min == count.max ? count.min : 0;
  return {.info = {.type = Type::kNumbers, .unit = std::string(unit), .range = range, .count = count},
          .read =
              [si, size](const Field& row, ObjectReader& reader, std::optional<Numbers> fallback) {
                if (fallback) std::ranges::transform(*fallback, fallback->begin(), [&](double x) { return x / si; });
                Numbers values = reader.numbers(row.key, size, fallback, row.range);
                if (si != 1.0) warn_of_radians(values, reader.at(row.key), reader.diagnostics());
                std::ranges::transform(values, values.begin(), [&](double x) { return x * si; });
                return values;
              },
          .write =
              [si](const Field& row, const Numbers& value, Writer& to) {
                nlohmann::ordered_json list = nlohmann::ordered_json::array();
                for (const double one : value) list.push_back(plain_number(one / si));
                to.json(row.key, std::move(list));
              },
          .text = [si](const Numbers& value) { return numbers_text(value, si); }};
}

ValueType<nlohmann::ordered_json> json_type(Field info) {
  using Json = nlohmann::ordered_json;
  return {.info = std::move(info),
          .read = read_json,
          .write = [](const Field& row, const Json& value, Writer& to) { to.json(row.key, value); },
          .text = [](const Json&) { return std::string(); }};
}

}  // namespace takt::table
