#include "tools/machine.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include "core/rcc/control_core.h"
#include "core/rcc/realtime_clock.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

/// The content without the last line feed; nothing: there is no such file, or it may not be read.
std::optional<std::string> text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text;
}

MachineFinding kernel(const fs::path& root) {
  const std::string version = text_of(root / "proc/version").value_or("unknown");
  const bool realtime = text_of(root / "sys/kernel/realtime") == "1" || version.contains("PREEMPT_RT");
  return {"kernel", realtime, realtime ? "with PREEMPT_RT" : "without PREEMPT_RT",
          realtime ? "" : "a kernel with PREEMPT_RT; on Debian: apt install linux-image-rt-amd64"};
}

MachineFinding virtual_machine(const fs::path& root) {
  const bool guest = text_of(root / "proc/cpuinfo").value_or("").contains(" hypervisor");
  return {"machine", !guest, guest ? "a virtual machine" : "no virtual machine",
          guest ? "a machine of its own: a hypervisor takes the processor away for milliseconds" : ""};
}

MachineFinding processors(const fs::path& root) {
  const std::string isolated = text_of(root / "sys/devices/system/cpu/isolated").value_or("");
  const unsigned count = std::max(1u, std::thread::hardware_concurrency());
  const bool enough = count >= 2;
  if (!enough) return {"processors", false, "one", "two or more: the cycle wants one for itself"};
  return {"processors", !isolated.empty(),
          fmt::format("{}, {}", count, isolated.empty() ? "none isolated" : "isolated: " + isolated),
          isolated.empty() ? "one kept free by the kernel's options isolcpus=N nohz_full=N rcu_nocbs=N" : ""};
}

MachineFinding governor(const fs::path& root) {
  const auto name = text_of(root / "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  const bool good = !name || *name == "performance";
  return {"frequency", good, name ? fmt::format("governor '{}'", *name) : "not governed by this system",
          good ? "" : "cpupower frequency-set -g performance"};
}

MachineFinding idle_states(const fs::path& root) {
  const fs::path file = root / "dev/cpu_dma_latency";
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return {"idle states", true, "not controlled by this system", ""};
  const bool may = std::ofstream(file, std::ios::binary | std::ios::app).good();
  return {"idle states", may, may ? "may be held off" : "deep ones cannot be held off",
          may ? "" : "write access to /dev/cpu_dma_latency, or the kernel's option processor.max_cstate=1"};
}

MachineFinding throttling(const fs::path& root) {
  const auto runtime = text_of(root / "proc/sys/kernel/sched_rt_runtime_us");
  const bool good = !runtime || *runtime == "-1";
  return {"throttling", good, good ? "off" : fmt::format("real-time threads get {} us of each second", *runtime),
          good ? "" : "sysctl kernel.sched_rt_runtime_us=-1, once nothing else runs away"};
}

MachineFinding clock_source(const fs::path& root) {
  const auto name = text_of(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  const bool good = name && (*name == "tsc" || *name == "kvm-clock" || *name == "arch_sys_counter");
  return {"clock", good, name.value_or("unknown"), good ? "" : "the processor's own counter: clocksource=tsc"};
}

MachineFinding scheduling() {
  int error = 0;
  std::thread([&error] {
    const sched_param parameters{.sched_priority = 80};
    error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  }).join();
  return {"scheduling", error == 0, error == 0 ? "SCHED_FIFO is permitted" : "SCHED_FIFO is not permitted",
          error == 0 ? "" : "a line 'YOU - rtprio 90' in /etc/security/limits.d/takt.conf, then log in again"};
}

MachineFinding memory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const bool all = limit.rlim_cur == RLIM_INFINITY;
  const bool may = mlockall(MCL_CURRENT) == 0;
  if (may) munlockall();
  const bool good = all || may;
  return {"memory", good, good ? "may be locked" : fmt::format("only {} KiB may be locked", limit.rlim_cur / 1024),
          good ? "" : "a line 'YOU - memlock unlimited' in /etc/security/limits.d/takt.conf, then log in again"};
}

}  // namespace

std::vector<MachineFinding> look_at_machine(const fs::path& root) {
  return {kernel(root),     virtual_machine(root), processors(root), governor(root), idle_states(root),
          throttling(root), clock_source(root),    scheduling(),     memory()};
}

MeasuredCycles measure_cycles(double seconds, int processor) {
  rcc::ControlCore core({});
  rcc::RealtimeClock clock({.processor = processor, .overrun_limit = std::numeric_limits<int>::max(), .watchdog = 0});
  MeasuredCycles measured;
  std::jthread cycle([&](const std::stop_token& stop) {
    const auto granted = clock.run(core, stop);
    measured.realtime_scheduling = granted.realtime_scheduling;
    measured.locked_memory = granted.locked_memory;
  });
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  cycle.request_stop();
  cycle.join();
  munlockall();
  measured.wakeups = clock.wakeups();
  return measured;
}

}  // namespace takt::tools
