#include "hw/rtde/package.h"

#include "hw/rtde/big_endian.h"

namespace takt::hw::rtde {

std::string_view name_of(PackageType type) {
  switch (type) {
    case PackageType::kProtocolVersion:
      return "REQUEST_PROTOCOL_VERSION";
    case PackageType::kControllerVersion:
      return "GET_URCONTROL_VERSION";
    case PackageType::kText:
      return "TEXT_MESSAGE";
    case PackageType::kData:
      return "DATA_PACKAGE";
    case PackageType::kSetupOutputs:
      return "SETUP_OUTPUTS";
    case PackageType::kSetupInputs:
      return "SETUP_INPUTS";
    case PackageType::kStart:
      return "START";
    case PackageType::kPause:
      return "PAUSE";
  }
  return "unknown";
}

void append_package(std::string& bytes, PackageType type, std::string_view payload) {
  payload = payload.substr(0, kLargestPackage - kHeaderSize);
  append(bytes, static_cast<std::uint16_t>(kHeaderSize + payload.size()));
  append(bytes, static_cast<std::uint8_t>(type));
  bytes.append(payload);
}

std::string make_package(PackageType type, std::string_view payload) {
  std::string bytes;
  append_package(bytes, type, payload);
  return bytes;
}

bool PackageParser::feed(std::string_view bytes) {
  if (broken_) return false;
  buffer_.erase(0, begin_);
  begin_ = 0;
  buffer_.append(bytes);
  return true;
}

std::optional<Package> PackageParser::next() {
  if (broken_ || pending() < kHeaderSize) return std::nullopt;
  ByteReader header(std::string_view(buffer_).substr(begin_, kHeaderSize));
  const auto size = header.take<std::uint16_t>();
  const auto type = header.take<std::uint8_t>();
  if (size < kHeaderSize) {
    broken_ = true;
    return std::nullopt;
  }
  if (pending() < size) return std::nullopt;
  const Package package{static_cast<PackageType>(type),
                        std::string_view(buffer_).substr(begin_ + kHeaderSize, size - kHeaderSize)};
  begin_ += size;
  return package;
}

}  // namespace takt::hw::rtde
