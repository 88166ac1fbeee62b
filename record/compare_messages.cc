#include "record/compare_messages.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/utf8.h"

namespace takt::record {
namespace {

std::string kind_of(const ChannelInfo& channel) {
  return fmt::format("{} {} ({})", channel.encoding, channel.schema, channel.schema_encoding);
}

}  // namespace

ColumnComparison compare_messages(const Recording& a, const Recording& b, const std::string& topic,
                                  const Tolerance& tolerance) {
  ColumnComparison result;
  result.topic = topic;
  result.column = "messages";
  result.tolerance = tolerance;
  const auto fail_at = [&](Nanoseconds time, std::string note) {
    ++result.samples_outside;
    if (!result.note.empty()) return;
    result.time = time;
    result.note = std::move(note);
    result.passed = tolerance.kind == ToleranceKind::kReportOnly;
    if (!result.passed) result.first_outside = time;
  };
  const std::string kind_a = kind_of(*a.find_channel(topic)), kind_b = kind_of(*b.find_channel(topic));
  if (kind_a != kind_b) fail_at(0, to_valid_utf8(fmt::format("{} in A, {} in B", kind_a, kind_b)));
  MessageCursor in_a(a, topic), in_b(b, topic);
  MessageView ma, mb;
  for (std::size_t i = 1;; ++i) {
    const bool more_a = in_a.next(ma), more_b = in_b.next(mb);
    if (!more_a && !more_b) break;
    if (!more_a || !more_b) {
      fail_at(more_a ? ma.time : mb.time, fmt::format("message {} is only in {}", i, more_a ? "A" : "B"));
    } else if (ma.time != mb.time) {
      fail_at(std::min(ma.time, mb.time),
              fmt::format("message {} is at {:.6f} s, not {:.6f} s", i, to_seconds(ma.time), to_seconds(mb.time)));
    } else if (!std::ranges::equal(ma.data, mb.data)) {
      fail_at(ma.time, fmt::format("message {} has other bytes", i));
    }
  }
  if (result.note.empty()) result.note = "equal to the byte";
  return result;
}

std::string why_not_decoded(const ChannelInfo& channel) {
  const std::string& what = channel.encoding == "protobuf" ? channel.schema : channel.encoding;
  return fmt::format("{} '{}'", channel.encoding == "protobuf" ? "message type" : "encoding",
                     cut_utf8(to_valid_utf8(what), 60));
}

}  // namespace takt::record
