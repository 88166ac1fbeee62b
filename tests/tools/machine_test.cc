#include "tools/machine.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

/// A file system with what a machine says of itself.
class MachineTest : public testing::Test {
 protected:
  MachineTest() : root(fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::remove_all(root);
  }
  ~MachineTest() override { fs::remove_all(root); }
  void write(const std::string& file, const std::string& text) const {
    fs::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text;
  }
  MachineFinding finding(const std::string& name) const {
    const auto all = look_at_machine(root);
    const auto found = std::ranges::find(all, name, &MachineFinding::name);
    if (found != all.end()) return *found;
    ADD_FAILURE() << "no finding '" << name << "'";
    return {};
  }

  fs::path root;
};

TEST_F(MachineTest, AMachineForRealTimeIsGood) {
  write("proc/version", "Linux version 6.1.0-rt7 (PREEMPT_RT)\n");
  write("proc/cpuinfo", "flags : fpu tsc\n");
  write("sys/devices/system/cpu/isolated", "3\n");
  write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  write("proc/sys/kernel/sched_rt_runtime_us", "-1\n");
  write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
  write("dev/cpu_dma_latency", "");
  for (const char* name : {"kernel", "machine", "frequency", "idle states", "throttling", "clock"}) {
    EXPECT_TRUE(finding(name).good) << name << ": " << finding(name).found;
    EXPECT_EQ(finding(name).change, "") << name;
  }
}

TEST_F(MachineTest, WhatIsPoorComesWithWhatToChange) {
  write("proc/version", "Linux version 6.1.0 SMP PREEMPT_DYNAMIC\n");
  write("proc/cpuinfo", "flags : fpu tsc hypervisor\n");
  write("sys/devices/system/cpu/isolated", "\n");
  write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n");
  write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
  write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  for (const char* name : {"kernel", "machine", "processors", "frequency", "throttling", "clock"}) {
    EXPECT_FALSE(finding(name).good) << name << ": " << finding(name).found;
    EXPECT_NE(finding(name).change, "") << name;
  }
  EXPECT_NE(finding("frequency").found.find("powersave"), std::string::npos);
  EXPECT_NE(finding("throttling").found.find("950000"), std::string::npos);
}

TEST_F(MachineTest, ASystemThatSaysNothingIsNoError) {
  EXPECT_FALSE(finding("kernel").good);
  EXPECT_FALSE(finding("clock").good);
  EXPECT_TRUE(finding("frequency").good) << "nobody governs it";
}

TEST(MeasuredCycles, CountsOneWakeUpAMillisecondAtMost) {
  const MeasuredCycles measured = measure_cycles(1.0);  // s: a busy machine needs some to begin
  EXPECT_GE(measured.wakeups.count(), 1);
  EXPECT_GE(measured.wakeups.worst(), measured.wakeups.quantile(0.5));
}

}  // namespace
}  // namespace takt::tools
