#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace takt::hw::rtde {

/// Types of RTDE packages: a letter each. Setup requests, start, pause and both questions for a version are answered by
/// one package of the same type; data and text are not answered.
enum class PackageType : std::uint8_t {
  kProtocolVersion = 'V',
  kControllerVersion = 'v',
  kText = 'M',
  kData = 'U',
  kSetupOutputs = 'O',
  kSetupInputs = 'I',
  kStart = 'S',
  kPause = 'P'
};
/// Its name in messages, such as "SETUP_OUTPUTS"; "unknown" for a byte that is no type.
[[nodiscard]] std::string_view name_of(PackageType type);

/// Size of the header: uint16 size of the whole package, uint8 type.
inline constexpr std::size_t kHeaderSize = 3;
inline constexpr std::size_t kLargestPackage = 65535;

struct Package {
  PackageType type = PackageType::kText;
  std::string_view payload;
};

/// A package with its header. @param payload  what is beyond kLargestPackage is cut off
void append_package(std::string& bytes, PackageType type, std::string_view payload);
[[nodiscard]] std::string make_package(PackageType type, std::string_view payload = {});

/// Cuts a byte stream into packages, wherever the network has cut it. Holds at most one package and what was fed since.
/// A size that no package has breaks the stream for good: the connection is to be closed. One thread.
class PackageParser {
 public:
  /// More of the stream. @return false if it is broken.
  bool feed(std::string_view bytes);
  /// The next whole package; its payload is valid until the next call of any function.
  [[nodiscard]] std::optional<Package> next();
  [[nodiscard]] bool broken() const { return broken_; }
  /// Bytes that wait for the rest of their package.
  [[nodiscard]] std::size_t pending() const { return buffer_.size() - begin_; }

 private:
  std::string buffer_;
  std::size_t begin_ = 0;  // of what is not yet taken
  bool broken_ = false;
};

}  // namespace takt::hw::rtde
