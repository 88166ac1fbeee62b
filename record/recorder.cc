#include "record/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>
#include <thread>

#include "core/base/utf8.h"
#include "record/recording_thread.h"

namespace takt::record {

namespace {

constexpr std::size_t kMostText = 4000;
/// Field numbers from 19000 on belong to protobuf.
constexpr std::size_t kMostColumns = 18'000;

constexpr double kNullRecorded = std::numeric_limits<double>::quiet_NaN();

void copy_values(std::uint64_t* to, std::span<const double> values) {
  for (const double value : values) {
    const double recorded = std::isfinite(value) ? value : kNullRecorded;
    std::memcpy(to++, &recorded, sizeof(recorded));
  }
}

}  // namespace

/// The cycle's side: everything here belongs to the run loop's thread, but for the atomic counters.
class Recorder::Impl {
 public:
  Impl(const std::filesystem::path& path, const RecorderOptions& options)
      : policy_(options.policy), thread_(path, options) {}

  ChannelId add(ChannelPlan plan);
  /// Room for a row of a channel, or nullptr if it is to be left out.
  std::uint64_t* begin_row(ChannelId channel, RowKind kind, std::size_t words);
  std::uint64_t* reserve(std::uint32_t tag, std::size_t words);
  void write_texts(ChannelId channel, RowKind kind, std::optional<std::uint64_t> first_word,
                   std::array<std::string_view, 4> texts);

  /// A full ring takes it later.
  void try_keep() {
    if (keep_pending_ && started_ && reserve(kKeepTag, 0) != nullptr) keep_pending_ = false;
  }

  FullPolicy policy_;
  RecordingThread thread_;
  bool keep_pending_ = false;
  bool started_ = false;
  bool closed_ = false;
  bool dropping_ = false;  ///< the rest of this cycle is left out
  Nanoseconds time_ = 0;
  std::atomic<std::uint64_t> dropped_cycles_{0}, refused_rows_{0};
};

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Recorder::~Recorder() { close(); }

Result<std::unique_ptr<Recorder>> Recorder::open(const std::filesystem::path& path, RecorderOptions options) {
  auto impl = std::make_unique<Impl>(path, options);
  if (const std::string error = impl->thread_.error(); !error.empty())
    return failure(Code::kFileNotWritable, "", error);
  try {
    impl->thread_.start();
  } catch (const std::system_error& error) {
    return failure(Code::kSystem, "", fmt::format("no thread to write the recording: {}", error.what()));
  }
  return std::unique_ptr<Recorder>(new Recorder(std::move(impl)));
}

ChannelId Recorder::Impl::add(ChannelPlan plan) {
  const auto refuse = [&](std::string_view why) {
    thread_.report_error(fmt::format("channel '{}': {}", plan.topic, why));
    return ChannelId{};
  };
  if (started_ || closed_) return refuse("channels are added before the first cycle");
  if (plan.topic.size() < 2 || plan.topic.front() != '/') return refuse("a topic is '/' and a name");
  for (const ChannelPlan& other : thread_.plans) {
    if (other.topic == plan.topic) return refuse("the topic exists already");
  }
  if (plan.row_size > std::min(kMostColumns, thread_.ring.max_words() - 1)) return refuse("too many columns");
  thread_.plans.push_back(std::move(plan));
  return {static_cast<std::uint32_t>(thread_.plans.size())};
}

ChannelId Recorder::add_joint_states(std::string topic, std::vector<std::string> joints, JointFields fields) {
  return impl_->add(plan_joint_states(std::move(topic), std::move(joints), fields));
}
ChannelId Recorder::add_transforms(std::string topic, std::vector<std::pair<std::string, std::string>> frames) {
  return impl_->add(plan_transforms(std::move(topic), std::move(frames)));
}
ChannelId Recorder::add_wrench(std::string topic, std::string frame) {
  return impl_->add(plan_wrench(std::move(topic), std::move(frame)));
}
ChannelId Recorder::add_samples(std::string topic, std::vector<std::string> columns, std::vector<std::string> units,
                                const Words& words) {
  ChannelPlan plan = plan_samples(std::move(topic), std::move(columns), std::move(units));
  for (const auto& [column, list] : words) plan.metadata["words:" + column] = text_list(list);
  return impl_->add(std::move(plan));
}
ChannelId Recorder::add_state(std::string topic, std::vector<std::string> names) {
  return impl_->add(plan_state(std::move(topic), std::move(names)));
}
ChannelId Recorder::add_digest(std::string topic) { return impl_->add(plan_texts(std::move(topic), RowKind::kDigest)); }
ChannelId Recorder::add_events(std::string topic) { return impl_->add(plan_texts(std::move(topic), RowKind::kEvent)); }
ChannelId Recorder::add_log(std::string topic) { return impl_->add(plan_texts(std::move(topic), RowKind::kLog)); }

std::uint64_t* Recorder::Impl::reserve(std::uint32_t tag, std::size_t words) {
  if (closed_ || dropping_) return nullptr;
  const auto count = static_cast<std::uint32_t>(words);
  std::uint64_t* room = thread_.ring.reserve(tag, count);
  while (room == nullptr) {
    if (policy_ == FullPolicy::kDrop) {
      thread_.ring.roll_back();
      dropping_ = true;
      dropped_cycles_.fetch_add(1, std::memory_order_relaxed);
      return nullptr;
    }
    // Entries stand by themselves, so a part of a cycle may go ahead; the writer always makes room, also after errors.
    thread_.ring.publish();
    std::this_thread::sleep_for(std::chrono::microseconds(50));
    room = thread_.ring.reserve(tag, count);
  }
  return room;
}

std::uint64_t* Recorder::Impl::begin_row(ChannelId channel, RowKind kind, std::size_t words) {
  if (channel.value == 0 || closed_) return nullptr;
  const bool fits = started_ && channel.value <= thread_.plans.size() &&
                    thread_.plans[channel.value - 1].kind == kind &&
                    (kind != RowKind::kNumbers || thread_.plans[channel.value - 1].row_size == words);
  if (!fits) {
    refused_rows_.fetch_add(1, std::memory_order_relaxed);
    return nullptr;
  }
  return reserve(channel.value - 1, words);
}

void Recorder::begin_cycle(Nanoseconds time, std::uint64_t cycle) {
  Impl& impl = *impl_;
  impl.started_ = true;
  impl.thread_.ring.publish();
  impl.dropping_ = false;
  impl.time_ = std::max(impl.time_, time);
  if (std::uint64_t* words = impl.reserve(kCycleTag, 2); words != nullptr) {
    words[0] = static_cast<std::uint64_t>(impl.time_);
    words[1] = cycle;
  }
  impl.try_keep();
}

void Recorder::write(ChannelId channel, std::span<const double> row) {
  if (std::uint64_t* words = impl_->begin_row(channel, RowKind::kNumbers, row.size()); words != nullptr) {
    copy_values(words, row);
  }
}

void Recorder::write_joints(ChannelId channel, std::span<const double> q, std::span<const double> dq,
                            std::span<const double> tau) {
  if (channel.value == 0 || channel.value > impl_->thread_.plans.size()) return;
  const ChannelPlan& plan = impl_->thread_.plans[channel.value - 1];
  const std::size_t n = plan.joint_count;
  const bool sizes_fit = std::ranges::all_of(std::array{q.size(), dq.size(), tau.size()},
                                             [n](std::size_t size) { return size == 0 || size == n; });
  std::uint64_t* words = impl_->begin_row(channel, RowKind::kNumbers, sizes_fit ? plan.row_size : plan.row_size + 1);
  if (words == nullptr) return;
  const auto put = [&](bool carried, std::span<const double> values) {
    if (!carried) return;
    if (values.empty()) {
      std::fill_n(words, n, std::bit_cast<std::uint64_t>(kNullRecorded));
    } else {
      copy_values(words, values);
    }
    words += n;
  };
  put(plan.joint_fields.position, q);
  put(plan.joint_fields.velocity, dq);
  put(plan.joint_fields.effort, tau);
}

void Recorder::write_transforms(ChannelId channel, std::span<const Eigen::Isometry3d> poses) {
  if (channel.value == 0 || channel.value > impl_->thread_.plans.size()) return;
  auto& rotations = impl_->thread_.plans[channel.value - 1].last_rotations;
  const bool fits = rotations.size() == poses.size();
  std::uint64_t* words = impl_->begin_row(channel, RowKind::kNumbers, fits ? 7 * poses.size() : 7 * poses.size() + 1);
  if (words == nullptr) return;
  auto last = rotations.begin();
  for (const Eigen::Isometry3d& pose : poses) {
    const Eigen::Vector3d p = pose.translation();
    Eigen::Quaterniond q(pose.linear());
    // Of the two quaternions of a rotation the one that is nearer to the last, so that curves never jump; at first w >=
    // 0.
    if (q.dot(*last) < 0.0) q.coeffs() *= -1.0;
    *last++ = q;
    copy_values(words, std::array{p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
    words += 7;
  }
}

void Recorder::digest(ChannelId channel, std::uint64_t digest) {
  if (std::uint64_t* words = impl_->begin_row(channel, RowKind::kDigest, 1); words != nullptr) words[0] = digest;
}

void Recorder::Impl::write_texts(ChannelId channel, RowKind kind, std::optional<std::uint64_t> first_word,
                                 std::array<std::string_view, 4> texts) {
  std::size_t size = 0;
  for (std::string_view& text : texts) {
    text = cut_utf8(text, kMostText);
    size += text.size();
  }
  std::uint64_t* words = begin_row(channel, kind, (first_word ? 2 : 1) + (size + 7) / 8);
  if (words == nullptr) return;
  if (first_word) *words++ = *first_word;
  std::uint64_t sizes = 0;
  for (std::size_t i = 0; i < texts.size(); ++i) sizes |= texts[i].size() << (16 * i);
  *words++ = sizes;
  auto* bytes = reinterpret_cast<char*>(words);
  for (const std::string_view text : texts) bytes = std::copy(text.begin(), text.end(), bytes);
}

void Recorder::event(ChannelId channel, std::string_view source, std::string_view name, std::string_view text,
                     std::string_view step) {
  impl_->write_texts(channel, RowKind::kEvent, std::nullopt, {source, name, text, step});
}

void Recorder::log(ChannelId channel, LogLevel level, std::string_view source, std::string_view text) {
  impl_->write_texts(channel, RowKind::kLog, static_cast<std::uint64_t>(level), {source, text, {}, {}});
}

void Recorder::add_constant(std::string topic, std::string_view schema, std::string bytes) {
  impl_->add(plan_constant(std::move(topic), schema, std::move(bytes)));
}

void Recorder::keep() {
  impl_->keep_pending_ = true;
  impl_->try_keep();
}

RecorderStatus Recorder::close() {
  if (!impl_->closed_) {
    impl_->thread_.ring.publish();
    impl_->closed_ = true;
    impl_->thread_.keep_at_end.store(impl_->keep_pending_);
    impl_->thread_.stop();
  }
  return status();
}

RecorderStatus Recorder::status() const {
  RecorderStatus status;
  status.error = impl_->thread_.error();
  status.recording = !impl_->closed_ && status.error.empty();
  status.messages = impl_->thread_.messages.load(std::memory_order_relaxed);
  status.bytes = impl_->thread_.bytes.load(std::memory_order_relaxed);
  status.dropped_cycles = impl_->dropped_cycles_.load(std::memory_order_relaxed);
  status.refused_rows = impl_->refused_rows_.load(std::memory_order_relaxed);
  status.removed = impl_->thread_.removed.load(std::memory_order_relaxed);
  return status;
}

}  // namespace takt::record
