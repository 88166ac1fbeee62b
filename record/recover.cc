#include "record/recover.h"

#include <map>

#include <fmt/format.h>

#include "record/mcap_writer.h"
#include "record/recording.h"

namespace takt::record {
namespace {

constexpr int kZstdLevel = 1;
constexpr std::size_t kChunkBytes = 1u << 20;
constexpr Nanoseconds kChunkTime = 200 * kMillisecond;

/// Copies a recording, part by part, in the order in which the recorder writes them.
class Copy {
 public:
  Copy(const Recording& from, mcap::Writer& to) : from_(from), to_(to) { recovered_.lost = from.damage(); }

  Recovered all() {
    for (const auto& [name, map] : from_.metadata()) to_.add_metadata(name, map);
    for (const AttachmentInfo& attachment : from_.attachments()) copy(attachment);
    for (const ChannelInfo& channel : from_.channels()) copy(channel);
    from_.for_each([this](const MessageView& message) {
      copy(message);
      return to_.error().empty();
    });
    to_.finish();
    return std::move(recovered_);
  }

 private:
  void copy(const AttachmentInfo& attachment) {
    const auto data = from_.attachment(attachment.name);
    if (!data) return recovered_.lost.push_back(fmt::format("attachment '{}': checksum", attachment.name));
    to_.add_attachment(attachment.name, attachment.media_type, *data);
    ++recovered_.attachments;
  }
  void copy(const ChannelInfo& channel) {
    std::uint16_t schema = 0;
    if (!channel.schema.empty())
      schema = to_.add_schema(channel.schema, channel.schema_encoding, from_.schema_data(channel));
    ids_[channel.id] = to_.add_channel(schema, channel.topic, channel.encoding, channel.metadata);
  }
  void copy(const MessageView& message) {
    const auto id = ids_.find(message.channel->id);
    if (id == ids_.end()) return;
    to_.begin_message(id->second, message.time, message.published)
        .append(reinterpret_cast<const char*>(message.data.data()), message.data.size());
    to_.end_message();
    ++recovered_.messages;
    if (to_.open_bytes() >= kChunkBytes || message.time - to_.open_since() >= kChunkTime) to_.close_chunk();
  }

  const Recording& from_;
  mcap::Writer& to_;
  std::map<std::uint16_t, std::uint16_t> ids_;
  Recovered recovered_;
};

/// What is whole and not read would be gone from the copy, and a copy of nothing is none.
Diagnostics check(const Recording& from) {
  Diagnostics diagnostics;
  for (const std::string& unread : from.unread())
    diagnostics.error(Code::kFileNotReadable, "", unread, "Write it without compression, with zstd or with lz4");
  const auto lost = from.lost();
  if (!diagnostics.has_errors() && from.message_count() == 0 && !lost.empty())
    diagnostics.error(Code::kFileNotReadable, "", fmt::format("no message can be read; {}", lost.front()));
  return diagnostics;
}

}  // namespace

Result<Recovered> recover(const std::filesystem::path& source, const std::filesystem::path& target) {
  const auto from = Recording::open(source);
  if (!from) return std::unexpected(from.error());
  if (Diagnostics diagnostics = check(*from); diagnostics.has_errors()) {
    diagnostics.set_file(source.string());
    return std::unexpected(std::move(diagnostics));
  }
  mcap::Writer to(target, kZstdLevel, kChunkBytes);
  Recovered recovered;
  if (to.error().empty()) recovered = Copy(*from, to).all();
  if (!to.error().empty()) return failure(Code::kFileNotWritable, "", to.error());
  return recovered;
}

}  // namespace takt::record
