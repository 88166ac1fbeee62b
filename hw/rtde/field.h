#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hw/rtde/big_endian.h"

/// The fields that a controller offers over RTDE: names, types, and since which version.
namespace takt::hw::rtde {

/// Version of the controller's software. CB3 has major 3, e-Series 5.
struct Version {
  std::uint32_t major = 0, minor = 0, bugfix = 0, build = 0;
  [[nodiscard]] auto operator<=>(const Version&) const = default;
  /// Control cycles a second: 125 (CB3) or 500.
  [[nodiscard]] int frequency() const { return major >= 5 ? 500 : 125; }
};
/// "3.15.8".
[[nodiscard]] std::string to_string(const Version& version);

enum class FieldType : std::uint8_t {
  kBool,
  kUint8,
  kUint32,
  kUint64,
  kInt32,
  kDouble,
  kVector3d,
  kVector6d,
  kVector6Int32,
  kVector6Uint32
};
/// Its name on the wire, such as "VECTOR6D".
[[nodiscard]] std::string_view name_of(FieldType type);
[[nodiscard]] std::optional<FieldType> field_type_of(std::string_view name);
/// Numbers in a field, and bytes of the whole field on the wire.
[[nodiscard]] std::size_t element_count(FieldType type);
[[nodiscard]] std::size_t wire_size(FieldType type);

/// A value of any type: the first element_count() numbers. All that the fields hold is exact in a double: counts and
/// bits use less than 53 bits.
using FieldValue = std::array<double, 6>;

/// Realtime: cyclic while the string has room.
void append_value(std::string& bytes, FieldType type, const FieldValue& value);
/// Past the end of the reader the value is 0 and the reader says so.
[[nodiscard]] FieldValue take_value(ByteReader& reader, FieldType type);

/// One field. A `since` with major 0: that series does not have it.
struct Field {
  std::string name;
  FieldType type = FieldType::kDouble;
  Version since_cb3, since_e;
  [[nodiscard]] bool offered_by(const Version& controller) const {
    const Version& since = controller.major >= 5 ? since_e : since_cb3;
    return since.major > 0 && controller >= since;
  }
};

/// A list of fields in a fixed order; a field's number in it is its place.
class FieldTable {
 public:
  using Id = std::uint16_t;
  explicit FieldTable(std::vector<Field> fields);

  [[nodiscard]] const std::vector<Field>& fields() const { return fields_; }
  [[nodiscard]] std::size_t size() const { return fields_.size(); }
  [[nodiscard]] const Field& operator[](Id id) const { return fields_[id]; }
  [[nodiscard]] std::optional<Id> find(std::string_view name) const;
  /// A name that is in the table.
  [[nodiscard]] Id at(std::string_view name) const;
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::vector<Field> fields_;
  std::vector<Id> by_name_;
};

/// What a controller sends, and what it accepts. Immutable; any thread.
[[nodiscard]] const FieldTable& output_fields();
[[nodiscard]] const FieldTable& input_fields();

/// "a,b,,c," as its names; empty ones are left out.
[[nodiscard]] std::vector<std::string_view> split_names(std::string_view list);

}  // namespace takt::hw::rtde
