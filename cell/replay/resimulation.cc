#include "cell/replay/resimulation.h"

#include <utility>

#include <fmt/format.h>

#include "cell/build/site_devices.h"
#include "cell/replay/recorded_run.h"
#include "record/decode.h"

namespace takt::cell {
namespace {

/// The site of the recorded run. What its drivers reached is simulated.
Result<Site> recorded_site(const record::Recording& recording) {
  const auto text = recording.attachment("site.json");
  if (!text) return Site{};
  auto site = parse_site(*text);
  if (site) std::erase_if(site->devices, [](const auto& one) { return one.second.driver != nullptr; });
  return site;
}

}  // namespace

Result<ReopenedRun> ReopenedRun::open(const record::Recording& recording, const device::ModelLibrary& otherwise,
                                      const Options& options) {
  ReopenedRun run;
  auto models = RecordedModels::unpack(recording);
  if (!models) return std::unexpected(std::move(models.error()));
  run.models_ = std::move(*models);
  auto description = recorded_scenario(recording, options.overrides, options.seed);
  if (!description) return std::unexpected(std::move(description.error()));
  auto site = options.site ? Result<Site>(*options.site) : recorded_site(recording);
  if (!site) return std::unexpected(std::move(site.error()));
  description->site = std::move(*site);
  auto session = Session::create(std::move(*description), run.models_ ? run.models_->library() : otherwise);
  if (!session) return std::unexpected(std::move(session.error()));
  run.session_ = std::move(*session);
  run.entry_ = recorded_entry(recording);
  return run;
}

Result<std::int64_t> whole_cycles(const record::Recording& recording) {
  record::DigestCursor cursor(recording);
  std::uint64_t expected = 0;
  for (record::RecordedDigest digest; cursor.next(digest); ++expected) {
    if (digest.cycle == expected) continue;
    return failure(Code::kIncompatible, {},
                   fmt::format("the recording has cycle {} where cycle {} should be", digest.cycle, expected),
                   "Use one with all cycles from the first on, made without --record-last");
  }
  if (expected == 0)
    return failure(Code::kMissing, {}, "there are no cycles in this recording", "Use the recording of a run");
  return static_cast<std::int64_t>(expected);
}

record::CompareOptions states_only() {
  record::CompareOptions options;
  options.topics = {"/*/joint_states", "/*/wrench", "/*/gripper", "/objects", "/tf", "/state"};
  options.rules = {{"/*/gripper", "wanted_*", {.kind = record::ToleranceKind::kReportOnly}}};
  return options;
}

}  // namespace takt::cell
