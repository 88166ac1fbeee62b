// Any bytes as a program in URScript lead to a program, or to diagnostics with reasons; a program runs without harm,
// and the same again; printed and read again it is the same.
#include <string>
#include <string_view>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/languages/urscript/trace_host.h"

namespace takt {
namespace {

namespace urscript = languages::urscript;
using test::demand;

const std::set<std::string> kCalls{"close_gripper"};

std::string trace_of(const std::shared_ptr<const urscript::Program>& program) {
  urscript::test::TraceHost host({{.at = 0.02, .input = 1, .value = 1.0}});
  urscript::Session session(program, host, kCalls,
                            {{"part", urscript::Value(urscript::Pose{0.5, 0.2, 0.1, 0.0, 0.0, 0.0})}});
  const auto progress = host.run(session, 0.1);
  std::string trace = std::to_string(static_cast<int>(progress)) + session.error().text;
  for (const std::string& line : host.trace()) trace += line + "\n";
  return trace;
}

void load(std::string_view input) {
  urscript::Script script, again;
  urscript::ScriptErrors errors;
  if (urscript::parse(input, script, errors)) {
    const std::string text = urscript::print(script);
    demand(urscript::parse(text, again, errors), "what is printed can be read");
    demand(urscript::print(again) == text, "and is the same");
  } else {
    demand(!errors.empty(), "what is refused has a reason");
  }
  const auto program = urscript::compile_for_arm({"main.script", std::string(input)}, kCalls, {"part"});
  if (!program) return test::expect_reasons(program.error());
  demand(trace_of(*program) == trace_of(*program), "a program does the same again");
}

}  // namespace

const test::FuzzTarget& test::fuzz_target() {
  static const FuzzTarget target{.words = {"def main():\n",
                                           "end\n",
                                           "thread t():\n",
                                           "run t()\n",
                                           "join h\n",
                                           "kill h\n",
                                           "h = run t()\n",
                                           "if x:\n",
                                           "elif y:\n",
                                           "else:\n",
                                           "while True:\n",
                                           "break\n",
                                           "continue\n",
                                           "return x\n",
                                           "global x = 1\n",
                                           "local y = 2\n",
                                           "halt\n",
                                           "movej([0.1, 0, 0, 0, 0, 0], a=1, v=1)\n",
                                           "movel(p[0.1, 0, 0, 0, 0, 0], r=0.01)\n",
                                           "movec(part, part, mode=1)\n",
                                           "servoj(part, t=0.01)\n",
                                           "speedl([0, 0, 0.1, 0, 0, 0], 1, 0.1)\n",
                                           "stopj(2)\n",
                                           "sync()\n",
                                           "sleep(0.01)\n",
                                           "set_digital_out(1, True)\n",
                                           "get_digital_in(1)",
                                           "get_actual_tcp_pose()",
                                           "get_inverse_kin(part)",
                                           "pose_trans(part, part)",
                                           "interpolate_pose(part, part, 0.5)",
                                           "set_tcp(part)\n",
                                           "force_mode(part, [0,0,1,0,0,0], [0,0,5,0,0,0], 2, [1,1,1,1,1,1])\n",
                                           "end_force_mode()\n",
                                           "freedrive_mode()\n",
                                           "end_freedrive_mode()\n",
                                           "textmsg(x, y)\n",
                                           "make_list(10, 0)",
                                           "x[0] = 1\n",
                                           " and ",
                                           " not ",
                                           " % ",
                                           "close_gripper()\n"},
                                 .load = load,
                                 .share = 0.0,
                                 .mutate = nullptr};
  return target;
}

}  // namespace takt
