#include "cell/judge/run_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json_numbers.h"
#include "core/base/text_location.h"

namespace takt::cell {

using Json = nlohmann::ordered_json;

int exit_status(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPassed:
      return 0;
    case Verdict::kFailed:
      return 1;
    case Verdict::kRefused:
      return 2;
    case Verdict::kError:
      return 3;
    case Verdict::kInterrupted:
      return 130;
  }
  return 3;
}

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPassed:
      return "passed";
    case Verdict::kFailed:
      return "failed";
    case Verdict::kRefused:
    case Verdict::kError:
      return "error";
    case Verdict::kInterrupted:
      return "interrupted";
  }
  return "error";
}

Json to_json(Diagnostics diagnostics) {
  locate(diagnostics);
  auto list = Json::array();
  for (const Diagnostic& diagnostic : diagnostics.list()) {
    const char* severity = diagnostic.severity == Severity::kError     ? "error"
                           : diagnostic.severity == Severity::kWarning ? "warning"
                                                                       : "note";
    list.push_back({{"severity", severity},
                    {"code", name_of(diagnostic.code)},
                    {"file", diagnostic.file},
                    {"line", diagnostic.line > 0 ? Json(diagnostic.line) : Json()},
                    {"column", diagnostic.line > 0 ? Json(diagnostic.column) : Json()},
                    {"pointer", diagnostic.pointer},
                    {"message", diagnostic.message},
                    {"hint", diagnostic.hint}});
  }
  return list;
}

std::string to_output_text(Json report) {
  // Until 1.0 the list has its former name as well: programs that read reports know it.
  if (report.contains("diagnostics")) report["findings"] = report["diagnostics"];
  return without_noise(std::move(report)).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

namespace {

Json site_json(const SiteReport& site) {
  Json devices = Json::object();
  for (const DeviceTiming& one : site.devices) {
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
  Json realities = Json::object();
  for (const auto& [name, reality] : site.realities) realities[name] = device::name_of(reality);
  Json reactions = Json::array();
  for (const SiteReaction& one : site.reactions) {
    reactions.push_back({{"sensor", one.sensor}, {"arm", one.arm}, {"most_ns", one.most}});
  }
  Json master;
  if (site.master) {
    master = {
        {"device", site.master->device},
        {"cycles", site.master->cycles},
        {"off_ns", {{"p50", site.master->off_p50}, {"p99", site.master->off_p99}, {"worst", site.master->off_worst}}}};
  }
  return {{"realities", std::move(realities)},
          {"devices", std::move(devices)},
          {"master_clock", std::move(master)},
          {"skew_ns", site.skew},
          {"reactions", std::move(reactions)}};
}

}  // namespace

Json to_json(const RunReport& report) {
  const auto lateness = [](const RealtimeReport::Lateness& late) -> Json {
    return {{"p50_ns", late.p50}, {"p99_ns", late.p99}, {"p999_ns", late.p999}, {"worst_ns", late.worst}};
  };
  Json realtime;
  if (report.realtime) {
    realtime = {{"realtime_scheduling", report.realtime->realtime_scheduling},
                {"locked_memory", report.realtime->locked_memory},
                {"processor", report.realtime->processor >= 0 ? Json(report.realtime->processor) : Json()},
                {"wakeups", lateness(report.realtime->wakeups)},
                {"begins", lateness(report.realtime->begins)},
                {"cycles_unseen", report.realtime->cycles_unseen},
                {"cycles_not_recorded", report.realtime->cycles_not_recorded}};
  }
  Json expectations = Json::array();
  for (const auto& result : report.expectations) {
    expectations.push_back({{"name", result.name},
                            {"kind", result.kind},
                            {"passed", result.passed},
                            {"judged", result.judged},
                            {"value", result.value},
                            {"unit", result.unit},
                            {"lower", result.lower ? Json(*result.lower) : Json()},
                            {"upper", result.upper ? Json(*result.upper) : Json()},
                            {"measured", result.measured}});
  }
  Json estimates = Json::object();
  for (const auto& [name, X] : report.estimates) {
    const Eigen::Quaterniond q(X.linear());
    estimates[name] = {{"position_m", {X.translation().x(), X.translation().y(), X.translation().z()}},
                       {"quaternion", {q.w(), q.x(), q.y(), q.z()}}};
  }
  Json reactions = Json::array();
  for (const activity::Reaction& one : report.reactions) {
    reactions.push_back({{"activity", one.activity},
                         {"event", one.event},
                         {"event_cycle", one.event_cycle},
                         {"braking_cycle", one.braking_cycle},
                         {"certified_cycles", {{"least", one.least}, {"most", one.most}}}});
  }
  Json events = Json::array();
  for (const LogEntry& entry : report.log) events.push_back(to_json(entry));
  const Timing& t = report.timing;
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
          {"realtime", std::move(realtime)},
          {"site", site_json(report.site)},
          {"frames", report.frames},
          {"reactions", std::move(reactions)},
          {"lines", report.lines},
          {"events", std::move(events)},
          {"events_omitted", report.log_omitted},
          {"products", report.products},
          {"diagnostics", to_json(report.diagnostics)}};
}

std::string to_text(const RunReport& report, const std::string& title) {
  std::string text = fmt::format("{}: {}\n", title, name_of(report.verdict));
  for (const auto& result : report.expectations) {
    const char* mark = result.passed ? "ok  " : result.judged ? "FAIL" : "open";
    text += fmt::format("  {} {:<28} {}\n", mark, result.name, result.measured);
  }
  text += fmt::format("  {:.3f} s simulated in {:.3f} s ({:.1f} times real time), {} cycles, digest {}\n",
                      report.sim_time, report.wall_time,
                      report.wall_time > 0 ? report.sim_time / report.wall_time : 0.0, report.cycles, report.digest);
  if (report.realtime) {
    const RealtimeReport& real = *report.realtime;
    const auto us = [](Nanoseconds time) { return 1e-3 * static_cast<double>(time); };
    text += fmt::format(
        "  real time: wake-ups {:.0f} us late (median), {:.0f} us (99.9 %), {:.0f} us (worst); {} overruns; "
        "scheduling {}, memory {}\n",
        us(real.wakeups.p50), us(real.wakeups.p999), us(real.wakeups.worst), report.overruns,
        real.realtime_scheduling ? "real-time" : "ordinary (takt doctor)",
        real.locked_memory ? "locked" : "not locked");
  }
  if (!report.site.realities.empty()) text += fmt::format("  devices: {}\n", to_text(report.site.realities));
  if (const auto& master = report.site.master) {
    text += fmt::format("  paced by the clock of {}: {} cycles, {:.0f} us off (99 %), {:.0f} us (worst)\n",
                        master->device, master->cycles, 1e-3 * static_cast<double>(master->off_p99),
                        1e-3 * static_cast<double>(master->off_worst));
  }
  for (const DeviceTiming& one : report.site.devices) {
    if (!one.drives || one.declared.cycle == 0) continue;
    if (one.delay_most == 0) {
      text +=
          fmt::format("  {} ({}): cycle {:g} ms, set points {:.3f} ms late as declared, samples up to {:.3f} ms old\n",
                      one.device, one.backend, 1e-6 * static_cast<double>(one.declared.cycle),
                      1e-6 * static_cast<double>(one.declared.driver_delay + one.declared.dead_time),
                      1e-6 * static_cast<double>(one.sample_age_most));
      continue;
    }
    text += fmt::format("  {} ({}): cycle {:g} ms, set points {:.3f} to {:.3f} ms late, samples up to {:.3f} ms old\n",
                        one.device, one.backend, 1e-6 * static_cast<double>(one.declared.cycle),
                        1e-6 * static_cast<double>(one.delay_least), 1e-6 * static_cast<double>(one.delay_most),
                        1e-6 * static_cast<double>(one.sample_age_most));
  }
  for (const std::string& product : report.products) text += fmt::format("  wrote {}\n", product);
  return text;
}

}  // namespace takt::cell
