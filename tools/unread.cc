#include "tools/unread.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/base/utf8.h"
#include "record/compare_messages.h"

namespace takt::tools {
namespace {

constexpr const char* kCompressions = "Write it without compression, with zstd or with lz4";
constexpr const char* kEncodings = "Write it as protobuf, with a message type that takt knows";

}  // namespace

Diagnostics unread_parts(const record::Recording& recording, const std::string& file,
                         const std::function<bool(const record::ChannelInfo&)>& wanted) {
  Diagnostics diagnostics;
  const auto& unread = recording.unread();
  for (const std::string& lost : recording.lost()) {
    const bool is_unknown = std::ranges::find(unread, lost) != unread.end();
    diagnostics.error(is_unknown ? Code::kUnsupported : Code::kFileNotReadable, "", lost,
                      is_unknown ? kCompressions : "");
  }
  for (const record::ChannelInfo& channel : recording.channels()) {
    const std::size_t messages = recording.rows(channel.topic);
    if (messages == 0 || record::Recording::decodes(channel) || !wanted(channel)) continue;
    diagnostics.error(Code::kUnsupported, "",
                      fmt::format("topic '{}': {} is not decoded ({} messages)", to_valid_utf8(channel.topic),
                                  record::why_not_decoded(channel), messages),
                      kEncodings);
  }
  if (recording.truncated_at()) diagnostics.note("", fmt::format("truncated at byte {}", *recording.truncated_at()));
  diagnostics.set_file(file);
  return diagnostics;
}

}  // namespace takt::tools
