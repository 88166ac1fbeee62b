#include "record/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/record/support.h"
#include "tests/support/reports.h"

namespace takt::record {
namespace {

using takt::test::Reports;
using testing::ElementsAre;

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) lines.push_back(line.substr(0, line.find('\r')));
  return lines;
}

class ExportTest : public testing::Test {
 protected:
  void SetUp() override { record_run(folder_ / "a.mcap", 90); }
  [[nodiscard]] Recording recording() const { return Recording::open(folder_ / "a.mcap").value(); }

  TestFolder folder_{"export"};
};

TEST_F(ExportTest, ATableHasUnitsAndEmptyCellsForNull) {
  ASSERT_TRUE(write_csv(recording(), "/net/probe", folder_ / "p.csv"));
  const auto lines = lines_of(folder_ / "p.csv");
  ASSERT_EQ(lines.size(), 91u);
  EXPECT_EQ(lines[0], "time_s,speed [m/s],force.z [N],contact");
  EXPECT_EQ(lines[1], "0.000000000,0,,0");
  EXPECT_EQ(lines[8], "0.007000000,1.75,7,0");
}

TEST_F(ExportTest, NumbersHaveAllTheirDigits) {
  ASSERT_TRUE(write_csv(recording(), "/left/joints", folder_ / "j.csv"));
  const auto lines = lines_of(folder_ / "j.csv");
  EXPECT_EQ(std::stod(lines[18].substr(lines[18].find(',') + 1)), SampleRun::position(17, 0));
}

TEST_F(ExportTest, EventsAreTablesToo) {
  ASSERT_TRUE(write_csv(recording(), "/events", folder_ / "e.csv"));
  EXPECT_THAT(lines_of(folder_ / "e.csv"),
              ElementsAre("time_s,cycle,source,name,step,text", "0.000000000,0,net,started,a / b (2),cycle 0",
                          "0.040000000,40,net,started,,cycle 40", "0.080000000,80,net,started,a / b (2),cycle 80"));
}

TEST_F(ExportTest, WordsStandBesideTheNumbersOfAnEnumeration) {
  {
    auto recorder = Recorder::open(folder_ / "w.mcap").value();
    const ChannelId id =
        recorder->add_samples("/state", {"state", "x"}, {"", "m"}, {{"state", {"idle", "say \"hi\", you"}}});
    for (int k = 0; k < 3; ++k) {
      recorder->begin_cycle(k * kMillisecond, static_cast<std::uint64_t>(k));
      recorder->write(id, std::vector<double>{static_cast<double>(k), 0.5});
    }
    recorder->close();
  }
  ASSERT_TRUE(write_csv(Recording::open(folder_ / "w.mcap").value(), "/state", folder_ / "w.csv"));
  EXPECT_THAT(lines_of(folder_ / "w.csv"),
              ElementsAre("time_s,state,state.name,x [m]", "0.000000000,0,idle,0.5",
                          "0.001000000,1,\"say \"\"hi\"\", you\",0.5", "0.002000000,2,,0.5"));
}

TEST_F(ExportTest, APoseIsALineOfTheTumFormat) {
  ASSERT_TRUE(write_tum(recording(), "/frames", "tool", folder_ / "t.txt"));
  const auto lines = lines_of(folder_ / "t.txt");
  ASSERT_EQ(lines.size(), 90u);
  EXPECT_EQ(lines[10], "0.010000000 10 20 30 0.5 0.5 0.5 0.5");
  EXPECT_THAT(write_tum(recording(), "/frames", "tol", folder_ / "t.txt"),
              Reports(Code::kUnknownName, "", {"tol", "tool", "base"}));
  EXPECT_FALSE(write_tum(recording(), "/no/topic", "tool", folder_ / "t.txt"));
}

TEST_F(ExportTest, WhatCannotBeIsRefused) {
  EXPECT_FALSE(write_csv(recording(), "/none", folder_ / "n.csv"));
  EXPECT_THAT(write_csv(recording(), "/net/probe", folder_ / "none" / "n.csv"), Reports(Code::kFileNotWritable, ""));
  EXPECT_EQ(file_name_of("/left arm/joint_states"), "left_arm_joint_states");
  EXPECT_EQ(file_name_of("/"), "topic");
}

}  // namespace
}  // namespace takt::record
