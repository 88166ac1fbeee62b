#include "core/program/tree/node_forms.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/program/language/value.h"

namespace takt::program {
namespace {

constexpr Range kRounds{.low = 0, .high = 1e6};
constexpr std::size_t kMostBranches = 32;

const NameRule kVariableName{.pattern = "^(?!(and|or|not|true|false|null)$)[A-Za-z_][A-Za-z_0-9]*$",
                             .allows = [](std::string_view name) { return is_variable_name(std::string(name)); },
                             .hint = "Use letters, digits and _, and none of the words of expressions"};

Key steps_key(std::string name, std::string doc) { return any_key(std::move(name), "steps", std::move(doc)); }
Key question_key(std::string name, std::string doc) { return any_key(std::move(name), "question", std::move(doc)); }
Key variable_key(std::string name, std::string doc) {
  return any_key(std::move(name), "variable_name", std::move(doc));
}
Key variables_key(std::string name, std::string doc) {
  return any_key(std::move(name), "declarations", std::move(doc)).optional();
}
/// Values of the language by name.
Key values_key(std::string name, std::string doc) {
  return members_key(std::move(name), any_key("", "value", ""), std::move(doc)).with_names(kVariableName);
}

Key count_key() {
  Key key = list_key("count", 3, integer_key("", {.low = 1, .high = 1000}, ""),
                     "Number of poses along x, y and z of the first pose.");
  key.max_size = 3;
  return key;
}

Form text_form(const char* kind, const char* doc) {
  return node_form(kind, doc, {text_key("text", "The text; usually an expression.")});
}

}  // namespace

Form node_form(const char* kind, const char* doc, std::vector<Key> keys, std::vector<Rule> rules) {
  Form form{.doc = doc,
            .keys = {any_key("do", "", "").optional(), any_key("name", "", "").optional()},
            .rules = std::move(rules),
            .definition = kind};
  std::ranges::move(keys, std::back_inserter(form.keys));
  return form;
}

const Form& branch_form() {
  static const Form form = node_form(
      "branch", "Takes one of several branches.",
      {objects_key("cases", 1,
                   {.doc = "",
                    .keys = {question_key("when", "Condition of the case."), steps_key("steps", "Steps of the case.")}},
                   "Cases; the first whose condition is true runs."),
       steps_key("else", "Steps if no case is true.").optional()});
  return form;
}

const Form& call_form() {
  static const Form form =
      node_form("call", "Runs a program of the file.",
                {text_key("program", "Name of one of 'programs'."),
                 members_key("with", any_key("", "value", ""), "Values of its parameters, by name.").optional(),
                 text_key("as", "Variable that receives the result.").optional()});
  return form;
}

const Form& fail_form() {
  static const Form form = text_form("fail", "Fails with a text.");
  return form;
}

const Form& grid_form() {
  static const Form form{.doc = "",
                         .keys = {text_key("in", "Frame of the first pose.").by_default("world"),
                                  any_key("position_m", "program_position_m", "").optional(),
                                  any_key("rpy_deg", "program_rpy_deg", "").optional(),
                                  any_key("quaternion", "program_quaternion", "").optional(), count_key(),
                                  vector_key("step_m", "m", "Distance between poses along x, y and z.")},
                         .rules = {pose_rule()}};
  return form;
}

const Form& for_each_form() {
  static const Form form =
      node_form("for_each", "Runs its steps for each element of a list.",
                {variable_key("as", "Variable that holds the element."),
                 variable_key("index", "Variable that counts the elements from 0.").optional(),
                 any_of_key("in", {"array"}, "List of elements. This or 'grid'.").with_parameter().optional(),
                 object_key("grid", grid_form(), "Poses of a grid as elements; x runs fastest.").optional(),
                 steps_key("steps", "Steps of a round.")},
                {exactly_one({"in", "grid"})});
  return form;
}

const Form& let_form() {
  static const Form form = node_form("let", "Gives variables values.",
                                     {values_key("values", "New values of variables, assigned one after the other.")});
  return form;
}

const Form& log_form() {
  static const Form form = text_form("log", "Writes a text into the recording.");
  return form;
}

const Form& parallel_form() {
  static const Form form = [] {
    Key branches = list_key("branches", 1, any_key("", "step", ""), "Steps that run side by side.");
    branches.max_size = kMostBranches;
    return node_form("parallel", "Runs branches side by side.",
                     {std::move(branches),
                      choice_key("end", {"all", "first"},
                                 "all: it ends with the last branch; first: the first branch that ends cancels the "
                                 "others.")
                          .by_default("all")});
  }();
  return form;
}

const Form& repeat_form() {
  static const Form form = node_form(
      "repeat", "Runs its steps again and again.",
      {integer_key("times", kRounds, "Number of rounds.").with_parameter().optional(),
       question_key("while", "Checked before each round.").optional(),
       question_key("until", "Checked after each round.").optional(),
       integer_key("at_most", {.low = 1, .high = 1e6}, "More rounds than this are a failure.").by_default(10'000.0),
       variable_key("as", "Variable that counts the rounds from 0.").optional(),
       steps_key("steps", "Steps of a round.")},
      {exactly_one({"times", "while", "until"}),
       at_most_one({"times", "at_most"}, "Remove one of them; at_most goes with 'while' and 'until'")});
  return form;
}

const Form& sequence_form() {
  static const Form form =
      node_form("sequence", "Runs steps one after the other.",
                {steps_key("steps", "Steps, one after the other."),
                 variables_key("variables", "Variables that live in the sequence."),
                 texts_key("frames",
                           "Names of frames that steps make in the sequence (set_frame) and that end with each of its "
                           "rounds.")
                     .optional(),
                 integer_key("times", kRounds, "Number of repetitions.").by_default(1.0)});
  return form;
}

const Form& stop_form() {
  static const Form form = node_form("stop", "Ends the program in order.", {});
  return form;
}

const Form& try_form() {
  static const Form form = node_form(
      "try", "Deals with failures.",
      {steps_key("steps", "Steps that may fail."),
       integer_key("retry", {.low = 1, .high = 1000}, "Number of further attempts.").optional(),
       steps_key("recover", "Steps before each further attempt.").optional(),
       object_key("on_error",
                  Form{.doc = "",
                       .keys = {variable_key("as", "Variable of type text that holds the failure.").optional(),
                                steps_key("steps", "Steps that handle the failure.")}},
                  "What happens after the last attempt has failed.")
           .optional(),
       steps_key("finally", "Steps that run afterwards in any case: completed, failed or stopped.").optional()},
      {at_least_one({"retry", "on_error", "finally"}), needs("recover", "retry", "Add \"retry\": how many more")});
  return form;
}

const Form& sub_program_form() {
  static const Form form{
      .doc = "A program that the step `call` runs.",
      .keys = {text_key("description", "Text for readers of the file.").optional(),
               variables_key("parameters", "Parameters; one without a value must be given by the caller."),
               variables_key("variables", "Variables that live while the program runs."),
               steps_key("steps", "Steps, one after the other."),
               any_key("result", "value", "Value that the call returns, usually an expression.").optional()},
      .definition = "sub_program"};
  return form;
}

}  // namespace takt::program
