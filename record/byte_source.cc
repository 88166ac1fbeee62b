#include "record/byte_source.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>

namespace takt::record {

namespace {

/// Read at once, so that records that follow one another cost one call together.
constexpr std::uint64_t kWindowBytes = 1u << 20;

}  // namespace

Result<ByteSource> ByteSource::open(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::exists(path, code))
    return failure(Code::kNotFound, "", fmt::format("there is no file {}", path.string()));
  if (!std::filesystem::is_regular_file(path, code))
    return failure(Code::kFileNotReadable, "", fmt::format("{} is not a file", path.string()));
  const auto size = std::filesystem::file_size(path, code);
  const int file = code ? -1 : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    const std::string why = code ? code.message() : std::strerror(errno);
    return failure(Code::kFileNotReadable, "", fmt::format("cannot read {}: {}", path.string(), why));
  }
  return ByteSource(file, size);
}

ByteSource::~ByteSource() {
  if (file_ >= 0) ::close(file_);
}

ByteSource::ByteSource(ByteSource&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      window_(std::move(other.window_)),
      begin_(other.begin_),
      size_(other.size_) {}

ByteSource& ByteSource::operator=(ByteSource&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(window_, other.window_);
  std::swap(begin_, other.begin_);
  std::swap(size_, other.size_);
  return *this;
}

std::string_view ByteSource::view(std::uint64_t offset, std::uint64_t size) const {
  if (offset >= size_) return {};
  size = std::min(size, size_ - offset);
  const bool inside = offset >= begin_ && offset + size <= begin_ + window_.size();
  if (!inside && file_ >= 0) read(offset, std::max(size, kWindowBytes));
  if (offset < begin_ || offset >= begin_ + window_.size()) return {};
  return std::string_view(window_).substr(offset - begin_, size);
}

void ByteSource::read(std::uint64_t offset, std::uint64_t size) const {
  begin_ = offset;
  window_.resize(std::min(size, size_ - offset));
  std::size_t done = 0;
  while (done < window_.size()) {
    const ssize_t got = ::pread(file_, window_.data() + done, window_.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;  // unreadable, or shorter than it was
    done += static_cast<std::size_t>(got);
  }
  window_.resize(done);
}

}  // namespace takt::record
