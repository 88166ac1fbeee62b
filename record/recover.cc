#include "record/recover.h"

#include <algorithm>
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
    last_ = std::max(last_, message.time);  // times never go back
    to_.begin_message(id->second, last_)
        .append(reinterpret_cast<const char*>(message.data.data()), message.data.size());
    to_.end_message();
    ++recovered_.messages;
    if (to_.open_bytes() >= kChunkBytes || last_ - to_.open_since() >= kChunkTime) to_.close_chunk();
  }

  const Recording& from_;
  mcap::Writer& to_;
  std::map<std::uint16_t, std::uint16_t> ids_;
  Nanoseconds last_ = 0;
  Recovered recovered_;
};

}  // namespace

Result<Recovered> recover(const std::filesystem::path& source, const std::filesystem::path& target) {
  const auto from = Recording::open(source);
  if (!from) return std::unexpected(from.error());
  mcap::Writer to(target, kZstdLevel, kChunkBytes);
  Recovered recovered;
  if (to.error().empty()) recovered = Copy(*from, to).all();
  if (!to.error().empty()) return failure(Code::kFileNotWritable, "", to.error());
  return recovered;
}

}  // namespace takt::record
