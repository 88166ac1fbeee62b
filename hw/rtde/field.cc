#include "hw/rtde/field.h"

#include <algorithm>
#include <concepts>
#include <numeric>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

/// A number of one of the types that fields consist of.
struct Element {
  std::size_t size;  // bytes
  void (*append)(std::string& bytes, double value);
  double (*take)(ByteReader& reader);
};

/// What T cannot hold is the nearest that it can.
template <class T>
void append_as(std::string& bytes, double value) {
  if constexpr (std::integral<T>) {
    takt::hw::rtde::append(bytes, saturated<T>(value));
  } else {
    takt::hw::rtde::append(bytes, T{value});
  }
}
template <class T>
double take_as(ByteReader& reader) {
  return static_cast<double>(reader.take<T>());
}
template <class T>
constexpr Element kElement{sizeof(T), &append_as<T>, &take_as<T>};

struct TypeRow {
  std::string_view name;
  Element element;
  std::size_t count;
};

constexpr std::array<TypeRow, 10> kTypes = {{{"BOOL", kElement<std::uint8_t>, 1},
                                             {"UINT8", kElement<std::uint8_t>, 1},
                                             {"UINT32", kElement<std::uint32_t>, 1},
                                             {"UINT64", kElement<std::uint64_t>, 1},
                                             {"INT32", kElement<std::int32_t>, 1},
                                             {"DOUBLE", kElement<double>, 1},
                                             {"VECTOR3D", kElement<double>, 3},
                                             {"VECTOR6D", kElement<double>, 6},
                                             {"VECTOR6INT32", kElement<std::int32_t>, 6},
                                             {"VECTOR6UINT32", kElement<std::uint32_t>, 6}}};

const TypeRow& row_of(FieldType type) { return kTypes[static_cast<std::size_t>(type)]; }

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
std::size_t wire_size(FieldType type) { return row_of(type).count * row_of(type).element.size; }

void append_value(std::string& bytes, FieldType type, const FieldValue& value) {
  const TypeRow& row = row_of(type);
  for (std::size_t i = 0; i < row.count; ++i) row.element.append(bytes, value[i]);
}

FieldValue take_value(ByteReader& reader, FieldType type) {
  const TypeRow& row = row_of(type);
  FieldValue value{};
  for (std::size_t i = 0; i < row.count; ++i) value[i] = row.element.take(reader);
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
  return find(name).value();  // any other name is a mistake of ours
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

}  // namespace takt::hw::rtde
