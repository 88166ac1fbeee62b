#include "tools/run_verb.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

std::atomic<int> interrupts = 0;

void count_interrupt(int) { interrupts.fetch_add(1); }

struct RunArguments {
  std::string file, video, camera, size = "1280x720", record, from;
  int fps = 25;
  bool dry_run = false, realtime = false, record_blocks = false;
  std::uint64_t seed = 0;
  CLI::Option* seed_option = nullptr;
  std::vector<std::string> sets;
  std::string site;
  std::vector<std::string> backends;
};

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

/// A bar that is drawn over itself; only for terminals.
void show_progress(double sim_time, double planned, const std::string& step) {
  const double share = planned > 0 ? std::min(1.0, sim_time / planned) : 0.0;
  const int filled = static_cast<int>(share * 24);
  fmt::print(stderr, "\r\033[K[{:<24}] {:6.2f} s  {}", std::string(static_cast<std::size_t>(filled), '#'), sim_time,
             step);
  std::fflush(stderr);
}

int dry_run(const scenario::Session& session, const Common& common) {
  const auto& description = session.description();
  if (common.json) {
    print({{"result", "valid"},
           {"title", description.title},
           {"planned_duration", session.planned_duration()},
           {"steps", session.program().step_count()},
           {"devices", description.devices.size()},
           {"objects", description.objects.size()},
           {"triangles", session.built().triangles},
           {"findings", to_json(session.warnings())}});
    return kHeld;
  }
  fmt::print("{}\n", description.title);
  for (const auto& device : description.devices) fmt::print("  device {:<12} {}\n", device.name, device.model);
  for (const auto& object : description.objects) fmt::print("  object {}\n", object.name);
  fmt::print("  {} steps, about {:.1f} s, {} triangles; nothing was moved\n", session.program().step_count(),
             session.planned_duration(), session.built().triangles);
  return kHeld;
}

int run(const RunArguments& arguments, const Common& common) {
  Findings findings;
  scenario::RunOptions options;
  if (!parse_size(arguments.size, options)) {
    findings.error("--size", fmt::format("'{}' is no size", arguments.size), "WIDTHxHEIGHT, e.g. 1280x720");
  }
  scenario::OpenOptions opening{parse_sets(arguments.sets, findings), {}, true, parse_site(arguments, findings)};
  if (findings.has_errors()) return report(findings, common);
  if (arguments.seed_option->count() > 0) opening.seed = arguments.seed;
  const device::ModelLibrary library = common.library();
  auto session = scenario::Session::open(arguments.file, library, opening);
  if (!session) return report(session.error(), common);
  fmt::print(stderr, "{}", (*session)->warnings().to_string());
  if (arguments.dry_run) return dry_run(**session, common);

  options.video = arguments.video;
  options.camera = arguments.camera;
  options.fps = arguments.fps;
  options.record = arguments.record;
  options.realtime = arguments.realtime;
  options.from = arguments.from;
  options.record_blocks = arguments.record_blocks;
  options.interrupt = &catch_interrupts();
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal) options.progress = show_progress;
  const scenario::RunReport report = (*session)->run(options);
  if (terminal) fmt::print(stderr, "\r\033[K");
  fmt::print(stderr, "{}", report.findings.to_string());
  if (common.json) {
    print(to_json(report));
  } else if (report.verdict != scenario::Verdict::kRefused) {
    fmt::print("{}", to_text(report, (*session)->description().title));
  }
  return exit_status(report.verdict);
}

}  // namespace

const std::atomic<int>& catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = count_interrupt;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return interrupts;
}

int exit_status(scenario::Verdict verdict) {
  switch (verdict) {
    case scenario::Verdict::kPassed:
      return kHeld;
    case scenario::Verdict::kFailed:
      return kNotHeld;
    case scenario::Verdict::kRefused:
      return kBadInput;
    case scenario::Verdict::kError:
      return kFault;
    case scenario::Verdict::kInterrupted:
      return kInterrupted;
  }
  return kFault;
}

Json to_json(const scenario::SiteReport& site) {
  Json devices = Json::object();
  for (const scenario::DeviceTiming& one : site.devices) {
    Json& device = devices[one.device];
    device = {{"backend", one.backend},
              {"cycle_ns", one.declared.cycle},
              {"sample_age_ns", {{"declared", one.declared.sample_age}, {"most", one.sample_age_most}}},
              {"samples", {{"lost", one.lost}, {"repeated", one.repeated}, {"reordered", one.reordered}}},
              {"drift_ppm", one.drift_ppm}};
    if (!one.drives) continue;
    device["driver_delay_ns"] = one.declared.driver_delay;
    device["dead_time_ns"] = one.declared.dead_time;
    device["delay_ns"] = {{"least", one.delay_least}, {"most", one.delay_most}};
    device["missed_answers"] = one.missed_answers;
    device["dry"] = one.dry;
  }
  Json reactions = Json::array();
  for (const scenario::SiteReaction& one : site.reactions) {
    reactions.push_back({{"sensor", one.sensor}, {"arm", one.arm}, {"most_ns", one.most}});
  }
  return {{"devices", std::move(devices)}, {"skew_ns", site.skew}, {"reactions", std::move(reactions)}};
}

Json to_json(const scenario::RunReport& report) {
  Json expectations = Json::array();
  for (const auto& result : report.expectations) {
    expectations.push_back({{"name", result.name},
                            {"kind", result.kind},
                            {"passed", result.passed},
                            {"value", result.value},
                            {"measured", result.measured}});
  }
  Json estimates = Json::object();
  for (const auto& [name, X] : report.estimates) {
    const Eigen::Quaterniond q(X.linear());
    estimates[name] = {{"position_m", {X.translation().x(), X.translation().y(), X.translation().z()}},
                       {"quaternion", {q.w(), q.x(), q.y(), q.z()}}};
  }
  const scenario::Timing& t = report.timing;
  return {{"result", name_of(report.verdict)},
          {"sim_time", report.sim_time},
          {"wall_time", report.wall_time},
          {"cycles", report.cycles},
          {"digest", report.digest},
          {"expectations", std::move(expectations)},
          {"estimates", std::move(estimates)},
          {"timing",
           {{"physics", t.physics},
            {"controller", t.controller},
            {"core", t.core},
            {"program", t.program},
            {"digest", t.digest},
            {"rendering", t.rendering},
            {"recording", t.recording},
            {"core_ns_per_cycle", report.core_ns_per_cycle},
            {"core_ns_longest", report.core_ns_longest},
            {"overruns", report.overruns}}},
          {"site", to_json(report.site)},
          {"frames", report.frames},
          {"products", report.products},
          {"findings", to_json(report.findings)}};
}

std::string to_text(const scenario::RunReport& report, const std::string& title) {
  std::string text = fmt::format("{}: {}\n", title, name_of(report.verdict));
  for (const auto& result : report.expectations) {
    text += fmt::format("  {} {:<28} {}\n", result.passed ? "ok  " : "FAIL", result.name, result.measured);
  }
  text += fmt::format("  {:.3f} s simulated in {:.3f} s ({:.1f} times real time), {} cycles, digest {}\n",
                      report.sim_time, report.wall_time,
                      report.wall_time > 0 ? report.sim_time / report.wall_time : 0.0, report.cycles, report.digest);
  for (const scenario::DeviceTiming& one : report.site.devices) {
    if (!one.drives || one.declared.cycle == 0) continue;
    text += fmt::format("  {} ({}): cycle {:g} ms, set points {:.3f} to {:.3f} ms late, samples up to {:.3f} ms old\n",
                        one.device, one.backend, 1e-6 * static_cast<double>(one.declared.cycle),
                        1e-6 * static_cast<double>(one.delay_least), 1e-6 * static_cast<double>(one.delay_most),
                        1e-6 * static_cast<double>(one.sample_age_most));
  }
  for (const std::string& product : report.products) text += fmt::format("  wrote {}\n", product);
  return text;
}

std::pair<CLI::App*, Verb> add_run(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* verb = app.add_subcommand("run", "Run a scenario file: a verdict, and a film and a recording if asked for");
  verb->add_option("FILE", arguments->file, "Scenario file")->required();
  verb->add_option("--video", arguments->video, "Film of the run (MP4, H.264)")->type_name("OUT.mp4");
  verb->add_option("--camera", arguments->camera, "Camera of the film; without it the scenario's cuts")
      ->type_name("NAME");
  verb->add_option("--size", arguments->size, "Size of the film")->type_name("WxH")->capture_default_str();
  verb->add_option("--fps", arguments->fps, "Pictures per second of the film")->capture_default_str();
  verb->add_option("--record", arguments->record, "Recording of the run (MCAP)")->type_name("OUT.mcap");
  verb->add_flag("--record-blocks", arguments->record_blocks, "Record the digest of each block, not of the whole only");
  verb->add_option("--from", arguments->from, "Begin at the step of this name")->type_name("NAME");
  verb->add_option("--site", arguments->site, "Site file: back ends of the devices")->type_name("FILE");
  verb->add_option("--backend", arguments->backends, "Back end of one device (sim, slow), over the site file")
      ->type_name("NAME=KIND[:ADDR]");
  verb->add_flag("--realtime", arguments->realtime, "Not faster than the wall clock");
  verb->add_flag("--dry-run", arguments->dry_run, "Check, build, plan; move nothing");
  arguments->seed_option = verb->add_option("--seed", arguments->seed, "Seed in place of the file's");
  verb->add_option("--set", arguments->sets, "Change one value of the file")->type_name("JSON_POINTER=VALUE");
  return {verb, [arguments, &common] { return run(*arguments, common); }};
}

}  // namespace takt::tools
