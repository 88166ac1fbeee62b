#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "record/byte_source.h"
#include "record/mcap_format.h"

namespace takt::record::mcap {

struct ChannelRecord {
  std::uint16_t id = 0, schema = 0;
  std::string topic, encoding;
  Map metadata;
};

struct SchemaRecord {
  std::string name, encoding, data;
};

struct AttachmentRecord {
  std::string name, media_type;
  std::uint64_t offset = 0, size = 0;  ///< of its data, in the file
  bool whole = true;                   ///< the checksum holds
};

/// A stretch of records to read messages from: a chunk, or messages outside of chunks that follow one another.
struct Stretch {
  std::uint64_t offset = 0;       ///< of the first record, in the file
  std::uint64_t data_offset = 0;  ///< of what it holds
  std::uint64_t data_size = 0;
  std::string compression;
  std::uint64_t raw_size = 0;
  std::uint32_t raw_crc = 0;  ///< 0: not checked
  bool is_chunk = false;
};

/// What a recording may be at most, whatever it claims. Reading one costs at most 1 GiB of memory, and time in
/// proportion to the size of the file: what it unpacks to and how often it is gone through grow with the bytes that are
/// there.
struct ReadLimits {
  static constexpr std::uint64_t kFileBytes = 64ull << 30;
  static constexpr std::uint64_t kChunkBytes = 32u << 20;       ///< unpacked; ours have about 1 MiB
  static constexpr std::uint64_t kRawBytes = 1u << 30;          ///< of all chunks, unpacked, and
  static constexpr std::uint64_t kRawPerByte = 64;              ///< so many for each byte of the file
  static constexpr std::uint64_t kVisitBytes = 16ull << 30;     ///< gone through for tables, and
  static constexpr std::uint64_t kVisitPerByte = 256;           ///< so many for each byte of the file
  static constexpr std::size_t kStretches = 500'000;            ///< 27 hours of ours
  static constexpr std::size_t kDefinitions = 4096;             ///< channels, and as many schemas, attachments, maps
  static constexpr std::uint64_t kDefinitionBytes = 64u << 20;  ///< of all of them together
  static constexpr std::uint64_t kAttachmentBytes = 64u << 20;  ///< of one that is read
  static constexpr std::size_t kDamages = 100;                  ///< that are listed; more are counted
  static constexpr std::size_t kColumns = 4096;                 ///< of one topic; more are left out
  static constexpr std::size_t kTableValues = 32u << 20;        ///< of what is in memory at a time
  static constexpr std::size_t kEvents = 1'000'000;             ///< of one topic
  static constexpr std::uint64_t kEventBytes = 128u << 20;      ///< of their texts
  /// ns; later ones cannot be told apart from negative ones (about the year 2116).
  static constexpr std::uint64_t kLatestTime = 1ull << 62;
};

/// Everything in a file but the messages themselves.
struct Contents {
  std::map<std::uint16_t, SchemaRecord> schemas;
  std::map<std::uint16_t, ChannelRecord> channels;
  std::vector<Stretch> stretches;
  std::vector<AttachmentRecord> attachments;
  std::map<std::string, Map> metadata;
  std::optional<std::uint64_t> truncated_at;
  std::vector<std::string> damage;
  std::size_t unlisted_damage = 0;     ///< beyond ReadLimits::kDamages
  std::uint64_t raw_bytes = 0;         ///< that the chunks claim to have
  std::uint64_t definition_bytes = 0;  ///< of schemas, channels, metadata and names of attachments
};

/// A torn end in words.
[[nodiscard]] std::string truncation(std::uint64_t offset);

/// Lists a damage, or counts it.
void note_damage(Contents& contents, std::string text);

/// Walks the records of `source`. What does not fit its own lengths is skipped up to the next chunk and noted as
/// damage. Diagnostics: no MCAP file at all. Realtime: setup.
[[nodiscard]] Result<Contents> scan(const ByteSource& source);

/// The records of a stretch, or why they cannot be had ("checksum", ...).
/// @param check  false: it has been checked
[[nodiscard]] std::expected<std::string, std::string> unpack(const ByteSource& source, const Stretch& stretch,
                                                             bool check = true);

/// A message that is whole and has a time that can be counted with.
[[nodiscard]] bool has_valid_time(const Record& message);

/// Takes up a schema or channel record, wherever it is; false if the record does not fit its own lengths.
bool take_definition(const Record& record, Contents& contents);

}  // namespace takt::record::mcap
