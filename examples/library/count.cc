// Runs a net in the control core, in lock-step: a stopwatch ends it after three seconds, a monitor shows the cycles.
#include <cstdio>

#include "core/net/description.h"
#include "core/rcc/control_core.h"

using namespace takt;

int main() {
  net::NetDescription description;
  description.name = "count";
  description.add("time", "Stopwatch", {{"running", true}})
      .add("over", "GreaterThan", {{"b", 2.9985}})
      .add("end", "Termination")
      .add("cycles", "CycleCounter", {{"counted", true}})
      .link("time.elapsed", "over.a")
      .link("over.value", "end.condition");

  rcc::ControlCore core({});
  const auto net = core.load(description);
  if (!net) {
    std::fputs(net.error().to_string().c_str(), stderr);
    return 2;
  }
  core.start(*net);
  while (core.state(*net) != rcc::NetState::kTerminated) core.step();
  const auto* cycles = core.net(*net)->find<net::Integer>("cycles.count");
  std::printf("3 seconds are %lld cycles\n", static_cast<long long>(cycles->value));
  return 0;
}
