#include "sim/film/film_encoder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

// GCC leaves the conversion loops scalar at -O2.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC push_options
#pragma GCC optimize("O3")
#endif

extern char** environ;

namespace takt::sim {
namespace {

std::uint32_t load(const std::uint8_t* pixel) {
  std::uint32_t word = 0;
  std::memcpy(&word, pixel, 4);
  return word;
}

// BT.709 in 1/256: Y = 16 + 0.183 R + 0.614 G + 0.062 B for the range 16 ... 235.
void luma_row(const std::uint8_t* in, int width, std::uint8_t* y) {
  for (int x = 0; x < width; ++x) {
    const std::uint32_t p = load(in + 4 * x);
    y[x] = static_cast<std::uint8_t>((47 * (p & 0xff) + 157 * ((p >> 8) & 0xff) + 16 * ((p >> 16) & 0xff) + 4224) >> 8);
  }
}

// One colour sample per 2x2 pixels, of their mean; 32896 = 128.5 * 256 keeps the sums positive.
void chroma_row(const std::uint8_t* upper, const std::uint8_t* lower, int width, std::uint8_t* u, std::uint8_t* v) {
  for (int x = 0; x < width / 2; ++x) {
    const std::uint32_t a = load(upper + 8 * x), b = load(upper + 8 * x + 4);
    const std::uint32_t c = load(lower + 8 * x), d = load(lower + 8 * x + 4);
    constexpr std::uint32_t kMask = 0xff00ff;
    const std::uint32_t red_blue = (a & kMask) + (b & kMask) + (c & kMask) + (d & kMask);
    const auto green =
        static_cast<std::int32_t>(((a >> 8) & 0xff) + ((b >> 8) & 0xff) + ((c >> 8) & 0xff) + ((d >> 8) & 0xff));
    const auto red = static_cast<std::int32_t>(red_blue & 0xffff), blue = static_cast<std::int32_t>(red_blue >> 16);
    u[x] = static_cast<std::uint8_t>((4 * 32896 - 26 * red - 87 * green + 113 * blue) >> 10);
    v[x] = static_cast<std::uint8_t>((4 * 32896 + 113 * red - 102 * green - 11 * blue) >> 10);
  }
}

/// A name that no other process takes meanwhile; what is there and is no file (a device) is written to directly.
std::filesystem::path place_beside(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return path;
  const auto target = std::filesystem::exists(status) ? std::filesystem::canonical(path, error) : path;
  std::string beside = (error ? path : target).string() + ".XXXXXX";
  const int file = mkostemp(beside.data(), O_CLOEXEC);
  if (file < 0) return path;  // ffmpeg says why it cannot be written
  const mode_t mask = umask(0);
  umask(mask);
  (void)fchmod(file, 0666 & ~mask);
  close(file);
  return beside;
}

constexpr int kPatience_ms = 30'000;  ///< with an ffmpeg that does not move any more
constexpr int kStep_ms = 2;           ///< between two looks whether it has ended

std::vector<std::string> arguments(const std::string& program, const std::filesystem::path& path, int width, int height,
                                   int fps) {
  return {program, "-hide_banner", "-loglevel", "error", "-nostdin", "-y",
          // what we send
          "-f", "rawvideo", "-pixel_format", "yuv420p", "-video_size", fmt::format("{}x{}", width, height),
          "-framerate", std::to_string(fps), "-i", "pipe:0",
          // what comes out; a fixed number of threads keeps the file the same on every machine
          "-an", "-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-threads", "2", "-pix_fmt", "yuv420p",
          "-color_range", "tv", "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-fflags",
          "+bitexact", "-movflags", "+faststart", "-f", "mp4", "file:" + path.string()};
}

}  // namespace

void to_yuv420(const Image& image, std::vector<std::uint8_t>& yuv) {
  const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  yuv.resize(pixels + pixels / 2);
  std::uint8_t* u = yuv.data() + pixels;
  std::uint8_t* v = u + pixels / 4;
  for (int y = 0; y < image.height; ++y)
    luma_row(image.pixel(0, y), image.width,
             yuv.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width));
  for (int y = 0; y < image.height; y += 2, u += image.width / 2, v += image.width / 2)
    chroma_row(image.pixel(0, y), image.pixel(0, y + 1), image.width, u, v);
}

Result<FilmEncoder> FilmEncoder::start(const std::string& program, const std::filesystem::path& path, int width,
                                       int height, int fps) {
  FilmEncoder encoder;
  encoder.program_ = program;
  encoder.path_ = path;
  // A socket and not a pipe: writing to a dead process then is an error and no signal.
  std::array<int, 2> ends{-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return failure(Code::kSystem, "", fmt::format("no socket for {}: {}", program, std::strerror(errno)));
  encoder.input_ = ends[0];
  encoder.messages_ = memfd_create("takt-ffmpeg", MFD_CLOEXEC);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (encoder.messages_ >= 0) posix_spawn_file_actions_adddup2(&actions, encoder.messages_, STDERR_FILENO);
  // A group of its own: Ctrl-C ends the run, and the run then ends ffmpeg with a complete file.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // What this process ignores, ffmpeg does not.
  sigset_t defaults;
  sigemptyset(&defaults);
  for (const int one : {SIGPIPE, SIGXFSZ}) sigaddset(&defaults, one);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  encoder.beside_ = place_beside(path);
  std::vector<std::string> words = arguments(program, encoder.beside_, width, height, fps);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const int error = posix_spawnp(&encoder.process_, program.c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (error == 0) {
    encoder.unfinished_ = Unfinished(encoder.beside_, encoder.process_);
    return encoder;
  }
  encoder.process_ = -1;
  return failure(Code::kSystem, "/ffmpeg", fmt::format("cannot start '{}': {}", program, std::strerror(error)),
                 "Install ffmpeg, or run without --video");
}

FilmEncoder::FilmEncoder(FilmEncoder&& other) noexcept { *this = std::move(other); }

FilmEncoder& FilmEncoder::operator=(FilmEncoder&& other) noexcept {
  std::swap(program_, other.program_);
  std::swap(path_, other.path_);
  std::swap(beside_, other.beside_);
  std::swap(unfinished_, other.unfinished_);
  std::swap(process_, other.process_);
  std::swap(input_, other.input_);
  std::swap(messages_, other.messages_);
  std::swap(yuv_, other.yuv_);
  return *this;
}

FilmEncoder::~FilmEncoder() {
  (void)wait();
  if (messages_ >= 0) close(messages_);
  std::error_code ignored;
  if (!beside_.empty() && beside_ != path_) std::filesystem::remove(beside_, ignored);
}

Result<void> FilmEncoder::write(const Image& image) {
  if (input_ < 0) return failure(Code::kSystem, "", "the film has been closed");
  to_yuv420(image, yuv_);
  std::size_t sent = 0;
  while (sent < yuv_.size()) {
    pollfd ready{.fd = input_, .events = POLLOUT, .revents = 0};
    const int polled = poll(&ready, 1, kPatience_ms);
    if (polled < 0 && errno == EINTR) continue;
    if (polled == 0) {
      (void)kill(process_, SIGKILL);
      (void)wait();
      return failure(Code::kSystem, "/ffmpeg",
                     fmt::format("{} took no picture for {} s, and was ended", program_, kPatience_ms / 1000));
    }
    const ssize_t count = send(input_, yuv_.data() + sent, yuv_.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count <= 0) {
      Result<void> ended = wait();
      if (!ended) return ended;
      return failure(Code::kSystem, "", fmt::format("{} ended before the film did", program_));
    }
    sent += static_cast<std::size_t>(count);
  }
  return {};
}

Result<void> FilmEncoder::wait() {
  if (input_ >= 0) close(std::exchange(input_, -1));
  if (process_ < 0) return {};
  int status = 0;
  // It still has to put the index of a long film in front of it.
  for (int waited_ms = 0; waitpid(process_, &status, WNOHANG) == 0; waited_ms += kStep_ms) {
    if (waited_ms == kPatience_ms) (void)kill(process_, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(kStep_ms));
  }
  process_ = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  std::string said(4096, '\0');
  const ssize_t length = messages_ >= 0 ? pread(messages_, said.data(), said.size(), 0) : 0;
  said.resize(static_cast<std::size_t>(std::max<ssize_t>(0, length)));
  while (!said.empty() && (said.back() == '\n' || said.back() == ' ')) said.pop_back();
  const std::string end =
      WIFEXITED(status) ? fmt::format("status {}", WEXITSTATUS(status)) : fmt::format("signal {}", WTERMSIG(status));
  return failure(Code::kSystem, "/path",
                 fmt::format("{} ended with {}: {}", program_, end, said.empty() ? "no message" : said));
}

Result<void> FilmEncoder::finish() {
  Result<void> ended = wait();
  if (!ended) return ended;
  std::error_code error;
  if (beside_ == path_ && !std::filesystem::is_regular_file(path_, error)) return {};
  if (const auto size = std::filesystem::file_size(beside_, error); error || size == 0)
    return failure(Code::kFileNotWritable, "/path",
                   fmt::format("{} has left no film in '{}'", program_, path_.string()));
  if (beside_ == path_) return {};
  const auto target = std::filesystem::exists(path_, error) ? std::filesystem::canonical(path_, error) : path_;
  std::filesystem::rename(beside_, target, error);
  if (error)
    return failure(Code::kFileNotWritable, "/path",
                   fmt::format("'{}' cannot be written: {}", path_.string(), error.message()));
  beside_.clear();
  unfinished_ = {};
  return {};
}

}  // namespace takt::sim

// What follows in a batch of files keeps its own level.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif
