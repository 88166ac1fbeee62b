#include "record/mcap_reader.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>

namespace takt::record::mcap {

namespace {

constexpr std::size_t kMessageHead = 22;  ///< bytes: channel, sequence, two times

bool room_for_stretch(const Record& record, std::uint64_t raw_size, Contents& contents) {
  const bool room =
      contents.stretches.size() < ReadLimits::kStretches && raw_size <= ReadLimits::kRawBytes - contents.raw_bytes;
  if (room) contents.raw_bytes += raw_size;
  if (!room)
    note_damage(contents, fmt::format("record at byte {}: left out, the recording is too large", record.offset));
  return room;
}

bool take_chunk(const Record& record, Contents& contents) {
  Cursor cursor(record.body);
  cursor.get<std::uint64_t>();
  cursor.get<std::uint64_t>();
  Stretch stretch;
  stretch.offset = record.offset;
  stretch.is_chunk = true;
  stretch.raw_size = cursor.get<std::uint64_t>();
  stretch.raw_crc = cursor.get<std::uint32_t>();
  stretch.compression = cursor.get_text();
  stretch.data = cursor.get_blob();
  if (!cursor.ok() || !cursor.at_end()) return false;
  const std::uint64_t raw_size = stretch.compression.empty() ? stretch.data.size() : stretch.raw_size;
  if (raw_size > ReadLimits::kChunkBytes) {
    note_damage(contents, fmt::format("chunk at byte {}: its size is implausible", record.offset));
  } else if (room_for_stretch(record, raw_size, contents)) {
    contents.stretches.push_back(std::move(stretch));
  }
  return true;
}

/// Messages outside of chunks that follow one another are one stretch.
bool take_message(const Record& record, std::string_view bytes, Contents& contents) {
  constexpr std::size_t kMostTogether = 8u << 20;
  if (record.body.size() < kMessageHead) return false;
  const std::size_t size = record.end() - record.offset;
  if (size > ReadLimits::kChunkBytes || !room_for_stretch(record, size, contents)) return true;
  Stretch* last = contents.stretches.empty() ? nullptr : &contents.stretches.back();
  const bool follows = last && !last->is_chunk && last->offset + last->data.size() == record.offset &&
                       last->data.size() + size <= kMostTogether;
  if (follows) {
    last->data = bytes.substr(last->offset, last->data.size() + size);
    return true;
  }
  contents.stretches.emplace_back();
  contents.stretches.back().offset = record.offset;
  contents.stretches.back().data = bytes.substr(record.offset, size);
  return true;
}

bool take_attachment(const Record& record, Contents& contents) {
  Cursor cursor(record.body);
  cursor.get<std::uint64_t>();
  cursor.get<std::uint64_t>();
  AttachmentRecord attachment;
  attachment.name = cursor.get_text();
  attachment.media_type = cursor.get_text();
  attachment.data = cursor.get_blob();
  const auto crc = cursor.get<std::uint32_t>();
  if (!cursor.ok() || !cursor.at_end()) return false;
  attachment.whole = crc == 0 || crc == crc32(0, record.body.substr(0, record.body.size() - sizeof(crc)));
  if (!attachment.whole) {
    note_damage(contents, fmt::format("attachment '{}' at byte {}: checksum", attachment.name, record.offset));
  }
  contents.attachments.push_back(std::move(attachment));
  return true;
}

bool take_metadata(const Record& record, Contents& contents) {
  Cursor cursor(record.body);
  std::string name(cursor.get_text());
  Map map = cursor.get_map();
  if (!cursor.ok() || !cursor.at_end()) return false;
  contents.metadata.insert_or_assign(std::move(name), std::move(map));
  return true;
}

bool check_message_index(const Record& record) {
  Cursor cursor(record.body);
  cursor.get<std::uint16_t>();
  cursor.get_text();
  return cursor.ok() && cursor.at_end();
}

bool check_data_end(const Record& record, std::string_view bytes, Contents& contents) {
  Cursor cursor(record.body);
  const auto crc = cursor.get<std::uint32_t>();
  if (!cursor.ok()) return false;
  // Each byte is summed once, however many such records there are.
  contents.data_crc =
      crc32(contents.data_crc, bytes.substr(contents.data_crc_end, record.offset - contents.data_crc_end));
  contents.data_crc_end = record.offset;
  if (crc != 0 && crc != contents.data_crc) note_damage(contents, "checksum of the data section");
  contents.in_summary = !contents.channels.empty();
  return true;
}

/// A message outside of chunks is one's own choice for a whole file; among chunks it is a rotten message index.
void drop_stray_messages(Contents& contents) {
  if (std::ranges::none_of(contents.stretches, &Stretch::is_chunk)) return;
  std::erase_if(contents.stretches, [&](const Stretch& stretch) {
    if (!stretch.is_chunk) note_damage(contents, fmt::format("message at byte {}: no chunk", stretch.offset));
    return !stretch.is_chunk;
  });
}

/// False: the record does not fit its own lengths.
bool take_record(const Record& record, std::string_view bytes, Contents& contents) {
  switch (static_cast<Op>(record.op)) {
    case Op::kSchema:
    case Op::kChannel:
      return contents.in_summary || take_definition(record, contents);
    case Op::kChunk:
      return take_chunk(record, contents);
    case Op::kMessage:
      return take_message(record, bytes, contents);
    case Op::kMessageIndex:
      return check_message_index(record);
    case Op::kAttachment:
      return take_attachment(record, contents);
    case Op::kMetadata:
      return take_metadata(record, contents);
    case Op::kDataEnd:
      return check_data_end(record, bytes, contents);
    case Op::kHeader:
    case Op::kFooter:
    case Op::kChunkIndex:
    case Op::kAttachmentIndex:
    case Op::kStatistics:
    case Op::kMetadataIndex:
    case Op::kSummaryOffset:
      return true;
  }
  return record.op >= kFirstPrivateOp;
}

/// Where the next chunk begins at or after `from`: its length, its compression and its inner length must agree.
std::optional<std::size_t> find_chunk(std::string_view bytes, std::size_t from) {
  constexpr std::size_t kCompressionAt = kRecordHead + 28;
  const std::string_view mark{"\x04\0\0\0zstd", 8};
  for (std::size_t at = bytes.find(mark, from + kCompressionAt); at != std::string_view::npos;
       at = bytes.find(mark, at + 1)) {
    const std::size_t offset = at - kCompressionAt;
    if (bytes[offset] != static_cast<char>(Op::kChunk)) continue;
    const auto record = record_at(bytes, offset);
    Contents ignored;
    if (record && take_chunk(*record, ignored)) return offset;
  }
  return std::nullopt;
}

}  // namespace

void note_damage(Contents& contents, std::string text) {
  if (contents.damage.size() < ReadLimits::kDamages) {
    contents.damage.push_back(std::move(text));
  } else {
    ++contents.unlisted_damage;
  }
}

bool has_valid_time(const Record& message) {
  if (message.body.size() < kMessageHead) return false;
  Cursor cursor(message.body);
  cursor.get<std::uint16_t>();
  cursor.get<std::uint32_t>();
  return cursor.get<std::uint64_t>() <= ReadLimits::kLatestTime;
}

bool take_definition(const Record& record, Contents& contents) {
  Cursor cursor(record.body);
  if (static_cast<Op>(record.op) == Op::kSchema) {
    const auto id = cursor.get<std::uint16_t>();
    std::string name(cursor.get_text());
    cursor.get_text();
    cursor.get_text();
    if (!cursor.ok() || !cursor.at_end()) return false;
    if (contents.schema_names.size() < ReadLimits::kDefinitions) contents.schema_names.try_emplace(id, std::move(name));
    return true;
  }
  ChannelRecord channel;
  channel.id = cursor.get<std::uint16_t>();
  channel.schema = cursor.get<std::uint16_t>();
  channel.topic = cursor.get_text();
  channel.encoding = cursor.get_text();
  channel.metadata = cursor.get_map();
  if (!cursor.ok() || !cursor.at_end()) return false;
  const std::uint16_t id = channel.id;
  if (contents.channels.size() < ReadLimits::kDefinitions) contents.channels.try_emplace(id, std::move(channel));
  return true;
}

Result<Contents> scan(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) {
    return failure(Code::kSyntax, "",
                   bytes.empty() ? "the file is empty" : "this is not an MCAP file: its first 8 bytes are others");
  }
  Contents contents;
  std::size_t offset = kMagic.size();
  for (;;) {
    const auto record = record_at(bytes, offset);
    if (record && take_record(*record, bytes, contents)) {
      offset = record->end();
      if (static_cast<Op>(record->op) != Op::kFooter) continue;
      if (bytes.substr(offset) != kMagic) {
        contents.truncated_at = offset;
        note_damage(contents, fmt::format("truncated at byte {}", offset));
      }
      drop_stray_messages(contents);
      return contents;
    }
    // Torn at the end, or rotted in the middle: then whole chunks may follow.
    const auto next = find_chunk(bytes, offset + 1);
    if (!next) break;
    note_damage(contents, fmt::format("record at byte {}: unreadable up to byte {}", offset, *next));
    offset = *next;
  }
  drop_stray_messages(contents);
  contents.truncated_at = offset;
  note_damage(contents, fmt::format("truncated at byte {}", offset));
  return contents;
}

std::expected<std::string, std::string> unpack(const Stretch& stretch, bool check) {
  std::string raw;
  if (stretch.compression == "zstd") {
    // The size stands twice; a rotted one must not cost memory.
    if (stretch.raw_size > ReadLimits::kChunkBytes ||
        ZSTD_getFrameContentSize(stretch.data.data(), stretch.data.size()) != stretch.raw_size) {
      return std::unexpected("its size is implausible");
    }
    raw.resize(stretch.raw_size);
    const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), stretch.data.data(), stretch.data.size());
    if (ZSTD_isError(size) || size != raw.size()) return std::unexpected("it does not decompress");
  } else if (stretch.compression.empty()) {
    raw = stretch.data;
  } else {
    return std::unexpected(fmt::format("compression '{}' is not known", stretch.compression));
  }
  if (check && stretch.raw_crc != 0 && crc32(0, raw) != stretch.raw_crc) return std::unexpected("checksum");
  return raw;
}

}  // namespace takt::record::mcap
