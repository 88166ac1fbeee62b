#pragma once

#include <string>
#include <vector>

#include "record/comparison.h"
#include "record/recording.h"

namespace takt::record {

/// The events of a program that say when its steps begin and end.
struct StepEvent {
  Nanoseconds time = 0;
  std::string name;  ///< "begin", "end", "failed"; others are skipped
  std::string step;  ///< its path
};
[[nodiscard]] std::vector<StepEvent> step_events(const Recording& recording);

/// Durations of all steps, side by side; a path that runs several times is counted. Steps that have not ended when
/// their run does last until `end_a`, `end_b`. @param window  within which durations count as the same
[[nodiscard]] std::vector<StepDuration> compare_durations(const std::vector<StepEvent>& a,
                                                          const std::vector<StepEvent>& b, Nanoseconds end_a,
                                                          Nanoseconds end_b, Nanoseconds window);

/// Fills `departure` of a comparison that has been judged and has not passed: the earliest time at which a column is
/// outside, or at which a step that took another time should have ended. Of columns that leave at the same time what
/// was commanded comes first.
void find_departure(Comparison& comparison);

}  // namespace takt::record
