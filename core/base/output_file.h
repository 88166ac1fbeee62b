#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/unfinished.h"

namespace takt {

/// Writes a whole file: beside `path` first, then in its place, so that a full disk leaves what was there before and
/// nothing half written. What is there and is no regular file (a device, a terminal) is written to directly; a FIFO
/// that has no reader is refused. The mode of a file that is replaced is kept. Realtime: setup.
/// @param option  pointer of the diagnostic, e.g. "--report"
[[nodiscard]] Diagnostics write_file(const std::filesystem::path& path, std::string_view content,
                                     const std::string& option = {});

/// A diagnostic if `path` cannot become a new file of ours: a folder, a FIFO, a socket, or one of `inputs`, which would
/// be lost; a file that cannot be written, or is to be in a folder that is not there or cannot be written. Nothing is
/// created. Realtime: setup.
[[nodiscard]] Diagnostics check_output(const std::filesystem::path& path,
                                       const std::vector<std::filesystem::path>& inputs,
                                       const std::string& option = {});

/// A file of a name of its own in the folder for temporary files, which goes when this goes, or when a signal ends the
/// process. Move-only.
class TemporaryFile {
 public:
  /// @param suffix  end of the name, e.g. ".mcap". Diagnostics: the folder is missing or cannot be written.
  [[nodiscard]] static Result<TemporaryFile> create(const std::string& suffix);
  ~TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&& other) noexcept;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)), unfinished_(path_) {}

  std::filesystem::path path_;  ///< empty: it was moved from
  Unfinished unfinished_;
};

/// The same as a folder, with all that is in it.
class TemporaryFolder {
 public:
  [[nodiscard]] static Result<TemporaryFolder> create();
  ~TemporaryFolder();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)), unfinished_(path_) {}

  std::filesystem::path path_;  ///< empty: it was moved from
  Unfinished unfinished_;
};

}  // namespace takt
