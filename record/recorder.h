#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/time.h"

namespace takt::record {

/// What happens when the writer is slower than the cycle.
enum class FullPolicy {
  kBlock,  ///< the cycle waits: nothing is lost (lock-step)
  kDrop,   ///< the whole cycle is left out and counted: the cycle never waits (real time)
};

/// A file that travels inside the recording: the scenario, the models.
struct Attachment {
  std::string name;        ///< as the scenario names it
  std::string media_type;  ///< e.g. "application/json", "application/xml"
  std::string data;
};

struct RecorderOptions {
  FullPolicy policy = FullPolicy::kBlock;
  /// Goes into the metadata record "takt.run", e.g. {"scenario": ..., "seed": ...}. No wall time belongs here: the same
  /// run gives the same bytes.
  std::map<std::string, std::string> metadata;
  /// Versions and the machine's class, see fingerprint(); the metadata record "takt.fingerprint".
  std::map<std::string, std::string> fingerprint;
  std::vector<Attachment> attachments;
  /// Room between cycle and writer, rounded up to a power of two.
  std::size_t ring_bytes = 8u << 20;
  /// A chunk is closed after this much recorded time or raw size. Both are functions of the run alone.
  Nanoseconds chunk_time = 200 * kMillisecond;
  std::size_t chunk_bytes = 1u << 20;
  /// What a chunk still open has gathered is on its way to the disk after this much wall time at the latest.
  Nanoseconds flush_wall_time = 30 * kMillisecond;
  int zstd_level = -1;  ///< of a run's numbers 1.75 times as fast as level 1, for files that are 2 % larger
  /// Only so much recorded time is held, in memory, and written when keep() is called; if it never is, close() removes
  /// the file. 0: all is written as it comes. Killed before the first keep(), it leaves a file without messages.
  Nanoseconds keep_last = 0;
  /// Called at most once, from the writer's thread: the recording stopped, and why.
  std::function<void(const std::string&)> on_error;
};

/// Names a channel of one Recorder. A default one is valid to write to and records nothing.
struct ChannelId {
  std::uint32_t value = 0;
};

/// Which fields of a joint a channel has.
struct JointFields {
  bool position = true;  ///< rad (m for a prismatic joint)
  bool velocity = true;  ///< rad/s
  bool effort = true;    ///< Nm
};

enum class LogLevel { kDebug = 1, kInfo = 2, kWarning = 3, kError = 4, kFatal = 5 };

/// What became of a recording.
struct RecorderStatus {
  bool recording = false;            ///< open, and no error so far
  std::string error;                 ///< empty, or why the recording stopped
  std::uint64_t messages = 0;        ///< encoded by the writer so far
  std::uint64_t bytes = 0;           ///< on the way to the disk so far
  std::uint64_t dropped_cycles = 0;  ///< left out by kDrop
  std::uint64_t refused_rows = 0;    ///< rows of the wrong size, a defect of the caller
  bool removed = false;              ///< nothing was to be kept, so there is no file
};

/// Writes one run into an MCAP file. The run loop owns it and is the only thread that calls it; a thread of its own
/// encodes, compresses and writes. After a write error the recording stops, the run goes on: status() and on_error say
/// so once. The file is readable at any time up to the last flush, also after kill -9.
///
/// Order of calls: open, add_... for every channel, then per cycle begin_cycle, write..., at the end close.
/// Time stamps are the simulated time that begin_cycle states; wall time never enters the file.
/// A value that is not finite stands for null (nothing non-finite passes a port, row N5) and is recorded as one NaN.
class Recorder {
 public:
  /// Creates the file (an existing one is replaced) and starts the writer. Fails if the file cannot be made.
  /// Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<Recorder>> open(const std::filesystem::path& path,
                                                              RecorderOptions options = {});
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Channels. Topics are unique and start with '/'; a wrong call gives an empty id and an error in status().
  // Realtime: setup, before the first begin_cycle.

  /// foxglove.JointStates. A row: all positions, then all velocities, then all efforts, as far as `fields` has them.
  ChannelId add_joint_states(std::string topic, std::vector<std::string> joints, JointFields fields = {});
  /// foxglove.FrameTransforms, pairs (parent, child). A row: per pair x y z [m], qw qx qy qz of child in parent.
  ChannelId add_transforms(std::string topic, std::vector<std::pair<std::string, std::string>> frames);
  /// takt.Wrench. A row: force x y z [N], torque x y z [Nm], expressed in `frame`.
  ChannelId add_wrench(std::string topic, std::string frame);
  /// What the whole numbers from 0 on of a column stand for, by column.
  using Words = std::map<std::string, std::vector<std::string>>;
  /// A message type of its own with a field per column. A row: one value per column; `units` as SI text, "" = none;
  /// fewer units than columns: the rest has none.
  ChannelId add_samples(std::string topic, std::vector<std::string> columns, std::vector<std::string> units = {},
                        const Words& words = {});
  /// takt.SimState: the whole state of the simulation, from which a run can be drawn again. A row: one value per name.
  ChannelId add_state(std::string topic, std::vector<std::string> names);
  /// takt.Digest; written with digest().
  ChannelId add_digest(std::string topic);
  /// takt.Event; written with event().
  ChannelId add_events(std::string topic);
  /// foxglove.Log; written with log().
  ChannelId add_log(std::string topic);

  // The cycle. Realtime: cyclic; no allocation, no lock, no system call but the wait of kBlock.

  /// Opens a cycle; what is written until the next call belongs to it. Time never goes back.
  void begin_cycle(Nanoseconds time, std::uint64_t cycle);
  void write(ChannelId channel, std::span<const double> row);
  /// Joint states from their parts; a part that the channel does not have is ignored, an empty one is null.
  void write_joints(ChannelId channel, std::span<const double> q, std::span<const double> dq,
                    std::span<const double> tau);
  /// As many poses X_parent_child as the channel has pairs.
  void write_transforms(ChannelId channel, std::span<const Eigen::Isometry3d> poses);
  void digest(ChannelId channel, std::uint64_t digest);
  /// Texts are cut after 4000 bytes each. @param step  path of the steps of the program in which it happened
  void event(ChannelId channel, std::string_view source, std::string_view name, std::string_view text,
             std::string_view step = {});
  void log(ChannelId channel, LogLevel level, std::string_view source, std::string_view text);

  /// A message that the file begins with: `bytes` are one message of the schema, a protobuf type of those that
  /// record/proto has. Realtime: setup, before the first begin_cycle.
  void add_constant(std::string topic, std::string_view schema, std::string bytes);

  /// With RecorderOptions::keep_last: the last seconds, and one more, are to be written. What comes later is held as
  /// before, until the next call: a file has a stretch for each. Thread: that of the cycle. Realtime: cyclic.
  void keep();

  /// Hands the rest over, writes the summary and closes the file; what went wrong is in the result. Realtime: setup.
  RecorderStatus close();

  /// Thread: any.
  [[nodiscard]] RecorderStatus status() const;

 private:
  class Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// What the bits of a run depend on (row D5): takt's version, compiler, flags, CPU features, protobuf and zstd, plus
/// what the caller adds (MuJoCo's version, seed). Two equal fingerprints promise equal bits.
[[nodiscard]] std::map<std::string, std::string> fingerprint(std::map<std::string, std::string> more = {});

/// "xxh3-64:" and 16 hexadecimal digits over `data`; the recorder notes it for each attachment.
[[nodiscard]] std::string content_hash(std::string_view data);

}  // namespace takt::record
