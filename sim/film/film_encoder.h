#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

#include "core/base/diagnostics.h"
#include "core/base/unfinished.h"
#include "sim/film/render_image.h"

namespace takt::sim {

/// Converts to planar YUV 4:2:0 in the colours of HD video (ITU-R BT.709, 16 ... 235): all of Y, then U, then V.
/// Even sizes only.
void to_yuv420(const Image& image, std::vector<std::uint8_t>& yuv);

/// An ffmpeg process that takes pictures of one size and writes an H.264 file: beside its place, and whole into it.
/// Move-only; the destructor ends the input, waits, and leaves no file if finish() has not. Thread: one at a time.
class FilmEncoder {
 public:
  /// @return diagnostics if `program` cannot be started
  [[nodiscard]] static Result<FilmEncoder> start(const std::string& program, const std::filesystem::path& path,
                                                 int width, int height, int fps);
  FilmEncoder(FilmEncoder&& other) noexcept;
  FilmEncoder& operator=(FilmEncoder&& other) noexcept;
  ~FilmEncoder();

  /// Hands a picture over; waits while ffmpeg is busy. If ffmpeg has ended, the diagnostic carries what it said.
  [[nodiscard]] Result<void> write(const Image& image);

  /// Ends the input, waits for ffmpeg, checks its exit status and the file, and puts the file in its place.
  [[nodiscard]] Result<void> finish();

 private:
  FilmEncoder() = default;
  Result<void> wait();

  std::string program_;
  std::filesystem::path path_, beside_;
  Unfinished unfinished_;
  pid_t process_ = -1;
  int input_ = -1;     // our end of the socket that is ffmpeg's standard input
  int messages_ = -1;  // a file in memory that is ffmpeg's standard error
  std::vector<std::uint8_t> yuv_;
};

}  // namespace takt::sim
