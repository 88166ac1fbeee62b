// The table by which the scheduler works: complete, and the one that docs/activity-layer.md shows.
#include "core/activity/run_state.h"

#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::activity {
namespace {

constexpr int kStates = 8, kEvents = 8;

TEST(RunState, EveryRowIsThereOnceAndNothingLeavesAFinalState) {
  std::set<std::pair<RunState, RunEvent>> seen;
  for (const RunTransition& row : run_transitions()) {
    EXPECT_TRUE(seen.emplace(row.from, row.event).second) << name_of(row.from) << ", " << name_of(row.event);
    EXPECT_FALSE(is_final(row.from)) << name_of(row.from);
    EXPECT_EQ(next_state(row.from, row.event), row.to);
  }
  EXPECT_EQ(next_state(RunState::kCompleted, RunEvent::kFailed), std::nullopt);
  EXPECT_EQ(next_state(RunState::kQueued, RunEvent::kBegan), std::nullopt) << "it has to be planned before";
}

TEST(RunState, EveryStateIsReachedAndEveryOneThatIsNotFinalCanFail) {
  std::set<RunState> reached{RunState::kQueued};
  for (int round = 0; round < kStates; ++round) {
    for (const RunTransition& row : run_transitions())
      if (reached.contains(row.from)) reached.insert(row.to);
  }
  EXPECT_EQ(reached.size(), static_cast<std::size_t>(kStates));
  for (int i = 0; i < kStates; ++i) {
    const auto state = static_cast<RunState>(i);
    if (is_final(state)) continue;
    EXPECT_EQ(next_state(state, RunEvent::kFailed), RunState::kFailed) << name_of(state);
  }
}

TEST(RunState, ThePageShowsTheSameTable) {
  std::ifstream file("docs/activity-layer.md");
  std::stringstream page;
  page << file.rdbuf();
  for (const RunTransition& row : run_transitions()) {
    EXPECT_THAT(page.str(), testing::HasSubstr(fmt::format("| {} | {} | {} |", name_of(row.from), name_of(row.event),
                                                           name_of(row.to))));
  }
  for (int i = 0; i < kEvents; ++i)
    EXPECT_THAT(page.str(), testing::HasSubstr(std::string(name_of(static_cast<RunEvent>(i)))));
}

}  // namespace
}  // namespace takt::activity
