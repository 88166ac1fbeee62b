#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/time.h"

namespace takt::record {

class ByteSource;

/// Topic of the digests of single blocks, where a run recorded them: an event a block and cycle, its name and 16
/// hexadecimal digits.
inline constexpr std::string_view kBlockTopic = "/blocks";
/// Topic of what a program does, and of what happens to it.
inline constexpr std::string_view kProgramTopic = "/program";
/// Topic of what touches in a simulation: events for people, whose times depend on the processor.
inline constexpr std::string_view kContactTopic = "/contacts";
/// Topic of the greatest contact forces on machines, in columns "1.point.x" ... "8.force.z", m and N in world; null
/// where there are fewer. For people as well.
inline constexpr std::string_view kContactForceTopic = "/contact_forces";
inline constexpr std::size_t kMostContactForces = 8;
/// Topic of the greatest contact forces between objects, and of objects on the floor, in columns "1.first", "1.second"
/// (names of the bodies), "1.point.x" ... "8.force.z", m and N in world, what the first exerts on the second; null
/// where there are fewer. A row where they change. For people as well.
inline constexpr std::string_view kObjectForceTopic = "/object_forces";
/// Topic of what became of the expectations, at the end of the run.
inline constexpr std::string_view kExpectationTopic = "/expectations";
/// End of the topics of what was commanded, call by call.
inline constexpr std::string_view kCommandSuffix = "/command";
/// Topic of the log as other tools show it (foxglove.Log); takt's own events say the same and more.
inline constexpr std::string_view kLogTopic = "/log";

/// A channel as the file states it.
struct ChannelInfo {
  std::uint16_t id = 0;
  std::string topic;
  std::string schema;                ///< full message name, e.g. "foxglove.JointStates"; empty if it has none
  std::string schema_encoding = {};  ///< of its description, "protobuf" for what the Recorder writes
  std::string encoding;              ///< "protobuf" for what the Recorder writes
  std::map<std::string, std::string> metadata;
};

/// One message, valid inside the callback only.
struct MessageView {
  const ChannelInfo* channel = nullptr;
  Nanoseconds time = 0;
  Nanoseconds published = 0;  ///< when it was sent; of what takt writes the same as `time`
  std::uint32_t sequence = 0;
  std::span<const std::byte> data;
};

/// A topic of numbers: column c has time.size() values. NaN = null.
struct Table {
  std::string topic;
  std::vector<std::string> columns, units;
  std::vector<Nanoseconds> time;
  std::vector<std::vector<double>> values;
};

/// Which columns of a topic, by their number in its header; nothing: all of them.
struct ColumnChoice {
  std::string topic;
  std::optional<std::vector<std::size_t>> columns = {};
};

struct RecordedEvent {
  Nanoseconds time = 0;
  std::uint64_t cycle = 0;
  std::string source, name, text;
  std::string step = {};  ///< path of the steps in which it happened; of takt.Event only
};

struct RecordedDigest {
  Nanoseconds time = 0;
  std::uint64_t cycle = 0, digest = 0;
};

struct AttachmentInfo {
  std::string name, media_type;
  std::uint64_t size = 0;
};

/// Reads an MCAP file, also one whose writer was killed or whose bytes have rotted: what is whole is served, what is
/// not is counted. Never trusts a length. The file is read piece by piece, again in each pass: what is in memory is
/// bounded whatever its size (mcap::ReadLimits). Thread: any, one at a time. Realtime: setup.
class Recording {
 public:
  /// Fails if the file cannot be read or does not begin as an MCAP file; a torn end is no failure.
  [[nodiscard]] static Result<Recording> open(const std::filesystem::path& path);
  /// The same over bytes in memory.
  [[nodiscard]] static Result<Recording> from_bytes(std::string bytes);
  ~Recording();
  Recording(Recording&&) noexcept;
  Recording& operator=(Recording&&) noexcept;

  /// In the order of their ids.
  [[nodiscard]] const std::vector<ChannelInfo>& channels() const;
  [[nodiscard]] const ChannelInfo* find_channel(std::string_view topic) const;
  /// The description of its messages, as it is in the file.
  [[nodiscard]] std::string_view schema_data(const ChannelInfo& channel) const;
  /// By record name ("takt.run", "takt.fingerprint"), then by key.
  [[nodiscard]] const std::map<std::string, std::map<std::string, std::string>>& metadata() const;
  [[nodiscard]] const std::vector<AttachmentInfo>& attachments() const;
  /// The content; nothing if there is no attachment of that name or its checksum is wrong.
  [[nodiscard]] std::optional<std::string> attachment(std::string_view name) const;

  /// The byte from which on the file is not whole (killed or cut); nothing if it was closed in order.
  [[nodiscard]] std::optional<std::uint64_t> truncated_at() const;
  /// Damage in words, with byte positions: "truncated at byte N", "chunk at byte N: checksum". Empty: all is well.
  [[nodiscard]] const std::vector<std::string>& damage() const;
  /// Damage but for a torn end, behind which nothing is lost that the times of messages do not show.
  [[nodiscard]] std::vector<std::string> lost() const;
  /// What is whole and not read, in words, part of damage(): compressions that are not known.
  [[nodiscard]] const std::vector<std::string>& unread() const;
  /// True for messages that become numbers, events or digests; others are bytes: an encoding other than protobuf, or a
  /// message type that is not known.
  [[nodiscard]] static bool decodes(const ChannelInfo& channel);

  [[nodiscard]] std::uint64_t message_count() const;
  /// Time of the first and last message; 0 if there is none.
  [[nodiscard]] Nanoseconds start_time() const;
  [[nodiscard]] Nanoseconds end_time() const;

  /// All messages in the order of the file (which is the order of time), until `visit` returns false; with a `topic`
  /// only that one's.
  void for_each(const std::function<bool(const MessageView&)>& visit, std::string_view topic = {}) const;

  /// A channel of numbers as columns: joint states "joint.position", transforms "child.x" to "child.qz", wrenches
  /// "force.x" to "torque.z", samples and states by their names. Diagnostics: no such topic (with the nearest), one
  /// without columns, or one with more values than are held at a time.
  [[nodiscard]] Result<Table> table(std::string_view topic) const;
  /// Names and units of its columns, without values.
  [[nodiscard]] Result<Table> header(std::string_view topic) const;
  /// Of several topics, each named once, in one pass over the file; in the order of `wanted`.
  [[nodiscard]] Result<std::vector<Table>> tables(std::span<const ColumnChoice> wanted) const;
  /// The first row at or after each multiple of `period` since the first one: what a film shows.
  [[nodiscard]] Result<Table> table_every(std::string_view topic, Nanoseconds period) const;
  /// How many messages a topic has; 0 if there is no such topic.
  [[nodiscard]] std::size_t rows(std::string_view topic) const;
  /// Topics that table() can give.
  [[nodiscard]] std::vector<std::string> table_topics() const;
  /// takt.Event and foxglove.Log of one topic.
  [[nodiscard]] Result<std::vector<RecordedEvent>> events(std::string_view topic) const;
  [[nodiscard]] std::vector<std::string> event_topics() const;
  /// The same one by one until `visit` returns false; none where the topic has no events.
  void for_each_event(std::string_view topic, const std::function<bool(const RecordedEvent&)>& visit) const;
  /// The digests of the first channel of takt.Digest; empty if there is none.
  [[nodiscard]] std::vector<RecordedDigest> digests() const;
  /// Topic of the first channel of takt.Digest; empty if there is none.
  [[nodiscard]] std::string_view digest_topic() const;

 private:
  friend class MessageCursor;
  struct Impl;
  [[nodiscard]] static Result<Recording> from_source(ByteSource source);
  /// The channel of a topic with columns.
  [[nodiscard]] Result<const ChannelInfo*> numbers(std::string_view topic) const;
  [[nodiscard]] std::unexpected<Diagnostics> too_much() const;
  explicit Recording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Goes through messages one by one, in the order of the file. The recording must outlive it.
class MessageCursor {
 public:
  /// @param topic  the only one; empty: all
  explicit MessageCursor(const Recording& recording, std::string_view topic = {});
  /// @return false: there are no more. What `message` refers to is valid until the next call.
  [[nodiscard]] bool next(MessageView& message);

 private:
  [[nodiscard]] bool enter_stretch();

  const Recording::Impl& impl_;
  const ChannelInfo* wanted_ = nullptr;
  std::size_t stretch_ = 0, offset_ = 0;
  std::string fresh_;     ///< a stretch that is not kept
  std::string_view raw_;  ///< the stretch that is read
  bool inside_ = false;
};

/// Goes through the digests of a recording one by one.
class DigestCursor {
 public:
  explicit DigestCursor(const Recording& recording);
  [[nodiscard]] bool next(RecordedDigest& digest);

 private:
  std::optional<MessageCursor> messages_;
};

}  // namespace takt::record
