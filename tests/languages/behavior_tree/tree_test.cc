// Behaviour trees by themselves: what is refused, scripts, times, halts. What ticks do is held against BehaviorTree.CPP
// in behavior_tree_oracle.py.
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "languages/behavior_tree/session.h"

namespace takt::languages {
namespace {

using testing::Contains;
using testing::ElementsAre;

std::string file_with(const std::string& body, const std::string& more = "") {
  return fmt::format(
      "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\n<BehaviorTree "
      "ID=\"Main\">\n{}\n</BehaviorTree>{}\n</root>",
      body, more);
}

/// Leaves that run until the test says how they end.
class Told final : public TreeLeaves {
 public:
  std::map<std::string, TreeStatus> status;
  std::vector<std::string> events;

  TreeStatus tick(std::size_t, const TreeLeaf& leaf, bool fresh) override {
    if (fresh) events.push_back("start " + leaf.spec->type);
    const auto found = status.find(leaf.spec->type);
    return found == status.end() ? TreeStatus::kRunning : found->second;
  }
  void halt(std::size_t, const TreeLeaf& leaf) override { events.push_back("halt " + leaf.spec->type); }
};

class Trees : public testing::Test {
 protected:
  TreeSession& begin(const std::string& xml) {
    auto read = read_trees(xml);
    if (!read) ADD_FAILURE() << read.error().to_string();
    file = read ? *read : std::make_shared<const TreeFile>();
    session = std::make_unique<TreeSession>(*file, leaves);
    return *session;
  }
  /// Code and line of each diagnostic.
  static std::vector<std::pair<Code, int>> wrong(const std::string& xml) {
    const auto read = read_trees(xml);
    std::vector<std::pair<Code, int>> found;
    if (!read)
      for (const Diagnostic& one : read.error().list()) found.emplace_back(one.code, one.line);
    return found;
  }
  double number(const std::string& entry) {
    const TreeValue* found = session->board().find(entry);
    return found != nullptr && found->is_number() ? found->number() : -1.0;
  }

  Told leaves;
  std::shared_ptr<const TreeFile> file;
  std::unique_ptr<TreeSession> session;
};

TEST_F(Trees, AllThatIsWrongIsSaidAtOnceWithItsLine) {
  const std::string xml =
      "<root BTCPP_format=\"3\">\n<BehaviorTree ID=\"A\">\n<Sequence wrong=\"1\">\n<Repeat "
      "num_cycles=\"many\">\n<a/>\n<b/>\n</Repeat>\n"
      "<Switch2 variable=\"{x}\">\n<a/>\n</Switch2>\n<SubTree ID=\"B\"/>\n<c _skipIf=\"1 +\" "
      "_skip=\"1\"/>\n<d><e/></d>\n</Sequence>\n"
      "</BehaviorTree>\n<include path=\"x\"/>\n</root>";
  const auto found = wrong(xml);
  for (const auto& [code, line] : std::vector<std::pair<Code, int>>{{Code::kUnsupported, 1},
                                                                    {Code::kUnknownName, 3},
                                                                    {Code::kWrongType, 4},
                                                                    {Code::kWrongSize, 4},
                                                                    {Code::kMissing, 8},
                                                                    {Code::kWrongSize, 8},
                                                                    {Code::kUnknownName, 11},
                                                                    {Code::kSyntax, 12},
                                                                    {Code::kUnknownName, 12},
                                                                    {Code::kWrongSize, 13},
                                                                    {Code::kUnsupported, 16}})
    EXPECT_THAT(found, Contains(std::pair(code, line))) << line;
}

TEST_F(Trees, ATreeThatContainsItselfIsRefused) {
  EXPECT_THAT(
      wrong(file_with("<SubTree ID=\"Other\"/>", "<BehaviorTree ID=\"Other\"><SubTree ID=\"Main\"/></BehaviorTree>")),
      Contains(std::pair(Code::kConflict, 4)));
}

TEST_F(Trees, ManyTreesThatDoubleEachOtherAreRefused) {
  std::string more;
  for (int i = 0; i < 40; ++i)
    more += fmt::format(
        "<BehaviorTree ID=\"T{}\"><Sequence><SubTree ID=\"T{}\"/><SubTree ID=\"T{}\"/></Sequence></BehaviorTree>", i,
        i + 1, i + 1);
  more += "<BehaviorTree ID=\"T40\"><AlwaysSuccess/></BehaviorTree>";
  EXPECT_THAT(wrong(file_with("<SubTree ID=\"T0\"/>", more)), Contains(std::pair(Code::kTooLarge, 1)));
}

TEST_F(Trees, ScriptsCalculate) {
  begin(
      file_with("<Script code=\"a := 7; a += 1; b := a / 2 - 1; c := 'x' .. b; d := a > 7 &amp;&amp; !(b == 2) ? 1 : "
                "2; e := 6 &amp; 3 | 8; "
                "f := -a * 2\"/>"));
  EXPECT_EQ(session->tick(0), TreeStatus::kSuccess);
  EXPECT_EQ(number("a"), 8.0);
  EXPECT_EQ(number("b"), 3.0);
  EXPECT_EQ(session->board().find("c")->text(), "x3");
  EXPECT_EQ(number("d"), 1.0);
  EXPECT_EQ(number("e"), 10.0);
  EXPECT_EQ(number("f"), -16.0);
}

TEST_F(Trees, AScriptThatFailsFailsTheTreeAtItsLine) {
  for (const char* code : {"a = 1", "a := 1; a = 'x'", "a := 'x' - 1", "b + 1"}) {
    begin(file_with(fmt::format("<ForceSuccess>\n<Script code=\"{}\"/></ForceSuccess>", code)));
    EXPECT_EQ(session->tick(0), TreeStatus::kFailure) << code;
    ASSERT_TRUE(session->error()) << code;
    EXPECT_EQ(session->error()->line, 4) << code;
  }
}

TEST_F(Trees, ScriptsWithErrorsInTheirFormAreRefused) {
  for (const char* code : {"a :=", "1 +* 2", "(1", "a 'x'", "'x", "3x", "a := 1 ? 2", "#"})
    EXPECT_THAT(wrong(file_with(fmt::format("<Script code=\"{}\"/>", code))), Contains(std::pair(Code::kSyntax, 3)))
        << code;
  const std::string deep(200, '(');
  EXPECT_FALSE(wrong(file_with(fmt::format("<Script code=\"{}1\"/>", deep))).empty());
}

TEST_F(Trees, TimesAreThoseOfTheRun) {
  begin(file_with("<Sequence><Delay delay_msec=\"20\"><a/></Delay><Sleep msec=\"10\"/></Sequence>"));
  leaves.status["a"] = TreeStatus::kSuccess;
  for (int ms = 0; ms < 20; ++ms) EXPECT_EQ(session->tick(ms * kMillisecond), TreeStatus::kRunning) << ms;
  EXPECT_TRUE(leaves.events.empty());
  for (int ms = 20; ms < 30; ++ms) EXPECT_EQ(session->tick(ms * kMillisecond), TreeStatus::kRunning) << ms;
  EXPECT_EQ(session->tick(30 * kMillisecond), TreeStatus::kSuccess);
}

TEST_F(Trees, ATimeoutHaltsWhatStillRuns) {
  begin(file_with("<Timeout msec=\"{limit}\"><a _onHalted=\"h := 1\"/></Timeout>"));
  session->board().set("limit", {50.0});
  for (int ms = 0; ms < 50; ++ms) EXPECT_EQ(session->tick(ms * kMillisecond), TreeStatus::kRunning);
  EXPECT_EQ(session->tick(50 * kMillisecond), TreeStatus::kFailure);
  EXPECT_THAT(leaves.events, ElementsAre("start a", "halt a"));
  EXPECT_EQ(number("h"), 1.0);
}

TEST_F(Trees, AReactiveSequenceHaltsWhenItsConditionFalls) {
  begin(file_with("<ReactiveSequence><guard/><work/></ReactiveSequence>"));
  leaves.status["guard"] = TreeStatus::kSuccess;
  EXPECT_EQ(session->tick(0), TreeStatus::kRunning);
  leaves.status["guard"] = TreeStatus::kFailure;
  EXPECT_EQ(session->tick(kMillisecond), TreeStatus::kFailure);
  EXPECT_THAT(leaves.events, ElementsAre("start guard", "start work", "start guard", "halt work"));
}

TEST_F(Trees, ASubtreeHasEntriesOfItsOwn) {
  begin(
      file_with("<Sequence><Script code=\"x := 1; y := 2\"/><SubTree ID=\"S\" in=\"{x}\" out=\"{result}\" "
                "word=\"five\"/></Sequence>",
                "<BehaviorTree ID=\"S\"><Script code=\"out := in + 1; y := 9; z := word; @y = 4\"/></BehaviorTree>"));
  EXPECT_EQ(session->tick(0), TreeStatus::kSuccess);
  EXPECT_EQ(number("result"), 2.0);
  EXPECT_EQ(number("y"), 4.0) << "of the outermost tree, by its own name";
  EXPECT_EQ(session->board().find("z"), nullptr);
}

TEST_F(Trees, HaltingATreeHaltsItsLeaves) {
  begin(file_with("<Parallel><a/><b/></Parallel>"));
  EXPECT_EQ(session->tick(0), TreeStatus::kRunning);
  session->halt();
  EXPECT_THAT(leaves.events, ElementsAre("start a", "start b", "halt a", "halt b"));
  EXPECT_EQ(session->status(), TreeStatus::kIdle);
}

}  // namespace
}  // namespace takt::languages
