#include "hw/rtde/field.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include <fmt/format.h>

namespace takt::rtde {

namespace {

enum class Element : std::uint8_t { kByte, kUnsigned, kLongUnsigned, kInteger, kReal };

struct TypeRow {
  std::string_view name;
  Element element;
  std::size_t count;
};

constexpr std::array<TypeRow, 10> kTypes = {{{"BOOL", Element::kByte, 1},
                                             {"UINT8", Element::kByte, 1},
                                             {"UINT32", Element::kUnsigned, 1},
                                             {"UINT64", Element::kLongUnsigned, 1},
                                             {"INT32", Element::kInteger, 1},
                                             {"DOUBLE", Element::kReal, 1},
                                             {"VECTOR3D", Element::kReal, 3},
                                             {"VECTOR6D", Element::kReal, 6},
                                             {"VECTOR6INT32", Element::kInteger, 6},
                                             {"VECTOR6UINT32", Element::kUnsigned, 6}}};

const TypeRow& row_of(FieldType type) { return kTypes[static_cast<std::size_t>(type)]; }

std::size_t size_of(Element element) {
  switch (element) {
    case Element::kByte:
      return 1;
    case Element::kUnsigned:
    case Element::kInteger:
      return 4;
    case Element::kLongUnsigned:
    case Element::kReal:
      break;
  }
  return 8;
}

void append_element(std::string& bytes, Element element, double value) {
  switch (element) {
    case Element::kByte:
      return append(bytes, saturated<std::uint8_t>(value));
    case Element::kUnsigned:
      return append(bytes, saturated<std::uint32_t>(value));
    case Element::kLongUnsigned:
      return append(bytes, saturated<std::uint64_t>(value));
    case Element::kInteger:
      return append(bytes, saturated<std::int32_t>(value));
    case Element::kReal:
      return append(bytes, value);
  }
}

double take_element(ByteReader& reader, Element element) {
  switch (element) {
    case Element::kByte:
      return reader.take<std::uint8_t>();
    case Element::kUnsigned:
      return reader.take<std::uint32_t>();
    case Element::kLongUnsigned:
      return static_cast<double>(reader.take<std::uint64_t>());
    case Element::kInteger:
      return reader.take<std::int32_t>();
    case Element::kReal:
      break;
  }
  return reader.take<double>();
}

}  // namespace

std::string to_string(const Version& version) {
  return fmt::format("{}.{}.{}", version.major, version.minor, version.bugfix);
}

std::string_view name_of(FieldType type) { return row_of(type).name; }

std::optional<FieldType> field_type_of(std::string_view name) {
  for (std::size_t i = 0; i < kTypes.size(); ++i)
    if (kTypes[i].name == name) return static_cast<FieldType>(i);
  return std::nullopt;
}

std::size_t element_count(FieldType type) { return row_of(type).count; }
std::size_t wire_size(FieldType type) { return row_of(type).count * size_of(row_of(type).element); }

void append_value(std::string& bytes, FieldType type, const FieldValue& value) {
  const TypeRow& row = row_of(type);
  for (std::size_t i = 0; i < row.count; ++i) append_element(bytes, row.element, value[i]);
}

FieldValue take_value(ByteReader& reader, FieldType type) {
  const TypeRow& row = row_of(type);
  FieldValue value{};
  for (std::size_t i = 0; i < row.count; ++i) value[i] = take_element(reader, row.element);
  return value;
}

FieldTable::FieldTable(std::vector<Field> fields) : fields_(std::move(fields)), by_name_(fields_.size()) {
  std::iota(by_name_.begin(), by_name_.end(), Id{0});
  std::ranges::sort(by_name_, {}, [this](Id id) -> std::string_view { return fields_[id].name; });
}

std::optional<FieldTable::Id> FieldTable::find(std::string_view name) const {
  const auto at =
      std::ranges::lower_bound(by_name_, name, {}, [this](Id id) -> std::string_view { return fields_[id].name; });
  if (at == by_name_.end() || fields_[*at].name != name) return std::nullopt;
  return *at;
}

FieldTable::Id FieldTable::at(std::string_view name) const {
  const auto id = find(name);
  assert(id && "a name of the table");
  return *id;
}

std::vector<std::string> FieldTable::names() const {
  std::vector<std::string> all;
  for (const Field& field : fields_) all.push_back(field.name);
  return all;
}

std::vector<std::string_view> split_names(std::string_view list) {
  std::vector<std::string_view> names;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    if (comma > 0) names.push_back(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return names;
}

}  // namespace takt::rtde
