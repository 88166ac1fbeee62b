// The table of threads that comes with the models, against the formulas of the standard.
#include "core/device/screw_thread.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/screwdriver.h"
#include "tests/support/reports.h"

namespace takt::device {
namespace {

TEST(ScrewThreadTable, TheModelsHaveMetricCoarseThreads) {
  const auto table = read_threads(ModelLibrary({"models"}));
  ASSERT_TRUE(table) << table.error().to_string();
  std::vector<std::string> sizes;
  for (const auto& [size, thread] : *table) {
    sizes.push_back(size);
    // ISO 724, rounded to micrometres there.
    EXPECT_NEAR(thread.pitch_diameter, thread.major - 0.649519 * thread.pitch, 1e-6) << size;
    EXPECT_NEAR(thread.minor, thread.major - 1.082532 * thread.pitch, 1e-6) << size;
  }
  EXPECT_THAT(sizes, testing::UnorderedElementsAre("M3", "M4", "M5", "M6", "M8", "M16"));
  EXPECT_DOUBLE_EQ(table->at("M6").pitch, 0.001);
  EXPECT_DOUBLE_EQ(table->at("M8").pitch, 0.00125);
  EXPECT_DOUBLE_EQ(table->at("M16").pitch, 0.002);
}

TEST(ScrewThreadTable, WhatDoesNotFitIsReported) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "takt_threads";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::copy("models/table", folder / "table", std::filesystem::copy_options::recursive);
  std::ofstream(folder / "threads.json") << R"({"threads": {"X1": {
    "pitch_m": 0.001, "major_m": 0.006, "pitch_diameter_m": 0.0065, "minor_m": 0.0049, "clearance_m": 0.0066,
    "head": {"diameter_m": 0.01, "height_m": 0.006, "socket_width_m": 0.005, "socket_depth_m": 0.003},
    "run_down_Nm": 0.06, "friction": 0.12}, "X2": {"pitch_m": -1}}})";
  const auto table = read_threads(ModelLibrary({folder}));
  std::filesystem::remove_all(folder);
  EXPECT_THAT(table, test::Reports(Code::kInvalidValue, "/threads/X1"));
  EXPECT_THAT(table, test::Reports(Code::kOutOfRange, "/threads/X2/pitch_m"));
}

TEST(ScrewdriverFile, ReadsTheModel) {
  const auto driver = read_screwdriver("models/screwdriver");
  ASSERT_TRUE(driver) << driver.error().to_string();
  EXPECT_EQ((*driver)->spindle, "spindle");
  EXPECT_EQ((*driver)->bit, "bit");
  EXPECT_NEAR((*driver)->X_MT.translation().z(), 0.19, 1e-9);
  EXPECT_NEAR((*driver)->payload.mass, 0.9, 1e-9);
  EXPECT_LT((*driver)->torque_min, (*driver)->torque_max);
}

}  // namespace
}  // namespace takt::device
