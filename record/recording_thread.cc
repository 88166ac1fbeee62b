#include "record/recording_thread.h"

#include <array>
#include <cstring>

#include <fmt/format.h>

#include "core/base/last_catch.h"
#include "core/base/utf8.h"
#include "record/wire_pattern.h"

namespace takt::record {

namespace {

/// The texts of an event or a log line: a word with their lengths (16 bits each), then their bytes.
using MessageTexts = std::array<std::string_view, 4>;

MessageTexts unpack_texts(std::span<const std::uint64_t> words) {
  MessageTexts texts;
  const auto* bytes = reinterpret_cast<const char*>(words.data() + 1);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    texts[i] = {bytes, (words[0] >> (16 * i)) & 0xFFFF};
    bytes += texts[i].size();
  }
  return texts;
}

void put_stamp(std::string& out, const std::string& stamp) {
  put_varint(out, (1u << 3) | 2u);
  put_varint(out, stamp.size());
  out += stamp;
}

/// Protobuf's readers refuse a message with a text that is no UTF-8.
void put_text(std::string& out, int field, std::string_view text) {
  if (is_utf8(text)) return put_text_field(out, field, text);
  put_text_field(out, field, to_valid_utf8(text));
}

}  // namespace

RecordingThread::RecordingThread(const std::filesystem::path& path, const RecorderOptions& options)
    : ring(options.ring_bytes),
      options_(options),
      path_(path),
      history_(options.keep_last, [this](const SampleRing::Entry& entry) { take(entry); }),
      writer_(path, options.zstd_level, options.chunk_bytes) {
  writer_.add_metadata("takt.fingerprint", options_.fingerprint);
  mcap::Map run = options_.metadata;
  for (const Attachment& attachment : options_.attachments) {
    run["hash:" + attachment.name] = content_hash(attachment.data);
  }
  writer_.add_metadata("takt.run", run);
  for (const Attachment& attachment : options_.attachments) {
    writer_.add_attachment(attachment.name, attachment.media_type, attachment.data);
  }
  options_.attachments.clear();
  note_progress();
}

void RecordingThread::start() {
  thread_ = std::thread([this] { run(); });
}

void RecordingThread::stop() {
  if (!thread_.joinable()) return;
  stop_.store(true, std::memory_order_release);
  thread_.join();
}

std::string RecordingThread::error() const {
  const std::lock_guard lock(error_mutex_);
  return error_;
}

void RecordingThread::report_error(const std::string& text) {
  {
    const std::lock_guard lock(error_mutex_);
    if (!error_.empty()) return;
    error_ = text;
  }
  failed.store(true, std::memory_order_release);
  if (options_.on_error) options_.on_error(text);
}

void RecordingThread::note_progress() {
  messages.store(writer_.message_count(), std::memory_order_relaxed);
  bytes.store(writer_.size(), std::memory_order_relaxed);
  if (!writer_.error().empty()) report_error(writer_.error());
}

void RecordingThread::run() {
  try {
    write_all();
  } catch (...) {
    // The run goes on without its recording; the ring is emptied so that it does not wait.
    const std::string why = exception_text();
    (void)run_caught("tell that the recording failed",
                     [&] { report_error(fmt::format("the writer of the recording failed: {}", why)); });
    drop_all();
  }
}

void RecordingThread::drop_all() {
  for (;;) {
    const bool last_round = stop_.load(std::memory_order_acquire);
    for (auto entry = ring.front(); entry.valid; entry = ring.front()) ring.release();
    if (last_round) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void RecordingThread::write_all() {
  // The producer never wakes this thread (that would be a system call in its cycle); it looks by itself. The ring has
  // room for much more than comes in between.
  constexpr auto kPause = std::chrono::milliseconds(1);
  for (;;) {
    const bool last_round = stop_.load(std::memory_order_acquire);
    for (auto entry = ring.front(); entry.valid; entry = ring.front()) {
      options_.keep_last > 0 ? remember(entry) : take(entry);
      ring.release();
    }
    if (last_round) break;
    flush_if_due();
    note_progress();
    std::this_thread::sleep_for(kPause);
  }
  if (options_.keep_last > 0 && keep_at_end.load(std::memory_order_acquire)) history_.keep();
  write_channels();
  writer_.finish();
  note_progress();
  if (options_.keep_last == 0 || history_.kept() || failed.load(std::memory_order_relaxed)) return;
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  removed.store(true, std::memory_order_relaxed);
}

void RecordingThread::remember(const SampleRing::Entry& entry) {
  if (entry.tag == kKeepTag) return history_.keep();
  if (entry.tag == kCycleTag) history_.begin_cycle(static_cast<Nanoseconds>(entry.words[0]));
  history_.add(entry);
}

void RecordingThread::write_channels() {
  if (channels_written_) return;
  channels_written_ = true;
  for (const ChannelPlan& plan : plans) {
    const std::uint16_t schema = writer_.add_schema(plan.schema.name, "protobuf", plan.schema.descriptor_set);
    ids_.push_back(writer_.add_channel(schema, plan.topic, "protobuf", plan.metadata));
  }
  for (std::size_t i = 0; i < plans.size(); ++i) {
    if (plans[i].kind != RowKind::kConstant) continue;
    writer_.begin_message(ids_[i], time_).append(plans[i].constant);
    writer_.end_message();
  }
}

void RecordingThread::take(const SampleRing::Entry& entry) {
  // After an error entries only make room.
  if (failed.load(std::memory_order_relaxed) || entry.tag == kKeepTag) return;
  if (entry.tag == kCycleTag && !channels_written_) time_ = static_cast<Nanoseconds>(entry.words[0]);
  write_channels();
  if (entry.tag == kCycleTag) {
    take_cycle(static_cast<Nanoseconds>(entry.words[0]), entry.words[1]);
  } else {
    take_message(entry.tag, entry.words);
  }
}

void RecordingThread::take_cycle(Nanoseconds time, std::uint64_t cycle) {
  // Where chunks end follows from the run alone, never from the wall clock: the same run gives the same bytes.
  const bool full = writer_.open_bytes() >= options_.chunk_bytes || time - writer_.open_since() >= options_.chunk_time;
  if (writer_.open_bytes() > 0 && full) {
    writer_.close_chunk();
    flushed_bytes_ = 0;
    flushed_at_ = Clock::now();
    note_progress();
  }
  flush_if_due();
  time_ = time;
  cycle_ = cycle;
  stamp_ = timestamp_bytes(time);
}

void RecordingThread::flush_if_due() {
  if (writer_.open_bytes() == flushed_bytes_) {
    flushed_at_ = Clock::now();
    return;
  }
  if (Clock::now() - flushed_at_ < std::chrono::nanoseconds(options_.flush_wall_time)) return;
  writer_.flush_open_chunk();
  flushed_bytes_ = writer_.open_bytes();
  flushed_at_ = Clock::now();
}

void RecordingThread::take_message(std::uint32_t channel, std::span<const std::uint64_t> words) {
  ChannelPlan& plan = plans[channel];
  std::string& out = writer_.begin_message(ids_[channel], time_);
  switch (plan.kind) {
    case RowKind::kNumbers:
      plan.rows.encode(out, stamp_, {reinterpret_cast<const double*>(words.data()), words.size()});
      break;
    case RowKind::kDigest:
      put_stamp(out, stamp_);
      put_varint_field(out, 2, cycle_);
      put_fixed64_field(out, 3, words[0]);
      break;
    case RowKind::kEvent: {
      const MessageTexts texts = unpack_texts(words);
      put_stamp(out, stamp_);
      put_varint_field(out, 2, cycle_);
      put_text(out, 3, texts[0]);
      put_text(out, 4, texts[1]);
      put_text(out, 5, texts[2]);
      if (!texts[3].empty()) put_text(out, 6, texts[3]);
      break;
    }
    case RowKind::kConstant:
      break;
    case RowKind::kLog: {
      const MessageTexts texts = unpack_texts(words.subspan(1));
      put_stamp(out, stamp_);
      put_varint_field(out, 2, words[0]);
      put_text(out, 3, texts[1]);
      put_text(out, 4, texts[0]);
      break;
    }
  }
  writer_.end_message();
}

}  // namespace takt::record
