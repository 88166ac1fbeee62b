// Bounds: what is too large, too deep or without end is refused or ended with a message. And what does not end.
#include <string>

#include <gtest/gtest.h>

#include "tests/languages/urscript/trace_host.h"

namespace takt::languages::urscript::test {
namespace {

Diagnostics refused(std::string source) {
  const auto program = compile_for_arm({"main.script", std::move(source)}, {}, {});
  return program ? Diagnostics() : program.error();
}

std::string repeated(int count, const std::string& text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

/// Runs for at most so many seconds of its clock. @return the line at which it failed; 0: it did not
int failure_of(const std::string& source, double seconds = 1.0) {
  const auto program = compile_for_arm({"main.script", source}, {}, {});
  if (!program) ADD_FAILURE() << program.error().to_string();
  if (!program) return -1;
  TraceHost host;
  Session session(*program, host, {}, {});
  return host.run(session, seconds) == Session::Progress::kFailed ? session.error().line : 0;
}

TEST(UrscriptLimits, RefusesWhatNestsTooDeep) {
  EXPECT_EQ(refused("x = " + repeated(200, "(") + "1" + repeated(200, ")") + "\n").list().size(), 1u);
  EXPECT_EQ(refused("x = " + repeated(200, "-") + "1\n").list().size(), 1u);
  EXPECT_EQ(refused("x = " + repeated(200, "[") + repeated(200, "]") + "\n").list().size(), 1u);
  EXPECT_EQ(refused(repeated(200, "while True:\n") + repeated(200, "end\n")).list().size(), 1u);
}

TEST(UrscriptLimits, RefusesWhatIsTooLong) {
  EXPECT_EQ(refused(std::string((1u << 20) + 1, ' ')).list().front().code, Code::kTooLarge);
  EXPECT_EQ(refused("x = 1" + repeated(3'000, "+1") + "\n").list().size(), 1u);
}

TEST(UrscriptLimits, AMillionErrorsAreFew) {
  EXPECT_LE(refused(repeated(200'000, "?\n")).list().size(), 100u);
  EXPECT_LE(refused(repeated(100'000, "x =\n")).list().size(), 100u);
  EXPECT_LE(refused(repeated(50'000, "f()\n")).list().size(), 100u);
}

TEST(UrscriptLimits, WordsOfATextOrItsFirstError) {
  std::vector<Token> tokens;
  ScriptError error;
  EXPECT_TRUE(tokenize("x = 1", tokens, error));
  EXPECT_EQ(tokens.size(), 4u);
  EXPECT_FALSE(tokenize("x\n ? !", tokens, error));
  EXPECT_EQ(error.line, 2);
  EXPECT_EQ(error.column, 2);
}

TEST(UrscriptLimits, EndsAProgramThatAllocatesWithoutEnd) {
  EXPECT_EQ(failure_of("l = make_list(5000, 1)\nwhile True:\n  l = [l, l]\nend\n"), 3);
  // Many lists, none of them too large.
  EXPECT_GT(failure_of("def main():\n  def f(n):\n    local l = make_list(9000, 1)\n    sync()\n    f(n + 1)\n  end\n"
                       "  f(0)\nend\n",
                       5.0),
            0);
}

TEST(UrscriptLimits, EndsALoopThatTakesNoTime) {
  EXPECT_GT(failure_of("while True:\n  x = 1\nend\n"), 0);
  EXPECT_GT(failure_of("thread t():\n  while True:\n    x = 1\n  end\nend\nrun t()\nsleep(10)\n"), 0);
}

TEST(UrscriptLimits, ALoopThatTakesTimeGoesOn) {
  EXPECT_EQ(failure_of("i = 0\nwhile True:\n  i = i + 1\n  sync()\nend\n"), 0);
  EXPECT_EQ(failure_of("i = 0\nwhile i < 20000:\n  i = i + 1\nend\nsleep(10)\n"), 0);
}

TEST(UrscriptLimits, BeginsAtALineWithTheAssignmentsBeforeIt) {
  const auto program =
      compile_for_arm({"main.script",
                       "a = 2\nb = get_target_tcp_pose()\nc = a * 3\nmovej([1, 0, 0, 0, 0, 0])\ntextmsg(c)\n"
                       "textmsg(b)\n"},
                      {}, {});
  ASSERT_TRUE(program);
  TraceHost host;
  Session session(*program, host, {}, {});
  EXPECT_TRUE(session.enter(5));
  EXPECT_EQ(host.run(session), Session::Progress::kEnded);
  EXPECT_EQ(host.trace(), (std::vector<std::string>{"textmsg 6", "textmsg None"}));
  Session other(*program, host, {}, {});
  EXPECT_FALSE(other.enter(7));
}

}  // namespace
}  // namespace takt::languages::urscript::test
