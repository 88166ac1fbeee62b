#include "record/recording.h"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <set>

#include "core/base/utf8.h"
#include "foxglove/Log.pb.h"
#include "record/byte_source.h"
#include "record/chunk_compression.h"
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

/// The next message of `raw` at or after `offset`, which goes on behind it. @return false: there is none
bool next_message(std::string_view raw, std::size_t& offset, std::uint16_t& id, MessageView& view) {
  while (const auto record = offset < raw.size() ? mcap::record_at(raw, offset) : std::nullopt) {
    offset = record->end();
    if (static_cast<mcap::Op>(record->op) != mcap::Op::kMessage || !mcap::has_valid_time(*record)) continue;
    mcap::Cursor cursor(record->body);
    id = cursor.get<std::uint16_t>();
    view.sequence = cursor.get<std::uint32_t>();
    view.time = static_cast<Nanoseconds>(cursor.get<std::uint64_t>());
    view.published = static_cast<Nanoseconds>(cursor.get<std::uint64_t>());
    const std::string_view data = cursor.take(cursor.left());
    view.data = std::as_bytes(std::span(data));
    return true;
  }
  return false;
}

}  // namespace

struct Recording::Impl {
  explicit Impl(ByteSource bytes) : source(std::move(bytes)) {}

  ByteSource source;
  mcap::Contents contents;
  std::vector<ChannelInfo> channels;
  std::vector<AttachmentInfo> attachments;
  std::vector<std::optional<std::string>> unpacked;  ///< per stretch
  std::vector<std::vector<std::uint16_t>> ids;       ///< per stretch: channels with messages in it, sorted
  std::map<std::uint16_t, std::size_t> rows;         ///< messages per channel
  std::size_t kept_bytes = 0;                        ///< of unpacked
  mutable std::uint64_t visited_bytes = 0;           ///< by all passes so far
  std::uint64_t message_count = 0;
  Nanoseconds start = 0, end = 0;
  std::map<std::string, std::size_t> unknown_compressions;  ///< chunks of each
  std::vector<std::string> unread;

  /// Keeps the stretches that unpack, each message once, and counts their messages.
  void take_stretches();
  void keep(mcap::Stretch stretch, std::string raw);
  void take_stretch(std::string_view raw);
  void list_channels();
  /// Names what is whole and cannot be read, and messages of channels that nobody defines.
  void list_unread();
  template <class Visit>
  void visit_messages(std::string_view raw, Visit&& visit) const;
  [[nodiscard]] const ChannelInfo* channel(std::uint16_t id) const;
  [[nodiscard]] std::size_t rows_of(const ChannelInfo& info) const;
  [[nodiscard]] std::uint64_t most_visited_bytes() const {
    return mcap::ReadLimits::kVisitBytes + mcap::ReadLimits::kVisitPerByte * source.size();
  }
  [[nodiscard]] bool visited_too_much() const { return visited_bytes > most_visited_bytes(); }
};

Recording::Recording(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;
Recording& Recording::operator=(Recording&&) noexcept = default;

Result<Recording> Recording::open(const std::filesystem::path& path) {
  Result<ByteSource> source = ByteSource::open(path);
  if (!source) return std::unexpected(std::move(source.error()));
  Result<Recording> recording = from_source(std::move(*source));
  if (!recording) recording.error().set_file(path.string());
  return recording;
}

Result<Recording> Recording::from_bytes(std::string bytes) { return from_source(ByteSource(std::move(bytes))); }

Result<Recording> Recording::from_source(ByteSource source) {
  // What does not parse is told as damage; protobuf's own words on stderr would come besides.
  [[maybe_unused]] static const auto silenced = google::protobuf::SetLogHandler(nullptr);
  auto impl = std::make_unique<Impl>(std::move(source));
  Result<mcap::Contents> contents = mcap::scan(impl->source);
  if (!contents) return std::unexpected(std::move(contents.error()));
  impl->contents = std::move(*contents);
  impl->take_stretches();
  if (const std::size_t more = impl->contents.unlisted_damage; more > 0)
    impl->contents.damage.push_back(fmt::format("and {} more of this kind", more));
  impl->list_channels();
  impl->list_unread();
  for (const auto& attachment : impl->contents.attachments)
    impl->attachments.push_back({attachment.name, attachment.media_type, attachment.size});
  return Recording(std::move(impl));
}

template <class Visit>
void Recording::Impl::visit_messages(std::string_view raw, Visit&& visit) const {
  std::uint16_t id = 0;
  MessageView view;
  for (std::size_t offset = 0; next_message(raw, offset, id, view);) visit(id, view);
}

void Recording::Impl::take_stretches() {
  std::vector<mcap::Stretch> found = std::move(contents.stretches);
  contents.stretches.clear();
  mcap::Stretch held;
  std::string held_raw;
  for (mcap::Stretch& stretch : found) {
    if (!mcap::is_known_compression(stretch.compression)) {
      ++unknown_compressions[stretch.compression];
      continue;
    }
    auto raw = mcap::unpack(source, stretch);
    if (!raw) {
      note_damage(contents, fmt::format("chunk at byte {}: {}", stretch.offset, raw.error()));
      continue;
    }
    // A writer killed in the middle of a flush can leave two stages of its open chunk: the longer one counts.
    if (!held_raw.empty() && held_raw.starts_with(*raw)) continue;
    if (!held_raw.empty() && !raw->starts_with(held_raw)) keep(std::move(held), std::move(held_raw));
    held = std::move(stretch);
    held_raw = std::move(*raw);
  }
  if (!held_raw.empty()) keep(std::move(held), std::move(held_raw));
}

void Recording::Impl::keep(mcap::Stretch stretch, std::string raw) {
  take_stretch(raw);
  contents.stretches.push_back(std::move(stretch));
  kept_bytes += raw.size();
  unpacked.push_back(kept_bytes <= kKeptBytes ? std::optional(std::move(raw)) : std::nullopt);
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
    const auto schema = contents.schemas.find(record.schema);
    const bool known = schema != contents.schemas.end();
    channels.push_back({.id = id,
                        .topic = record.topic,
                        .schema = known ? schema->second.name : "",
                        .schema_encoding = known ? schema->second.encoding : "",
                        .encoding = record.encoding,
                        .metadata = record.metadata});
  }
}

void Recording::Impl::list_unread() {
  for (const auto& [name, count] : unknown_compressions)
    unread.push_back(fmt::format("{} {} compressed with '{}', which is not read", count,
                                 count == 1 ? "chunk is" : "chunks are", cut_utf8(to_valid_utf8(name), 40)));
  contents.damage.insert(contents.damage.end(), unread.begin(), unread.end());
  std::size_t orphans = 0;
  for (const auto& [id, count] : rows) orphans += contents.channels.contains(id) ? 0 : count;
  if (orphans > 0) contents.damage.push_back(fmt::format("{} messages of channels that are not defined", orphans));
}

std::string_view Recording::schema_data(const ChannelInfo& channel) const {
  const auto record = impl_->contents.channels.find(channel.id);
  if (record == impl_->contents.channels.end()) return {};
  const auto schema = impl_->contents.schemas.find(record->second.schema);
  return schema == impl_->contents.schemas.end() ? std::string_view() : std::string_view(schema->second.data);
}

const ChannelInfo* Recording::Impl::channel(std::uint16_t id) const {
  const auto found = std::ranges::lower_bound(channels, id, {}, &ChannelInfo::id);
  return found != channels.end() && found->id == id ? &*found : nullptr;
}

std::size_t Recording::Impl::rows_of(const ChannelInfo& info) const {
  const auto found = rows.find(info.id);
  return found == rows.end() ? 0 : found->second;
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
    if (attachment.name != name || !attachment.whole) continue;
    const std::string_view data = impl_->source.view(attachment.offset, attachment.size);
    if (data.size() == attachment.size) return std::string(data);
  }
  return std::nullopt;
}

std::optional<std::uint64_t> Recording::truncated_at() const { return impl_->contents.truncated_at; }
const std::vector<std::string>& Recording::damage() const { return impl_->contents.damage; }
const std::vector<std::string>& Recording::unread() const { return impl_->unread; }

std::vector<std::string> Recording::lost() const {
  std::vector<std::string> lost = damage();
  if (truncated_at()) std::erase(lost, mcap::truncation(*truncated_at()));
  return lost;
}

bool Recording::decodes(const ChannelInfo& channel) {
  const bool is_digest = channel.encoding == "protobuf" && channel.schema == kDigestSchema;
  return has_columns(channel) || is_event_channel(channel) || is_digest;
}

std::uint64_t Recording::message_count() const { return impl_->message_count; }
Nanoseconds Recording::start_time() const { return impl_->start; }
Nanoseconds Recording::end_time() const { return impl_->end; }

void Recording::for_each(const std::function<bool(const MessageView&)>& visit, std::string_view topic) const {
  MessageCursor cursor(*this, topic);
  for (MessageView message; cursor.next(message);)
    if (!visit(message)) return;
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

Result<const ChannelInfo*> Recording::numbers(std::string_view topic) const {
  const ChannelInfo* channel = find_channel(topic);
  if (channel != nullptr && has_columns(*channel)) return channel;
  const std::string why = channel == nullptr ? "is not in the recording" : "has no columns of numbers";
  return failure(Code::kUnknownName, "", fmt::format("topic '{}' {}", topic, why),
                 nearest_choice(topic, table_topics()));
}

std::unexpected<Diagnostics> Recording::too_much() const {
  return failure(Code::kTooLarge, "",
                 fmt::format("{} messages of {} channels: too much to be read", message_count(), channels().size()),
                 "Use a shorter recording");
}

std::size_t Recording::rows(std::string_view topic) const {
  const ChannelInfo* channel = find_channel(topic);
  return channel == nullptr ? 0 : impl_->rows_of(*channel);
}

Result<Table> Recording::header(std::string_view topic) const {
  const Result<const ChannelInfo*> channel = numbers(topic);
  if (!channel) return std::unexpected(channel.error());
  Table table;
  table.topic = topic;
  RowDecoder decoder(**channel);
  for_each([&](const MessageView& message) { return !decoder.append(message, table); }, topic);
  if (impl_->visited_too_much()) return too_much();
  table.time.clear();
  for (std::vector<double>& column : table.values) column.clear();
  return table;
}

Result<Table> Recording::table(std::string_view topic) const {
  const Result<Table> names = header(topic);
  if (!names) return names;
  if ((names->columns.size() + 1) * rows(topic) > mcap::ReadLimits::kTableValues)
    return failure(Code::kTooLarge, "",
                   fmt::format("topic '{}' has more than {} values", topic, mcap::ReadLimits::kTableValues),
                   "Use a shorter recording");
  const ColumnChoice all[] = {{.topic = std::string(topic)}};
  Result<std::vector<Table>> tables = this->tables(all);
  if (!tables) return std::unexpected(std::move(tables.error()));
  return std::move(tables->front());
}

Result<std::vector<Table>> Recording::tables(std::span<const ColumnChoice> wanted) const {
  std::vector<Table> tables(wanted.size());
  std::vector<std::optional<RowDecoder>> decoders(impl_->channels.size());  // by the channel's place in the list
  std::vector<Table*> table_of(impl_->channels.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Result<const ChannelInfo*> channel = numbers(wanted[i].topic);
    if (!channel) return std::unexpected(channel.error());
    const auto index = static_cast<std::size_t>(*channel - impl_->channels.data());
    tables[i].topic = wanted[i].topic;
    table_of[index] = &tables[i];
    decoders[index].emplace(**channel, wanted[i].columns, impl_->rows_of(**channel));
  }
  // One topic alone is found by the lists of the chunks that have it.
  MessageCursor cursor(*this, wanted.size() == 1 ? std::string_view(wanted[0].topic) : std::string_view());
  for (MessageView message; cursor.next(message);) {
    const auto index = static_cast<std::size_t>(message.channel - impl_->channels.data());
    if (!decoders[index]) continue;
    // Curves go forward in time; what goes back says nothing that could be drawn or compared.
    Table& table = *table_of[index];
    if (table.time.empty() || message.time >= table.time.back()) decoders[index]->append(message, table);
  }
  if (impl_->visited_too_much()) return too_much();
  return tables;
}

Result<Table> Recording::table_every(std::string_view topic, Nanoseconds period) const {
  const Result<const ChannelInfo*> channel = numbers(topic);
  if (!channel) return std::unexpected(channel.error());
  Table table;
  table.topic = topic;
  RowDecoder decoder(**channel);
  Nanoseconds next = 0;
  bool fits = true;
  for_each(
      [&](const MessageView& message) {
        const bool first = table.time.empty();
        if (!first && message.time < next) return true;
        if (first) next = message.time;
        if (decoder.append(message, table)) next += period;
        fits = table.time.size() * (table.columns.size() + 1) <= mcap::ReadLimits::kTableValues;
        return fits;
      },
      topic);
  if (!fits || impl_->visited_too_much()) return too_much();
  return table;
}

Result<std::vector<RecordedEvent>> Recording::events(std::string_view topic) const {
  const ChannelInfo* channel = find_channel(topic);
  if (channel == nullptr || !is_event_channel(*channel)) {
    return failure(Code::kFileNotReadable, "", fmt::format("topic '{}' has no events", topic),
                   nearest_choice(topic, event_topics()));
  }
  std::vector<RecordedEvent> events;
  std::uint64_t bytes = 0;
  const auto fits = [&] {
    return events.size() <= mcap::ReadLimits::kEvents && bytes <= mcap::ReadLimits::kEventBytes;
  };
  for_each_event(topic, [&](const RecordedEvent& event) {
    bytes += event.source.size() + event.name.size() + event.text.size();
    events.push_back(event);
    return fits();
  });
  if (fits() && !impl_->visited_too_much()) return events;
  return failure(Code::kTooLarge, "",
                 fmt::format("topic '{}' has more than {} events or {} bytes of them", topic, mcap::ReadLimits::kEvents,
                             mcap::ReadLimits::kEventBytes),
                 "Use a shorter recording");
}

void Recording::for_each_event(std::string_view topic, const std::function<bool(const RecordedEvent&)>& visit) const {
  const ChannelInfo* channel = find_channel(topic);
  if (channel == nullptr || !is_event_channel(*channel)) return;
  const auto visit_event = [&](const MessageView& view) {
    Event event;
    return !parse_message(view, event) ||
           visit({view.time, event.cycle(), event.source(), event.name(), event.text(), event.step()});
  };
  const auto visit_log = [&](const MessageView& view) {
    foxglove::Log log;
    return !parse_message(view, log) ||
           visit({view.time, 0, log.name(), foxglove::Log::Level_Name(log.level()), log.message(), {}});
  };
  if (channel->schema == kEventSchema) {
    for_each(visit_event, topic);
  } else {
    for_each(visit_log, topic);
  }
}

std::string_view Recording::digest_topic() const {
  const auto channel = std::ranges::find(impl_->channels, kDigestSchema, &ChannelInfo::schema);
  return channel == impl_->channels.end() ? std::string_view() : std::string_view(channel->topic);
}

std::vector<RecordedDigest> Recording::digests() const {
  std::vector<RecordedDigest> digests;
  DigestCursor cursor(*this);
  for (RecordedDigest digest; cursor.next(digest);) digests.push_back(digest);
  return digests;
}

MessageCursor::MessageCursor(const Recording& recording, std::string_view topic)
    : impl_(*recording.impl_), wanted_(topic.empty() ? nullptr : recording.find_channel(topic)) {
  if (!topic.empty() && wanted_ == nullptr) stretch_ = impl_.contents.stretches.size();
}

/// Goes on to the next stretch that has something of it. @return false: there is none, or too much has been read
bool MessageCursor::enter_stretch() {
  for (; stretch_ < impl_.contents.stretches.size(); ++stretch_) {
    if (wanted_ != nullptr && !std::ranges::binary_search(impl_.ids[stretch_], wanted_->id)) continue;
    if (impl_.visited_too_much()) return false;
    const std::optional<std::string>& kept = impl_.unpacked[stretch_];
    if (!kept) fresh_ = mcap::unpack(impl_.source, impl_.contents.stretches[stretch_], false).value_or("");
    raw_ = kept ? *kept : fresh_;
    impl_.visited_bytes += raw_.size();
    offset_ = 0;
    return inside_ = true;
  }
  return false;
}

bool MessageCursor::next(MessageView& message) {
  while (inside_ || enter_stretch()) {
    for (std::uint16_t id = 0; next_message(raw_, offset_, id, message);) {
      if (wanted_ != nullptr && id != wanted_->id) continue;
      message.channel = wanted_ != nullptr ? wanted_ : impl_.channel(id);
      if (message.channel != nullptr) return true;
    }
    inside_ = false;
    ++stretch_;
  }
  return false;
}

DigestCursor::DigestCursor(const Recording& recording) {
  if (!recording.digest_topic().empty()) messages_.emplace(recording, recording.digest_topic());
}

bool DigestCursor::next(RecordedDigest& digest) {
  MessageView view;
  while (messages_ && messages_->next(view)) {
    Digest message;
    if (!parse_message(view, message)) continue;
    digest = {view.time, message.cycle(), message.digest()};
    return true;
  }
  return false;
}

}  // namespace takt::record
