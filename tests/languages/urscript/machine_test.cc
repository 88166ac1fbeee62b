// The language of programs for UR controllers: what is accepted, what it does, and what stops it.
#include "languages/urscript/machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::languages::urscript {
namespace {

/// Built-in functions that record what they are called with.
class Bench {
 public:
  Bench() {
    library.add("note(value)", [this](const Call& call) -> Outcome {
      notes.push_back(call.arguments[0].text());
      return Value();
    });
    library.add("sync()", [](const Call&) -> Outcome { return Wait([] { return std::optional<Value>(Value()); }); });
    library.add("pair(a, b=2)", [](const Call& call) -> Outcome {
      return Value(List{call.arguments[0], call.arguments[1]});
    });
    library.add("fails()", [](const Call&) -> Outcome { return Failed{"as asked"}; });
  }
  /// Runs it to its end, at most `frames`. @return what was noted, joined by blanks
  std::string run(std::string_view text, int frames = 100) {
    notes.clear();
    error = {};
    const auto program = compile(text, library, error);
    if (program == nullptr) return "refused: " + error.text;
    machine = std::make_unique<Machine>(program, library);
    for (int i = 0; i < frames && machine->run_frame(); ++i) continue;
    std::string out;
    for (const std::string& note : notes) out += (out.empty() ? "" : " ") + note;
    if (machine->error()) out += " failed: " + machine->error()->text;
    return out;
  }

  Library library;
  std::vector<std::string> notes;
  ScriptError error;
  std::unique_ptr<Machine> machine;
};

TEST(Urscript, ExpressionsHaveTheUsualOrder) {
  Bench bench;
  EXPECT_EQ(bench.run("note(1 + 2 * 3)"), "7");
  EXPECT_EQ(bench.run("note((1 + 2) * -3)"), "-9");
  EXPECT_EQ(bench.run("note(7 / 2)"), "3.5") << "a division gives a real number";
  EXPECT_EQ(bench.run("note(7 % 4)"), "3");
  EXPECT_EQ(bench.run("note(not 1 == 2)"), "True") << "'not' binds weaker than a comparison";
  EXPECT_EQ(bench.run("note(True or fails())"), "True") << "what decides is not followed by the rest";
  EXPECT_EQ(bench.run("note(1 < 2 and 2 < 1)"), "False");
  EXPECT_EQ(bench.run("note([1, 2] + [3, 4])"), "[4, 6]");
  EXPECT_EQ(bench.run("note(2 * [1, 2])"), "[2, 4]");
  EXPECT_EQ(bench.run("note(1 == 1.0)"), "True");
  EXPECT_EQ(bench.run("note(2147483647 + 1)"), "2.14748e+09");
}

TEST(Urscript, WordsNumbersAndTexts) {
  Bench bench;
  EXPECT_EQ(bench.run("note(.5 + 0.25)"), "0.75") << "a number may begin with its point";
  EXPECT_EQ(bench.run("note(1e1)"), "10");
  EXPECT_EQ(bench.run("note(99999999999)"), "1e+11") << "beyond an integer it is a real number";
  EXPECT_EQ(bench.run("note('a b')"), bench.run("note(\"a b\")")) << "either quotation mark";
  EXPECT_EQ(bench.run("\tAb_9 = +1 \r\n note(Ab_9) # a comment\n$ 1 \"a line of the editor\"\nnote(False)"), "1 False");
  EXPECT_EQ(bench.run("note(- -1)"), "1");
  EXPECT_EQ(bench.run("note(1 + (not True))"), bench.run("note(1 + not True)"));
  EXPECT_EQ(bench.run("note(pair(-1))"), "[-1, 2]");
  EXPECT_EQ(bench.run("x = [[1, 2], 3]\nnote(x[1])"), "3");
  EXPECT_EQ(bench.run("note(1);;note(2);"), "1 2");
}

TEST(Urscript, ASumWithATextIsAText) {
  Bench bench;
  EXPECT_EQ(bench.run("note('a' + \"b\" + 3)"), "ab3");
  EXPECT_EQ(bench.run("note(1 + 2 + ' and ' + 0.5)"), "3 and 0.5") << "from the left";
  EXPECT_EQ(bench.run("note('is ' + True)"), "is True");
  EXPECT_EQ(bench.run("note('at ' + [1, 2])"), "at [1, 2]");
  EXPECT_EQ(bench.run("note([1, 2] + 'x')"), "[1, 2]x");
  EXPECT_THAT(bench.run("note('a' - 'b')"), testing::HasSubstr("failed"));
}

TEST(Urscript, APoseIsToldFromAnElementOfAVariable) {
  Bench bench;
  EXPECT_EQ(bench.run("note(p[pair(1, 2)[0], (2), [3, 9][0], 4, 5, 6])"), bench.run("note(p[1, 2, 3, 4, 5, 6])"));
  EXPECT_EQ(bench.run("p = [[1, 2], [3, 4]]\nnote(p[1, pair(0, 1)[0]])"), "3");
  EXPECT_EQ(bench.run("p = 3\nnote(p)"), "3");
}

TEST(Urscript, AReturnWithoutAValueMayEndItsLine) {
  Bench bench;
  EXPECT_EQ(bench.run("note(1)\nreturn"), "1");
  EXPECT_EQ(bench.run("def m():\n def f():\n  return; note(1)\n end\n f()\n note(2)\nend"), "2");
  EXPECT_EQ(bench.run("def m():\n def f(): return end\n f()\n note(2)\nend"), "2");
}

TEST(Urscript, AnExpressionGoesOnWithAnOperatorInTheNextLine) {
  Bench bench;
  EXPECT_EQ(bench.run("note(1\n + 2)"), "3");
  EXPECT_EQ(bench.run("x = 1\n  + 2\n  - 7\nnote(x)"), "-4");
  EXPECT_EQ(bench.run("if 1 < 2\n  and 2 < 3:\n  note(1)\nend"), "1");
  EXPECT_EQ(bench.run("x = 1\n\n# a comment\n* 5\nnote(x)"), "5");
}

TEST(Urscript, AnIndexInALineOfItsOwnIsAListUnlessABracketIsOpen) {
  Bench bench;
  EXPECT_EQ(bench.run("x = [7, 8]\ny = x\n[1]\nnote(y)"), "[7, 8]");
  EXPECT_EQ(bench.run("x = [7, 8]\nnote(x\n[1])"), "8");
}

TEST(Urscript, DefaultsAreConstants) {
  Bench bench;
  EXPECT_EQ(bench.run("def m():\ndef f(a=-1):\nreturn a\nend\nnote(f())\nend"), "-1");
  EXPECT_EQ(bench.run("def m():\ndef f(a=[1, -2]):\nreturn a\nend\nnote(f())\nend"), "[1, -2]");
  EXPECT_EQ(bench.run("def m():\ndef f(a=p[1, 2, 3, 0, 0, 0]):\nreturn a\nend\nnote(f())\nend"),
            bench.run("note(p[1, 2, 3, 0, 0, 0])"));
  EXPECT_TRUE(bench.run("def m():\ndef f(a=1 + g()):\nreturn a\nend\nnote(f())\nend").starts_with("refused"));
  EXPECT_TRUE(bench.run("def m():\ndef f(a=-\"x\"):\nreturn a\nend\nnote(f())\nend").starts_with("refused"))
      << "nothing that has a sign";
}

TEST(Urscript, WhatIsNoScriptIsRefused) {
  Bench bench;
  for (const char* wrong : {"note(1",
                            "note(1]",
                            "note 1)",
                            "x = ",
                            "x = * 1",
                            "x[",
                            "x[]= 1",
                            "x[1 = 2",
                            "def (",
                            "def end():",
                            "def f(1):\nend",
                            "def f():",
                            "if True\nend",
                            "if True:",
                            "while:",
                            "thread t()",
                            "run 1",
                            "join",
                            "return return",
                            "global 1",
                            "local = 1",
                            "1 = 2",
                            "f() = 2",
                            "\x01",
                            "@",
                            "\"no end",
                            "'no end",
                            "end",
                            "else:",
                            "not",
                            "sec s(:",
                            "x = p[1, 2",
                            "x = [1, 2",
                            "x.y = 1",
                            "{",
                            "~",
                            "note(1) $ 2",
                            "\xe9",
                            "[1, 2][0] = 3",
                            "pair(1)[0] = 3"}) {
    EXPECT_TRUE(bench.run(wrong).starts_with("refused")) << wrong;
    EXPECT_FALSE(bench.error.text.empty()) << wrong;
  }
}

/// Any beginning of a script is accepted or refused, and a refusal has a reason.
TEST(Urscript, AScriptThatIsCutAnywhere) {
  const std::string whole = R"(def program():
  global q = [0, -1.5, .5e1, "a", 'b', True, False]
  local p1 = p[0.1, 0.2, 0.3, 0, 0, 0]
  thread t():
    while True:
      sync()
    end
  end
  def g(a, b=2):
    return a + b % 3
  end
  h = run t()
  if not (g(1) >= 2 and q[0] == 0):
    note(q[1])
  elif 1 != 2 or False:
    q[0] = -g(1, b=3)
  else:
    note(+1)
  end
  kill h
end
)";
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    Bench bench;
    const bool refused = bench.run(whole.substr(0, size), 3).starts_with("refused");
    EXPECT_EQ(refused, !bench.error.text.empty()) << whole.substr(0, size);
  }
}

TEST(Urscript, ASecondaryProgramMayBeDefinedWithinAnother) {
  Bench bench;
  EXPECT_EQ(bench.run("def m():\n sec s():\n  note(1)\n end\n s()\n note(2)\nend"), "1 2");
}

TEST(Urscript, BranchesOfOneIfAreBounded) {
  const auto with_branches = [](int count) {
    std::string script = "if False:\n";
    for (int i = 1; i < count; ++i) script += "elif False:\n";
    return script + "else:\n note(1)\nend\n";
  };
  Bench bench;
  EXPECT_EQ(bench.run(with_branches(900)), "1");
  EXPECT_THAT(bench.run(with_branches(1001)), testing::StartsWith("refused: too many branches"));
}

TEST(Urscript, BranchesAndLoops) {
  Bench bench;
  EXPECT_EQ(
      bench.run("def p():\n i = 0\n while i < 5:\n  i = i + 1\n  if i == 2:\n   continue\n  elif i == 4:\n   break\n"
                "  else:\n   note(i)\n  end\n end\n note(\"end\")\nend\n"),
      "1 3 end");
}

TEST(Urscript, FunctionsHaveDefaultsAndNamedArguments) {
  Bench bench;
  EXPECT_EQ(
      bench.run(
          "def p():\n def f(a, b=10):\n  return a + b\n end\n note(f(1))\n note(f(1, 2))\n note(f(b=5, a=1))\nend\n"),
      "11 3 6");
  EXPECT_EQ(bench.run("note(pair(1))"), "[1, 2]");
  EXPECT_EQ(bench.run("note(pair(b=3, a=1))"), "[1, 3]");
}

TEST(Urscript, ScopesAreThoseOfThePrograms) {
  Bench bench;
  EXPECT_EQ(bench.run("def p():\n x = 1\n def f():\n  x = 2\n end\n f()\n note(x)\nend\n"), "2")
      << "what the program assigns is seen by its functions";
  EXPECT_EQ(bench.run("def p():\n x = 1\n def f():\n  local x = 2\n end\n f()\n note(x)\nend\n"), "1");
  EXPECT_EQ(bench.run("def p():\n def f():\n  global y = 7\n end\n f()\n note(y)\nend\n"), "7");
}

TEST(Urscript, ListsAndPosesAreValues) {
  Bench bench;
  EXPECT_EQ(bench.run("a = [1, 2]\nb = a\nb[0] = 9\nnote(a[0])"), "1");
  EXPECT_EQ(bench.run("m = [[1, 2], [3, 4]]\nm[1, 0] = 5\nnote(m[1][0])"), "5");
  EXPECT_EQ(bench.run("q = p[1, 2, 3, 4, 5, 6]\nq[2] = 0\nnote(q)"), "p[1, 2, 0, 4, 5, 6]");
  EXPECT_EQ(bench.run("p = [7, 8]\nnote(p[1])"), "8") << "p is a name as well";
}

/// As programs that are put together by clients have them: a comment swallows the rest of a line.
TEST(Urscript, NewlinesCountLittle) {
  Bench bench;
  EXPECT_EQ(bench.run("def p():\n  global x = # offset\n0    global y = # another\n5\n  note(x + y)\nend\n"), "5");
  EXPECT_EQ(bench.run("a = 1\n(note(a))\n"), "1") << "a bracket on a line of its own calls nothing";
  EXPECT_EQ(bench.run("a = 3\n-1\nnote(a)"), "2") << "an operator goes on with what stands before it";
  EXPECT_EQ(bench.run("note(1 +\n 2)"), "3");
  EXPECT_EQ(bench.run("def p():\n def f():\n  return\n  note(1)\n end\n f()\nend\n"), "");
  EXPECT_EQ(bench.run("$ 3 \"label\"\nnote(1) # tail\r\n"), "1");
}

TEST(Urscript, ThreadsAlternateWhereTheyTakeTime) {
  Bench bench;
  const std::string script =
      "def p():\n thread t():\n  while True:\n   note(\"t\")\n   sync()\n  end\n end\n h = run t()\n note(\"m\")\n "
      "sync()\n"
      " note(\"m\")\n sync()\n kill h\n sync()\n note(h > 0)\nend\n";
  EXPECT_EQ(bench.run(script), "m t m t True");
  EXPECT_EQ(bench.run("def p():\n thread t():\n  sync()\n  note(1)\n end\n h = run t()\n join h\n note(2)\nend\n"),
            "1 2");
  EXPECT_EQ(bench.run("def p():\n thread t():\n  note(1)\n  halt\n end\n h = run t()\n sync()\n note(2)\nend\n"), "1");
}

TEST(Urscript, WhatCannotBeIsRefusedWithItsPlace) {
  Bench bench;
  EXPECT_EQ(bench.run("def p():\n  sync()\n  nothing_of_the_kind(1)\nend\n"),
            "refused: compile_error_name_not_found:nothing_of_the_kind:");
  EXPECT_EQ(bench.error.line, 3);
  EXPECT_EQ(bench.error.column, 3);
  for (const std::string_view script :
       {"def p():\n note(1)\n", "note(", "a = ", "x = y", "if True:", "break", "note(1, 2)", "\"open", "1e999", "3 = 4",
        "def (:", "pair()", "a = p[1,2,3,4,5,]", "note(c=1)", "run note(1)", "@"}) {
    EXPECT_TRUE(bench.run(script).starts_with("refused: ")) << script;
  }
}

TEST(Urscript, WhatGoesWrongEndsTheProgram) {
  Bench bench;
  EXPECT_EQ(bench.run("note(1)\nfails()\nnote(2)"), "1 failed: fails: as asked");
  EXPECT_EQ(bench.machine->error()->line, 2);
  for (const std::string_view script : {"a = [1]\nnote(a[1])", "note(1 / 0)", "note(1 - \"a\")", "if [1]:\nend",
                                        "def p():\n def f():\n  f()\n end\n f()\nend\n", "a = 1\na[0] = 2"}) {
    const std::string result = bench.run(script);
    EXPECT_NE(result.find("failed: "), std::string::npos) << script << ": " << result;
  }
}

TEST(Urscript, HostileProgramsAreBounded) {
  Bench bench;
  EXPECT_EQ(bench.run("while True:\nend\n", 3), "") << "it gives up the frame";
  EXPECT_EQ(bench.machine->overruns(), 3u);
  EXPECT_NE(bench.run("a = [1]\nwhile True:\n a = [a, a]\nend\n").find("too large"), std::string::npos);
  EXPECT_NE(bench.run("def p():\n thread t():\n  sync()\n  sync()\n end\n while True:\n  run t()\n end\nend\n")
                .find("threads"),
            std::string::npos);
  for (const std::string_view part : {"(", "[", "not ", "-", "if True:\n", "while True:\n", "a[", "note("}) {
    std::string deep;
    for (int i = 0; i < 100'000; ++i) deep += part;
    EXPECT_TRUE(bench.run(deep).starts_with("refused: ")) << part;
  }
  std::string sum = "a = 1";
  for (int i = 0; i < 100'000; ++i) sum += "+1";
  EXPECT_TRUE(bench.run(sum).starts_with("refused: "));
}

}  // namespace
}  // namespace takt::languages::urscript
