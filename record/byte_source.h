#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt::record {

/// The bytes of a recording, in a file or in memory, read piece by piece: a file may be larger than the memory, and may
/// shrink while it is read. One thread. Realtime: setup.
class ByteSource {
 public:
  /// Diagnostics: no such file, no file at all, a file that cannot be opened.
  [[nodiscard]] static Result<ByteSource> open(const std::filesystem::path& path);
  explicit ByteSource(std::string bytes) : window_(std::move(bytes)), size_(window_.size()) {}
  ~ByteSource();
  ByteSource(ByteSource&& other) noexcept;
  ByteSource& operator=(ByteSource&& other) noexcept;

  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// `size` bytes from `offset` on, fewer where the bytes end or cannot be read. Valid until the next call.
  [[nodiscard]] std::string_view view(std::uint64_t offset, std::uint64_t size) const;

 private:
  ByteSource(int file, std::uint64_t size) : file_(file), size_(size) {}
  void read(std::uint64_t offset, std::uint64_t size) const;

  int file_ = -1;               ///< -1: all is in window_
  mutable std::string window_;  ///< the bytes from begin_ on
  mutable std::uint64_t begin_ = 0;
  std::uint64_t size_ = 0;
};

}  // namespace takt::record
