// Modules: functions, declarations, statements.
#include "languages/krl/parser.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "languages/krl/parser_state.h"

namespace takt::languages::krl {
namespace {

using Kind = Statement::Kind;

constexpr std::array kMotionWords{"PTP",      "PTP_REL", "LIN",      "LIN_REL", "CIRC", "CIRC_REL", "SPTP",
                                  "SPTP_REL", "SLIN",    "SLIN_REL", "SCIRC",   "SPL",  "SCIRC_REL"};
constexpr std::array kApproximations{"C_PTP", "C_DIS", "C_VEL", "C_ORI", "C_SPL"};
/// Words of KRL that are refused here: what they do is nothing that takt has, or is not done yet.
constexpr std::array kUnsupportedWords{
    "ANOUT",  "ANIN",    "DIGIN",   "CHANNEL",    "COPEN",     "CCLOSE",    "CREAD",   "CWRITE",           "SREAD",
    "SWRITE", "IMPORT",  "IS",      "TIME_BLOCK", "CONST_VEL", "STOP",      "CONFIRM", "ON_ERROR_PROCEED", "INVERSE",
    "ASYPTP", "ASYSTOP", "ASYCONT", "ASYCANCEL",  "MKSPTP",    "CAST_FROM", "CAST_TO"};
constexpr int kMostStatements = 20'000;

template <class Words>
bool one_of(const Words& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

/// Ends of blocks: a block is left at any of them, and whoever opened it says which one it must be.
constexpr std::array kBlockEnds{"ENDIF",   "ELSE", "ENDLOOP", "ENDWHILE", "ENDFOR", "UNTIL",  "ENDSWITCH", "CASE",
                                "DEFAULT", "END",  "ENDFCT",  "ENDDAT",   "DEF",    "DEFFCT", "ENDSPLINE"};

class Parser {
 public:
  Parser(std::string_view text, const std::string& file, Diagnostics& diagnostics, Module& module)
      : in_(text, file, diagnostics), module_(module) {}

  void source() {
    for (in_.skip_empty_lines(); !in_.at_end(); in_.skip_empty_lines()) {
      const bool is_global = in_.accept("GLOBAL");
      if (in_.sees("DEF") || in_.sees("DEFFCT")) {
        function(is_global);
      } else {
        in_.error(in_.peek().at, Code::kSyntax, "a statement outside of DEF and END", "Begin with DEF name ( )");
        in_.skip_line();
      }
    }
  }

  void data() {
    in_.skip_empty_lines();
    if (in_.at_end()) return;
    if (!in_.expect("DEFDAT")) return;
    (void)in_.expect_name("the name of the data list");
    (void)in_.accept("PUBLIC");
    in_.end_line();
    for (in_.skip_empty_lines(); !in_.at_end() && !in_.sees("ENDDAT"); in_.skip_empty_lines()) data_line();
    if (in_.expect("ENDDAT")) in_.end_line();
    in_.skip_empty_lines();
    if (!in_.at_end()) in_.error(in_.peek().at, Code::kSyntax, "text behind ENDDAT", "Remove it");
  }

 private:
  void function(bool is_global) {
    Function made;
    made.is_global = is_global;
    made.at = in_.peek().at;
    const bool has_result = in_.take().text == "DEFFCT";
    if (has_result) made.result = in_.expect_name("the type of the result");
    made.name = in_.expect_name("the name of the program");
    if (in_.expect("(")) parameters(made);
    in_.end_line();
    function_ = &made;
    made.body = block();
    (void)in_.expect(has_result ? "ENDFCT" : "END");
    in_.end_line();
    function_ = nullptr;
    module_.functions.push_back(std::move(made));
  }

  void parameters(Function& made) {
    if (in_.accept(")")) return;
    do {
      Parameter one;
      one.at = in_.peek().at;
      one.name = in_.expect_name("the name of a parameter");
      if (in_.accept("[")) {
        one.is_array = true;
        while (in_.accept(",")) continue;
        (void)in_.expect("]");
      }
      if (in_.accept(":")) {
        one.is_out = in_.accept("OUT");
        if (!one.is_out) (void)in_.expect("IN");
      } else {
        one.is_out = true;  // as KRL has it
      }
      made.parameters.push_back(std::move(one));
    } while (in_.accept(","));
    (void)in_.expect(")");
  }

  // -- Declarations --------------------------------------------------------------------------------------------------

  void data_line() {
    if (declares()) return declaration(module_.data);
    // An element of an array that was declared before: TAB[1]={...}
    const TextLocation at = in_.peek().at;
    const std::string name = in_.expect_name("a declaration");
    const auto known = std::ranges::find(module_.data, name, &Declaration::name);
    if (known == module_.data.end()) {
      in_.error(at, Code::kSyntax, fmt::format("'{}' begins no declaration", name), "Write DECL TYPE NAME=VALUE");
      return in_.skip_line();
    }
    std::vector<int> index;
    if (in_.expect("[")) index = numbers();
    if (in_.expect("=")) known->initial.emplace_back(std::move(index), in_.expression());
    in_.end_line();
  }

  std::vector<int> numbers() {
    std::vector<int> all;
    if (in_.accept("]")) return all;
    do {
      const Token token = in_.at_line_end() ? in_.peek() : in_.take();
      if (token.kind != Token::Kind::kNumber || token.value.kind != Value::Kind::kInt)
        in_.error(token.at, Code::kSyntax, "not a whole number", "Write a number");
      all.push_back(static_cast<int>(token.value.integer));
    } while (in_.accept(","));
    (void)in_.expect("]");
    return all;
  }

  [[nodiscard]] bool declares() const {
    const Token& first = in_.peek();
    if (first.kind != Token::Kind::kName) return false;
    for (const char* word : {"DECL", "GLOBAL", "CONST", "STRUC", "ENUM", "EXT", "EXTP", "EXTFCT", "EXTFCTP", "SIGNAL"})
      if (first.text == word && !(first.text == "GLOBAL" && in_.peek(1).is("INTERRUPT"))) return true;
    const bool keyword =
        one_of(kMotionWords, first.text) || one_of(kUnsupportedWords, first.text) || one_of(kBlockEnds, first.text);
    constexpr std::array kStatements{"IF",    "LOOP",    "WHILE",    "REPEAT", "FOR",    "SWITCH",     "GOTO",
                                     "EXIT",  "HALT",    "WAIT",     "RETURN", "BRAKE",  "RESUME",     "INTERRUPT",
                                     "PULSE", "TRIGGER", "CONTINUE", "SPLINE", "GLOBAL", "PTP_SPLINE", "ELSEIF"};
    return !keyword && !one_of(kStatements, first.text) && in_.peek(1).kind == Token::Kind::kName;
  }

  void declaration(std::vector<Declaration>& to) {
    bool is_global = false, is_constant = false;
    for (;;) {
      if (in_.accept("GLOBAL")) {
        is_global = true;
      } else if (in_.accept("CONST")) {
        is_constant = true;
      } else if (!in_.accept("DECL")) {
        break;
      }
    }
    if (in_.sees("STRUC")) return structure();
    if (in_.sees("ENUM")) return enumeration();
    if (in_.sees("SIGNAL")) return signal();
    if (in_.peek().text.starts_with("EXT") && in_.peek().kind == Token::Kind::kName) return in_.skip_line();
    if (in_.sees("INTERRUPT")) {
      in_.error(in_.peek().at, Code::kSyntax, "an interrupt among the declarations", "Declare it in a program");
      return in_.skip_line();
    }
    variables(to, is_global, is_constant);
    in_.end_line();
  }

  void variables(std::vector<Declaration>& to, bool is_global, bool is_constant) {
    const std::string type = in_.expect_name("a type");
    do {
      Declaration one;
      one.type = type;
      one.at = in_.peek().at;
      one.is_global = is_global;
      one.is_constant = is_constant;
      one.name = in_.expect_name("the name of a variable");
      if (in_.accept("[")) one.size = in_.list("]");
      if (in_.accept("=")) one.initial.emplace_back(std::vector<int>(), in_.expression());
      to.push_back(std::move(one));
    } while (in_.accept(","));
  }

  void structure() {
    TypeDeclaration made;
    (void)in_.take();
    made.at = in_.peek().at;
    made.name = in_.expect_name("the name of a structure");
    std::string type;
    do {
      if (in_.peek(1).kind == Token::Kind::kName) type = in_.expect_name("a type");
      Declaration field;
      field.type = type;
      field.at = in_.peek().at;
      field.name = in_.expect_name("the name of a component");
      if (in_.accept("[")) field.size = in_.list("]");
      made.fields.push_back(std::move(field));
    } while (in_.accept(","));
    in_.end_line();
    module_.types.push_back(std::move(made));
  }

  void enumeration() {
    TypeDeclaration made;
    made.is_enumeration = true;
    (void)in_.take();
    made.at = in_.peek().at;
    made.name = in_.expect_name("the name of an enumeration");
    do {
      made.constants.push_back(in_.expect_name("a constant"));
    } while (in_.accept(","));
    in_.end_line();
    module_.types.push_back(std::move(made));
  }

  void signal() {
    Signal made;
    (void)in_.take();
    made.at = in_.peek().at;
    made.name = in_.expect_name("the name of a signal");
    made.first = in_.primary();
    if (in_.accept("TO")) made.last = in_.primary();
    in_.end_line();
    module_.signals.push_back(std::move(made));
  }

  // -- Statements ----------------------------------------------------------------------------------------------------

  [[nodiscard]] bool at_block_end() const {
    const Token& token = in_.peek();
    if (token.kind != Token::Kind::kName) return false;
    if (token.text == "GLOBAL") return in_.peek(1).is("DEF") || in_.peek(1).is("DEFFCT");
    return one_of(kBlockEnds, token.text);
  }

  Block block() {
    Block made;
    if (in_.depth >= ParserState::kMostDepth) {
      in_.error(in_.peek().at, Code::kTooLarge, fmt::format("blocks nest more than {} deep", ParserState::kMostDepth),
                "Move a part of it into a program of its own");
      while (!in_.at_end()) in_.skip_line();
      return made;
    }
    ++in_.depth;
    for (in_.skip_empty_lines(); !in_.at_end() && !at_block_end(); in_.skip_empty_lines()) {
      if (function_ != nullptr && declares()) {
        declaration(function_->declarations);
        continue;
      }
      if (++count_ > kMostStatements) {
        in_.error(in_.peek().at, Code::kTooLarge, fmt::format("more than {} statements", kMostStatements),
                  "Split the module");
        while (!in_.at_end()) in_.skip_line();
        break;
      }
      made.push_back(statement());
    }
    --in_.depth;
    return made;
  }

  Statement statement() {
    Statement made = simple();
    // What was not closed leaves the end of another block for that block.
    if (!std::exchange(unclosed_, false)) in_.end_line();
    return made;
  }

  void close(std::string_view word) { unclosed_ = !in_.expect(word); }

  /// All of a statement but the end of its last line.
  Statement simple() {
    Statement made;
    made.at = in_.peek().at;
    made.text = in_.rest_of_line();
    const Token first = in_.peek();
    if (first.kind != Token::Kind::kName) {
      in_.error(first.at, Code::kSyntax, "no statement begins like this", "Write a statement");
      while (!in_.at_line_end()) (void)in_.take();
      return made;
    }
    if (in_.peek(1).is(":") && in_.peek(2).kind == Token::Kind::kLineEnd) {
      made.kind = Kind::kLabel;
      made.word = in_.take().text;
      (void)in_.take();
      return made;
    }
    if (one_of(kUnsupportedWords, first.text) && !in_.peek(1).is("=")) return unsupported(made, first);
    if (one_of(kMotionWords, first.text)) return motion(made);
    if (first.text == "GLOBAL" || first.text == "INTERRUPT") return interrupt(made);
    struct Word {
      std::string_view word;
      void (Parser::*read)(Statement&);
    };
    static constexpr std::array<Word, 19> kWords{{{"IF", &Parser::condition},
                                                  {"LOOP", &Parser::loop},
                                                  {"WHILE", &Parser::while_loop},
                                                  {"REPEAT", &Parser::repeat},
                                                  {"FOR", &Parser::count},
                                                  {"SWITCH", &Parser::selection},
                                                  {"GOTO", &Parser::jump},
                                                  {"EXIT", &Parser::exit},
                                                  {"RETURN", &Parser::leave},
                                                  {"HALT", &Parser::halt},
                                                  {"CONTINUE", &Parser::advance},
                                                  {"WAIT", &Parser::wait},
                                                  {"SPLINE", &Parser::spline},
                                                  {"PTP_SPLINE", &Parser::spline},
                                                  {"TRIGGER", &Parser::trigger},
                                                  {"BRAKE", &Parser::brake},
                                                  {"RESUME", &Parser::resume},
                                                  {"PULSE", &Parser::pulse},
                                                  {"ELSEIF", &Parser::no_elseif}}};
    const auto found = std::ranges::find(kWords, first.text, &Word::word);
    if (found == kWords.end()) return assignment(made);
    (void)in_.take();
    (this->*found->read)(made);
    return made;
  }

  Statement unsupported(Statement& made, const Token& word) {
    in_.error(word.at, Code::kUnsupported, fmt::format("'{}' is not supported", word.text),
              "Remove it; docs/krl.md lists what is supported");
    while (!in_.at_line_end()) (void)in_.take();
    return std::move(made);
  }

  Statement assignment(Statement& made) {
    made.a = in_.primary();
    if (in_.accept("=")) {
      made.kind = Kind::kAssign;
      made.b = in_.expression();
    } else {
      made.kind = Kind::kCall;
      if (made.a->kind != Expression::Kind::kCall)
        in_.error(made.at, Code::kSyntax, fmt::format("'{}' is no statement", to_string(*made.a)),
                  "Write an assignment, or a call with ( )");
    }
    return std::move(made);
  }

  void condition(Statement& made) {
    made.kind = Kind::kIf;
    made.a = in_.expression();
    (void)in_.expect("THEN");
    in_.end_line();
    made.body = block();
    if (in_.accept("ELSE")) {
      in_.end_line();
      made.flag = true;
      made.otherwise = block();
    }
    close("ENDIF");
  }
  void no_elseif(Statement& made) {
    in_.error(made.at, Code::kSyntax, "KRL has no ELSEIF", "Write ELSE and another IF");
    while (!in_.at_line_end()) (void)in_.take();
  }
  void loop(Statement& made) {
    made.kind = Kind::kLoop;
    in_.end_line();
    made.body = block();
    close("ENDLOOP");
  }
  void while_loop(Statement& made) {
    made.kind = Kind::kWhile;
    made.a = in_.expression();
    in_.end_line();
    made.body = block();
    close("ENDWHILE");
  }
  void repeat(Statement& made) {
    made.kind = Kind::kRepeat;
    in_.end_line();
    made.body = block();
    close("UNTIL");
    made.a = unclosed_ ? std::make_unique<Expression>() : in_.expression();
  }
  void count(Statement& made) {
    made.kind = Kind::kFor;
    made.a = in_.primary();
    if (in_.expect("=")) made.b = in_.expression();
    if (in_.expect("TO")) made.c = in_.expression();
    if (in_.accept("STEP")) made.d = in_.expression();
    in_.end_line();
    made.body = block();
    close("ENDFOR");
  }
  void selection(Statement& made) {
    made.kind = Kind::kSwitch;
    made.a = in_.expression();
    in_.end_line();
    in_.skip_empty_lines();
    while (in_.sees("CASE") || in_.sees("DEFAULT")) {
      Case one;
      if (in_.take().text == "CASE") {
        do {
          one.labels.push_back(in_.expression());
        } while (in_.accept(","));
      }
      in_.end_line();
      one.body = block();
      made.cases.push_back(std::move(one));
    }
    close("ENDSWITCH");
  }
  void jump(Statement& made) {
    made.kind = Kind::kGoto;
    made.word = in_.expect_name("a label");
  }
  void exit(Statement& made) { made.kind = Kind::kExit; }
  void leave(Statement& made) {
    made.kind = Kind::kReturn;
    if (!in_.at_line_end()) made.a = in_.expression();
  }
  void halt(Statement& made) { made.kind = Kind::kHalt; }
  void advance(Statement& made) { made.kind = Kind::kContinue; }
  void wait(Statement& made) {
    if (in_.accept("SEC")) {
      made.kind = Kind::kWaitSeconds;
    } else {
      made.kind = Kind::kWaitFor;
      (void)in_.expect("FOR");
    }
    made.a = in_.expression();
  }
  void brake(Statement& made) {
    made.kind = Kind::kBrake;
    made.flag = in_.accept("F");
  }
  void resume(Statement& made) { made.kind = Kind::kResume; }
  void pulse(Statement& made) {
    made.kind = Kind::kPulse;
    if (!in_.expect("(")) return;
    made.a = in_.primary();
    if (in_.expect(",")) made.b = in_.expression();
    if (in_.expect(",")) made.c = in_.expression();
    (void)in_.expect(")");
  }

  Statement motion(Statement& made) {
    made.kind = Kind::kMotion;
    made.word = in_.take().text;
    do {
      if (in_.accept("CA")) {
        made.c = in_.expression();
      } else if (in_.peek().kind == Token::Kind::kConstant &&
                 (in_.peek().text == "BASE" || in_.peek().text == "TOOL")) {
        made.flag = in_.take().text == "TOOL";
      } else {
        made.goals.push_back(in_.expression());
      }
    } while (in_.accept(","));
    ending(made);
    if (made.word.ends_with("_REL") && in_.peek().kind == Token::Kind::kConstant) {
      const Token frame = in_.take();
      made.flag = frame.text == "TOOL";
      if (frame.text != "TOOL" && frame.text != "BASE")
        in_.error(frame.at, Code::kInvalidValue, fmt::format("#{} is no frame of a motion", frame.text),
                  "Use #BASE or #TOOL");
    }
    const std::size_t wanted = made.word.find("CIRC") != std::string::npos ? 2 : 1;
    if (made.goals.size() != wanted)
      in_.error(made.at, Code::kWrongSize, fmt::format("{} with {} points", made.word, made.goals.size()),
                wanted == 2 ? "Give a point on the way and the goal" : "Give one goal");
    return std::move(made);
  }

  /// WITH and what is approximated.
  void ending(Statement& made) {
    while (in_.peek().kind == Token::Kind::kName) {
      const Token word = in_.peek();
      if (in_.accept("WITH")) {
        do {
          auto target = in_.primary();
          if (!in_.expect("=")) return;
          made.with.emplace_back(std::move(target), in_.expression());
        } while (in_.accept(","));
      } else if (one_of(kApproximations, word.text)) {
        made.approximation.push_back(in_.take().text);
      } else {
        return;
      }
    }
  }

  void spline(Statement& made) {
    made.kind = Kind::kSpline;
    made.word = made.text.starts_with('P') || made.text.starts_with('p') ? "PTP_SPLINE" : "SPLINE";
    if (made.word == "PTP_SPLINE")
      in_.error(made.at, Code::kUnsupported, "'PTP_SPLINE' is not supported", "Use SPLINE, or single SPTP motions");
    ending(made);
    in_.end_line();
    made.body = block();
    for (const Statement& one : made.body) {
      const bool segment =
          one.kind == Kind::kMotion && one.word.starts_with('S') && one.word != "SPTP" && one.word != "SPTP_REL";
      if (!segment)
        in_.error(one.at, Code::kUnsupported, "no segment of a spline", "Use SPL, SLIN and SCIRC inside of SPLINE");
    }
    close("ENDSPLINE");
    ending(made);
  }

  void trigger(Statement& made) {
    made.kind = Kind::kTrigger;
    (void)in_.expect("WHEN");
    if (in_.sees("DISTANCE") || in_.sees("PATH")) {
      made.word = in_.take().text;
    } else {
      (void)in_.expect("DISTANCE");
    }
    if (in_.expect("=")) made.a = in_.expression();
    made.flag = in_.accept("ONSTART");
    if (in_.expect("DELAY") && in_.expect("=")) made.b = in_.expression();
    if (!in_.expect("DO")) return;
    ++in_.depth;
    made.body.push_back(simple());
    --in_.depth;
    if (in_.accept("PRIO") && in_.expect("=")) made.c = in_.expression();
    const Kind kind = made.body.front().kind;
    if (kind != Kind::kAssign && kind != Kind::kCall && kind != Kind::kPulse)
      in_.error(made.body.front().at, Code::kUnsupported, "what a trigger cannot do",
                "Use an assignment, PULSE or a call");
  }

  Statement interrupt(Statement& made) {
    made.flag = in_.accept("GLOBAL");
    if (!in_.expect("INTERRUPT")) return std::move(made);
    if (in_.accept("DECL")) {
      made.kind = Kind::kInterruptDeclare;
      made.a = in_.expression();
      if (in_.expect("WHEN")) made.b = in_.expression();
      if (!in_.expect("DO")) return std::move(made);
      made.c = in_.primary();
      if (made.c->kind != Expression::Kind::kCall)
        in_.error(made.c->at, Code::kUnsupported, "an interrupt that calls no program", "Write DO NAME ( )");
      return std::move(made);
    }
    made.kind = Kind::kInterruptSwitch;
    constexpr std::array kSwitches{"ON", "OFF", "ENABLE", "DISABLE"};
    const Token word = in_.at_line_end() ? in_.peek() : in_.take();
    if (word.kind != Token::Kind::kName || !one_of(kSwitches, word.text)) {
      in_.error(word.at, Code::kSyntax, "unexpected word behind INTERRUPT", "Write DECL, ON, OFF, ENABLE or DISABLE");
      return std::move(made);
    }
    made.word = word.text;
    if (!in_.at_line_end()) made.a = in_.expression();
    return std::move(made);
  }

  ParserState in_;
  Module& module_;
  Function* function_ = nullptr;
  int count_ = 0;
  bool unclosed_ = false;
};

}  // namespace

Module parse_module(const ModuleText& text, Diagnostics& diagnostics) {
  Module module;
  module.name = text.name;
  for (char& c : module.name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  module.file = text.file;
  module.data_file = text.data_file;
  if (!text.source.empty()) Parser(text.source, text.file, diagnostics, module).source();
  if (!text.data.empty()) Parser(text.data, text.data_file, diagnostics, module).data();
  return module;
}

}  // namespace takt::languages::krl
