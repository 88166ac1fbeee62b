#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

#include <Eigen/Geometry>

#include "core/base/time.h"
#include "core/device/channel.h"
#include "serve/picture_maker.h"

/// The binary messages of the streams, byte by byte as docs/remote.md has them. Realtime: setup.
namespace takt::serve {

/// A frame of values.
class ValueFrame {
 public:
  /// @param value  empty: null
  void add(std::uint32_t id, net::ValueType type, std::int64_t cycle, const std::optional<device::ChannelValue>& value);
  [[nodiscard]] bool empty() const { return entries_ == 0; }
  /// @param frame  its number; @param cycle  after which it is made
  [[nodiscard]] std::string finish(std::uint32_t frame, std::int64_t cycle) const;

 private:
  std::string bytes_;
  std::uint16_t entries_ = 0;
};

/// A frame of poses in the world: of the bodies that move, then of those that are commanded.
[[nodiscard]] std::string pose_frame(std::uint32_t frame, std::int64_t cycle, Nanoseconds time,
                                     std::span<const Eigen::Isometry3d> moving,
                                     std::span<const Eigen::Isometry3d> commanded);

/// A frame with the picture of a camera. @param id  of the monitor
[[nodiscard]] std::string picture_frame(std::uint32_t frame, std::uint32_t id, const PictureFormat& format,
                                        const CameraPicture& picture);

/// Numbers one after the other as the wire has them: little-endian, without gaps.
template <class T>
void append_number(std::string& bytes, T value) {
  static_assert(std::endian::native == std::endian::little && std::is_arithmetic_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace takt::serve
