#include "core/operations/motion/motion_verdict.h"

#include <fmt/format.h>

#include "core/operations/motion/motion_plan.h"

namespace takt::operations {
namespace {

/// One error at a key of a motion.
void add_error(const MotionPlace& place, const char* key, Code code, const std::string& message, const char* hint,
               Diagnostics& diagnostics) {
  diagnostics.error(code, place.pointer + (place.has_keys ? key : ""), place.prefix + message, hint);
}

constexpr const char* kCheckSensor = "check the sensor's power and wiring";

}  // namespace

Diagnostics motion_verdict(const std::vector<MotionTask>& tasks, const activity::GuardedEnd& end,
                           const MotionPlaces& places) {
  Diagnostics diagnostics;
  if (end.no_force) {
    const std::size_t first = first_offset(tasks).value_or(0);
    add_error(places(static_cast<int>(first)), "/force_offset/sensor", Code::kSensorSilent,
              fmt::format("'{}' did not answer, so the arm stopped on its path", tasks[first].force_offset->sensor),
              kCheckSensor, diagnostics);
  }
  const auto left = [&](const std::optional<double>& at, const char* key, const char* what, double longest) {
    if (!at) return;
    const auto first = static_cast<int>(first_offset(tasks).value_or(0));
    add_error(
        places(first), key, Code::kConditionNotMet,
        fmt::format("the tool was {} for longer than {:g} s, at {:.0f} % of the path", what, longest, 100.0 * *at),
        "Move more slowly, give the offset more reach and speed, or allow a longer time", diagnostics);
  };
  if (const auto first = first_offset(tasks)) {
    const ForceOffsetParameters& force = *tasks[*first].force_offset;
    left(end.lost, "/force_offset/lost_max_s", "without contact", force.lost_max);
    left(end.off_force, "/force_offset/off_force_max_s", "farther than a tenth from its force",
         force.off_max.value_or(0.0));
  }
  if (end.broken) {
    const MotionPlace place = places(end.broken->motion);
    Diagnostics broken;
    activity::add_abort_diagnostic(end.broken->silent, end.broken->compared,
                                   place.pointer + (place.has_keys ? "/abort_if" : ""), broken);
    for (Diagnostic diagnostic : broken.list()) {
      diagnostic.message.insert(0, place.prefix);
      diagnostics.add(std::move(diagnostic));
    }
  }
  const MotionTask& last = tasks.back();
  if (diagnostics.has_errors() || !last.until) return diagnostics;
  const MotionPlace place = places(static_cast<int>(tasks.size()) - 1);
  using enum activity::GuardedOutcome::Kind;
  if (end.outcome.kind == kSensorSilent)
    add_error(place, "/until", Code::kSensorSilent,
              "a sensor of the condition did not answer, so the arm stopped on its path", kCheckSensor, diagnostics);
  if (end.outcome.kind == kNotTouched && last.must_touch)
    add_error(place, "/until", Code::kConditionNotMet, "the motion reached its end and the condition never held",
              "Move farther, choose another threshold, or set \"on_end\": \"continue\" (must_touch in C++)",
              diagnostics);
  return diagnostics;
}

}  // namespace takt::operations
