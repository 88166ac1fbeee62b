// Nodes, variables, calls, loops: what is wrong with their form.
#include "tests/core/activity/broken_rules.h"

namespace takt::test {
namespace {

std::string declared(const std::string& variables, const std::string& steps = "") {
  return R"({"do": "sequence", "variables": {)" + variables + R"(}, "steps": [)" + steps + "]}";
}
std::string log(const std::string& text) { return R"({"do": "log", "text": ")" + text + "\"}"; }

/// Programs that call one another, one more than calls may nest.
std::string chain_of_calls() {
  std::string programs = R"({"link 17": {"steps": []})";
  for (int i = 1; i <= 16; ++i) {
    programs += ", \"link " + std::to_string(i) + R"(": {"steps": [{"do": "call", "program": "link )" +
                std::to_string(i + 1) + "\"}]}";
  }
  return programs + "}";
}

std::vector<BrokenRule> any_node() {
  return {
      {"5", "", Code::kWrongType, {"5"}},
      {R"({"seconds": 1})", "/do", Code::kMissing, {"do"}},
      {R"({"do": "wiat", "seconds": 1})", "/do", Code::kUnknownName, {"wiat", "wait"}},
      {R"({"do": "stop", "now": true})", "/now", Code::kUnknownKey, {"now"}},
      {R"({"do": "wait", "name": "$'x'", "seconds": 1})", "/name", Code::kNotKnownYet, {"name"}},
      {R"({"do": "sequence"})", "", Code::kMissing, {"steps"}},
      {R"({"do": "sequence", "steps": {}})", "/steps", Code::kWrongType},
      {R"({"do": "sequence", "steps": [], "times": 1.5})", "/times", Code::kOutOfRange, {"1.5", "0", "1000000"}},
      {R"({"do": "parallel", "branches": []})", "/branches", Code::kMissing, {"0", "1"}},
      {R"({"do": "parallel", "branches": [{"do": "stop"}], "end": "frist"})",
       "/end",
       Code::kUnknownName,
       {"frist", "first"}},
      {R"({"do": "branch", "cases": []})", "/cases", Code::kMissing},
      {R"({"do": "branch", "cases": [{"steps": []}]})", "/cases/0", Code::kMissing, {"when"}},
      {R"({"do": "branch", "cases": [{"when": "yes", "steps": []}]})", "/cases/0/when", Code::kSyntax, {"yes"}},
      {R"({"do": "branch", "cases": [{"when": "$1[m]", "steps": []}]})", "/cases/0/when", Code::kWrongType},
      {R"({"do": "try", "steps": []})", "", Code::kMissing, {"retry", "on_error", "finally"}},
      {R"({"do": "try", "steps": [], "recover": [], "finally": []})", "/recover", Code::kMissing, {"retry"}},
      {R"({"do": "try", "steps": [], "on_error": {"as": "1x", "steps": []}})",
       "/on_error/as",
       Code::kInvalidName,
       {"1x"}},
      {R"({"do": "try", "steps": [], "retry": 0, "finally": []})", "/retry", Code::kOutOfRange, {"0", "1", "1000"}},
      {R"({"do": "log"})", "", Code::kMissing, {"text"}},
      {R"({"do": "fail", "text": 5})", "/text", Code::kWrongType},
  };
}

std::vector<BrokenRule> variables() {
  return {
      {declared(R"("2x": 1)"), "/variables/2x", Code::kInvalidName, {"2x"}},
      {declared(R"("x": {"type": "nubmer"})"), "/variables/x", Code::kInvalidValue, {"nubmer"}},
      {declared(R"("x": {"unit": "furlong"})"), "/variables/x", Code::kInvalidValue, {"number", "furlong"}},
      {declared(R"("x": {"type": "number", "value": "red"})"), "/variables/x/value", Code::kWrongType},
      {declared(R"("x": [1, "a"])"), "/variables/x/1", Code::kTypeMismatch},
      {declared(R"("x": 1)", R"({"do": "let", "values": {"y": 2}})"), "/steps/0/values/y", Code::kUnknownName, {"y"}},
      {declared(R"("x": {"unit": "m"})", R"({"do": "let", "values": {"x": "$2[N]"}})"), "/steps/0/values/x",
       Code::kWrongType},
      {declared(R"("x": {"unit": "m"})", R"({"do": "wait", "seconds": "$x"})"),
       "/steps/0/seconds",
       Code::kUnitMismatch,
       {"seconds"}},
  };
}

std::vector<BrokenRule> calls() {
  return {
      {R"({"do": "call", "program": "nowhere"})", "/program", Code::kUnknownName, {"nowhere"}},
      {R"({"do": "call"})", "", Code::kMissing, {"program"}},
      {R"({"do": "call", "program": "plain", "with": {"speed": 1}})",
       "/with/speed",
       Code::kUnknownName,
       {"plain", "speed"},
       R"({"plain": {"steps": []}})"},
      {R"({"do": "call", "program": "asks"})",
       "/with",
       Code::kMissing,
       {"h", "asks"},
       R"({"asks": {"parameters": {"h": {"unit": "m"}}, "steps": []}})"},
      {R"({"do": "call", "program": "asks too", "with": {"h": "high"}})",
       "/with/h",
       Code::kWrongType,
       {},
       R"({"asks too": {"parameters": {"h": {"unit": "m"}}, "steps": []}})"},
      {R"({"do": "call", "program": "gives", "as": "x"})",
       "/as",
       Code::kUnknownName,
       {"x"},
       R"({"gives": {"steps": [], "result": 1}})"},
      {declared(R"("x": 1)", R"({"do": "call", "program": "gives nothing", "as": "x"})"),
       "/steps/0/as",
       Code::kRequires,
       {"gives nothing", "result"},
       R"({"gives nothing": {"steps": []}})"},
      {declared(R"("x": 1)", R"({"do": "call", "program": "gives a text", "as": "x"})"),
       "/steps/0/as",
       Code::kTypeMismatch,
       {"x"},
       R"({"gives a text": {"steps": [], "result": "red"}})"},
      {R"({"do": "stop"})",
       "/programs/round/steps/0/program",
       Code::kInvalidValue,
       {"round", "repeat"},
       R"({"round": {"steps": [{"do": "call", "program": "round"}]}})"},
      {R"({"do": "call", "program": "link 1"})",
       "/programs/link 16/steps/0/program",
       Code::kTooLarge,
       {"16"},
       chain_of_calls()},
      {R"({"do": "stop"})", "/programs", Code::kWrongType, {"5"}, "5"},
  };
}

std::vector<BrokenRule> loops() {
  const std::string steps = R"(, "steps": []})";
  const std::string place = R"("step_m": [0, 0, 0], "position_m": [0, 0, 0]})";
  return {
      {R"({"do": "repeat")" + steps, "", Code::kMissing, {"times", "while", "until"}},
      {R"({"do": "repeat", "times": 2, "while": "$true")" + steps, "", Code::kConflict, {"times", "while"}},
      {R"({"do": "repeat", "times": 2.5)" + steps, "/times", Code::kOutOfRange, {"2.5", "0", "1000000"}},
      {R"({"do": "repeat", "times": 2, "as": "and")" + steps, "/as", Code::kInvalidName, {"and"}},
      {R"({"do": "repeat", "times": 2, "at_most": 5)" + steps, "/times", Code::kConflict, {"times", "at_most"}},
      {R"({"do": "repeat", "while": "$true", "at_most": 0)" + steps,
       "/at_most",
       Code::kOutOfRange,
       {"0", "1", "1000000"}},
      {R"({"do": "for_each", "as": "x")" + steps, "", Code::kMissing, {"in", "grid"}},
      {R"({"do": "for_each", "as": "x", "in": 3)" + steps, "/in", Code::kWrongType},
      {R"({"do": "for_each", "in": [1])" + steps, "", Code::kMissing, {"as"}},
      {R"({"do": "for_each", "as": "x", "grid": {"count": [1.5, 1, 1], )" + place + steps,
       "/grid/count/0",
       Code::kOutOfRange,
       {"1.5"}},
      {R"({"do": "for_each", "as": "x", "grid": {"count": [100, 100, 2], )" + place + steps,
       "/grid/count",
       Code::kOutOfRange,
       {"20000", "10000"}},
  };
}

}  // namespace

std::vector<BrokenRule> broken_nodes() {
  std::vector<BrokenRule> all;
  for (const auto& some : {any_node(), variables(), calls(), loops()}) all.insert(all.end(), some.begin(), some.end());
  return all;
}

std::vector<BrokenRule> broken_expressions() {
  const auto said = [](const std::string& text, std::size_t character, Code code, std::vector<std::string> names) {
    names.push_back(std::to_string(character));
    return BrokenRule{log("$" + text), "/text", code, names};
  };
  return {
      // What cannot be read.
      said("1 +", 4, Code::kSyntax, {}),
      said("#", 1, Code::kSyntax, {"#"}),
      said("(1", 3, Code::kSyntax, {")"}),
      said("1 2", 3, Code::kSyntax, {"2"}),
      said("'open", 2, Code::kSyntax, {}),
      said("1e999", 1, Code::kSyntax, {"1e-3"}),
      said("1[m", 2, Code::kSyntax, {"0.25"}),
      said("3[furlong]", 2, Code::kSyntax, {"furlong"}),
      said(std::string(60, '(') + "1" + std::string(60, ')'), 51, Code::kSyntax, {}),
      {log("$" + std::string(2000, '1')), "/text", Code::kTooLarge, {"2000", "1000"}},
      // What does not fit together.
      said("text(height)", 6, Code::kUnknownName, {"height"}),
      said("text(sqtr(2))", 6, Code::kUnknownName, {"sqtr", "sqrt"}),
      said("text(max(1, 2, 3))", 6, Code::kTypeMismatch, {"max", "2", "3"}),
      said("text(sin(1[m]))", 10, Code::kTypeMismatch, {"sin"}),
      said("text(1[m] + 1[N])", 11, Code::kTypeMismatch, {"+"}),
      said("text(1 and true)", 8, Code::kTypeMismatch, {"and"}),
      said("text(true or 'a')", 11, Code::kTypeMismatch, {"or"}),
      said("text(1[m^1000000000] * 1[m])", 22, Code::kTypeMismatch, {}),
      said("text(1 / 0)", 8, Code::kTypeMismatch, {"1", "0"}),
      said("text(sqrt(-1))", 6, Code::kTypeMismatch, {}),
      said("text(-'red')", 6, Code::kTypeMismatch, {}),
      said("text(3[m] [0])", 11, Code::kTypeMismatch, {}),
      said("text([1]['a'])", 9, Code::kTypeMismatch, {"0"}),
      said("text([1, 'a'])", 6, Code::kTypeMismatch, {}),
      said("text(append([1], 'a'))", 6, Code::kTypeMismatch, {}),
      said("text(max(1[m], 1[s]))", 6, Code::kTypeMismatch, {}),
      said("text(select(true, 1, 'a'))", 6, Code::kTypeMismatch, {}),
      said("text(sum(['a']))", 6, Code::kTypeMismatch, {}),
      said("text(width('grapper'))", 6, Code::kTypeMismatch, {"grapper", "gripper"}),
  };
}

}  // namespace takt::test
