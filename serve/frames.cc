#include "serve/frames.h"

#include <variant>

namespace takt::serve {
namespace {

constexpr std::uint8_t kVersion = 1, kValues = 1, kPoses = 2, kPicture = 3;
constexpr std::size_t kAligned = 8;

std::string frame_header(std::uint8_t kind, std::uint16_t entries, std::uint32_t frame, std::int64_t cycle) {
  std::string bytes;
  append_number(bytes, kind);
  append_number(bytes, kVersion);
  append_number(bytes, entries);
  append_number(bytes, frame);
  append_number(bytes, cycle);
  return bytes;
}

void fill(std::string& bytes) { bytes.resize((bytes.size() + kAligned - 1) / kAligned * kAligned, '\0'); }

void append_all(std::string& bytes, std::span<const double> numbers) {
  for (const double number : numbers) append_number(bytes, number);
}
void append_rotation(std::string& bytes, const net::Rotation& q) {
  for (const double part : {q.w(), q.x(), q.y(), q.z()}) append_number(bytes, part);
}

/// What a value looks like on the wire.
struct OnWire {
  std::string& bytes;

  void operator()(net::Boolean value) const { append_number(bytes, value ? 1.0 : 0.0); }
  void operator()(net::Integer value) const { append_number(bytes, value); }
  void operator()(net::Real value) const { append_number(bytes, value); }
  void operator()(const net::Text& value) const { bytes += value.view(); }
  void operator()(const net::Vector& value) const { append_all(bytes, {value.data(), 3}); }
  void operator()(const net::Rotation& value) const { append_rotation(bytes, value); }
  void operator()(const net::Frame& value) const {
    const net::Vector position = value.translation();
    append_all(bytes, {position.data(), 3});
    append_rotation(bytes, net::Rotation(value.linear()));
  }
  void operator()(const net::Twist& value) const {
    append_all(bytes, {value.linear.data(), 3});
    append_all(bytes, {value.angular.data(), 3});
  }
  void operator()(const net::Wrench& value) const {
    append_all(bytes, {value.force.data(), 3});
    append_all(bytes, {value.torque.data(), 3});
  }
  void operator()(const net::JointArray& value) const {
    append_all(bytes, {value.value.data(), static_cast<std::size_t>(value.size)});
  }
};

void append_pose(std::string& bytes, const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const auto& p = X.translation();
  for (const double part : {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()})
    append_number(bytes, static_cast<float>(part));
}

}  // namespace

void ValueFrame::add(std::uint32_t id, net::ValueType type, std::int64_t cycle,
                     const std::optional<device::ChannelValue>& value) {
  std::string content;
  if (value) std::visit(OnWire{content}, *value);
  append_number(bytes_, id);
  append_number(bytes_, static_cast<std::uint8_t>(type));
  append_number(bytes_, static_cast<std::uint8_t>(value ? 0 : 1));
  append_number(bytes_, static_cast<std::uint16_t>(content.size()));
  append_number(bytes_, cycle);
  bytes_ += content;
  fill(bytes_);
  ++entries_;
}

std::string ValueFrame::finish(std::uint32_t frame, std::int64_t cycle) const {
  return frame_header(kValues, entries_, frame, cycle) + bytes_;
}

std::string pose_frame(std::uint32_t frame, std::int64_t cycle, Nanoseconds time,
                       std::span<const Eigen::Isometry3d> moving, std::span<const Eigen::Isometry3d> commanded) {
  std::string bytes = frame_header(kPoses, 0, frame, cycle);
  append_number(bytes, to_seconds(time));
  append_number(bytes, static_cast<std::uint32_t>(moving.size()));
  append_number(bytes, static_cast<std::uint32_t>(commanded.size()));
  for (const auto& poses : {moving, commanded})
    for (const Eigen::Isometry3d& X : poses) append_pose(bytes, X);
  fill(bytes);
  return bytes;
}

std::string picture_frame(std::uint32_t frame, std::uint32_t id, const PictureFormat& format,
                          const CameraPicture& picture) {
  std::string bytes = frame_header(kPicture, 0, frame, picture.cycle - 1);
  append_number(bytes, to_seconds(picture.time));
  append_number(bytes, id);
  append_number(bytes, static_cast<std::uint16_t>(format.width));
  append_number(bytes, static_cast<std::uint16_t>(format.height));
  append_number(bytes, static_cast<std::uint32_t>(picture.png.size()));
  append_number(bytes, std::uint32_t{0});
  bytes += picture.png;
  fill(bytes);
  return bytes;
}

}  // namespace takt::serve
