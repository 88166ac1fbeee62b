// Each rule of the command layer broken once from a file: rule, place in the file, way out; nothing moves.
#include "tests/core/activity/command_fixture.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::AllOf;
using testing::Not;

class TransactionRulesTest : public test::CommandStepTest {
 protected:
  /// An error with this code at this location that names the rule.
  void expect_refused(const std::string& text, Code code, const char* pointer, const std::vector<std::string>& names) {
    const auto before = cell.q();
    EXPECT_THAT(wrong(text), Reports(code, pointer, names));
    EXPECT_EQ(cell.q(), before);
  }
  static std::string transaction(const std::string& commands, const std::string& more = "") {
    return R"({"do": "transaction", "name": "t", "commands": {)" + commands + "}" + more + "}";
  }
  const std::string on = R"({"do": "set", "start": true, "output": "driver", "value": true})";
  const std::string later = R"({"do": "set", "output": "lamp", "value": true})";
};

TEST_F(TransactionRulesTest, C1_StartTargetsTheSameTransaction) {
  expect_refused(transaction(R"("a": {"do": "set", "start": true, "output": "driver", "value": true,
                                      "on": [{"entered": {"completed": "a"}, "start": "b"}]}, "b": )" +
                             later),
                 Code::kConflict, "/program/commands/a/on/0", {"C1"});
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "commands": {
                                "b": )" +
                                 later + R"(}, "on": [{"entered": {"started": "inner"}, "start": "b"}]})",
                             R"(, "on": [{"entered": {"completed": "a"}, "start": "inner/b"}])"),
                 Code::kConflict, "/program/on/0", {"C1"});
}

TEST_F(TransactionRulesTest, C2_StopAndCancelTargetOneselfOrWhatIsInside) {
  expect_refused(transaction("\"a\": " + on + R"(, "b": {"do": "set", "start": true, "output": "lamp", "value": true,
                                                      "on": [{"entered": {"completed": "b"}, "cancel": "a"}]})"),
                 Code::kConflict, "/program/commands/b/on/0", {"C2"});
  expect_refused(transaction(R"("a": {"do": "set", "start": true, "output": "driver", "value": true,
                                      "on": [{"entered": {"completed": "a"}, "stop": "t"}]})"),
                 Code::kConflict, "/program/commands/a/on/0", {"C2"});
}

TEST_F(TransactionRulesTest, C4_CancelIsForwardedToWhatIsInside) {
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "commands": {"b":
                             {"do": "set", "start": true, "output": "lamp", "value": true}}})",
                             R"(, "on_cancel": ["a", "inner/b"])"),
                 Code::kInvalidValue, "/program", {"C4"});
}

TEST_F(TransactionRulesTest, C5_NothingStartsItself) {
  expect_refused(
      transaction("\"c\": " + on + R"(, "a": {"do": "wait", "seconds": 1}, "b": {"do": "wait", "seconds": 1})",
                  R"(, "on": [{"entered": {"any": [{"completed": "c"}, {"completed": "b"}]}, "start": "a"},
                              {"entered": {"completed": "a"}, "start": "b"}])"),
      Code::kInvalidValue, "/program/commands/a", {"C5"});
  expect_refused(transaction("\"a\": " + on + R"(, "b": {"do": "wait", "start": true, "seconds": 1})",
                             R"(, "on": [{"entered": {"completed": "a"}, "start": "b"}])"),
                 Code::kInvalidValue, "/program/on/0", {"C5"});
}

TEST_F(TransactionRulesTest, C6_NamesAreThoseOfTheTree) {
  expect_refused(
      transaction("\"insert\": " + on, R"(, "on": [{"entered": {"completed": "insret"}, "cancel": "insert"}])"),
      Code::kUnknownName, "/program/on/0/entered/completed", {"insret", "t", "C6"});
  expect_refused(
      transaction("\"insert\": " + on, R"(, "on": [{"entered": {"completed": "insert"}, "cancel": ["t", "x"]}])"),
      Code::kUnknownName, "/program/on/0/cancel/1", {"C6", "insert"});
  expect_refused(transaction("\"a\": " + on, R"(, "on": [{"entered": {"actuator": "arm", "is": "invalid_set_point"},
                                                          "cancel": "a"}])"),
                 Code::kUnknownName, "/program/on/0", {"arm", "C6"});
}

TEST_F(TransactionRulesTest, C7_WhatRunsTogetherHasDevicesOfItsOwn) {
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "commands": {"b":
                             {"do": "set", "start": true, "output": "driver", "value": false}}})"),
                 Code::kResourceConflict, "/program/commands/inner/commands/b", {"driver", "/t/a", "C7"});
}

TEST_F(TransactionRulesTest, C8_AnActionOffersItsStates) {
  expect_refused(
      transaction("\"a\": " + on, R"(, "on": [{"entered": {"action": "a", "at_path": 0.5}, "cancel": "a"}])"),
      Code::kUnknownName, "/program/on/0", {"C8", "started", "completed"});
  expect_refused(transaction(R"("w": {"do": "wait", "start": true, "seconds": 1})",
                             R"(, "on": [{"entered": {"action": "w", "is": "error"}, "cancel": "w"}])"),
                 Code::kInvalidValue, "/program/on/0", {"w", "C8"});
  expect_refused(transaction(R"("w": {"do": "ptp", "start": true, "to": "home"})",
                             R"(, "capture": {"x": {"value": {"progress": "t"}}})"),
                 Code::kInvalidValue, "/program/capture/x", {"t", "C8"});
}

TEST_F(TransactionRulesTest, C9_SomethingMustStart) {
  expect_refused(transaction(""), Code::kNeverFires, "/program", {"C9"});
  expect_refused(transaction(R"("a": {"do": "wait", "seconds": 1}, "b": {"do": "wait", "seconds": 1})",
                             R"(, "on": [{"entered": {"completed": "a"}, "start": "b"}])"),
                 Code::kNeverFires, "/program", {"C9"});
}

TEST_F(TransactionRulesTest, C9_WhatNothingStartsIsTold) {
  expect_refused(transaction("\"a\": " + on + ", \"b\": " + later), Code::kNeverFires, "/program/commands/b",
                 {"C9", "b"});
}

TEST_F(TransactionRulesTest, C10_ARaisedStateBelongsToATransaction) {
  expect_refused(
      transaction("\"a\": " + on, R"(, "raised": ["lost"], "on": [{"entered": {"completed": "a"}, "raise": "lots"}])"),
      Code::kUnknownName, "/program/on/0/raise", {"C10"});
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "raised": ["lost"],
                             "commands": {"b": {"do": "set", "start": true, "output": "lamp", "value": true}}})",
                             R"(, "on": [{"entered": {"completed": "a"}, "raise": "lost"}])"),
                 Code::kInvalidValue, "/program/on/0", {"C10"});
}

TEST_F(TransactionRulesTest, AMotionBeginsWhereItIsKnownToBegin) {
  const std::string insert = R"("insert": {"do": "lin", "start": true, "to": {"by_m": [0, 0, -0.02]},
      "on": [{"entered": {"sensor": "wrist", "above_N": 5}, "cancel": "insert"}]},
      "up": {"do": "lin", "to": {"by_m": [0, 0, 0.02]}})";
  expect_refused(transaction(insert, R"(, "on": [{"entered": {"completed": "insert"}, "start": "up"}])"),
                 Code::kUnknownPosition, "/program/commands/up", {"arm", "up"});
  EXPECT_FALSE(wrong(transaction(insert, R"(, "on": [{"entered": {"all": [{"completed": "insert"},
      {"not": {"cancelled": "insert"}}]}, "start": "up"}])"))
                   .has_errors());
  expect_refused(transaction(R"("p": {"do": "hold", "start": true, "seconds": 1}, "up": {"do": "ptp", "to": "home"})",
                             R"(, "on": [{"entered": {"completed": "p"}, "start": "up"}])"),
                 Code::kUnknownPosition, "/program/commands/up", {"p"});
}

TEST_F(TransactionRulesTest, AllFindingsComeAtOnceWithTheirPlaces) {
  const Diagnostics text = wrong(transaction(R"("far": {"do": "lin", "start": true, "to": {"by_m": [0, 0, 5]}},
                           "valve": {"do": "set", "start": true, "output": "valve", "value": 11},
                           "wide": {"do": "grip", "start": true, "width_m": 0.3},
                           "empty": {"do": "transaction", "commands": {}})",
                                             R"(, "on": [{"entered": {"completed": "far"}, "start": "wide"}])"));
  EXPECT_THAT(text, AllOf(Reports(Code::kUnreachable, "/program/commands/far/to"),
                          Reports(Code::kOutOfRange, "/program/commands/valve/value", {"valve", "11", "0", "10"}),
                          Reports(Code::kOutOfRange, "/program/commands/wide/width_m", {"gripper", "0.3", "0", "0.11"}),
                          Reports(Code::kNeverFires, "/program/commands/empty", {"C9"}),
                          Reports(Code::kInvalidValue, "/program/on/0", {"C5"})));
  EXPECT_THAT(text, AllOf(Not(Reports(Code::kOutOfRange, "/valve")), Not(Reports(Code::kOutOfRange, "/width"))))
      << "told twice";
  EXPECT_EQ(std::ranges::count(text.list(), Code::kOutOfRange, &Diagnostic::code), 2) << "each once";
}

TEST_F(TransactionRulesTest, TheFormIsTold) {
  const Diagnostics text = wrong(R"({"do": "transaction", "name": "t", "cmmands": {}, "commands": {
      "a": {"do": "fly"}, "b": {"do": "set", "output": "driver", "value": true, "name": "c", "start": 1},
      "d": {"do": "lin", "to": "home", "blend_m": -1}, "e": 3, "f/g": {"do": "wait", "seconds": 1}},
      "on": [{"entered": {"completed": "b"}, "left": {"completed": "b"}}, {"start": "b"},
             {"entered": {}, "tell": ""}, {"entered": {"channel": "speed"}, "cancel": "b", "after_s": -1}, 7],
      "capture": {"x": {"when": {"completed": "b"}}}, "on_cancel": "never"})");
  const takt::test::Expected all[] = {{Code::kUnknownKey, "/program/cmmands"},
                                      {Code::kUnknownName, "/program/commands/a/do", {"fly"}},
                                      {Code::kDuplicate, "/program/commands/b/name"},
                                      {Code::kWrongType, "/program/commands/b/start"},
                                      {Code::kOutOfRange, "/program/commands/d/blend_m"},
                                      {Code::kWrongType, "/program/commands/e"},
                                      {Code::kInvalidName, "/program/commands/f~1g", {"f/g"}},
                                      {Code::kMissing, "/program/on/0"},
                                      {Code::kMissing, "/program/on/0"},
                                      {Code::kMissing, "/program/on/1"},
                                      {Code::kMissing, "/program/on/2/entered"},
                                      {Code::kMissing, "/program/on/2/tell"},
                                      {Code::kTypeMismatch, "/program/on/3/entered/channel", {"speed"}},
                                      {Code::kOutOfRange, "/program/on/3/after_s"},
                                      {Code::kWrongType, "/program/on/4"},
                                      {Code::kMissing, "/program/capture/x"},
                                      {Code::kUnknownName, "/program/on_cancel"}};
  for (const takt::test::Expected& one : all) EXPECT_THAT(text, Reports(one));
}

}  // namespace
}  // namespace takt::operations
