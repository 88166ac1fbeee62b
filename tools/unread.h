#pragma once

#include <functional>
#include <string>

#include "core/base/diagnostics.h"
#include "record/recording.h"

namespace takt::tools {

/// What a recording has and takt does not read: damage, compressions and encodings that are not known, as errors; a
/// torn end as a note. @param wanted  whether the messages of a channel that is not decoded are missed
[[nodiscard]] Diagnostics unread_parts(const record::Recording& recording, const std::string& file,
                                       const std::function<bool(const record::ChannelInfo&)>& wanted);

}  // namespace takt::tools
