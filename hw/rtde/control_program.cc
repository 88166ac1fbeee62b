#include "hw/rtde/control_program.h"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace takt::hw::rtde {

namespace {

// The driver's half of the program is hw/rtde/driver.cc: every package carries a number, a mode and six joint
// positions. A package counts once. Without a new one the arm goes on as it moved for a few cycles and then brakes; it
// stays where it is until the driver has said "idle".
constexpr std::string_view kProgram = R"(def takt_control():
  FIRST = {first}
  STEP = {step}
  BRIDGED = {bridged}
  DECELERATION = {deceleration}
  write_output_integer_register(FIRST + 2, {mark})
  write_output_integer_register(FIRST + 1, read_input_integer_register(FIRST))
  rtde_set_watchdog("input_int_register_{first}", {watchdog}, "stop")
  goal = get_target_joint_positions()
  before = goal
  last = read_input_integer_register(FIRST)
  missed = 0
  moving = False
  stopped = False
  state = 1
  mode = 0
  while mode != 9:
    sequence = read_input_integer_register(FIRST)
    mode = read_input_integer_register(FIRST + 1)
    fresh = sequence != last
    last = sequence
    if mode == 0:
      stopped = False
      state = 1
    end
    if mode == 1 and fresh:
      i = 0
      while i < 6:
        before[i] = goal[i]
        goal[i] = read_input_float_register(FIRST + i)
        i = i + 1
      end
      if not moving:
        before = goal
      end
      missed = 0
    elif mode == 1:
      i = 0
      while i < 6:
        here = goal[i]
        goal[i] = here + here - before[i]
        before[i] = here
        i = i + 1
      end
      missed = missed + 1
    end
    if mode == 1 and missed > BRIDGED:
      stopped = True
      state = 3
    end
    write_output_integer_register(FIRST + 1, sequence)
    if mode == 1 and not stopped:
      state = 2
      moving = True
      write_output_integer_register(FIRST, state)
      servoj(goal, 0, 0, STEP, {lookahead}, {gain})
    else:
      if moving:
        write_output_integer_register(FIRST, 3)
        stopj(DECELERATION)
        moving = False
        goal = get_target_joint_positions()
      end
      write_output_integer_register(FIRST, state)
      if mode == 4:
        write_output_integer_register(FIRST, 4)
        freedrive_mode()
        while read_input_integer_register(FIRST + 1) == 4:
          write_output_integer_register(FIRST + 1, read_input_integer_register(FIRST))
          sync()
        end
        end_freedrive_mode()
        goal = get_target_joint_positions()
      end
      sync()
    end
  end
  write_output_integer_register(FIRST, 5)
end
)";

}  // namespace

double ControlProgram::share() const { return 1.0 - std::exp(-1.0 / (version.frequency() * lag())); }

std::string ControlProgram::text() const {
  return fmt::format(fmt::runtime(kProgram), fmt::arg("first", registers.first()),
                     fmt::arg("step", version.frequency() == 500 ? "0.002" : "0.008"),
                     fmt::arg("bridged", bridged_cycles), fmt::arg("deceleration", deceleration),
                     fmt::arg("mark", mark), fmt::arg("watchdog", watchdog_hz), fmt::arg("lookahead", lookahead),
                     fmt::arg("gain", gain));
}

}  // namespace takt::hw::rtde
