#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "record/mcap_format.h"

namespace takt::record::mcap {

/// Where a recording goes. Each call is one change of what a killed process leaves behind. Errors are errno values, 0 =
/// done.
class File {
 public:
  virtual ~File() = default;
  virtual int write_at(std::uint64_t offset, std::string_view bytes) = 0;
  virtual int cut_at(std::uint64_t size) = 0;
  virtual int close() = 0;
};

/// A file of the operating system, created or replaced; every write has left the process when it returns. On error
/// nullptr, and `error` is set.
[[nodiscard]] std::unique_ptr<File> create_file(const std::filesystem::path& path, int& error);

/// Writes the container: schemas and channels first, then messages in compressed chunks with their indexes, at the end
/// the summary. One owner, one thread. After the first error (error() is not empty) all calls do nothing.
///
/// Chunks are final once closed. flush_open_chunk() puts what the open chunk holds so far behind it on the disk; the
/// final chunk later takes its place. At every moment the file is a valid sequence of records, so a killed process
/// loses what came after the last flush and nothing else, and a flush leaves no trace in the finished file.
/// Realtime: setup.
class Writer {
 public:
  /// Creates or replaces the file. Look at error().
  Writer(const std::filesystem::path& path, int zstd_level, std::size_t chunk_bytes);
  /// The same into any File; `name` is for messages.
  Writer(std::unique_ptr<File> file, std::string name, int zstd_level, std::size_t chunk_bytes);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void add_attachment(std::string_view name, std::string_view media_type, std::string_view data);
  void add_metadata(std::string_view name, const Map& map);
  /// Ids count from 1; equal (name, data) give the same id.
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data);
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic, std::string_view encoding, const Map& meta);

  /// Opens a message in the chunk; append its bytes to the string, then call end_message.
  /// @param published  when it was sent, if that is another time than `time`
  std::string& begin_message(std::uint16_t channel, Nanoseconds time, std::optional<Nanoseconds> published = {});
  void end_message();

  /// Raw bytes in the open chunk, and the least time of its messages.
  [[nodiscard]] std::size_t open_bytes() const { return raw_.size(); }
  [[nodiscard]] Nanoseconds open_since() const { return chunk_start_; }

  void close_chunk();
  void flush_open_chunk();
  /// Closes the chunk, writes the summary, closes the file.
  void finish();

  [[nodiscard]] const std::string& error() const { return error_; }
  [[nodiscard]] std::uint64_t message_count() const { return message_count_; }
  [[nodiscard]] std::uint64_t size() const { return end_; }

 private:
  struct ChannelState {
    std::uint64_t messages = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  ///< (time, offset in the open chunk)
  };
  struct ZstdFree {
    void operator()(void* context) const;
  };

  void write_start();
  void append(std::string_view bytes);
  void append_over_flushed(std::string_view bytes);
  /// Before a flushed chunk is written to [start, stop), behind the end of the file: a filler's head, so that whoever
  /// dies in between leaves no hole.
  bool cover_hole(std::uint64_t start, std::uint64_t stop);
  bool write_at(std::uint64_t offset, std::string_view bytes);
  void cut_at(std::uint64_t size);
  void fail(std::string_view what, int code);
  /// The open chunk as a record followed by its indexes, in record_bytes_; the chunk's index entry goes to
  /// chunk_index_entry_.
  bool encode_chunk();
  void write_summary();

  std::unique_ptr<File> file_;  ///< null once closed
  std::string name_;
  std::string error_;
  std::uint64_t end_ = 0;        ///< where the next final record goes
  std::uint64_t file_size_ = 0;  ///< more than end_ while a flushed chunk lies behind
  std::uint32_t data_crc_ = 0;

  std::unique_ptr<void, ZstdFree> zstd_;
  std::size_t slot_bytes_;  ///< room between end_ and a flushed chunk
  int live_slot_ = -1;      ///< 0 or 1: the slot with the newest flushed chunk; -1: none

  std::string raw_, compressed_, record_bytes_, chunk_index_entry_;
  std::size_t message_start_ = 0;
  Nanoseconds chunk_start_ = 0, chunk_end_ = 0;
  std::vector<ChannelState> channels_{1};  ///< by id; id 0 is not used

  std::map<std::pair<std::string, std::string>, std::uint16_t> schema_ids_;
  std::string schema_records_, channel_records_, chunk_indexes_, attachment_indexes_, metadata_indexes_;
  std::uint64_t message_count_ = 0;
  std::uint32_t attachment_count_ = 0, metadata_count_ = 0, chunk_count_ = 0;
  Nanoseconds first_time_ = 0, last_time_ = 0;
};

}  // namespace takt::record::mcap
