// The programs of examples/activities as they are, chosen by name.
#include <cstdio>
#include <map>
#include <string>

#include <takt/takt.h>

#include "tests/serve/programs/start_latencies.h"

#define main program
namespace first_motion {
#include "examples/activities/01_first_motion.cc"
}
namespace pick_and_place {
#include "examples/activities/02_pick_and_place.cc"
}
namespace screw {
#include "examples/activities/03_screw.cc"
}
namespace blending {
#include "examples/activities/04_blending.cc"
}
namespace beside_each_other {
#include "examples/activities/05_beside_each_other.cc"
}
namespace start_of_motion {
#include "examples/activities/06_start_of_motion.cc"
}
namespace two_arms {
#include "examples/activities/07_two_arms.cc"
}
namespace screw_as_command {
#include "examples/activities/08_screw_as_command.cc"
}
namespace wrong_use {
#include "examples/activities/09_wrong_use.cc"
}
namespace by_hand {
#include "examples/activities/10_by_hand.cc"
}
#undef main

int main(int argc, char** argv) {
  const std::map<std::string, int (*)(int, char**)> programs = {
      {"01_first_motion", first_motion::program},
      {"02_pick_and_place", pick_and_place::program},
      {"03_screw", screw::program},
      {"04_blending", blending::program},
      {"05_beside_each_other", beside_each_other::program},
      {"06_start_of_motion", start_of_motion::program},
      {"07_two_arms", two_arms::program},
      {"08_screw_as_command", screw_as_command::program},
      {"start_latencies", takt::test::measure_start_latencies},
      {"09_wrong_use", wrong_use::program},
      {"10_by_hand", by_hand::program}};
  const auto found = argc > 1 ? programs.find(argv[1]) : programs.end();
  if (found != programs.end()) return found->second(argc - 1, argv + 1);
  for (const auto& [name, program] : programs) std::printf("%s\n", name.c_str());
  return 2;
}
