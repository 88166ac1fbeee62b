#include "record/mcap_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace takt::record::mcap {

namespace {

std::uint64_t unsigned_time(Nanoseconds time) { return static_cast<std::uint64_t>(std::max<Nanoseconds>(time, 0)); }

/// The head of a record that readers skip, covering `size` bytes in all.
std::string filler_head(std::uint64_t size) {
  std::string head;
  put(head, kFirstPrivateOp);
  put(head, size - kRecordHead);
  return head;
}

class PosixFile : public File {
 public:
  explicit PosixFile(int fd) : fd_(fd) {}
  ~PosixFile() override { close(); }
  PosixFile(const PosixFile&) = delete;
  PosixFile& operator=(const PosixFile&) = delete;

  int write_at(std::uint64_t offset, std::string_view bytes) override {
    while (!bytes.empty()) {
      const ssize_t written = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return written < 0 ? errno : ENOSPC;
      bytes.remove_prefix(static_cast<std::size_t>(written));
      offset += static_cast<std::uint64_t>(written);
    }
    return 0;
  }
  int cut_at(std::uint64_t size) override { return ::ftruncate(fd_, static_cast<off_t>(size)) == 0 ? 0 : errno; }
  int close() override {
    if (fd_ < 0) return 0;
    const int result = ::close(std::exchange(fd_, -1));
    return result == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

}  // namespace

std::unique_ptr<File> create_file(const std::filesystem::path& path, int& error) {
  // A FIFO that nobody reads is an error, not something to wait for; one that is read has no places to write at.
  const int fd = ::open(path.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC | O_NONBLOCK, 0644);
  error = fd < 0 ? errno : 0;
  return fd < 0 ? nullptr : std::make_unique<PosixFile>(fd);
}

void Writer::ZstdFree::operator()(void* context) const { ZSTD_freeCCtx(static_cast<ZSTD_CCtx*>(context)); }

Writer::Writer(const std::filesystem::path& path, int zstd_level, std::size_t chunk_bytes)
    : Writer(nullptr, path.string(), zstd_level, chunk_bytes) {
  int code = 0;
  file_ = create_file(path, code);
  if (file_ == nullptr) {
    fail("create", code);
  } else {
    write_start();
  }
}

Writer::Writer(std::unique_ptr<File> file, std::string name, int zstd_level, std::size_t chunk_bytes)
    : file_(std::move(file)),
      name_(std::move(name)),
      zstd_(ZSTD_createCCtx()),
      slot_bytes_(2 * chunk_bytes + (64u << 10)) {
  ZSTD_CCtx_setParameter(static_cast<ZSTD_CCtx*>(zstd_.get()), ZSTD_c_compressionLevel, zstd_level);
  if (file_ != nullptr) write_start();
}

void Writer::write_start() {
  std::string start(kMagic);
  {
    const RecordScope record(start, Op::kHeader);
    put_text(start, "");
    put_text(start, "takt");
  }
  append(start);
}

void Writer::fail(std::string_view what, int code) {
  if (!error_.empty()) return;
  error_ = fmt::format("cannot {} {}: {}", what, name_, std::strerror(code));
}

bool Writer::write_at(std::uint64_t offset, std::string_view bytes) {
  if (!error_.empty()) return false;
  const int code = file_->write_at(offset, bytes);
  if (code != 0) {
    // What is torn goes, so that the file ends with a whole record; a flushed chunk stays.
    if (live_slot_ < 0) cut_at(end_);
    fail("write to", code);
    return false;
  }
  file_size_ = std::max(file_size_, offset + bytes.size());
  return true;
}

void Writer::cut_at(std::uint64_t size) {
  // A file that cannot be cut (a device) only keeps bytes behind its end.
  if (file_->cut_at(size) == 0) file_size_ = size;
}

void Writer::append(std::string_view bytes) {
  if (live_slot_ >= 0) {
    append_over_flushed(bytes);
  } else {
    write_at(end_, bytes);
  }
  if (!error_.empty()) return;
  data_crc_ = crc32(data_crc_, bytes);
  end_ += bytes.size();
}

void Writer::append_over_flushed(std::string_view bytes) {
  // The body first, under the filler's head that still leads to the flushed chunk; then the head in one short write.
  const std::uint64_t next = end_ + bytes.size();
  std::string body(bytes.substr(kRecordHead));
  if (next + kRecordHead <= file_size_) body += filler_head(file_size_ - next);
  if (!write_at(end_ + kRecordHead, body) || !write_at(end_, bytes.substr(0, kRecordHead))) return;
  live_slot_ = -1;
  cut_at(next);
}

bool Writer::cover_hole(std::uint64_t start, std::uint64_t stop) {
  if (live_slot_ < 0) return write_at(end_, filler_head(start - end_));
  return write_at(file_size_, filler_head(stop - file_size_));
}

void Writer::flush_open_chunk() {
  if (!error_.empty() || raw_.empty() || !encode_chunk()) return;
  if (record_bytes_.size() + kRecordHead > slot_bytes_) return close_chunk();
  // Two slots behind a filler record; the new content goes into the one that the filler does not lead to, then the
  // filler's head is turned. What lies behind a chunk in the first slot is covered by a second filler: of the zeros of
  // a hole readers would make records.
  const int slot = live_slot_ == 0 ? 1 : 0;
  const std::uint64_t start = end_ + kRecordHead + slot_bytes_ * static_cast<std::uint64_t>(slot + 1);
  const std::uint64_t stop = start + record_bytes_.size();
  if (stop + kRecordHead <= file_size_) record_bytes_ += filler_head(file_size_ - stop);
  if (start > file_size_ && !cover_hole(start, stop)) return;
  if (!write_at(start, record_bytes_) || !write_at(end_, filler_head(start - end_))) return;
  live_slot_ = slot;
  if (stop < file_size_) cut_at(stop);
}

void Writer::add_attachment(std::string_view name, std::string_view media_type, std::string_view data) {
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kAttachment);
    put(bytes, std::uint64_t{0});
    put(bytes, std::uint64_t{0});
    put_text(bytes, name);
    put_text(bytes, media_type);
    put(bytes, static_cast<std::uint64_t>(data.size()));
    bytes.append(data);
    put(bytes, crc32(0, std::string_view(bytes).substr(kRecordHead)));
  }
  {
    const RecordScope record(attachment_indexes_, Op::kAttachmentIndex);
    put(attachment_indexes_, end_);
    put(attachment_indexes_, static_cast<std::uint64_t>(bytes.size()));
    put(attachment_indexes_, std::uint64_t{0});
    put(attachment_indexes_, std::uint64_t{0});
    put(attachment_indexes_, static_cast<std::uint64_t>(data.size()));
    put_text(attachment_indexes_, name);
    put_text(attachment_indexes_, media_type);
  }
  ++attachment_count_;
  append(bytes);
}

void Writer::add_metadata(std::string_view name, const Map& map) {
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kMetadata);
    put_text(bytes, name);
    put_map(bytes, map);
  }
  {
    const RecordScope record(metadata_indexes_, Op::kMetadataIndex);
    put(metadata_indexes_, end_);
    put(metadata_indexes_, static_cast<std::uint64_t>(bytes.size()));
    put_text(metadata_indexes_, name);
  }
  ++metadata_count_;
  append(bytes);
}

std::uint16_t Writer::add_schema(std::string_view name, std::string_view encoding, std::string_view data) {
  const auto [found, added] = schema_ids_.try_emplace({std::string(name), std::string(data)},
                                                      static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (!added) return found->second;
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kSchema);
    put(bytes, found->second);
    put_text(bytes, name);
    put_text(bytes, encoding);
    put_text(bytes, data);
  }
  schema_records_ += bytes;
  append(bytes);
  return found->second;
}

std::uint16_t Writer::add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding,
                                  const Map& meta) {
  const auto id = static_cast<std::uint16_t>(channels_.size());
  channels_.emplace_back();
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kChannel);
    put(bytes, id);
    put(bytes, schema);
    put_text(bytes, topic);
    put_text(bytes, encoding);
    put_map(bytes, meta);
  }
  channel_records_ += bytes;
  append(bytes);
  return id;
}

std::string& Writer::begin_message(std::uint16_t channel, Nanoseconds time, std::optional<Nanoseconds> published) {
  chunk_start_ = raw_.empty() ? time : std::min(chunk_start_, time);
  chunk_end_ = raw_.empty() ? time : std::max(chunk_end_, time);
  first_time_ = message_count_ == 0 ? time : std::min(first_time_, time);
  last_time_ = message_count_ == 0 ? time : std::max(last_time_, time);
  ChannelState& state = channels_[channel];
  message_start_ = raw_.size();
  state.index.emplace_back(unsigned_time(time), message_start_);
  put(raw_, Op::kMessage);
  put(raw_, std::uint64_t{0});
  put(raw_, channel);
  put(raw_, static_cast<std::uint32_t>(state.messages));
  put(raw_, unsigned_time(time));
  put(raw_, unsigned_time(published.value_or(time)));
  ++state.messages;
  ++message_count_;
  return raw_;
}

void Writer::end_message() {
  const std::uint64_t size = raw_.size() - message_start_ - kRecordHead;
  std::memcpy(raw_.data() + message_start_ + 1, &size, sizeof(size));
}

bool Writer::encode_chunk() {
  compressed_.resize(ZSTD_compressBound(raw_.size()));
  const std::size_t size = ZSTD_compress2(static_cast<ZSTD_CCtx*>(zstd_.get()), compressed_.data(), compressed_.size(),
                                          raw_.data(), raw_.size());
  if (ZSTD_isError(size)) {
    error_ = fmt::format("cannot compress a chunk of {}: {}", name_, ZSTD_getErrorName(size));
    return false;
  }
  record_bytes_.clear();
  {
    const RecordScope record(record_bytes_, Op::kChunk);
    put(record_bytes_, unsigned_time(chunk_start_));
    put(record_bytes_, unsigned_time(chunk_end_));
    put(record_bytes_, static_cast<std::uint64_t>(raw_.size()));
    put(record_bytes_, crc32(0, raw_));
    put_text(record_bytes_, "zstd");
    put(record_bytes_, static_cast<std::uint64_t>(size));
    record_bytes_.append(compressed_, 0, size);
  }
  const std::uint64_t chunk_size = record_bytes_.size();

  std::string offsets;
  for (std::size_t id = 1; id < channels_.size(); ++id) {
    const auto& index = channels_[id].index;
    if (index.empty()) continue;
    put(offsets, static_cast<std::uint16_t>(id));
    put(offsets, end_ + record_bytes_.size());
    const RecordScope record(record_bytes_, Op::kMessageIndex);
    put(record_bytes_, static_cast<std::uint16_t>(id));
    put(record_bytes_, static_cast<std::uint32_t>(index.size() * 16));
    for (const auto& [time, offset] : index) {
      put(record_bytes_, time);
      put(record_bytes_, offset);
    }
  }

  chunk_index_entry_.clear();
  const RecordScope record(chunk_index_entry_, Op::kChunkIndex);
  put(chunk_index_entry_, unsigned_time(chunk_start_));
  put(chunk_index_entry_, unsigned_time(chunk_end_));
  put(chunk_index_entry_, end_);
  put(chunk_index_entry_, chunk_size);
  put_text(chunk_index_entry_, offsets);
  put(chunk_index_entry_, static_cast<std::uint64_t>(record_bytes_.size()) - chunk_size);
  put_text(chunk_index_entry_, "zstd");
  put(chunk_index_entry_, static_cast<std::uint64_t>(size));
  put(chunk_index_entry_, static_cast<std::uint64_t>(raw_.size()));
  return true;
}

void Writer::close_chunk() {
  if (!error_.empty() || raw_.empty() || !encode_chunk()) return;
  append(record_bytes_);
  chunk_indexes_ += chunk_index_entry_;
  ++chunk_count_;
  raw_.clear();
  for (ChannelState& channel : channels_) channel.index.clear();
}

void Writer::write_summary() {
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kDataEnd);
    put(bytes, data_crc_);
  }
  append(bytes);

  std::string statistics;
  {
    const RecordScope record(statistics, Op::kStatistics);
    put(statistics, message_count_);
    put(statistics, static_cast<std::uint16_t>(schema_ids_.size()));
    put(statistics, static_cast<std::uint32_t>(channels_.size() - 1));
    put(statistics, attachment_count_);
    put(statistics, metadata_count_);
    put(statistics, chunk_count_);
    put(statistics, unsigned_time(first_time_));
    put(statistics, unsigned_time(last_time_));
    put(statistics, static_cast<std::uint32_t>((channels_.size() - 1) * 10));
    for (std::size_t id = 1; id < channels_.size(); ++id) {
      put(statistics, static_cast<std::uint16_t>(id));
      put(statistics, channels_[id].messages);
    }
  }

  const std::uint64_t summary_start = end_;
  std::string summary, offsets;
  const auto add_group = [&](Op op, const std::string& records) {
    if (records.empty()) return;
    const RecordScope record(offsets, Op::kSummaryOffset);
    put(offsets, op);
    put(offsets, summary_start + summary.size());
    put(offsets, static_cast<std::uint64_t>(records.size()));
    summary += records;
  };
  add_group(Op::kSchema, schema_records_);
  add_group(Op::kChannel, channel_records_);
  add_group(Op::kStatistics, statistics);
  add_group(Op::kChunkIndex, chunk_indexes_);
  add_group(Op::kAttachmentIndex, attachment_indexes_);
  add_group(Op::kMetadataIndex, metadata_indexes_);
  const std::uint64_t offsets_start = summary_start + summary.size();
  summary += offsets;

  {
    const RecordScope record(summary, Op::kFooter);
    put(summary, summary_start);
    put(summary, offsets_start);
    // The checksum covers the footer up to itself, its length included.
    std::string covered = summary;
    const std::uint64_t footer_size = 20;
    std::memcpy(covered.data() + (offsets_start - summary_start + offsets.size()) + 1, &footer_size, 8);
    put(summary, crc32(0, covered));
  }
  summary += kMagic;
  append(summary);
}

void Writer::finish() {
  if (file_ == nullptr) return;
  close_chunk();
  if (error_.empty()) write_summary();
  if (const int code = file_->close(); code != 0) fail("close", code);
  file_.reset();
}

}  // namespace takt::record::mcap
