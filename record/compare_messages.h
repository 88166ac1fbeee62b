#pragma once

#include <string>

#include "record/comparison.h"
#include "record/recording.h"

namespace takt::record {

/// Messages that are not decoded: the same bytes at the same times, one by one. A message that only one has is a
/// difference.
[[nodiscard]] ColumnComparison compare_messages(const Recording& a, const Recording& b, const std::string& topic,
                                                const Tolerance& tolerance);

/// Why a channel's messages are compared as bytes: "encoding 'json'", "message type 'foxglove.PointCloud'".
[[nodiscard]] std::string why_not_decoded(const ChannelInfo& channel);

}  // namespace takt::record
