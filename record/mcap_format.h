#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace takt::record::mcap {

// The container of a recording. Source: the MCAP specification, version 0. Numbers are little-endian; a record is an
// opcode, a length of 8 bytes and that many bytes.
static_assert(std::endian::native == std::endian::little, "the container is written as memory has it");

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::size_t kRecordHead = 9;

enum class Op : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Opcodes from here on are free for applications; every reader skips them.
inline constexpr std::uint8_t kFirstPrivateOp = 0x80;

using Map = std::map<std::string, std::string>;

/// Appends `value` as the machine has it.
template <class T>
void put(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}
/// A text: 4 bytes of length, then the bytes.
void put_text(std::string& out, std::string_view text);
/// A map: 4 bytes of length in bytes, then key and value as texts.
void put_map(std::string& out, const Map& map);

/// Builds one record at the end of `out`; the length is filled in when it goes out of scope.
class RecordScope {
 public:
  RecordScope(std::string& out, Op op);
  ~RecordScope();
  RecordScope(const RecordScope&) = delete;
  RecordScope& operator=(const RecordScope&) = delete;

 private:
  std::string& out_;
  std::size_t start_;
};

/// CRC-32 (IEEE), continued from `crc`.
[[nodiscard]] std::uint32_t crc32(std::uint32_t crc, std::string_view data);

/// Takes numbers and texts off the front of bytes that nobody vouches for: past the end everything is zero and empty,
/// and ok() is false from then on.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    T value{};
    const std::string_view bytes = take(sizeof(T));
    if (ok_) std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  std::string_view take(std::uint64_t size);
  std::string_view get_text() { return take(get<std::uint32_t>()); }
  std::string_view get_blob() { return take(get<std::uint64_t>()); }
  Map get_map();

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

/// A record and its location in the bytes that it was read from.
struct Record {
  std::uint8_t op = 0;
  std::size_t offset = 0;  ///< of the opcode
  std::string_view body;
  [[nodiscard]] std::size_t end() const { return offset + kRecordHead + body.size(); }
};

/// The record at `offset`, or nothing if the bytes end before it does.
[[nodiscard]] std::optional<Record> record_at(std::string_view bytes, std::size_t offset);

}  // namespace takt::record::mcap
