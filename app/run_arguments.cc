#include "app/run_arguments.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/process.h"
#include "core/base/output_file.h"
#include "sim/film/film.h"

namespace takt::app {
namespace {

template <class Number>
bool parse_whole(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

std::optional<std::uint64_t> parse_seed(const std::optional<std::string>& text, Diagnostics& diagnostics) {
  std::uint64_t seed = 0;
  if (!text) return std::nullopt;
  if (parse_whole(*text, seed)) return seed;
  diagnostics.error(Code::kInvalidValue, "--seed", fmt::format("'{}' is not a seed", *text),
                    "Give a whole number from 0 to 18446744073709551615");
  return std::nullopt;
}

constexpr std::string_view kNoLog = "none";

void check_log_level(const std::string& level, Diagnostics& diagnostics) {
  if (level == kNoLog || cell::log_level_named(level)) return;
  std::vector<std::string> names = cell::log_level_names();
  names.emplace_back(kNoLog);
  diagnostics.error(Code::kUnknownName, "--log", fmt::format("'{}' is not a level", level),
                    nearest_choice(level, names));
}

/// The products of a run replace neither what it reads nor each other.
void check_products(const RunArguments& arguments, std::vector<std::filesystem::path> inputs,
                    Diagnostics& diagnostics) {
  if (!arguments.site.empty()) inputs.emplace_back(arguments.site);
  if (!arguments.record.empty()) diagnostics.append(check_output(arguments.record, inputs, "--record"));
  if (!arguments.video.empty()) diagnostics.append(check_output(arguments.video, inputs, "--video"));
  const auto same = [](const std::filesystem::path& a, const std::filesystem::path& b) {
    return std::filesystem::absolute(a).lexically_normal() == std::filesystem::absolute(b).lexically_normal();
  };
  if (!arguments.record.empty() && !arguments.video.empty() && same(arguments.record, arguments.video))
    diagnostics.error(Code::kConflict, "--record", fmt::format("'{}' is the file of --video too", arguments.record),
                      "Choose another name");
}

/// The site file, and what the command line says over it.
cell::Site parse_site(const RunArguments& arguments, Diagnostics& diagnostics) {
  cell::Site site;
  if (!arguments.site.empty()) {
    auto read = cell::read_site(arguments.site);
    if (read) {
      site = std::move(*read);
    } else {
      diagnostics.append(read.error());
    }
  }
  for (const std::string& backend : arguments.backends) diagnostics.append(cell::bind(site, backend));
  if (arguments.speed_override) site.speed_override = arguments.speed_override;
  diagnostics.append(cell::check_clocks(site, arguments.realtime));
  return site;
}

void show_progress(double sim_time, double planned, const std::string& step) {
  const double share = planned > 0 ? std::min(1.0, sim_time / planned) : 0.0;
  const int filled = static_cast<int>(share * 24);
  fmt::print(stderr, "\r\033[K[{:<24}] {:6.2f} s  {}", std::string(static_cast<std::size_t>(filled), '#'), sim_time,
             step);
  std::fflush(stderr);
}

/// A line every ten seconds, for logs: how far it is, and about how long the rest takes at the pace so far.
class ProgressLines {
 public:
  void operator()(double sim_time, double planned, const std::string& step) {
    using Seconds = std::chrono::duration<double>;
    const auto now = Clock::now();
    if (now - told_ < kEvery) return;
    told_ = now;
    const double taken = Seconds(now - begin_).count();
    std::string rest;
    if (sim_time > 0 && planned > sim_time)
      rest = fmt::format(" of about {:.0f} s; about {:.0f} s to go", planned, taken * (planned - sim_time) / sim_time);
    fmt::print(stderr, "progress: {:.1f} s{}; {}\n", sim_time, rest, step);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kEvery{10};
  Clock::time_point begin_ = Clock::now(), told_ = begin_;
};

bool on_terminal() { return isatty(STDERR_FILENO) != 0; }

}  // namespace

std::vector<cell::Override> parse_sets(const std::vector<std::string>& sets, Diagnostics& diagnostics) {
  std::vector<cell::Override> overrides;
  for (const std::string& set : sets) {
    const std::size_t equals = set.find('=');
    if (equals == std::string::npos || set[0] != '/') {
      diagnostics.error(Code::kInvalidValue, "--set", fmt::format("'{}' is not JSON_POINTER=VALUE", set),
                        "Write it as in --set /devices/arm/model=NAME");
      continue;
    }
    overrides.push_back({set.substr(0, equals), set.substr(equals + 1)});
  }
  return overrides;
}

void add_film_view_options(CLI::App& parser, FilmViewArguments& arguments) {
  parser.add_option("--eye", arguments.eye, "A camera that no file has: where it is, m in world, with --look-at")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->allow_extra_args(false);
  parser.add_option("--look-at", arguments.look_at, "The point that this camera looks at, m in world")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->allow_extra_args(false);
  parser
      .add_option("--show", arguments.show,
                  "Marks of the film, instead of the scenario's: traces, beams, forces, commanded, frames")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false);
}

std::optional<sim::FreeCamera> parse_view(const FilmViewArguments& arguments, Diagnostics& diagnostics) {
  if (arguments.eye.empty() && arguments.look_at.empty()) return std::nullopt;
  if (arguments.eye.size() != 3 || arguments.look_at.size() != 3) {
    diagnostics.error(Code::kRequires, arguments.eye.empty() ? "--look-at" : "--eye",
                      "a camera has a point where it is and one that it looks at",
                      "Give both: --eye X,Y,Z --look-at X,Y,Z");
    return std::nullopt;
  }
  std::array<double, 3> eye{}, target{};
  std::ranges::copy(arguments.eye, eye.begin());
  std::ranges::copy(arguments.look_at, target.begin());
  const auto usable = [](double v) { return std::isfinite(v) && std::abs(v) < 1e6; };
  if (!std::ranges::all_of(eye, usable) || !std::ranges::all_of(target, usable)) {
    diagnostics.error(Code::kOutOfRange, "--eye", "a camera so far away", "Use numbers below 1e6 m");
    return std::nullopt;
  }
  const double distance = std::hypot(eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]);
  if (distance < 1e-6) {
    diagnostics.error(Code::kInvalidValue, "--look-at", "the camera is at the point that it looks at",
                      "Choose another point");
    return std::nullopt;
  }
  return sim::camera_from(eye, target);
}

void add_run_options(CLI::App& parser, RunArguments& arguments) {
  parser.add_option("--video", arguments.video, "Film of the run (MP4, H.264)")->type_name("OUT.mp4");
  parser.add_option("--video-from", arguments.video_from, "The film begins at this simulated time, s")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  parser.add_option("--video-to", arguments.video_to, "The film ends at this simulated time, s")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  parser
      .add_option("--camera", arguments.camera,
                  "Camera of the film; without it the scenario's cuts; fit: one that fits the cell")
      ->type_name("NAME");
  add_film_view_options(parser, arguments.film);
  parser.add_option("--size", arguments.size, "Size of the film")->type_name("WxH")->capture_default_str();
  parser.add_option("--fps", arguments.fps, "Pictures per second of the film")->capture_default_str();
  parser.add_option("--record", arguments.record, "Recording of the run (MCAP)")->type_name("OUT.mcap");
  parser
      .add_option("--record-last", arguments.record_last,
                  "Keep only so many seconds of the recording, and write them if something goes wrong")
      ->type_name("S")
      ->check(CLI::Range(0.1, 3600.0));
  parser.add_flag("--record-blocks", arguments.record_blocks, "Record the digest of each block, too");
  parser
      .add_option("--log", arguments.log,
                  "What is reported on stderr while it runs: debug, info, warning, error, or none")
      ->type_name("LEVEL")
      ->capture_default_str();
  parser.add_option("--site", arguments.site, "Site file: back ends of the devices")->type_name("FILE");
  parser
      .add_option("--backend", arguments.backends,
                  "Back end of one device (sim, slow, fri, rtde, cia402), over the site file")
      ->type_name("NAME=KIND[:ADDR]")
      ->allow_extra_args(false);
  parser
      .add_option("--speed-override", arguments.speed_override,
                  "Share of the planned speed with which the run begins; default 1, on hardware 0.25")
      ->type_name("SHARE")
      ->check(CLI::Range(0.01, 1.0));
  parser.add_flag("--realtime", arguments.realtime, "Not faster than the wall clock");
  parser.add_option("--seed", arguments.seed, "Seed, instead of the file's")->type_name("N");
  parser.add_option("--set", arguments.sets, "Change one value of the file; several times")
      ->type_name("JSON_POINTER=VALUE")
      ->allow_extra_args(false);
}

ParsedRun parse(const RunArguments& arguments, const std::vector<std::filesystem::path>& inputs,
                Diagnostics& diagnostics) {
  ParsedRun parsed;
  if (!parse_size(arguments.size, parsed.run.width, parsed.run.height)) {
    diagnostics.error(Code::kInvalidValue, "--size", fmt::format("'{}' is not a size", arguments.size),
                      "Write WIDTHxHEIGHT, e.g. 1280x720");
  }
  if (arguments.fps < 1 || arguments.fps > sim::kMostFps) {
    diagnostics.error(Code::kOutOfRange, "--fps", fmt::format("{} pictures per second", arguments.fps),
                      fmt::format("Choose 1 to {}", sim::kMostFps));
  }
  if (arguments.video_from > 0.0 && arguments.video.empty())
    diagnostics.error(Code::kRequires, "--video-from", "there is no film that could begin then", "Add --video OUT.mp4");
  if (arguments.video_to && arguments.video.empty())
    diagnostics.error(Code::kRequires, "--video-to", "there is no film that could end then", "Add --video OUT.mp4");
  if (arguments.video_to && *arguments.video_to < arguments.video_from)
    diagnostics.error(Code::kOutOfRange, "--video-to",
                      fmt::format("{:g} s is before {:g} s", *arguments.video_to, arguments.video_from),
                      "Give a time after --video-from");
  if (arguments.record_last && arguments.record.empty())
    diagnostics.error(Code::kRequires, "--record-last", "there is no recording that could be so long",
                      "Add --record OUT.mcap");
  check_log_level(arguments.log, diagnostics);
  check_products(arguments, inputs, diagnostics);
  parsed.open.overrides = parse_sets(arguments.sets, diagnostics);
  parsed.open.seed = parse_seed(arguments.seed, diagnostics);
  parsed.open.measure_times = true;
  parsed.open.realtime = arguments.realtime;
  parsed.open.site = parse_site(arguments, diagnostics);
  parsed.run.video = arguments.video;
  parsed.run.video_from = arguments.video_from;
  if (arguments.video_to) parsed.run.video_to = *arguments.video_to;
  parsed.run.view = parse_view(arguments.film, diagnostics);
  parsed.run.show = arguments.film.show;
  parsed.run.camera = arguments.camera;
  parsed.run.fps = arguments.fps;
  parsed.run.record = arguments.record;
  parsed.run.record_last = arguments.record_last.value_or(0.0);
  parsed.run.record_blocks = arguments.record_blocks;
  parsed.run.realtime = arguments.realtime;
  constexpr Nanoseconds kStuck = 10 * kSecond;  // far above the longest cycle of a busy machine
  parsed.run.watchdog = is_traced() ? 0 : kStuck;
  return parsed;
}

void log_on_stderr(std::string_view level, cell::RunOptions& options) {
  const auto least = cell::log_level_named(level);
  if (!least) return;
  options.tell = [least = *least](const cell::LogEntry& entry) {
    if (entry.level < least) return;
    clear_progress();
    fmt::print(stderr, "{}\n", to_text(entry));
  };
}

void show_progress_of(cell::RunOptions& options) {
  if (on_terminal()) {
    options.progress = show_progress;
  } else {
    options.progress = ProgressLines();
  }
}

void clear_progress() {
  if (on_terminal()) fmt::print(stderr, "\r\033[K");
}

bool parse_size(std::string_view text, int& width, int& height) {
  const std::size_t cross = text.find('x');
  return cross != std::string_view::npos && parse_whole(text.substr(0, cross), width) &&
         parse_whole(text.substr(cross + 1), height);
}

Diagnostics check_model_folders(const std::vector<std::string>& folders) {
  Diagnostics diagnostics;
  std::error_code ignored;
  for (const std::string& folder : folders) {
    if (!std::filesystem::is_directory(folder, ignored))
      diagnostics.error(Code::kNotFound, "--models", fmt::format("'{}' is not a folder", folder),
                        "Name a folder with a folder per model");
  }
  return diagnostics;
}

cell::StepAnswer ask_on_terminal(const cell::NextStep& next) {
  for (const std::string& variable : next.changed) fmt::print(stderr, "            {}\n", variable);
  fmt::print(stderr, "{:9.3f} s  next: {}{}\n", next.sim_time, next.name,
             next.pointer.empty() ? std::string() : fmt::format(" ({})", next.pointer));
  std::string line;
  while (std::getline(std::cin, line)) {
    if (line.empty()) return cell::StepAnswer::kNext;
    if (line == "c") return cell::StepAnswer::kContinue;
    if (line == "q") return cell::StepAnswer::kCancel;
    fmt::print(stderr, "Enter: this step; c: go on without stops; q: cancel\n");
  }
  return cell::StepAnswer::kCancel;
}

}  // namespace takt::app
