#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"

namespace takt::record {

/// What became of a recording that was written anew.
struct Recovered {
  std::uint64_t messages = 0;
  std::size_t attachments = 0;
  std::vector<std::string> lost;  ///< damage of the source and what it cost, in words; empty: it was whole
};

/// Writes all that is whole in a recording (killed, cut, damaged, without an index) into a new file with a summary and
/// an index, as if it had been closed in order. Schemas, channels, metadata and attachments come along; messages keep
/// their bytes and times. The source is not changed. Diagnostics: the source is no recording, has chunks whose
/// compression is not known, or no message that can be read; the target cannot be written. Realtime: setup, in memory
/// of a chunk.
[[nodiscard]] Result<Recovered> recover(const std::filesystem::path& source, const std::filesystem::path& target);

}  // namespace takt::record
