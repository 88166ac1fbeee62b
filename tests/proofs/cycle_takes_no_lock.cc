// RealtimeSanitizer over the cycle: allocation, locks, files, sockets, sleep inside ControlCore::step() end the program
// with a report. GCC knows no such option; its runtime (clang 19) is linked whole, and this file says where the cycle
// begins and ends. A program of motions, guarded motions, a tare and stops runs on a cell without physics.
//
//   proof_cycle_takes_no_lock            status 0 if the cycle is clean
//   proof_cycle_takes_no_lock --plant X  does X (malloc, lock, file, sleep) inside the cycle: must be reported
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string_view>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/program/tree/program.h"
#include "tests/support/fake_cell.h"

extern "C" {
void __rtsan_init();
void __rtsan_realtime_enter();
void __rtsan_realtime_exit();
}

namespace takt::test {

// The sanitizer intercepts the allocator itself: the counting one of the other tests stays out.
AllocationGuard::AllocationGuard() : before_(0) {}
std::size_t AllocationGuard::count() const { return 0; }

namespace {

constexpr const char* kProgram = R"({"do": "sequence", "steps": [
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.04]}},
    {"do": "tare", "cycles": 50},
    {"do": "lin", "to": {"by_m": [0, 0, -0.025]}, "velocity_m_s": 0.02,
     "until": {"sensor": "wrist", "above_N": 5}},
    {"do": "record_contact", "as": "top"},
    {"do": "lin", "to": {"by_m": [0, 0, 0.03]}},
    {"do": "wait", "seconds": 0.05}]})";

/// What a cycle must not do, done on purpose.
void plant(std::string_view fault) {
  static std::mutex mutex;
  if (fault == "malloc") {
    void* volatile memory = std::malloc(64);
    std::free(memory);
  } else if (fault == "lock") {
    const std::scoped_lock lock(mutex);
  } else if (fault == "file") {
    if (std::FILE* file = std::fopen("README.md", "r")) (void)std::fclose(file);
  } else if (fault == "sleep") {
    std::this_thread::sleep_for(std::chrono::microseconds(1));
  }
}

int run(std::string_view fault) {
  FakeCell fake;
  long cycles = 0;
  fake.run_cycle = [&] {
    ++cycles;
    __rtsan_realtime_enter();
    fake.core.step();
    if (cycles == 100) plant(fault);
    __rtsan_realtime_exit();
  };
  const auto program = program::Program::parse(nlohmann::ordered_json::parse(kProgram), "/program", fake.cell);
  if (!program) {
    std::fprintf(stderr, "%s\n", program.error().to_string().c_str());
    return 2;
  }
  activity::Variables variables;
  activity::Context context{fake.cell, fake.core, variables, 2, [](auto, auto, auto) {}};
  program::ProgramRunner runner(*program, context);
  while (runner.advance() == operations::Progress::kRunning && cycles < 100'000) fake.step();
  const bool done = runner.progress() == operations::Progress::kDone;
  // A stop in full motion, too.
  const auto move = program::Program::parse(
      nlohmann::ordered_json::parse(R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}})"), "/program", fake.cell);
  program::ProgramRunner stopped(*move, context);
  for (int i = 0; i < 200 && stopped.advance() == operations::Progress::kRunning; ++i) fake.step();
  const bool moving = !fake.core_arm().at_rest();
  fake.core.stop_all(net::Cause::Code::kAborted, "a stop in motion");
  fake.step(1000);
  std::printf("%ld cycles under RealtimeSanitizer, nothing reported\n", cycles);
  return done && moving && fake.core_arm().at_rest() && !testing::Test::HasFailure() ? 0 : 1;
}

}  // namespace
}  // namespace takt::test

int main(int argc, char** argv) {
  __rtsan_init();
  testing::InitGoogleTest(&argc, argv);  // the cell speaks through it
  return takt::test::run(argc == 3 && std::strcmp(argv[1], "--plant") == 0 ? argv[2] : "");
}
