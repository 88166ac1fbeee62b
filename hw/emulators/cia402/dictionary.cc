#include "hw/emulators/cia402/dictionary.h"

namespace takt::hw::cia402 {
namespace {

std::int32_t extended(std::uint32_t value, std::uint8_t size) {
  const int unused = 32 - 8 * size;
  return static_cast<std::int32_t>(value << unused) >> unused;
}

}  // namespace

const Dictionary::Object* Dictionary::find(const ObjectId& id) const {
  const auto found = objects_.find(id);
  return found == objects_.end() ? nullptr : &found->second;
}

std::uint32_t Dictionary::value(const ObjectId& id) const {
  const Object* object = find(id);
  return object == nullptr ? 0 : object->value;
}

std::int32_t Dictionary::signed_value(const ObjectId& id) const {
  const Object* object = find(id);
  return object == nullptr ? 0 : extended(object->value, object->size);
}

void Dictionary::set(const ObjectId& id, std::uint32_t value) {
  const auto found = objects_.find(id);
  if (found == objects_.end()) return;
  const std::uint32_t mask = found->second.size == 4 ? ~0u : (1u << (8 * found->second.size)) - 1;
  found->second.value = value & mask;
}

std::optional<SdoAbort> Dictionary::refuse_write(const ObjectId& id, std::uint8_t size, std::uint32_t value) const {
  const Object* object = find(id);
  if (object == nullptr) {
    const auto same_index = objects_.lower_bound({id.index, 0});
    const bool has_index = same_index != objects_.end() && same_index->first.index == id.index;
    return has_index ? SdoAbort::kNoSubindex : SdoAbort::kNoObject;
  }
  if (object->access != Access::kReadWrite) return SdoAbort::kNotWritable;
  if (object->size != size) return SdoAbort::kWrongLength;
  const std::int64_t number = object->lowest < 0 ? std::int64_t{extended(value, size)} : std::int64_t{value};
  if (number < object->lowest || number > object->highest) return SdoAbort::kOutOfRange;
  return std::nullopt;
}

}  // namespace takt::hw::cia402
