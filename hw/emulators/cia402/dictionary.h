#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "hw/cia402/protocol/canopen.h"

namespace takt::hw::cia402 {

/// The object dictionary of an emulated node. Its objects are fixed once it is made. Realtime: cyclic but for add().
class Dictionary {
 public:
  enum class Access : std::uint8_t { kConstant, kReadOnly, kReadWrite };
  struct Object {
    std::uint8_t size = 4;  ///< bytes
    Access access = Access::kReadWrite;
    bool mappable = false;  ///< can be process data
    std::int64_t lowest = INT32_MIN, highest = UINT32_MAX;
    std::uint32_t value = 0;
  };

  void add(const ObjectId& id, const Object& object) { objects_[id] = object; }
  [[nodiscard]] const Object* find(const ObjectId& id) const;
  /// As bits; an object that is not there is 0.
  [[nodiscard]] std::uint32_t value(const ObjectId& id) const;
  [[nodiscard]] std::int32_t signed_value(const ObjectId& id) const;
  /// What the node itself writes, or process data; cut to the object's size.
  void set(const ObjectId& id, std::uint32_t value);
  /// @return why a master may not write this, or nothing
  [[nodiscard]] std::optional<SdoAbort> refuse_write(const ObjectId& id, std::uint8_t size, std::uint32_t value) const;

 private:
  std::map<ObjectId, Object> objects_;
};

}  // namespace takt::hw::cia402
