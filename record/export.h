#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"
#include "record/recording.h"

namespace takt::record {

/// A topic of numbers as comma-separated values (RFC 4180): the first line has "time_s" and the columns, each with its
/// unit in brackets; null is an empty cell; numbers have all their digits; a number that stands for a word (a state) is
/// followed by a column "NAME.name". Events: time_s, cycle, source, name, step, text. Diagnostics: no such topic, the
/// file cannot be written. Realtime: setup.
[[nodiscard]] Result<void> write_csv(const Recording& recording, std::string_view topic,
                                     const std::filesystem::path& file);

/// The poses of one frame of a topic of transforms in the format of the TUM benchmark: a line "time x y z qx qy qz qw"
/// for each, s and m, in the parent frame. Diagnostics: no such topic or frame, the file cannot be written.
/// Realtime: setup.
[[nodiscard]] Result<void> write_tum(const Recording& recording, std::string_view topic, const std::string& frame,
                                     const std::filesystem::path& file);

/// A name for the file of a topic: "/left/joint_states" becomes "left_joint_states".
[[nodiscard]] std::string file_name_of(std::string_view topic);

}  // namespace takt::record
