#include "core/table/members.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::table {

std::vector<Field> pose_fields(std::string_view position_doc) {
  using Type = Field::Type;
  Field position = field("position_m", Type::kVector, position_doc);
  position.unit = "m";
  position.fallback = "[0, 0, 0]";
  Field rpy = field("rpy_deg", Type::kVector,
                    "Roll, pitch and yaw about the fixed x, then y, then z axis; this or 'quaternion'.");
  rpy.unit = "deg";
  rpy.fallback = "no rotation";
  Field quaternion = field("quaternion", Type::kNumbers, "Unit quaternion w, x, y, z; this or 'rpy_deg'.");
  quaternion.count = {.min = 4, .max = 4};
  quaternion.range = {.low = -1.001, .high = 1.001};
  return {std::move(position), std::move(rpy), std::move(quaternion)};
}

Rule one_orientation() {
  return {.kind = Rule::Kind::kNotTogether, .groups = {{"rpy_deg"}, {"quaternion"}}, .checked = false};
}

Field map_field(std::string_view key, Field item, std::string_view doc) {
  Field map = field(key, Field::Type::kMap, doc);
  map.items = {std::move(item)};
  map.pattern = kMemberName;
  return map;
}

Field any_object() {
  Field object = field({}, Field::Type::kObject, {});
  object.any_key = true;
  return object;
}

std::optional<std::string> word_at(std::string_view key, const ObjectReader& reader) {
  if (!reader.has(key)) return std::nullopt;
  const auto& json = reader.json().at(std::string(key));
  return json.is_string() ? json.get<std::string>() : std::string();
}

double number_or_boolean(std::string_view key, ObjectReader& reader) {
  const auto* value = reader.child(key);
  if (value == nullptr || !value->is_boolean()) return reader.number(key);
  return value->get<bool>() ? 1.0 : 0.0;
}

void refuse_key(std::string_view key, ObjectReader& reader, const std::string& why, const std::string& hint) {
  (void)reader.child(key);
  reader.diagnostics().error(Code::kConflict, reader.at(key), why, hint);
}

void for_each_element(const Field& row, ObjectReader& reader, const std::function<void(ObjectReader&)>& read) {
  const auto* list = reader.array(row.key, row.required);
  if (list == nullptr) return;
  if (list->size() < row.count.min || list->size() > row.count.max)
    reader.diagnostics().error(list->empty() ? Code::kMissing : Code::kWrongSize, reader.at(row.key),
                               fmt::format("{} elements", list->size()),
                               list->size() < row.count.min ? fmt::format("Give at least {}", row.count.min)
                                                            : fmt::format("Give at most {}", row.count.max));
  for (std::size_t i = 0; i < list->size(); ++i) {
    ObjectReader element((*list)[i], reader.at(row.key) + pointer_segment(i), reader.diagnostics());
    read(element);
    element.finish();
  }
}

void for_each_key(std::string_view key, ObjectReader& reader,
                  const std::function<void(const std::string& name, const nlohmann::ordered_json& value,
                                           const std::string& pointer)>& read) {
  const auto* members = reader.object(key, false);
  if (members == nullptr) return;
  for (const auto& [name, value] : members->items()) {
    const std::string pointer = reader.at(key) + pointer_segment(name);
    if (name.empty()) reader.diagnostics().error(Code::kInvalidName, pointer, "an empty name", "Give a name");
    if (name.find('/') != std::string::npos || name == "world") {
      reader.diagnostics().error(Code::kInvalidName, pointer, fmt::format("invalid name '{}'", name),
                                 "Use a name without '/' that is not 'world'");
    }
    read(name, value, pointer);
  }
}

void for_each_member(std::string_view key, ObjectReader& reader,
                     const std::function<void(const std::string& name, ObjectReader&)>& read) {
  for_each_key(key, reader, [&](const std::string& name, const auto& value, const std::string& pointer) {
    ObjectReader member(value, pointer, reader.diagnostics());
    read(name, member);
    member.finish();
  });
}

}  // namespace takt::table
