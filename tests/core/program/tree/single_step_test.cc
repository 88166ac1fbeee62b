// Going through a program step by step: which step asks, what it knows, and that the time may stand meanwhile.
#include "tests/core/activity/fixture.h"

namespace takt::program {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class SingleStepTest : public test::ActivityTest {
 protected:
  /// Runs it with every step asked for between two cycles. @return names of those that asked
  std::vector<std::string> run_by_steps(const Program& program) {
    std::vector<std::string> asked;
    (void)run(program, [&](int cycle, ProgramRunner& runner) {
      if (cycle == 0) runner.set_single_step(true);
      while (runner.advance() == operations::Progress::kRunning && !runner.asking().empty()) {
        asked.push_back(runner.asking().front().name);
        changes.push_back(changed(runner));
        runner.step();
      }
    });
    return asked;
  }
  std::string changed(const ProgramRunner& runner) {
    std::string text;
    const auto now = runner.variables();
    for (const auto& [place, variable] : now) {
      if (known.contains(place) && known.at(place) == variable) continue;
      text += variable.name + "=" + variable.value + " ";
    }
    known = now;
    return text;
  }

  std::vector<std::string> changes;
  std::map<std::string, ProgramRunner::Known> known;
};

constexpr const char* kTwoSteps = R"({"do": "sequence", "variables": {"n": 0, "h": {"unit": "m"}}, "steps": [
  {"do": "repeat", "times": 2, "as": "i", "steps": [
    {"do": "let", "name": "count", "values": {"n": "$n + 2"}}, {"do": "wait", "name": "rest", "seconds": 0.003}]},
  {"do": "wait", "name": "until", "until": "$n == 4"},
  {"do": "let", "name": "measure", "values": {"h": 0.25}},
  {"do": "parallel", "branches": [
    {"do": "log", "name": "left", "text": "l"}, {"do": "log", "name": "right", "text": "r"}]},
  {"do": "stop", "name": "end"}]})";

TEST_F(SingleStepTest, EachStepAsksOnceInTheOrderInWhichTheyBeginAndTellsWhatChanged) {
  EXPECT_THAT(run_by_steps(good(kTwoSteps)),
              ElementsAre("count", "rest", "count", "rest", "until", "measure", "left", "right", "end"));
  EXPECT_THAT(changes, ElementsAre("h=unknown n=0 i=0 ", "n=2 ", "i=1 ", "n=4 ", "", "", "h=0.25 m ", "", ""));
}

TEST_F(SingleStepTest, TheRunIsTheSameAsWithoutStops) {
  ASSERT_EQ(run(kTwoSteps), operations::Progress::kDone);
  const auto log_without = log;
  const int cycles_without = cycles;
  log.clear();
  (void)run_by_steps(good(kTwoSteps));
  EXPECT_EQ(log, log_without);
  EXPECT_EQ(cycles, cycles_without);
}

TEST_F(SingleStepTest, NobodyAsksWhileItIsHeldOrRunsFreely) {
  const Program program = good(kTwoSteps);
  (void)run(program, [&](int cycle, ProgramRunner& runner) {
    if (cycle == 0) {
      runner.set_single_step(true);
      runner.hold(true);
      (void)runner.advance();
      EXPECT_THAT(runner.asking(), IsEmpty()) << "a pause is not a question";
      runner.hold(false);
      (void)runner.advance();
      ASSERT_EQ(runner.asking().size(), 1u);
      EXPECT_EQ(runner.asking().front().pointer, "/program/steps/0/steps/0");
      runner.set_single_step(false);
    }
    (void)runner.advance();
    EXPECT_THAT(runner.asking(), IsEmpty());
  });
}

}  // namespace
}  // namespace takt::program
