#include "core/operations/table/parameter_type.h"

#include "core/base/read_parts.h"
#include "core/net/file_unit.h"

namespace takt::operations {
namespace {

using Type = ParameterInfo::Type;

template <class Value>
std::optional<Value> divided(const std::optional<Value>& value, double by) {
  return value ? std::optional<Value>(*value / by) : std::nullopt;
}

}  // namespace

ParameterType<double> number_type(std::string_view unit, const Range& range) {
  const double si = net::file_unit(unit).si_per_unit;
  return {.info = {.type = Type::kNumber, .unit = std::string(unit), .range = range},
          .read =
              [si](const ParameterInfo& row, ObjectReader& reader, const std::optional<double>& fallback) {
                return si * reader.number(row.key, divided(fallback, si), row.range);
              },
          .write = [si](const ParameterInfo& row, const double& value,
                        ParameterWriter& to) { to.number(row.key, value / si); },
          .text = [si](const double& value) { return to_text(value / si); }};
}

ParameterType<Eigen::Vector3d> vector_type(std::string_view unit) {
  using Vector = Eigen::Vector3d;
  const double si = net::file_unit(unit).si_per_unit;
  return {
      .info = {.type = Type::kVector, .unit = std::string(unit)},
      .read = [si](const ParameterInfo& row, ObjectReader& reader, const std::optional<Vector>& fallback) -> Vector {
        return si * reader.vector(row.key, divided(fallback, si));
      },
      .write = [si](const ParameterInfo& row, const Vector& value,
                    ParameterWriter& to) { to.vector(row.key, value / si); },
      .text = [si](const Vector& value) { return to_text(Vector(value / si)); }};
}

ParameterType<Eigen::Vector3d> direction_type() {
  using Vector = Eigen::Vector3d;
  return {
      .info = {.type = Type::kVector},
      .read =
          [](const ParameterInfo& row, ObjectReader& reader, const std::optional<Vector>& fallback) {
            return read_direction(reader, row.key, fallback.value_or(Vector::UnitZ()));
          },
      .write = [](const ParameterInfo& row, const Vector& value, ParameterWriter& to) { to.vector(row.key, value); },
      .text = [](const Vector& value) { return to_text(value); }};
}

ParameterType<std::int64_t> integer_type(const Range& range) {
  return {
      .info = {.type = Type::kInteger, .range = range},
      .read = [](const ParameterInfo& row, ObjectReader& reader,
                 const std::optional<std::int64_t>& fallback) { return reader.integer(row.key, fallback, row.range); },
      .write = [](const ParameterInfo& row, const std::int64_t& value,
                  ParameterWriter& to) { to.integer(row.key, value); },
      .text = [](const std::int64_t& value) { return std::to_string(value); }};
}

ParameterType<bool> boolean_type() {
  return {.info = {.type = Type::kBoolean},
          .read = [](const ParameterInfo& row, ObjectReader& reader,
                     const std::optional<bool>& fallback) { return reader.boolean(row.key, fallback); },
          .write = [](const ParameterInfo& row, const bool& value, ParameterWriter& to) { to.boolean(row.key, value); },
          .text = [](const bool& value) { return std::string(value ? "true" : "false"); }};
}

ParameterType<std::string> text_type() {
  return {
      .info = {.type = Type::kText},
      .read = [](const ParameterInfo& row, ObjectReader& reader,
                 const std::optional<std::string>& fallback) { return reader.text(row.key, fallback); },
      .write = [](const ParameterInfo& row, const std::string& value, ParameterWriter& to) { to.text(row.key, value); },
      .text = [](const std::string& value) { return value; }};
}

ParameterType<std::vector<std::string>> texts_type() {
  using Texts = std::vector<std::string>;
  return {.info = {.type = Type::kTexts},
          .read = [](const ParameterInfo& row, ObjectReader& reader,
                     const std::optional<Texts>& fallback) { return reader.texts(row.key, fallback); },
          .write = [](const ParameterInfo& row, const Texts& value, ParameterWriter& to) { to.texts(row.key, value); },
          .text = [](const Texts&) { return std::string(); }};
}

}  // namespace takt::operations
