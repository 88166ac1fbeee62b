#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

namespace takt::record::mcap {

/// True for the compressions of chunks that are read: none (an empty name), "zstd", "lz4".
[[nodiscard]] bool is_known_compression(std::string_view name);

/// The bytes of a chunk as they were before they were compressed, or why they cannot be had. Memory: `raw_size`, which
/// the caller bounds. @param raw_size  as the chunk states it; bytes of another size are refused
[[nodiscard]] std::expected<std::string, std::string> decompress(std::string_view compression, std::string_view data,
                                                                 std::uint64_t raw_size);

}  // namespace takt::record::mcap
