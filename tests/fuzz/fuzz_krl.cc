// Any bytes as a program in KRL lead to a program, or to diagnostics with reasons; a program runs without harm, and the
// same again; printed and read again it is the same.
#include <string>
#include <string_view>

#include "languages/krl/lexer.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/languages/krl/trace_host.h"

namespace takt {
namespace {

namespace krl = languages::krl;
using test::demand;

std::string trace_of(const krl::Program& program) {
  krl::test::TraceHost host({{.at = 0.2, .input = 1, .value = 1.0}});
  krl::Machine machine(program, host);
  const auto progress = host.run(machine, 1.0);
  std::string trace = std::to_string(static_cast<int>(progress));
  for (const std::string& line : host.trace()) trace += line + "\n";
  return trace + machine.diagnostics().to_string();
}

void load(std::string_view input) {
  const std::size_t data = input.find("DEFDAT");
  krl::ModuleText text{"MAIN", "main.src", std::string(input.substr(0, data)), "main.dat",
                       data == std::string_view::npos ? std::string() : std::string(input.substr(data))};
  const auto program = krl::compile({text}, {});
  if (!program) return test::expect_reasons(program.error());
  demand(trace_of(**program) == trace_of(**program), "a program does the same again");
  const krl::Module& module = (*program)->modules.front();
  Diagnostics wrong;
  text.source = krl::print_source(module);
  text.data = krl::print_data(module);
  const krl::Module again = krl::parse_module(text, wrong);
  demand(wrong.empty(), "what is printed can be read");
  demand(krl::print_source(again) == text.source && krl::print_data(again) == text.data, "and is the same");
}

}  // namespace

const test::FuzzTarget& test::fuzz_target() {
  static const FuzzTarget target{.words = {"DEF MAIN()\n",
                                           "END\n",
                                           "DEFFCT INT F(X:IN)\n",
                                           "ENDFCT\n",
                                           "DECL INT I\n",
                                           "DEFDAT MAIN\n",
                                           "ENDDAT\n",
                                           "IF I THEN\n",
                                           "ELSE\n",
                                           "ENDIF\n",
                                           "LOOP\n",
                                           "ENDLOOP\n",
                                           "WHILE ",
                                           "ENDWHILE\n",
                                           "FOR I=1 TO 3\n",
                                           "ENDFOR\n",
                                           "REPEAT\n",
                                           "UNTIL ",
                                           "SWITCH I\n",
                                           "CASE 1\n",
                                           "DEFAULT\n",
                                           "ENDSWITCH\n",
                                           "GOTO L\n",
                                           "L:\n",
                                           "PTP ",
                                           "LIN ",
                                           "CIRC ",
                                           "SPLINE\n",
                                           "ENDSPLINE\n",
                                           "{X 1, Y 2}",
                                           "{A1 10}",
                                           " C_DIS",
                                           "TRIGGER WHEN DISTANCE=0 DELAY=0 DO ",
                                           "$OUT[1]=TRUE\n",
                                           "INTERRUPT DECL 1 WHEN $IN[1] DO MAIN()\n",
                                           "INTERRUPT ON 1\n",
                                           "BRAKE\n",
                                           "RESUME\n",
                                           "WAIT SEC 1\n",
                                           "STRUC S INT A\n",
                                           "ENUM E A, B\n",
                                           "#A",
                                           "$VEL.CP=1\n",
                                           "BAS(#INITMOV,0)\n",
                                           " : ",
                                           " AND ",
                                           "RETURN "},
                                 .load = load,
                                 .share = 0.0,
                                 .mutate = nullptr};
  return target;
}

}  // namespace takt
