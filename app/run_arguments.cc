#include "app/run_arguments.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace takt::app {
namespace {

std::atomic<int> interrupts = 0;

void count_interrupt(int) { interrupts.fetch_add(1); }

bool parse_size(const std::string& text, scenario::RunOptions& options) {
  int width = 0, height = 0, used = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &width, &height, &used) != 2) return false;
  if (used != static_cast<int>(text.size())) return false;
  options.width = width;
  options.height = height;
  return true;
}

std::vector<scenario::Override> parse_sets(const std::vector<std::string>& sets, Findings& findings) {
  std::vector<scenario::Override> overrides;
  for (const std::string& set : sets) {
    const std::size_t equals = set.find('=');
    if (equals == std::string::npos || set[0] != '/') {
      findings.error("--set", fmt::format("'{}' is not JSON_POINTER=VALUE", set), "--set /devices/arm/model=NAME");
      continue;
    }
    overrides.push_back({set.substr(0, equals), set.substr(equals + 1)});
  }
  return overrides;
}

/// The site file, and what the command line says over it.
scenario::Site parse_site(const RunArguments& arguments, Findings& findings) {
  scenario::Site site;
  if (!arguments.site.empty()) {
    auto read = scenario::read_site(arguments.site);
    if (read) {
      site = std::move(*read);
    } else {
      findings.append(read.error());
    }
  }
  for (const std::string& backend : arguments.backends) findings.append(scenario::bind(site, backend));
  findings.append(scenario::check_clocks(site, arguments.realtime));
  return site;
}

void show_progress(double sim_time, double planned, const std::string& step) {
  const double share = planned > 0 ? std::min(1.0, sim_time / planned) : 0.0;
  const int filled = static_cast<int>(share * 24);
  fmt::print(stderr, "\r\033[K[{:<24}] {:6.2f} s  {}", std::string(static_cast<std::size_t>(filled), '#'), sim_time,
             step);
  std::fflush(stderr);
}

bool on_terminal() { return isatty(STDERR_FILENO) != 0; }

}  // namespace

void add_run_options(CLI::App& parser, RunArguments& arguments) {
  parser.add_option("--video", arguments.video, "Film of the run (MP4, H.264)")->type_name("OUT.mp4");
  parser.add_option("--camera", arguments.camera, "Camera of the film; without it the scenario's cuts")
      ->type_name("NAME");
  parser.add_option("--size", arguments.size, "Size of the film")->type_name("WxH")->capture_default_str();
  parser.add_option("--fps", arguments.fps, "Pictures per second of the film")->capture_default_str();
  parser.add_option("--record", arguments.record, "Recording of the run (MCAP)")->type_name("OUT.mcap");
  parser.add_flag("--record-blocks", arguments.record_blocks, "Record the digest of each block, not of the whole only");
  parser.add_option("--site", arguments.site, "Site file: back ends of the devices")->type_name("FILE");
  parser.add_option("--backend", arguments.backends, "Back end of one device (sim, slow), over the site file")
      ->type_name("NAME=KIND[:ADDR]");
  parser.add_flag("--realtime", arguments.realtime, "Not faster than the wall clock");
  parser.add_option("--seed", arguments.seed, "Seed in place of the file's");
  parser.add_option("--set", arguments.sets, "Change one value of the file")->type_name("JSON_POINTER=VALUE");
}

ParsedRun parse(const RunArguments& arguments, Findings& findings) {
  ParsedRun parsed;
  if (!parse_size(arguments.size, parsed.run)) {
    findings.error("--size", fmt::format("'{}' is no size", arguments.size), "WIDTHxHEIGHT, e.g. 1280x720");
  }
  parsed.open.overrides = parse_sets(arguments.sets, findings);
  parsed.open.seed = arguments.seed;
  parsed.open.measure_times = true;
  parsed.open.site = parse_site(arguments, findings);
  parsed.run.video = arguments.video;
  parsed.run.camera = arguments.camera;
  parsed.run.fps = arguments.fps;
  parsed.run.record = arguments.record;
  parsed.run.record_blocks = arguments.record_blocks;
  parsed.run.realtime = arguments.realtime;
  return parsed;
}

void show_progress_on_terminal(scenario::RunOptions& options) {
  if (on_terminal()) options.progress = show_progress;
}

void clear_progress() {
  if (on_terminal()) fmt::print(stderr, "\r\033[K");
}

const std::atomic<int>& catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = count_interrupt;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return interrupts;
}

}  // namespace takt::app
