#include "core/base/output_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace takt {
namespace {

namespace fs = std::filesystem;

/// Writes and closes. @return 0 or an error number
int write_all(int file, std::string_view content) {
  int error = 0;
  while (!content.empty() && error == 0) {
    const ssize_t written = ::write(file, content.data(), content.size());
    if (written > 0) content.remove_prefix(static_cast<std::size_t>(written));
    if (written == 0) error = ENOSPC;
    if (written < 0 && errno != EINTR) error = errno;
  }
  return ::close(file) == 0 || error != 0 ? error : errno;
}

int write_directly(const fs::path& path, std::string_view content) {
  // A FIFO without a reader would wait for one for ever.
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return errno;
  ::fcntl(file, F_SETFL, ::fcntl(file, F_GETFL) & ~O_NONBLOCK);
  return write_all(file, content);
}

int write_beside(const fs::path& path, std::string_view content, mode_t mode) {
  std::string beside = path.string() + ".XXXXXX";
  const int file = ::mkostemp(beside.data(), O_CLOEXEC);
  if (file < 0) return errno;
  const Unfinished unfinished(beside);
  ::fchmod(file, mode);
  int error = write_all(file, content);
  if (error == 0 && ::rename(beside.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) ::unlink(beside.c_str());
  return error;
}

mode_t mode_of_new_files() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

/// A path with XXXXXX in the folder for temporary files.
Result<std::string> temporary_pattern(const std::string& suffix) {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (!error) return (folder / ("takt-XXXXXX" + suffix)).string();
  return failure(Code::kFileNotWritable, "", fmt::format("there is no folder for temporary files: {}", error.message()),
                 "TMPDIR names a folder that can be written");
}

}  // namespace

Diagnostics write_file(const fs::path& path, std::string_view content, const std::string& option) {
  struct stat there {};
  const bool exists = ::stat(path.c_str(), &there) == 0;
  int error = 0;
  if (exists && !S_ISREG(there.st_mode)) {
    error = write_directly(path, content);
  } else {
    // Links are followed, so that a file behind one is replaced and not the link.
    std::error_code unresolved;
    const fs::path target = exists ? fs::canonical(path, unresolved) : path;
    error = write_beside(target, content, exists ? there.st_mode & 07777 : mode_of_new_files());
  }
  Diagnostics diagnostics;
  if (error != 0) {
    diagnostics.error(Code::kFileNotWritable, option,
                      fmt::format("'{}' cannot be written: {}", path.string(), std::strerror(error)),
                      "a file in a folder that exists and has room");
  }
  return diagnostics;
}

Diagnostics check_output(const fs::path& path, const std::vector<fs::path>& inputs, const std::string& option) {
  Diagnostics diagnostics;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const auto refuse = [&](const std::string& why) {
    diagnostics.error(Code::kFileNotWritable, option, fmt::format("'{}' {}", path.string(), why),
                      "the name of a new file");
  };
  if (fs::is_directory(status)) refuse("is a folder");
  if (fs::is_fifo(status) || fs::is_socket(status)) refuse("is a pipe or a socket, not a file");
  const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
  if (!fs::exists(status) && !fs::is_directory(folder, error)) {
    refuse("is to be in a folder that is not there");
  } else if (::access(fs::exists(status) ? path.c_str() : folder.c_str(), W_OK) != 0) {
    refuse(fmt::format("cannot be written: {}", std::strerror(errno)));
  }
  for (const fs::path& input : inputs) {
    if (fs::equivalent(path, input, error) && !error) refuse("is read by this command and would be overwritten");
  }
  return diagnostics;
}

Result<TemporaryFile> TemporaryFile::create(const std::string& suffix) {
  auto pattern = temporary_pattern(suffix);
  if (!pattern) return std::unexpected(std::move(pattern.error()));
  const int file = ::mkostemps(pattern->data(), static_cast<int>(suffix.size()), O_CLOEXEC);
  if (file < 0) {
    return failure(Code::kFileNotWritable, "",
                   fmt::format("no temporary file can be made: '{}': {}", *pattern, std::strerror(errno)),
                   "TMPDIR names a folder that can be written");
  }
  ::close(file);
  return TemporaryFile(*pattern);
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove(path_, ignored);
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : path_(std::exchange(other.path_, {})), unfinished_(std::move(other.unfinished_)) {}

TemporaryFile& TemporaryFile::operator=(TemporaryFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(unfinished_, other.unfinished_);
  return *this;
}

Result<TemporaryFolder> TemporaryFolder::create() {
  auto pattern = temporary_pattern("");
  if (!pattern) return std::unexpected(std::move(pattern.error()));
  if (::mkdtemp(pattern->data()) == nullptr) {
    return failure(Code::kFileNotWritable, "",
                   fmt::format("no temporary folder can be made: '{}': {}", *pattern, std::strerror(errno)),
                   "TMPDIR names a folder that can be written");
  }
  return TemporaryFolder(*pattern);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})), unfinished_(std::move(other.unfinished_)) {}

TemporaryFolder& TemporaryFolder::operator=(TemporaryFolder&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(unfinished_, other.unfinished_);
  return *this;
}

}  // namespace takt
