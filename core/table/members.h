#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/table/field.h"

/// What rows of tables are made of that have several keys or members. Realtime: setup.
namespace takt::table {

/// Names that things of a cell may have.
inline constexpr const char* kMemberName = "^(?!world$)[^/]+$";

/// "position_m", "rpy_deg", "quaternion": a pose, read by ObjectReader::pose().
[[nodiscard]] std::vector<Field> pose_fields(std::string_view position_doc);
/// Not both "rpy_deg" and "quaternion"; ObjectReader::rotation() reports them.
[[nodiscard]] Rule one_orientation();

/// Names to what `item` says.
[[nodiscard]] Field map_field(std::string_view key, Field item, std::string_view doc);
/// Any object, for a reader of its own.
[[nodiscard]] Field any_object();
/// The text at a key; nothing if the key is not there, an empty one if it is no text.
[[nodiscard]] std::optional<std::string> word_at(std::string_view key, const ObjectReader& reader);
/// A number that is required; true is 1 and false 0.
[[nodiscard]] double number_or_boolean(std::string_view key, ObjectReader& reader);
/// Reports a key that an object does not have, with the reason.
void refuse_key(std::string_view key, ObjectReader& reader, const std::string& why, const std::string& hint);
/// Each element of a list, as an object; reports one that is not finished. The number of elements is checked.
void for_each_element(const Field& row, ObjectReader& reader, const std::function<void(ObjectReader&)>& read);
/// Each member of an object that maps names to something; invalid names are diagnostics.
void for_each_key(std::string_view key, ObjectReader& reader,
                  const std::function<void(const std::string& name, const nlohmann::ordered_json& value,
                                           const std::string& pointer)>& read);
/// Each member of an object that maps names to objects; invalid names are diagnostics.
void for_each_member(std::string_view key, ObjectReader& reader,
                     const std::function<void(const std::string& name, ObjectReader&)>& read);

}  // namespace takt::table
