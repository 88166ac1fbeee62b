#include "record/mcap_reader.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>

#include "record/chunk_compression.h"

namespace takt::record::mcap {

namespace {

constexpr std::size_t kMessageHead = 22;  ///< bytes: channel, sequence, two times

/// A record by its lengths; what it holds is read by whoever needs it.
struct RecordHead {
  std::uint8_t op = 0;
  std::uint64_t offset = 0;  ///< of the opcode
  std::uint64_t size = 0;    ///< of the body
  [[nodiscard]] std::uint64_t body() const { return offset + kRecordHead; }
  [[nodiscard]] std::uint64_t end() const { return body() + size; }
};

/// The record at `offset`, or nothing if the bytes end before it does.
std::optional<RecordHead> head_at(const ByteSource& source, std::uint64_t offset) {
  Cursor cursor(source.view(offset, kRecordHead));
  RecordHead head{.op = cursor.get<std::uint8_t>(), .offset = offset, .size = cursor.get<std::uint64_t>()};
  const bool whole = cursor.ok() && head.size <= source.size() - head.body();
  return whole ? std::optional(head) : std::nullopt;
}

/// A chunk by its own lengths, which must agree with the record's.
std::optional<Stretch> chunk_at(const ByteSource& source, const RecordHead& head) {
  constexpr std::uint64_t kFront = 64 + 40;  // the fixed part, and names of compressions that could be
  const std::string_view front = source.view(head.body(), std::min(head.size, kFront));
  Cursor cursor(front);
  cursor.get<std::uint64_t>();
  cursor.get<std::uint64_t>();
  Stretch stretch;
  stretch.offset = head.offset;
  stretch.is_chunk = true;
  stretch.raw_size = cursor.get<std::uint64_t>();
  stretch.raw_crc = cursor.get<std::uint32_t>();
  stretch.compression = cursor.get_text();
  stretch.data_size = cursor.get<std::uint64_t>();
  const std::uint64_t used = front.size() - cursor.left();
  if (!cursor.ok() || stretch.data_size != head.size - used) return std::nullopt;
  stretch.data_offset = head.body() + used;
  return stretch;
}

/// Whether a chunk may begin at `offset` of `block`: its opcode, and a name of a compression as long as names are.
bool may_be_chunk(std::string_view block, std::size_t offset) {
  constexpr std::size_t kNameAt = kRecordHead + 28, kLongestName = 32;
  if (block[offset] != static_cast<char>(Op::kChunk)) return false;
  Cursor cursor(block.substr(std::min(offset + kNameAt, block.size())));
  return cursor.get<std::uint32_t>() <= kLongestName && cursor.ok();
}

/// Where the next chunk begins at or after `from`: the two lengths that it has must agree.
std::optional<std::uint64_t> find_chunk(const ByteSource& source, std::uint64_t from) {
  constexpr std::uint64_t kFront = kRecordHead + 32, kBlock = 1u << 20;
  for (std::uint64_t begin = from; begin < source.size(); begin += kBlock) {
    // Blocks overlap, so that the front of each chunk lies in one of them.
    const std::string block(source.view(begin, kBlock + kFront - 1));
    for (std::size_t at = 0; at < std::min<std::size_t>(block.size(), kBlock); ++at) {
      if (!may_be_chunk(block, at)) continue;
      const auto head = head_at(source, begin + at);
      if (head && chunk_at(source, *head)) return begin + at;
    }
  }
  return std::nullopt;
}

/// One pass over the records of a file.
class Scanner {
 public:
  explicit Scanner(const ByteSource& source) : source_(source) {
    most_raw_bytes_ = ReadLimits::kRawBytes + ReadLimits::kRawPerByte * std::min(source.size(), ReadLimits::kFileBytes);
  }

  Contents scan() {
    std::uint64_t offset = kMagic.size();
    for (;;) {
      const auto head = head_at(source_, offset);
      if (head && take(*head)) {
        offset = head->end();
        if (static_cast<Op>(head->op) != Op::kFooter) continue;
        if (source_.view(offset, kMagic.size() + 1) != kMagic) end_at(offset);
        break;
      }
      // Torn at the end, or rotted in the middle: then whole chunks may follow.
      const auto next = find_chunk(source_, offset + 1);
      if (!next) {
        end_at(offset);
        break;
      }
      note_damage(contents_, fmt::format("record at byte {}: unreadable up to byte {}", offset, *next));
      offset = *next;
    }
    drop_stray_messages();
    return std::move(contents_);
  }

 private:
  void end_at(std::uint64_t offset) {
    contents_.truncated_at = offset;
    note_damage(contents_, truncation(offset));
  }

  /// False: the record does not fit its own lengths.
  bool take(const RecordHead& head) {
    switch (static_cast<Op>(head.op)) {
      case Op::kSchema:
      case Op::kChannel:
        return in_summary_ ||
               take_small(head, [this](const Record& record) { return take_definition(record, contents_); });
      case Op::kChunk:
        return take_chunk(head);
      case Op::kMessage:
        return take_message(head);
      case Op::kMessageIndex:
        return check_message_index(head);
      case Op::kAttachment:
        return take_attachment(head);
      case Op::kMetadata:
        return take_small(head, [this](const Record& record) { return take_metadata(record); });
      case Op::kDataEnd:
        return check_data_end(head);
      case Op::kHeader:
      case Op::kFooter:
      case Op::kChunkIndex:
      case Op::kAttachmentIndex:
      case Op::kStatistics:
      case Op::kMetadataIndex:
      case Op::kSummaryOffset:
        return true;
    }
    return head.op >= kFirstPrivateOp;
  }

  /// Calls take_record(Record) for a record that is kept as it is; what is too large is left out.
  template <class TakeRecord>
  bool take_small(const RecordHead& head, TakeRecord take_record) {
    if (!room_for_definition(head, head.size)) return true;
    return take_record(Record{.op = head.op, .offset = head.offset, .body = source_.view(head.body(), head.size)});
  }

  bool room_for_definition(const RecordHead& head, std::uint64_t size) {
    const bool room = size <= ReadLimits::kDefinitionBytes - contents_.definition_bytes;
    if (room) contents_.definition_bytes += size;
    if (!room) leave_out(head);
    return room;
  }

  bool room_for_stretch(const RecordHead& head, std::uint64_t raw_size) {
    const bool room =
        contents_.stretches.size() < ReadLimits::kStretches && raw_size <= most_raw_bytes_ - contents_.raw_bytes;
    if (room) contents_.raw_bytes += raw_size;
    if (!room) leave_out(head);
    return room;
  }

  void leave_out(const RecordHead& head) {
    note_damage(contents_, fmt::format("record at byte {}: left out, the recording is too large", head.offset));
  }

  bool take_chunk(const RecordHead& head) {
    auto stretch = chunk_at(source_, head);
    if (!stretch) return false;
    const std::uint64_t raw_size = stretch->compression.empty() ? stretch->data_size : stretch->raw_size;
    if (raw_size > ReadLimits::kChunkBytes || stretch->data_size > ZSTD_COMPRESSBOUND(ReadLimits::kChunkBytes)) {
      note_damage(contents_, fmt::format("chunk at byte {}: its size is implausible", head.offset));
    } else if (room_for_stretch(head, raw_size)) {
      contents_.stretches.push_back(std::move(*stretch));
    }
    return true;
  }

  /// Messages outside of chunks that follow one another are one stretch.
  bool take_message(const RecordHead& head) {
    constexpr std::uint64_t kMostTogether = 8u << 20;
    if (head.size < kMessageHead) return false;
    const std::uint64_t size = head.end() - head.offset;
    if (size > ReadLimits::kChunkBytes || !room_for_stretch(head, size)) return true;
    Stretch* last = contents_.stretches.empty() ? nullptr : &contents_.stretches.back();
    const bool follows = last != nullptr && !last->is_chunk && last->data_offset + last->data_size == head.offset &&
                         last->data_size + size <= kMostTogether;
    if (!follows) {
      last = &contents_.stretches.emplace_back();
      last->offset = last->data_offset = head.offset;
    }
    last->data_size += size;
    return true;
  }

  bool check_message_index(const RecordHead& head) const {
    Cursor cursor(source_.view(head.body(), std::min<std::uint64_t>(head.size, 6)));
    cursor.get<std::uint16_t>();
    const std::uint64_t entries = cursor.get<std::uint32_t>();
    return cursor.ok() && entries == head.size - 6;
  }

  bool take_attachment(const RecordHead& head) {
    constexpr std::uint64_t kFront = 1u << 17;  // two times, two names
    if (head.size < sizeof(std::uint32_t)) return false;
    const std::string_view front = source_.view(head.body(), std::min(head.size, kFront));
    Cursor cursor(front);
    cursor.get<std::uint64_t>();
    cursor.get<std::uint64_t>();
    AttachmentRecord attachment;
    attachment.name = cursor.get_text();
    attachment.media_type = cursor.get_text();
    attachment.size = cursor.get<std::uint64_t>();
    const std::uint64_t used = front.size() - cursor.left();
    if (!cursor.ok() || attachment.size != head.size - sizeof(std::uint32_t) - std::min(used, head.size - 4))
      return false;
    attachment.offset = head.body() + used;
    if (contents_.attachments.size() >= ReadLimits::kDefinitions || attachment.size > ReadLimits::kAttachmentBytes ||
        !room_for_definition(head, used)) {
      leave_out(head);
      return true;
    }
    Cursor last(source_.view(head.end() - sizeof(std::uint32_t), sizeof(std::uint32_t)));
    const auto crc = last.get<std::uint32_t>();
    attachment.whole = crc == 0 || crc == sum(0, head.body(), head.end() - sizeof(crc));
    if (!attachment.whole)
      note_damage(contents_, fmt::format("attachment '{}' at byte {}: checksum", attachment.name, head.offset));
    contents_.attachments.push_back(std::move(attachment));
    return true;
  }

  bool take_metadata(const Record& record) {
    Cursor cursor(record.body);
    std::string name(cursor.get_text());
    Map map = cursor.get_map();
    if (!cursor.ok() || !cursor.at_end()) return false;
    if (contents_.metadata.size() < ReadLimits::kDefinitions)
      contents_.metadata.insert_or_assign(std::move(name), std::move(map));
    return true;
  }

  bool check_data_end(const RecordHead& head) {
    Cursor cursor(source_.view(head.body(), std::min<std::uint64_t>(head.size, sizeof(std::uint32_t))));
    const auto crc = cursor.get<std::uint32_t>();
    if (!cursor.ok()) return false;
    // Each byte is summed once, however many such records there are; none where the file has no sum.
    if (crc != 0) {
      data_crc_ = sum(data_crc_, data_crc_end_, head.offset);
      data_crc_end_ = head.offset;
      if (crc != data_crc_) note_damage(contents_, "checksum of the data section");
    }
    // What the summary repeats is not taken twice.
    in_summary_ = !contents_.channels.empty();
    return true;
  }

  /// The checksum of [from, to), continued from `crc`.
  [[nodiscard]] std::uint32_t sum(std::uint32_t crc, std::uint64_t from, std::uint64_t to) const {
    constexpr std::uint64_t kBlock = 1u << 20;
    while (from < to) {
      const std::string_view block = source_.view(from, std::min(kBlock, to - from));
      if (block.empty()) break;
      crc = crc32(crc, block);
      from += block.size();
    }
    return crc;
  }

  /// A message outside of chunks is one's own choice for a whole file; among chunks it is a rotten message index.
  void drop_stray_messages() {
    if (std::ranges::none_of(contents_.stretches, &Stretch::is_chunk)) return;
    std::erase_if(contents_.stretches, [this](const Stretch& stretch) {
      if (!stretch.is_chunk) note_damage(contents_, fmt::format("message at byte {}: no chunk", stretch.offset));
      return !stretch.is_chunk;
    });
  }

  const ByteSource& source_;
  std::uint64_t most_raw_bytes_ = 0;
  Contents contents_;
  std::uint32_t data_crc_ = 0;  ///< of the bytes up to data_crc_end_
  std::uint64_t data_crc_end_ = 0;
  bool in_summary_ = false;
};

}  // namespace

std::string truncation(std::uint64_t offset) { return fmt::format("truncated at byte {}", offset); }

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
    SchemaRecord schema;
    schema.name = cursor.get_text();
    schema.encoding = cursor.get_text();
    schema.data = cursor.get_text();
    if (!cursor.ok() || !cursor.at_end()) return false;
    if (contents.schemas.size() < ReadLimits::kDefinitions) contents.schemas.try_emplace(id, std::move(schema));
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

Result<Contents> scan(const ByteSource& source) {
  if (source.size() > ReadLimits::kFileBytes)
    return failure(Code::kTooLarge, "", fmt::format("the file has {} bytes", source.size()),
                   fmt::format("Keep it to {} at most", ReadLimits::kFileBytes));
  if (source.view(0, kMagic.size()) != kMagic) {
    return failure(Code::kSyntax, "",
                   source.size() == 0 ? "the file is empty" : "this is not an MCAP file: its first 8 bytes are others");
  }
  return Scanner(source).scan();
}

std::expected<std::string, std::string> unpack(const ByteSource& source, const Stretch& stretch, bool check) {
  const std::string_view data = source.view(stretch.data_offset, stretch.data_size);
  if (data.size() != stretch.data_size) return std::unexpected("it cannot be read");
  if (stretch.is_chunk && stretch.raw_size > ReadLimits::kChunkBytes) return std::unexpected("its size is implausible");
  auto raw = decompress(stretch.compression, data, stretch.raw_size);
  if (!raw) return raw;
  if (check && stretch.raw_crc != 0 && crc32(0, *raw) != stretch.raw_crc) return std::unexpected("checksum");
  return raw;
}

}  // namespace takt::record::mcap
