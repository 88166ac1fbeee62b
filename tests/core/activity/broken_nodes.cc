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
      {"5", "", "unexpected value 5", "an object {...}"},
      {R"({"seconds": 1})", "/do", "'do' is missing", "allowed: branch, call"},
      {R"({"do": "wiat", "seconds": 1})", "/do", "there is no step 'wiat'", "did you mean 'wait'?"},
      {R"({"do": "stop", "now": true})", "/now", "unknown key 'now'", "allowed: do, name"},
      {R"({"do": "wait", "name": "$'x'", "seconds": 1})", "/name", "an expression at 'name'", "a text that is fixed"},
      {R"({"do": "sequence"})", "", "key 'steps' is missing", "an array [...]"},
      {R"({"do": "sequence", "steps": {}})", "/steps", "unexpected value {}", "an array [...]"},
      {R"({"do": "sequence", "steps": [], "times": 1.5})", "/times", "unexpected value 1.5",
       "a number from 0 to 1000000, whole"},
      {R"({"do": "parallel", "branches": []})", "/branches", "0 branches", "from 1 to 32"},
      {R"({"do": "parallel", "branches": [{"do": "stop"}], "end": "frist"})", "/end", "unknown value 'frist'",
       "did you mean 'first'?"},
      {R"({"do": "branch", "cases": []})", "/cases", "no case is given", "at least one"},
      {R"({"do": "branch", "cases": [{"steps": []}]})", "/cases/0", "key 'when' is missing", "a condition {...}"},
      {R"({"do": "branch", "cases": [{"when": "yes", "steps": []}]})", "/cases/0/when", "'yes' is not an expression",
       "a condition {...}"},
      {R"({"do": "branch", "cases": [{"when": "$1[m]", "steps": []}]})", "/cases/0/when", "unexpected number in m",
       "a boolean"},
      {R"({"do": "try", "steps": []})", "", "no reaction to a failure is given", "'retry', 'on_error' or 'finally'"},
      {R"({"do": "try", "steps": [], "recover": [], "finally": []})", "/recover",
       "there is no other attempt to recover for", "\"retry\""},
      {R"({"do": "try", "steps": [], "on_error": {"as": "1x", "steps": []}})", "/on_error/as",
       "invalid variable name '1x'", "letters, digits and _"},
      {R"({"do": "try", "steps": [], "retry": 0, "finally": []})", "/retry", "unexpected value 0",
       "a number from 1 to 1000, whole"},
      {R"({"do": "log"})", "", "key 'text' is missing", "a text"},
      {R"({"do": "fail", "text": 5})", "/text", "unexpected number without a unit", "a text"},
  };
}

std::vector<BrokenRule> variables() {
  return {
      {declared(R"("2x": 1)"), "/variables/2x", "invalid variable name '2x'", "letters, digits and _"},
      {declared(R"("x": {"type": "nubmer"})"), "/variables/x", "'nubmer' in '' is not a type", "list of ..."},
      {declared(R"("x": {"unit": "furlong"})"), "/variables/x", "'number' in 'furlong' is not a type", "with a unit"},
      {declared(R"("x": {"type": "number", "value": "red"})"), "/variables/x/value", "unexpected text", "a number"},
      {declared(R"("x": [1, "a"])"), "/variables/x/1", "a text in this list", "elements of one type and one unit"},
      {declared(R"("x": 1)", R"({"do": "let", "values": {"y": 2}})"), "/steps/0/values/y", "there is no variable 'y'",
       "allowed: x"},
      {declared(R"("x": {"unit": "m"})", R"({"do": "let", "values": {"x": "$2[N]"}})"), "/steps/0/values/x",
       "unexpected number in N", "a number in m"},
      {declared(R"("x": {"unit": "m"})", R"({"do": "wait", "seconds": "$x"})"), "/steps/0/seconds",
       "'seconds' is given a number in m", "a number in s"},
  };
}

std::vector<BrokenRule> calls() {
  return {
      {R"({"do": "call", "program": "nowhere"})", "/program", "there is no program 'nowhere'", "there are none"},
      {R"({"do": "call"})", "", "key 'program' is missing", "a text"},
      {R"({"do": "call", "program": "plain", "with": {"speed": 1}})", "/with/speed", "'plain' has no parameter 'speed'",
       "there are none", R"({"plain": {"steps": []}})"},
      {R"({"do": "call", "program": "asks"})", "/with", "parameter 'h' of 'asks' is missing", "a number in m",
       R"({"asks": {"parameters": {"h": {"unit": "m"}}, "steps": []}})"},
      {R"({"do": "call", "program": "asks too", "with": {"h": "high"}})", "/with/h", "unexpected text", "a number in m",
       R"({"asks too": {"parameters": {"h": {"unit": "m"}}, "steps": []}})"},
      {R"({"do": "call", "program": "gives", "as": "x"})", "/as", "there is no variable 'x'", "there are none",
       R"({"gives": {"steps": [], "result": 1}})"},
      {declared(R"("x": 1)", R"({"do": "call", "program": "gives nothing", "as": "x"})"), "/steps/0/as",
       "'gives nothing' has no result", "a \"result\" in that program", R"({"gives nothing": {"steps": []}})"},
      {declared(R"("x": 1)", R"({"do": "call", "program": "gives a text", "as": "x"})"), "/steps/0/as",
       "'x' is a number without a unit, the result a text", "a variable that is a text",
       R"({"gives a text": {"steps": [], "result": "red"}})"},
      {R"({"do": "stop"})", "/programs/round/steps/0/program", "'round' calls 'round': a program may not call itself",
       "\"repeat\"", R"({"round": {"steps": [{"do": "call", "program": "round"}]}})"},
      {R"({"do": "call", "program": "link 1"})", "/programs/link 16/steps/0/program",
       "calls are nested more than 16 deep", "fewer programs in programs", chain_of_calls()},
      {R"({"do": "stop"})", "/programs", "unexpected value 5", "an object {...}", "5"},
  };
}

std::vector<BrokenRule> loops() {
  const std::string steps = R"(, "steps": []})";
  const std::string place = R"("step_m": [0, 0, 0], "position_m": [0, 0, 0]})";
  return {
      {R"({"do": "repeat")" + steps, "", "exactly one end is needed", "'times', 'while' or 'until'"},
      {R"({"do": "repeat", "times": 2, "while": "$true")" + steps, "", "exactly one end is needed", "'times'"},
      {R"({"do": "repeat", "times": 2.5)" + steps, "/times", "2.5 rounds", "a whole number from 0 to 1000000"},
      {R"({"do": "repeat", "times": 2, "as": "and")" + steps, "/as", "invalid variable name 'and'",
       "not one of the words of expressions"},
      {R"({"do": "repeat", "while": "$true", "at_most": 0)" + steps, "/at_most", "unexpected value 0",
       "a number from 1 to 1000000, whole"},
      {R"({"do": "for_each", "as": "x")" + steps, "", "exactly one list is needed", "'in' or 'grid'"},
      {R"({"do": "for_each", "as": "x", "in": 3)" + steps, "/in", "unexpected number without a unit", "a list"},
      {R"({"do": "for_each", "in": [1])" + steps, "", "key 'as' is missing", "a text"},
      {R"({"do": "for_each", "as": "x", "grid": {"count": [1.5, 1, 1], )" + place + steps, "/grid/count/0",
       "1.5 places", "a whole number"},
      {R"({"do": "for_each", "as": "x", "grid": {"count": [100, 100, 2], )" + place + steps, "/grid/count",
       "20000 places", "at most 10000"},
  };
}

}  // namespace

std::vector<BrokenRule> broken_nodes() {
  std::vector<BrokenRule> all;
  for (const auto& some : {any_node(), variables(), calls(), loops()}) all.insert(all.end(), some.begin(), some.end());
  return all;
}

std::vector<BrokenRule> broken_expressions() {
  const auto said = [](const std::string& text, std::size_t character, const std::string& message,
                       const std::string& way_out) {
    return BrokenRule{log("$" + text), "/text",
                      "in '" + text + "', character " + std::to_string(character) + ": " + message, way_out};
  };
  return {
      // What cannot be read.
      said("1 +", 4, "the text ends where a value should stand", "a number, a variable"),
      said("#", 1, "'#' begins no value", "a number, a variable"),
      said("(1", 3, "')' is missing", "a ')' here"),
      said("1 2", 3, "'2' is not expected", "an operator or the end"),
      said("'open", 2, "the text has no end", "a second '"),
      said("1e999", 1, "this is not a number", "1e-3"),
      said("1[m", 2, "the unit has no end", "0.25[m/s]"),
      said("3[furlong]", 2, "'furlong' is not a unit", "m, mm, s"),
      said(std::string(60, '(') + "1" + std::string(60, ')'), 51, "this is nested too deeply", "variables for parts"),
      {log("$" + std::string(2000, '1')), "/text", "an expression of 2000 characters", "at most 1000"},
      // What does not fit together.
      said("text(height)", 6, "there is no variable 'height'", "there are none"),
      said("text(sqtr(2))", 6, "there is no function 'sqtr'", "did you mean 'sqrt'?"),
      said("text(max(1, 2, 3))", 6, "'max' takes 2 arguments, here are 3", "max(x, y)"),
      said("text(sin(1[m]))", 10, "'sin' takes an angle", "sin(angle)"),
      said("text(1[m] + 1[N])", 11, "'+' joins a number in m and a number in N", "two numbers of one unit"),
      said("text(1 and true)", 8, "'and' takes true or false, here is a number", "a comparison"),
      said("text(true or 'a')", 11, "'or' takes true or false, here is a text", "a comparison"),
      said("text(1[m^1000000000] * 1[m])", 22, "this unit is beyond any measure", "magnitude(x)"),
      said("text(1 / 0)", 8, "1 / 0 is not a number", "select(condition, a, b)"),
      said("text(sqrt(-1))", 6, "the result is not a number", "sqrt(x)"),
      said("text(-'red')", 6, "a text has no sign", "a number"),
      said("text(3[m] [0])", 11, "a number in m has no elements", "a list before the ["),
      said("text([1]['a'])", 9, "a text is not an index", "a number without a unit, from 0"),
      said("text([1, 'a'])", 6, "the elements are of different types", "one type, one unit"),
      said("text(append([1], 'a'))", 6, "a text does not go into a list of number", "append(list, value)"),
      said("text(max(1[m], 1[s]))", 6, "a number in m and a number in s cannot be compared", "max(x, y)"),
      said("text(select(true, 1, 'a'))", 6, "the two values are of different types", "select(condition, a, b)"),
      said("text(sum(['a']))", 6, "a list of numbers is needed", "sum(list)"),
      said("text(width('grapper'))", 6, "there is no gripper 'grapper'", "width('gripper')"),
  };
}

}  // namespace takt::test
