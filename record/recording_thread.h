#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "record/channel_encoder.h"
#include "record/entry_history.h"
#include "record/mcap_writer.h"
#include "record/recorder.h"
#include "record/sample_ring.h"

namespace takt::record {

/// The tag of an entry that opens a cycle: words time, cycle. Other tags are indices of channels.
inline constexpr std::uint32_t kCycleTag = 0xFFFFFFFE;
/// The tag of an entry without words: what is in the history stays (Recorder::keep).
inline constexpr std::uint32_t kKeepTag = 0xFFFFFFFD;

/// The side of a recorder that the cycle does not see: takes entries off the ring, encodes them, writes the file.
/// Channels may be planned until the first entry is published; after that they belong to the thread.
class RecordingThread {
 public:
  /// Creates the file and writes what is known before the run; look at error().
  RecordingThread(const std::filesystem::path& path, const RecorderOptions& options);
  ~RecordingThread() { stop(); }

  SampleRing ring;
  std::vector<ChannelPlan> plans;

  void start();
  /// Drains the ring, finishes the file. Call once the producer is silent.
  void stop();

  [[nodiscard]] std::string error() const;
  /// Keeps the first error and stops the recording. Thread: any.
  void report_error(const std::string& text);

  std::atomic<std::uint64_t> messages{0}, bytes{0};
  std::atomic<bool> failed{false}, removed{false};
  std::atomic<bool> keep_at_end{false};  ///< Recorder::keep() found no room in the ring

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  void write_all();
  void drop_all();
  void write_channels();
  void take(const SampleRing::Entry& entry);
  void remember(const SampleRing::Entry& entry);
  void take_cycle(Nanoseconds time, std::uint64_t cycle);
  void take_message(std::uint32_t channel, std::span<const std::uint64_t> words);
  void flush_if_due();
  void note_progress();

  RecorderOptions options_;
  std::filesystem::path path_;
  EntryHistory history_;
  mcap::Writer writer_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  mutable std::mutex error_mutex_;
  std::string error_;

  bool channels_written_ = false;
  std::vector<std::uint16_t> ids_;
  Nanoseconds time_ = 0;
  std::uint64_t cycle_ = 0;
  std::string stamp_;
  std::size_t flushed_bytes_ = 0;  ///< of the open chunk
  Clock::time_point flushed_at_ = Clock::now();
};

}  // namespace takt::record
