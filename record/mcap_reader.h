#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/findings.h"
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

/// Everything in a file but the messages themselves; views point into the file's bytes.
struct Contents {
  std::map<std::uint16_t, std::string> schema_names;
  std::map<std::uint16_t, ChannelRecord> channels;
  std::vector<Stretch> stretches;
  std::vector<AttachmentRecord> attachments;
  std::map<std::string, Map> metadata;
  std::optional<std::uint64_t> truncated_at;
  std::vector<std::string> damage;
  bool in_summary = false;  ///< scan() is past the data: what the summary repeats is not taken twice
};

/// Walks the records of `bytes`. What does not fit its own lengths is skipped up to the next chunk and noted as damage.
/// Findings: no MCAP file at all. Realtime: setup.
[[nodiscard]] Result<Contents> scan(std::string_view bytes);

/// The records of a stretch, or why they cannot be had ("checksum", ...).
[[nodiscard]] std::expected<std::string, std::string> unpack(const Stretch& stretch);

/// Takes up a schema or channel record, wherever it stands; false if the record does not fit its own lengths.
bool take_definition(const Record& record, Contents& contents);

}  // namespace takt::record::mcap
