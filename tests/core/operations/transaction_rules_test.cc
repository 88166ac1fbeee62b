// Each rule of the command layer broken once from a file: rule, place in the file, way out; nothing moves.
#include "tests/core/activity/command_fixture.h"

namespace takt::activity {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class TransactionRulesTest : public test::CommandStepTest {
 protected:
  /// A diagnostic at this place that names the rule and the way out.
  void expect_refused(const std::string& text, const char* rule, const char* pointer, const char* way_out) {
    const auto before = cell.q();
    const Diagnostics found = wrong(text);
    bool seen = false;
    for (const Diagnostic& diagnostic : found.list()) {
      const bool fits = diagnostic.pointer == pointer && diagnostic.message.find(rule) != std::string::npos &&
                        diagnostic.hint.find(way_out) != std::string::npos;
      seen = seen || (fits && diagnostic.severity == Severity::kError);
    }
    EXPECT_TRUE(seen) << rule << " at " << pointer << " (" << way_out << ") is not in:\n" << found.to_string();
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
                 "C1", "/program/commands/a/on/0", "transaction around it");
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "commands": {
                                "b": )" +
                                 later + R"(}, "on": [{"entered": {"started": "inner"}, "start": "b"}]})",
                             R"(, "on": [{"entered": {"completed": "a"}, "start": "inner/b"}])"),
                 "C1", "/program/on/0", "own transaction");
}

TEST_F(TransactionRulesTest, C2_StopAndCancelTargetOneselfOrWhatIsInside) {
  expect_refused(transaction("\"a\": " + on + R"(, "b": {"do": "set", "start": true, "output": "lamp", "value": true,
                                                      "on": [{"entered": {"completed": "b"}, "cancel": "a"}]})"),
                 "C2", "/program/commands/b/on/0", "transaction around it");
  expect_refused(transaction(R"("a": {"do": "set", "start": true, "output": "driver", "value": true,
                                      "on": [{"entered": {"completed": "a"}, "stop": "t"}]})"),
                 "C2", "/program/commands/a/on/0", "on the target itself");
}

TEST_F(TransactionRulesTest, C4_CancelIsForwardedToWhatIsInside) {
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "commands": {"b":
                             {"do": "set", "start": true, "output": "lamp", "value": true}}})",
                             R"(, "on_cancel": ["a", "inner/b"])"),
                 "C4", "/program", "commands of this transaction");
}

TEST_F(TransactionRulesTest, C5_NothingStartsItself) {
  expect_refused(
      transaction("\"c\": " + on + R"(, "a": {"do": "wait", "seconds": 1}, "b": {"do": "wait", "seconds": 1})",
                  R"(, "on": [{"entered": {"any": [{"completed": "c"}, {"completed": "b"}]}, "start": "a"},
                              {"entered": {"completed": "a"}, "start": "b"}])"),
      "C5: it would start itself: /t/a -> /t/b -> /t/a", "/program/commands/a", "once at most");
  expect_refused(transaction("\"a\": " + on + R"(, "b": {"do": "wait", "start": true, "seconds": 1})",
                             R"(, "on": [{"entered": {"completed": "a"}, "start": "b"}])"),
                 "C5", "/program/on/0", "no \"start\": true");
}

TEST_F(TransactionRulesTest, C6_NamesAreThoseOfTheTree) {
  expect_refused(
      transaction("\"insert\": " + on, R"(, "on": [{"entered": {"completed": "insret"}, "cancel": "insert"}])"),
      "C6: there is no command 'insret' in 't'", "/program/on/0/entered/completed", "did you mean 'insert'?");
  expect_refused(
      transaction("\"insert\": " + on, R"(, "on": [{"entered": {"completed": "insert"}, "cancel": ["t", "x"]}])"), "C6",
      "/program/on/0/cancel/1", "insert");
  expect_refused(transaction("\"a\": " + on, R"(, "on": [{"entered": {"actuator": "arm", "is": "invalid_set_point"},
                                                          "cancel": "a"}])"),
                 "C6: no command in this tree gives 'arm' set points", "/program/on/0", "a command in this tree");
}

TEST_F(TransactionRulesTest, C7_WhatRunsTogetherHasDevicesOfItsOwn) {
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "commands": {"b":
                             {"do": "set", "start": true, "output": "driver", "value": false}}})"),
                 "C7: it drives 'driver' together with '/t/a'", "/program/commands/inner/commands/b",
                 "one after the other");
}

TEST_F(TransactionRulesTest, C8_AnActionOffersItsStates) {
  expect_refused(
      transaction("\"a\": " + on, R"(, "on": [{"entered": {"action": "a", "at_path": 0.5}, "cancel": "a"}])"), "C8",
      "/program/on/0", "it offers started, completed");
  expect_refused(transaction(R"("w": {"do": "wait", "start": true, "seconds": 1})",
                             R"(, "on": [{"entered": {"action": "w", "is": "error"}, "cancel": "w"}])"),
                 "C8: 'w' is not an action", "/program/on/0", "completed");
  expect_refused(transaction(R"("w": {"do": "ptp", "start": true, "to": "home"})",
                             R"(, "capture": {"x": {"value": {"progress": "t"}}})"),
                 "C8: 't' is not a motion", "/program/capture/x", "a motion");
}

TEST_F(TransactionRulesTest, C9_SomethingMustStart) {
  expect_refused(transaction(""), "C9", "/program", "\"start\": true");
  expect_refused(transaction(R"("a": {"do": "wait", "seconds": 1}, "b": {"do": "wait", "seconds": 1})",
                             R"(, "on": [{"entered": {"completed": "a"}, "start": "b"}])"),
                 "C9", "/program", "not inside of it");
}

TEST_F(TransactionRulesTest, C9_WhatNothingStartsIsTold) {
  expect_refused(transaction("\"a\": " + on + ", \"b\": " + later), "C9: nothing ever starts 'b'",
                 "/program/commands/b", "\"start\": true");
}

TEST_F(TransactionRulesTest, C10_ARaisedStateBelongsToATransaction) {
  expect_refused(
      transaction("\"a\": " + on, R"(, "raised": ["lost"], "on": [{"entered": {"completed": "a"}, "raise": "lots"}])"),
      "C10", "/program/on/0/raise", "did you mean 'lost'?");
  expect_refused(transaction("\"a\": " + on + R"(, "inner": {"do": "transaction", "start": true, "raised": ["lost"],
                             "commands": {"b": {"do": "set", "start": true, "output": "lamp", "value": true}}})",
                             R"(, "on": [{"entered": {"completed": "a"}, "raise": "lost"}])"),
                 "C10", "/program/on/0", "'raised' of a transaction around the handler");
}

TEST_F(TransactionRulesTest, AMotionBeginsWhereItIsKnownToBegin) {
  const std::string insert = R"("insert": {"do": "lin", "start": true, "to": {"by_m": [0, 0, -0.02]},
      "on": [{"entered": {"sensor": "wrist", "above_N": 5}, "cancel": "insert"}]},
      "up": {"do": "lin", "to": {"by_m": [0, 0, 0.02]}})";
  expect_refused(transaction(insert, R"(, "on": [{"entered": {"completed": "insert"}, "start": "up"}])"),
                 "the position of 'arm' when 'up' begins is unknown before the run", "/program/commands/up",
                 "not cancelled");
  EXPECT_FALSE(wrong(transaction(insert, R"(, "on": [{"entered": {"all": [{"completed": "insert"},
      {"not": {"cancelled": "insert"}}]}, "start": "up"}])"))
                   .has_errors());
  expect_refused(transaction(R"("p": {"do": "hold", "start": true, "seconds": 1}, "up": {"do": "ptp", "to": "home"})",
                             R"(, "on": [{"entered": {"completed": "p"}, "start": "up"}])"),
                 "'p' may have been cut short", "/program/commands/up", "after all this");
}

TEST_F(TransactionRulesTest, AllFindingsComeAtOnceWithTheirPlaces) {
  const std::string text = wrong(transaction(R"("far": {"do": "lin", "start": true, "to": {"by_m": [0, 0, 5]}},
                           "valve": {"do": "set", "start": true, "output": "valve", "value": 11},
                           "wide": {"do": "grip", "start": true, "width_m": 0.3},
                           "empty": {"do": "transaction", "commands": {}})",
                                             R"(, "on": [{"entered": {"completed": "far"}, "start": "wide"}])"))
                               .to_string();
  EXPECT_THAT(text, AllOf(HasSubstr("/program/commands/far/to: error: "),
                          HasSubstr("/program/commands/valve/value: error: 11 V is not for 'valve' (0 to 10 V)"),
                          HasSubstr("/program/commands/wide/width_m: error: 0.3 is not for 'gripper' (0 to 0.11)"),
                          HasSubstr("/program/commands/empty: error: C9"), HasSubstr("/program/on/0: error: C5")));
  EXPECT_THAT(text, AllOf(Not(HasSubstr("/valve: error: 11 V")), Not(HasSubstr("/width: error: 0.3")))) << "told twice";
}

TEST_F(TransactionRulesTest, TheFormIsTold) {
  const std::string text = wrong(R"({"do": "transaction", "name": "t", "cmmands": {}, "commands": {
      "a": {"do": "fly"}, "b": {"do": "set", "output": "driver", "value": true, "name": "c", "start": 1},
      "d": {"do": "lin", "to": "home", "blend_m": -1}, "e": 3, "f/g": {"do": "wait", "seconds": 1}},
      "on": [{"entered": {"completed": "b"}, "left": {"completed": "b"}}, {"start": "b"},
             {"entered": {}, "tell": ""}, {"entered": {"channel": "speed"}, "cancel": "b", "after_s": -1}, 7],
      "capture": {"x": {"when": {"completed": "b"}}}, "on_cancel": "never"})")
                               .to_string();
  for (const char* part :
       {"/program/cmmands: error", "/program/commands/a/do: error: there is no command 'fly'",
        "/program/commands/b/name: error: a second name", "/program/commands/b/start: error",
        "/program/commands/d/blend_m: error", "/program/commands/e: error", "'f/g'",
        "/program/on/0: error: exactly one event", "/program/on/0: error: the event handler has no effect",
        "/program/on/1: error: exactly one event", "/program/on/2/entered: error: no state is given",
        "/program/on/2/tell: error: an empty text", "/program/on/3/entered/channel: error: 'speed' carries Real",
        "/program/on/3/after_s: error", "/program/on/4: error", "/program/capture/x: error",
        "/program/on_cancel: error"})
    EXPECT_THAT(text, HasSubstr(part));
}

}  // namespace
}  // namespace takt::activity
