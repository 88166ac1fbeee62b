// What a program pays for the start of a motion, by the language that it is written in: CPU time of the program's part
// of a run (planning, mapping, LOAD, interpreter) for each motion, on an LWR 4+ that is always where it was sent.
// Prints milliseconds and the ratio to steps of a scenario file.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/runtime.h"
#include "core/base/random.h"
#include "core/device/device_file.h"
#include "core/program/tree/program.h"
#include "languages/program/krl_node.h"
#include "languages/program/urscript_node.h"
#include "tests/support/fake_arm.h"

namespace takt {
namespace {

using Json = nlohmann::ordered_json;

double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Cell {
  Cell() {
    auto model = device::read_arm("models/lwr4plus");
    if (!model) {
      std::fprintf(stderr, "run from the root of the repository\n%s", model.error().to_string().c_str());
      std::exit(2);
    }
    arm = *model;
    auto backend = std::make_shared<test::FakeArm>(arm->home);
    backend->keep = false;
    auto& device = core.add(std::make_unique<device::Arm>("arm", arm, backend, core.period()));
    (void)cell.frames.add("arm", "world", Eigen::Isometry3d::Identity());
    cell.arms["arm"] = {.device = &device, .start = arm->home};
    (void)activity::declare_channels(core, cell);
    core.step();
  }

  std::shared_ptr<const device::ArmDescription> arm;
  rcc::ControlCore core{{.digest = false}};
  expression::Cell cell;
  activity::Variables variables;
};

/// Milliseconds for each of `count` motions.
double measure(const Json& json, int count) {
  Cell cell;
  const auto program = program::Program::parse(json, "/program", cell.cell);
  if (!program) {
    std::fprintf(stderr, "%s", program.error().to_string().c_str());
    std::exit(2);
  }
  activity::Context context{.cell = cell.cell,
                            .core = cell.core,
                            .variables = cell.variables,
                            .event = [](std::string_view, std::string_view, std::string_view) {}};
  program::ProgramRunner runner(*program, context);
  double spent = 0.0;
  for (auto progress = operations::Progress::kRunning; progress == operations::Progress::kRunning;) {
    const double before = processor_time();
    progress = runner.advance();
    spent += processor_time() - before;
    if (progress == operations::Progress::kFailed) {
      std::fprintf(stderr, "%s", runner.diagnostics().to_string().c_str());
      std::exit(2);
    }
    cell.core.step();
  }
  return 1e3 * spent / count;
}

/// The same motions near home in each form.
struct Programs {
  Json steps, krl, urscript;
};
Programs programs(int count, bool lines) {
  Random random(2013);
  Json steps = Json::array();
  std::string krl = "DEF MAIN()\n$VEL.CP=0.25\n", script;
  for (int i = 0; i < count; ++i) {
    if (lines) {
      const double x = 0.5 + random.uniform(-0.1, 0.1), y = random.uniform(-0.2, 0.2),
                   z = 0.5 + random.uniform(-0.1, 0.1);
      steps.push_back({{"do", "lin"},
                       {"to", {{"in", "arm"}, {"position_m", {x, y, z}}, {"rpy_deg", {0, 180, 0}}}},
                       {"velocity_m_s", 0.25}});
      krl += fmt::format("LIN {{X {:.17g}, Y {:.17g}, Z {:.17g}, A 0.0, B 180.0, C 0.0}}\n", x * 1e3, y * 1e3, z * 1e3);
      script += fmt::format("{}(p[{:.17g}, {:.17g}, {:.17g}, 0, 3.141592653589793, 0]{})\n", i > 0 ? "movel" : "movej",
                            x, y, z, i > 0 ? ", v=0.25" : ", v=100");
      if (i > 0) continue;
      steps.back()["do"] = "ptp";
      steps.back().erase("velocity_m_s");
      krl.replace(krl.rfind("LIN"), 3, "PTP");
      continue;
    }
    Json joints = Json::array();
    const double q[] = {random.uniform(-40, 40),
                        random.uniform(-40, 0),
                        0.0,
                        random.uniform(40, 80),
                        0.0,
                        random.uniform(-70, -40),
                        0.0};
    for (const double one : q) joints.push_back(one);
    steps.push_back({{"do", "ptp"}, {"to", {{"joints_deg", joints}}}});
    krl += fmt::format("PTP {{A1 {:.17g}, A2 {:.17g}, E1 0, A3 {:.17g}, A4 0, A5 {:.17g}, A6 0}}\n", q[0], q[1], q[3],
                       q[5]);
    std::string radians;
    for (const double one : q) radians += fmt::format("{}{:.17g}", radians.empty() ? "" : ", ", one * M_PI / 180.0);
    script += fmt::format("movej([{}], v=100)\n", radians);
  }
  krl += "END\n";
  Json module{{"name", "MAIN"}, {"file", "main.src"}, {"source", krl}, {"data_file", ""}, {"data", ""}};
  return {{{"do", "sequence"}, {"steps", steps}},
          {{"do", "krl"}, {"program", {{"modules", Json::array({module})}}}},
          {{"do", "urscript"}, {"program", {{"file", "main.script"}, {"source", script}}}}};
}

}  // namespace
}  // namespace takt

int main(int argc, char** argv) {
  using namespace takt;
  program::add_node_kind(languages::krl_kind());
  program::add_node_kind(languages::urscript_kind());
  const int count = argc > 1 ? std::max(std::atoi(argv[1]), 2) : 200;
  for (const bool lines : {false, true}) {
    const auto [steps, krl, urscript] = programs(count, lines);
    double json_ms = 1e9, krl_ms = 1e9, urscript_ms = 1e9;
    for (int i = 0; i < 3; ++i) {
      json_ms = std::min(json_ms, measure(steps, count));
      krl_ms = std::min(krl_ms, measure(krl, count));
      urscript_ms = std::min(urscript_ms, measure(urscript, count));
    }
    fmt::print("{}  steps {:6.3f} ms  KRL {:6.3f} ms  ratio {:.2f}  URScript {:6.3f} ms  ratio {:.2f}\n",
               lines ? "LIN" : "PTP", json_ms, krl_ms, krl_ms / json_ms, urscript_ms, urscript_ms / json_ms);
  }
  return 0;
}
