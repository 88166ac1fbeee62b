#include "core/activity/run_planner.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include <fmt/format.h>

#include "core/command/mapping.h"

namespace takt::activity {
namespace {

/// CPU time of this thread: the work, whoever else is on the machine; for people, nothing is decided by it.
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What LOAD gets of a planned activity.
Result<command::MappedCommand> mapped_net(const PlannedActivity& planned, const std::string& name, Nanoseconds period) {
  command::MappedCommand mapped;
  if (planned.net) {
    mapped.net = *planned.net;
    return mapped;
  }
  auto made = command::map(*planned.command, period);
  if (!made) return made;
  mapped = std::move(*made);
  mapped.net.name = name;
  // Where the activity itself says how it takes a device over, it knows more than the mapping.
  auto& begins = mapped.options.begins;
  std::erase_if(begins, [&](const rcc::NetSeam& seam) { return planned.begins.contains(seam.device); });
  for (const auto& [device, seams] : planned.begins)
    for (const device::Seam& seam : seams) begins.push_back({device, seam});
  return mapped;
}

}  // namespace

std::expected<bool, RunPlanner::Obstacle> RunPlanner::try_plan(ActivityRun& run, std::span<const RunPtr> runs) {
  const RunsBefore before = StartConditions::runs_before(run, runs);
  if (before.wait || (run.after_all_ && !before.running.empty())) return false;
  const std::string fault = before.running.empty() ? conditions_.fault_of(run) : std::string();
  if (!fault.empty()) {
    Obstacle obstacle{.failure = RunFailure::kFault, .diagnostics = {}};
    obstacle.diagnostics.error(Code::kDeviceFault, "", fmt::format("'{}' was given up: {}", run.name(), fault),
                               "remove the cause, acknowledge the fault, and ask for it again");
    return std::unexpected(std::move(obstacle));
  }
  auto planning = conditions_.planning_context(run, before);
  if (!planning) return false;
  const double begin = cpu_seconds();
  Obstacle obstacle{.failure = RunFailure::kImpossible, .diagnostics = plan(run, *planning)};
  run.preparation_.planning = cpu_seconds() - begin;
  if (!obstacle.diagnostics.has_errors()) obstacle.diagnostics = load(run);
  if (obstacle.diagnostics.has_errors()) return std::unexpected(std::move(obstacle));
  run.preparation_.total = cpu_seconds() - begin;
  if (run.net_ == 0) return true;
  run.rule_ = StartConditions::rule_for(run, before, *planning);
  if (run.rule_) return true;
  run.forget_net();
  run.after_all_ = true;
  return false;
}

Diagnostics RunPlanner::plan(ActivityRun& run, PlanningContext& planning) const {
  auto planned = run.model_->prepare(planning);
  const auto leaves = [](const auto& one) { return one.second.leaving.has_value(); };
  const auto wanted = static_cast<std::size_t>(std::ranges::count_if(planning.predecessors, leaves));
  if (planned && wanted > 0 && planned->taken_over.size() != wanted) {
    // All or nothing: what cannot be taken over together is waited for.
    for (auto& [name, predecessor] : planning.predecessors) predecessor.leaving.reset();
    planned = run.model_->prepare(planning);
  }
  if (!planned) return std::move(planned.error());
  if (Diagnostics wrong = agree_on_modes(*planned, planning); wrong.has_errors()) return wrong;
  run.planned_ = std::move(*planned);
  return {};
}

Diagnostics RunPlanner::load(ActivityRun& run) {
  if (!run.planned_.command && !run.planned_.net) return {};  // nothing but a change of control modes
  auto mapped = mapped_net(run.planned_, run.name(), core_.period());
  if (!mapped) return std::move(mapped.error());
  auto id = core_.load(mapped->net, mapped->options);
  if (!id) return std::move(id.error());
  run.net_ = *id;
  return run.attach(std::move(*mapped));
}

}  // namespace takt::activity
