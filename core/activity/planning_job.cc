#include "core/activity/planning_job.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include <fmt/format.h>

#include "core/activity/mode_change.h"
#include "core/activity/motion_collisions.h"
#include "core/base/last_catch.h"

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

std::unique_ptr<const expression::Cell> copy_of(const expression::Cell& cell) {
  auto copy = std::make_unique<expression::Cell>(cell);
  for (auto& [name, arm] : copy->arms) arm.told = {arm.set_point(), arm.tool(), arm.mode()};
  return copy;
}

}  // namespace

PlanningJob::PlanningJob(rcc::ControlCore& core, ActivityPtr model, PlanningContext planning, Cell cell)
    : core_(core),
      model_(std::move(model)),
      cell_(cell == Cell::kCopied ? copy_of(planning.cell) : nullptr),
      planning_{.cell = cell_ ? *cell_ : planning.cell,
                .period = planning.period,
                .predecessors = std::move(planning.predecessors),
                .checks_collisions = planning.checks_collisions,
                .beside = std::move(planning.beside)} {}

PlanningJob::~PlanningJob() {
  if (net_ != 0) (void)core_.unload(net_);
}

void PlanningJob::carry_out() noexcept {
  try {
    carry_out_or_throw();
  } catch (...) {
    (void)run_caught("report an exception", [this, text = exception_text()] {
      diagnostics_.error(Code::kInternal, "", fmt::format("planning of '{}' ended with: {}", model_->name(), text));
    });
  }
  done_.store(true, std::memory_order_release);
}

void PlanningJob::carry_out_or_throw() {
  const double begin = cpu_seconds();
  diagnostics_ = plan();
  planning_time_ = cpu_seconds() - begin;
  if (!diagnostics_.has_errors()) diagnostics_ = load();
  total_time_ = cpu_seconds() - begin;
}

Diagnostics PlanningJob::plan() {
  auto planned = model_->prepare(planning_);
  const auto leaves = [](const auto& one) { return one.second.leaving.has_value(); };
  const auto wanted = static_cast<std::size_t>(std::ranges::count_if(planning_.predecessors, leaves));
  if (planned && wanted > 0 && planned->taken_over.size() != wanted) {
    // All or nothing: it waits for what cannot be taken over together.
    for (auto& [name, predecessor] : planning_.predecessors) predecessor.leaving.reset();
    planned = model_->prepare(planning_);
  }
  if (!planned) return std::move(planned.error());
  if (Diagnostics wrong = agree_on_modes(*planned, planning_); wrong.has_errors()) return wrong;
  if (Diagnostics wrong = find_collisions(*planned, planning_, model_->name()); wrong.has_errors()) return wrong;
  planned_ = std::move(*planned);
  return {};
}

Diagnostics PlanningJob::load() {
  if (!planned_.command && !planned_.net) return {};  // nothing but a change of control modes
  auto mapped = mapped_net(planned_, model_->name(), core_.period());
  if (!mapped) return std::move(mapped.error());
  mapped_ = std::move(*mapped);
  auto id = core_.load(mapped_.net, mapped_.options);
  if (!id) return std::move(id.error());
  net_ = *id;
  return {};
}

}  // namespace takt::activity
