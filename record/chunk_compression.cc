#include "record/chunk_compression.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <memory>

namespace takt::record::mcap {
namespace {

using Unpacked = std::expected<std::string, std::string>;

constexpr const char* kBroken = "it does not decompress";

Unpacked unpack_zstd(std::string_view data, std::uint64_t raw_size) {
  // A frame need not state its size (a stream does not); one that does must agree, so that a rotted size of the chunk
  // costs no memory.
  const auto stated = ZSTD_getFrameContentSize(data.data(), data.size());
  if (stated != raw_size && stated != ZSTD_CONTENTSIZE_UNKNOWN) return std::unexpected("its size is implausible");
  std::string raw(raw_size, '\0');
  const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), data.data(), data.size());
  if (ZSTD_isError(size) || size != raw.size()) return std::unexpected(kBroken);
  return raw;
}

struct FreeLz4 {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

/// Of the frame format: the frame must end where the data ends, and give exactly `raw_size` bytes.
Unpacked unpack_lz4(std::string_view data, std::uint64_t raw_size) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)))
    return std::unexpected("there is no memory to decompress it");
  const std::unique_ptr<LZ4F_dctx, FreeLz4> owner(context);
  std::string raw(raw_size, '\0');
  std::size_t read = 0, written = 0, expected = 1;  // expected: 0 at the end of a frame
  while (expected != 0) {
    std::size_t source = data.size() - read, room = raw.size() - written;
    expected = LZ4F_decompress(context, raw.data() + written, &room, data.data() + read, &source, nullptr);
    if (LZ4F_isError(expected) || (source == 0 && room == 0 && expected != 0)) return std::unexpected(kBroken);
    read += source;
    written += room;
  }
  if (read != data.size() || written != raw.size()) return std::unexpected(kBroken);
  return raw;
}

}  // namespace

bool is_known_compression(std::string_view name) { return name.empty() || name == "zstd" || name == "lz4"; }

Unpacked decompress(std::string_view compression, std::string_view data, std::uint64_t raw_size) {
  if (compression.empty()) return std::string(data);
  if (compression == "zstd") return unpack_zstd(data, raw_size);
  if (compression == "lz4") return unpack_lz4(data, raw_size);
  return std::unexpected(fmt::format("compression '{}' is not known", compression));
}

}  // namespace takt::record::mcap
