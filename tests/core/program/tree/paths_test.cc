// Where in the tree something happens.
#include "tests/core/activity/fixture.h"

namespace takt::program {
namespace {

using testing::ElementsAre;

class PathsTest : public test::ActivityTest {};

TEST_F(PathsTest, EventsKnowWhereInTheTreeTheyHappen) {
  const test::Json programs = test::Json::parse(R"({"twice": {"steps": [
      {"do": "repeat", "times": 2, "name": "again", "steps": [{"do": "wait", "name": "w", "seconds": 0.001}]}]}})");
  const auto program = Program::parse(test::Json::parse(R"({"do": "sequence", "name": "main", "steps": [
      {"do": "for_each", "name": "part", "as": "p", "in": [1, 2], "steps": [{"do": "log", "text": "x"}]},
      {"do": "call", "program": "twice"},
      {"do": "call", "name": "once more", "program": "twice"},
      {"do": "try", "name": "carefully", "retry": 1, "steps": [{"do": "fail", "text": "no"}],
       "on_error": {"steps": []}},
      {"do": "parallel", "name": "both", "branches": [{"do": "wait", "name": "a", "seconds": 0.001},
                                                      {"do": "wait", "name": "b", "seconds": 0.002}]}]})"),
                                      "/program", fake.cell, &programs);
  ASSERT_TRUE(program) << program.error().to_string();
  std::vector<std::string> between;
  const AtCycle look = [&](int cycle, ProgramRunner& runner) {
    if (cycle > 0 && (between.empty() || between.back() != runner.path())) between.push_back(runner.path());
  };
  EXPECT_EQ(run(*program, look), operations::Progress::kDone) << diagnostics.to_string();
  EXPECT_THAT(paths, ElementsAre("log: main / part (1)", "log: main / part (2)",                              //
                                 "begin: main / twice / again (1) / w", "end: main / twice / again (1) / w",  //
                                 "begin: main / twice / again (2) / w", "end: main / twice / again (2) / w",  //
                                 "begin: main / once more / twice / again (1) / w",                           //
                                 "end: main / once more / twice / again (1) / w",                             //
                                 "begin: main / once more / twice / again (2) / w",                           //
                                 "end: main / once more / twice / again (2) / w",                             //
                                 "failed: main / carefully", "retry: main", "failed: main / carefully (2)",   //
                                 "handled: main", "begin: main / both / a", "begin: main / both / b",
                                 "end: main / both / a", "end: main / both / b"));
  EXPECT_THAT(between,
              ElementsAre("main / twice / again (1) / w", "main / twice / again (2) / w",
                          "main / once more / twice / again (1) / w", "main / once more / twice / again (2) / w",
                          "main / both / a + main / both / b", "main / both / b"));
}

}  // namespace
}  // namespace takt::program
