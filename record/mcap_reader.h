#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "record/mcap_format.h"

namespace takt::record::mcap {

struct ChannelRecord {
  std::uint16_t id = 0, schema = 0;
  std::string topic, encoding;
  Map metadata;
};

struct AttachmentRecord {
  std::string name, media_type;
  std::string_view data;
  bool whole = true;  ///< the checksum holds
};

/// A stretch of records to read messages from: a chunk, or one message that stands outside of chunks.
struct Stretch {
  std::size_t offset = 0;  ///< in the file
  std::string compression;
  std::string_view data;
  std::uint64_t raw_size = 0;
  std::uint32_t raw_crc = 0;  ///< 0: not checked
  bool is_chunk = false;
};

/// What a recording may be at most, whatever it claims: reading one costs at most 1 GiB of memory and some seconds.
struct ReadLimits {
  static constexpr std::uint64_t kFileBytes = 256u << 20;
  static constexpr std::uint64_t kChunkBytes = 32u << 20;  ///< unpacked; ours have about 1 MiB
  static constexpr std::uint64_t kRawBytes = 1u << 30;     ///< of all chunks, unpacked
  static constexpr std::size_t kStretches = 500'000;
  static constexpr std::size_t kDefinitions = 4096;          ///< channels, and as many schemas
  static constexpr std::size_t kDamages = 100;               ///< that are listed; more are counted
  static constexpr std::uint64_t kVisitBytes = 24ull << 30;  ///< to read all topics one by one, unpacked
  static constexpr std::size_t kTableValues = 16u << 20;     ///< of one topic
  /// ns; later ones cannot be told apart from negative ones (about the year 2116).
  static constexpr std::uint64_t kLatestTime = 1ull << 62;
};

/// Everything in a file but the messages themselves; views point into the file's bytes.
struct Contents {
  std::map<std::uint16_t, std::string> schema_names;
  std::map<std::uint16_t, ChannelRecord> channels;
  std::vector<Stretch> stretches;
  std::vector<AttachmentRecord> attachments;
  std::map<std::string, Map> metadata;
  std::optional<std::uint64_t> truncated_at;
  std::vector<std::string> damage;
  std::size_t unlisted_damage = 0;  ///< beyond ReadLimits::kDamages
  std::uint64_t raw_bytes = 0;      ///< that the chunks claim to have
  std::uint32_t data_crc = 0;       ///< of the bytes up to data_crc_end
  std::size_t data_crc_end = 0;
  bool in_summary = false;  ///< scan() is past the data: what the summary repeats is not taken twice
};

/// Lists a damage, or counts it.
void note_damage(Contents& contents, std::string text);

/// Walks the records of `bytes`. What does not fit its own lengths is skipped up to the next chunk and noted as damage.
/// Diagnostics: no MCAP file at all. Realtime: setup.
[[nodiscard]] Result<Contents> scan(std::string_view bytes);

/// The records of a stretch, or why they cannot be had ("checksum", ...). @param check  false: it has been checked
[[nodiscard]] std::expected<std::string, std::string> unpack(const Stretch& stretch, bool check = true);

/// A message that is whole and has a time that can be counted with.
[[nodiscard]] bool has_valid_time(const Record& message);

/// Takes up a schema or channel record, wherever it stands; false if the record does not fit its own lengths.
bool take_definition(const Record& record, Contents& contents);

}  // namespace takt::record::mcap
