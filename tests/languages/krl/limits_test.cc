// Bounds: what is too large, too deep or without end is refused or ended with a message.
#include <string>

#include <gtest/gtest.h>

#include "tests/languages/krl/trace_host.h"

namespace takt::languages::krl::test {
namespace {

ModuleText module_of(std::string source, std::string data = "") {
  return {"MAIN", "main.src", std::move(source), "main.dat", std::move(data)};
}

Code refused(std::string source, std::string data = "") {
  const auto program = compile({module_of(std::move(source), std::move(data))}, {});
  return program ? Code::kNote : program.error().list().front().code;
}

std::string times(int count, const std::string& text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

TEST(KrlLimits, RefusesWhatNestsTooDeep) {
  EXPECT_EQ(refused("DEF MAIN()\nX=" + times(200, "(") + "1" + times(200, ")") + "\nEND\n"), Code::kTooLarge);
  EXPECT_EQ(refused("DEF MAIN()\nX=" + times(200, "-") + "1\nEND\n"), Code::kTooLarge);
  EXPECT_EQ(refused("DEF MAIN()\nX=" + times(200, "{A ") + "1\nEND\n"), Code::kTooLarge);
  EXPECT_EQ(refused("DEF MAIN()\n" + times(100, "LOOP\n") + times(100, "ENDLOOP\n") + "END\n"), Code::kTooLarge);
}

TEST(KrlLimits, RefusesWhatIsTooLong) {
  EXPECT_EQ(refused("DEF MAIN()\n" + times(25'000, "HALT\n") + "END\n"), Code::kTooLarge);
  EXPECT_EQ(refused("DEF MAIN()\nX=1" + times(2'000, "+1") + "\nEND\n"), Code::kTooLarge);
  EXPECT_EQ(refused(std::string((1u << 20) + 1, ' ')), Code::kTooLarge);
  EXPECT_EQ(refused("DEF MAIN()\nDECL INT A[100000,100000]\nEND\n"), Code::kTooLarge);
}

TEST(KrlLimits, AMillionErrorsAreFew) {
  const auto program = compile({module_of(times(200'000, "?\n"))}, {});
  ASSERT_FALSE(program);
  EXPECT_LE(program.error().list().size(), 200u);
}

TEST(KrlLimits, EndsAProgramThatAllocatesWithoutEnd) {
  const auto program =
      compile({module_of("DEF MAIN()\nMORE()\nEND\nDEF MORE()\nDECL E6POS A[1000]\nMORE()\nEND\n")}, {});
  ASSERT_TRUE(program) << program.error().to_string();
  TraceHost host;
  Machine machine(**program, host);
  EXPECT_EQ(host.run(machine), Machine::Progress::kFailed);
  EXPECT_EQ(machine.diagnostics().list().front().code, Code::kTooLarge);
}

TEST(KrlLimits, EndsALoopThatCopiesWithoutEnd) {
  const auto program =
      compile({module_of("DEF MAIN()\nDECL REAL A[50000], B[50000]\nLOOP\nA[]=B[]\nENDLOOP\nEND\n")}, {});
  ASSERT_TRUE(program) << program.error().to_string();
  TraceHost host;
  Machine machine(**program, host);
  EXPECT_EQ(host.run(machine), Machine::Progress::kFailed);
  EXPECT_EQ(machine.diagnostics().list().front().code, Code::kTooLarge);
}

TEST(KrlLimits, RefusesStructuresThatContainEachOther) {
  EXPECT_EQ(refused("DEF MAIN()\nEND\n", "DEFDAT MAIN\nSTRUC A INT X, B Y\nSTRUC B A X\nENDDAT\n"),
            Code::kInvalidValue);
  EXPECT_EQ(refused("DEF MAIN()\nEND\n", "DEFDAT MAIN\nSTRUC A INT X[90000]\nSTRUC B A X[90000]\nENDDAT\n"),
            Code::kTooLarge);
}

TEST(KrlLimits, CyclicFlagsThatDependOnEachOtherEnd) {
  const auto program = compile(
      {module_of("DEF MAIN()\n$CYCFLAG[1]=$CYCFLAG[2]\n$CYCFLAG[2]=$CYCFLAG[1]\nWAIT FOR $CYCFLAG[1]\nEND\n")}, {});
  ASSERT_TRUE(program) << program.error().to_string();
  TraceHost host;
  Machine machine(**program, host);
  EXPECT_EQ(host.run(machine), Machine::Progress::kFailed);
}

}  // namespace
}  // namespace takt::languages::krl::test
