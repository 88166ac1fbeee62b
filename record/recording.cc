#include "record/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "foxglove/Log.pb.h"
#include "record/decode.h"
#include "record/mcap_reader.h"
#include "record/parse_message.h"
#include "record/schemas.h"
#include "takt/Digest.pb.h"
#include "takt/Event.pb.h"

namespace takt::record {

namespace {

/// Unpacked chunks are kept up to this many bytes; beyond, each pass unpacks again.
constexpr std::size_t kKeptBytes = 64u << 20;

bool is_event_channel(const ChannelInfo& channel) {
  return channel.encoding == "protobuf" && (channel.schema == kEventSchema || channel.schema == kLogSchema);
}

}  // namespace

struct Recording::Impl {
  std::string bytes;
  mcap::Contents contents;
  std::vector<ChannelInfo> channels;
  std::vector<AttachmentInfo> attachments;
  std::vector<std::optional<std::string>> unpacked;  ///< per stretch
  std::vector<std::vector<std::uint16_t>> ids;       ///< per stretch: channels with messages in it, sorted
  std::map<std::uint16_t, std::size_t> rows;         ///< messages per channel
  std::uint64_t visit_bytes = 0;                     ///< to read all channels one by one
  std::uint64_t message_count = 0;
  Nanoseconds start = 0, end = 0;

  /// Leaves the stretches that unpack, each message once.
  void check_stretches();
  /// Counts their messages and keeps their bytes.
  void take_stretches();
  void take_stretch(std::string_view raw);
  void list_channels();
  template <class Visit>
  bool visit_messages(std::string_view raw, Visit&& visit) const;
  [[nodiscard]] const ChannelInfo* channel(std::uint16_t id) const;
};

Recording::Recording(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;
Recording& Recording::operator=(Recording&&) noexcept = default;

Result<Recording> Recording::open(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::exists(path, code))
    return failure(Code::kNotFound, "", fmt::format("there is no file {}", path.string()));
  if (!std::filesystem::is_regular_file(path, code))
    return failure(Code::kFileNotReadable, "", fmt::format("{} is not a file", path.string()));
  const auto size = std::filesystem::file_size(path, code);
  if (code)
    return failure(Code::kFileNotReadable, "", fmt::format("cannot read {}: {}", path.string(), code.message()));
  if (size > mcap::ReadLimits::kFileBytes) {
    return failure(Code::kTooLarge, "", fmt::format("{} has {} bytes", path.string(), size),
                   fmt::format("at most {} are read", mcap::ReadLimits::kFileBytes));
  }
  std::ifstream in(path, std::ios::binary);
  std::string bytes(size, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!in) return failure(Code::kFileNotReadable, "", fmt::format("cannot read {}", path.string()));
  Result<Recording> recording = from_bytes(std::move(bytes));
  if (!recording) recording.error().set_file(path.string());
  return recording;
}

Result<Recording> Recording::from_bytes(std::string bytes) {
  auto impl = std::make_unique<Impl>();
  impl->bytes = std::move(bytes);
  Result<mcap::Contents> contents = mcap::scan(impl->bytes);
  if (!contents) return std::unexpected(std::move(contents.error()));
  impl->contents = std::move(*contents);
  impl->check_stretches();
  impl->take_stretches();
  if (impl->visit_bytes > mcap::ReadLimits::kVisitBytes) {
    return failure(Code::kTooLarge, "",
                   fmt::format("{} channels over {} bytes of messages: too much to be read", impl->rows.size(),
                               impl->contents.raw_bytes));
  }
  if (const std::size_t more = impl->contents.unlisted_damage; more > 0)
    impl->contents.damage.push_back(fmt::format("and {} more of this kind", more));
  impl->list_channels();
  for (const auto& attachment : impl->contents.attachments) {
    impl->attachments.push_back({attachment.name, attachment.media_type, attachment.data.size()});
  }
  return Recording(std::move(impl));
}

template <class Visit>
bool Recording::Impl::visit_messages(std::string_view raw, Visit&& visit) const {
  for (std::size_t offset = 0; offset < raw.size();) {
    const auto record = mcap::record_at(raw, offset);
    if (!record) return true;
    offset = record->end();
    if (static_cast<mcap::Op>(record->op) != mcap::Op::kMessage || !mcap::has_valid_time(*record)) continue;
    mcap::Cursor cursor(record->body);
    MessageView view;
    const auto id = cursor.get<std::uint16_t>();
    view.sequence = cursor.get<std::uint32_t>();
    view.time = static_cast<Nanoseconds>(cursor.get<std::uint64_t>());
    cursor.get<std::uint64_t>();
    const std::string_view data = cursor.take(cursor.left());
    view.data = std::as_bytes(std::span(data));
    if (!visit(id, view)) return false;
  }
  return true;
}

void Recording::Impl::check_stretches() {
  std::vector<mcap::Stretch> good;
  std::string last;
  for (mcap::Stretch& stretch : contents.stretches) {
    auto raw = mcap::unpack(stretch);
    if (!raw) {
      note_damage(contents, fmt::format("chunk at byte {}: {}", stretch.offset, raw.error()));
      continue;
    }
    // A writer killed in the middle of a flush can leave two stages of its open chunk: the longer one counts.
    if (!last.empty() && last.starts_with(*raw)) continue;
    if (!last.empty() && raw->starts_with(last)) good.pop_back();
    good.push_back(std::move(stretch));
    last = std::move(*raw);
  }
  contents.stretches = std::move(good);
}

void Recording::Impl::take_stretches() {
  std::size_t kept = 0;
  for (const mcap::Stretch& stretch : contents.stretches) {
    std::string raw = mcap::unpack(stretch, false).value_or("");
    take_stretch(raw);
    visit_bytes += ids.back().size() * raw.size();
    kept += raw.size();
    unpacked.push_back(kept <= kKeptBytes ? std::optional(std::move(raw)) : std::nullopt);
  }
}

void Recording::Impl::take_stretch(std::string_view raw) {
  std::size_t out_of_time = 0;
  for (std::size_t offset = 0; offset < raw.size();) {
    const auto record = mcap::record_at(raw, offset);
    if (!record) break;
    const auto op = static_cast<mcap::Op>(record->op);
    // Foreign writers define channels inside of chunks.
    if (op == mcap::Op::kSchema || op == mcap::Op::kChannel) mcap::take_definition(*record, contents);
    if (op == mcap::Op::kMessage && !mcap::has_valid_time(*record)) ++out_of_time;
    offset = record->end();
  }
  if (out_of_time > 0) note_damage(contents, fmt::format("{} messages with impossible times", out_of_time));
  std::map<std::uint16_t, std::size_t> found;
  visit_messages(raw, [&](std::uint16_t id, const MessageView& view) {
    start = message_count == 0 ? view.time : std::min(start, view.time);
    end = std::max(end, view.time);
    ++message_count;
    ++found[id];
    return true;
  });
  ids.emplace_back();
  for (const auto& [id, count] : found) {
    ids.back().push_back(id);
    rows[id] += count;
  }
}

void Recording::Impl::list_channels() {
  std::set<std::string> topics;
  for (const auto& [id, record] : contents.channels) {
    // A topic is asked for by its name: of two channels the first counts.
    if (!topics.insert(record.topic).second) {
      if (rows.contains(id)) contents.damage.push_back(fmt::format("topic '{}': a second channel", record.topic));
      continue;
    }
    const auto schema = contents.schema_names.find(record.schema);
    channels.push_back({.id = id,
                        .topic = record.topic,
                        .schema = schema == contents.schema_names.end() ? "" : schema->second,
                        .encoding = record.encoding,
                        .metadata = record.metadata});
  }
}

const ChannelInfo* Recording::Impl::channel(std::uint16_t id) const {
  const auto found = std::ranges::lower_bound(channels, id, {}, &ChannelInfo::id);
  return found != channels.end() && found->id == id ? &*found : nullptr;
}

const std::vector<ChannelInfo>& Recording::channels() const { return impl_->channels; }

const ChannelInfo* Recording::find_channel(std::string_view topic) const {
  const auto found = std::ranges::find(impl_->channels, topic, &ChannelInfo::topic);
  return found == impl_->channels.end() ? nullptr : &*found;
}

const std::map<std::string, std::map<std::string, std::string>>& Recording::metadata() const {
  return impl_->contents.metadata;
}

const std::vector<AttachmentInfo>& Recording::attachments() const { return impl_->attachments; }

std::optional<std::string> Recording::attachment(std::string_view name) const {
  for (const auto& attachment : impl_->contents.attachments) {
    if (attachment.name == name && attachment.whole) return std::string(attachment.data);
  }
  return std::nullopt;
}

std::optional<std::uint64_t> Recording::truncated_at() const { return impl_->contents.truncated_at; }
const std::vector<std::string>& Recording::damage() const { return impl_->contents.damage; }
std::uint64_t Recording::message_count() const { return impl_->message_count; }
Nanoseconds Recording::start_time() const { return impl_->start; }
Nanoseconds Recording::end_time() const { return impl_->end; }

void Recording::for_each(const std::function<bool(const MessageView&)>& visit, std::string_view topic) const {
  const ChannelInfo* wanted = topic.empty() ? nullptr : find_channel(topic);
  if (!topic.empty() && wanted == nullptr) return;
  for (std::size_t i = 0; i < impl_->contents.stretches.size(); ++i) {
    if (wanted != nullptr && !std::ranges::binary_search(impl_->ids[i], wanted->id)) continue;
    std::string fresh;
    if (!impl_->unpacked[i]) fresh = mcap::unpack(impl_->contents.stretches[i], false).value_or("");
    const std::string& raw = impl_->unpacked[i] ? *impl_->unpacked[i] : fresh;
    const bool go_on = impl_->visit_messages(raw, [&](std::uint16_t id, MessageView& view) {
      if (wanted != nullptr && id != wanted->id) return true;
      view.channel = wanted != nullptr ? wanted : impl_->channel(id);
      return view.channel == nullptr || visit(view);
    });
    if (!go_on) return;
  }
}

std::vector<std::string> Recording::table_topics() const {
  std::vector<std::string> topics;
  for (const ChannelInfo& channel : impl_->channels) {
    if (has_columns(channel)) topics.push_back(channel.topic);
  }
  return topics;
}

std::vector<std::string> Recording::event_topics() const {
  std::vector<std::string> topics;
  for (const ChannelInfo& channel : impl_->channels) {
    if (is_event_channel(channel)) topics.push_back(channel.topic);
  }
  return topics;
}

Result<Table> Recording::table(std::string_view topic) const {
  const ChannelInfo* channel = find_channel(topic);
  if (channel == nullptr || !has_columns(*channel)) {
    const std::string why = channel == nullptr ? "is not in the recording" : "has no columns of numbers";
    return failure(Code::kFileNotReadable, "", fmt::format("topic '{}' {}", topic, why),
                   nearest_choice(topic, table_topics()));
  }
  Table table;
  table.topic = topic;
  const auto rows = impl_->rows.find(channel->id);
  RowDecoder decoder(*channel, rows == impl_->rows.end() ? 0 : rows->second);
  bool fits = true;
  for_each(
      [&](const MessageView& message) {
        // Curves go forward in time; what goes back says nothing that could be drawn or compared.
        if (!table.time.empty() && message.time < table.time.back()) return true;
        decoder.append(message, table);
        fits = table.time.size() * table.columns.size() <= mcap::ReadLimits::kTableValues;
        return fits;
      },
      topic);
  if (fits) return table;
  return failure(Code::kTooLarge, "",
                 fmt::format("topic '{}' has more than {} values", topic, mcap::ReadLimits::kTableValues),
                 "a shorter recording");
}

Result<std::vector<RecordedEvent>> Recording::events(std::string_view topic) const {
  const ChannelInfo* channel = find_channel(topic);
  if (channel == nullptr || !is_event_channel(*channel)) {
    return failure(Code::kFileNotReadable, "", fmt::format("topic '{}' has no events", topic),
                   nearest_choice(topic, event_topics()));
  }
  std::vector<RecordedEvent> events;
  const auto take_event = [&](const MessageView& view) {
    if (Event event; parse_message(view, event)) {
      events.push_back({view.time, event.cycle(), event.source(), event.name(), event.text()});
    }
    return true;
  };
  const auto take_log = [&](const MessageView& view) {
    if (foxglove::Log log; parse_message(view, log)) {
      events.push_back({view.time, 0, log.name(), foxglove::Log::Level_Name(log.level()), log.message()});
    }
    return true;
  };
  if (channel->schema == kEventSchema) {
    for_each(take_event, topic);
  } else {
    for_each(take_log, topic);
  }
  return events;
}

std::vector<RecordedDigest> Recording::digests() const {
  std::vector<RecordedDigest> digests;
  const auto channel = std::ranges::find(impl_->channels, kDigestSchema, &ChannelInfo::schema);
  if (channel == impl_->channels.end()) return digests;
  for_each(
      [&](const MessageView& view) {
        if (Digest digest; parse_message(view, digest)) digests.push_back({view.time, digest.cycle(), digest.digest()});
        return true;
      },
      channel->topic);
  return digests;
}

}  // namespace takt::record
