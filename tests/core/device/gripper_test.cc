#include "core/device/gripper.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/device_file.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/fake_signals.h"
#include "tests/support/reports.h"

namespace takt::device {
namespace {

using takt::test::Reports;

class GripperTest : public testing::Test {
 protected:
  /// @return why the guard tripped, or an empty text
  std::string cycle(std::optional<GripperSetPoint> wanted = {}) {
    gripper.begin_cycle(k, k * kMillisecond);
    backend->sample.stamp = k++ * kMillisecond;
    if (wanted) gripper.propose(wanted->width, wanted->speed, wanted->force);
    const auto trip = gripper.check();
    gripper.hand_over();
    return trip ? std::string(trip->view()) : std::string();
  }
  static GripperSetPoint wanted(double width, double speed = 0.1, double force = 40.0) {
    return {.sequence = 0, .width = width, .speed = speed, .force = force};
  }

  std::shared_ptr<test::FakeGripper> backend = std::make_shared<test::FakeGripper>();
  Gripper gripper{"gripper", std::make_shared<const GripperDescription>(test::fake_gripper_description()), backend};
  std::int64_t k = 0;
};

TEST_F(GripperTest, SendsNothingBeforeTheFirstCommandAndThenTheSameAgain) {
  cycle();
  EXPECT_EQ(backend->writes, 0);
  gripper.hold();
  cycle(wanted(0.02));
  cycle(wanted(0.02));
  cycle();
  EXPECT_EQ(backend->writes, 3);
  ASSERT_EQ(backend->written.size(), 1u) << "one command, whatever the number of cycles";
  EXPECT_EQ(backend->written[0].width, 0.02);
}

TEST_F(GripperTest, AStopWhileItIsNotReadyIsDoneWhenItIsAgain) {
  cycle();
  gripper.hold();
  cycle(wanted(0.0));
  backend->answer(GripperState::kMoving, 0.06);
  backend->sample.ready = false;
  cycle();
  gripper.stop();
  cycle();
  cycle();
  EXPECT_EQ(backend->written.size(), 1u) << "nobody would hear it";
  backend->sample.ready = true;
  cycle();
  ASSERT_EQ(backend->written.size(), 2u);
  EXPECT_EQ(backend->written[1].width, 0.06) << "it stays where it is";
  gripper.hold();
  cycle(wanted(0.0));
  ASSERT_EQ(backend->written.size(), 3u) << "the command that was interrupted counts anew";
}

TEST_F(GripperTest, IsAtRestWhenItHasAnsweredAndStands) {
  cycle();
  EXPECT_TRUE(gripper.at_rest());
  gripper.hold();
  cycle(wanted(0.02));
  EXPECT_FALSE(gripper.at_rest()) << "not answered yet";
  backend->answer(GripperState::kMoving, 0.05);
  cycle();
  EXPECT_FALSE(gripper.at_rest());
  backend->answer(GripperState::kHolding, 0.04);
  cycle();
  EXPECT_TRUE(gripper.at_rest());
}

TEST_F(GripperTest, GuardRefusesAndNeverClamps) {
  cycle();
  const std::pair<GripperSetPoint, std::vector<std::string>> wrong[] = {
      {wanted(std::nan("")), {"gripper"}},      {wanted(0.02, INFINITY), {"gripper"}},
      {wanted(-0.001), {"width", "-0.001"}},    {wanted(0.12), {"width", "0", "0.11", "m"}},
      {wanted(0.02, 0.5), {"speed", "0.5"}},    {wanted(0.02, 0.001), {"speed", "0.001"}},
      {wanted(0.02, 0.1, 81), {"force", "81"}}, {wanted(0.02, 0.1, 4), {"force", "5", "80", "N"}}};
  for (const auto& [command, names] : wrong) {
    gripper.hold();
    EXPECT_THAT(cycle(command), takt::test::NamesMatcher(names));
    EXPECT_TRUE(backend->written.empty());
    EXPECT_FALSE(gripper.held());
  }
}

TEST_F(GripperTest, StopKeepsAPartThatIsHeld) {
  cycle();
  gripper.hold();
  cycle(wanted(0.0));
  backend->answer(GripperState::kHolding, 0.04);
  cycle();
  gripper.stop();
  cycle();
  ASSERT_EQ(backend->written.size(), 1u) << "the grip goes on";
  EXPECT_FALSE(gripper.stops_in_emergency());
}

TEST_F(GripperTest, StopTakesBackAnOpeningThatHasNotBegun) {
  cycle();
  gripper.hold();
  cycle(wanted(0.0, 0.1, 60));
  backend->answer(GripperState::kHolding, 0.04);
  cycle();
  cycle(wanted(0.1));
  gripper.stop();
  cycle();
  ASSERT_EQ(backend->written.size(), 3u);
  EXPECT_EQ(backend->written[2].width, 0.0) << "the part was still held: so it stays";
  EXPECT_EQ(backend->written[2].force, 60.0);
}

TEST_F(GripperTest, StopHaltsFingersOnTheirWay) {
  cycle();
  gripper.hold();
  cycle(wanted(0.0));
  backend->answer(GripperState::kMoving, 0.07);
  cycle();
  gripper.stop();
  cycle();
  ASSERT_EQ(backend->written.size(), 2u);
  EXPECT_EQ(backend->written[1].width, 0.07);
}

TEST_F(GripperTest, NetThatEndsWhileFingersMoveStopsThem) {
  cycle();
  gripper.hold();
  cycle(wanted(0.0));
  backend->answer(GripperState::kMoving, 0.07);
  cycle();
  gripper.release();
  cycle();
  ASSERT_EQ(backend->written.size(), 2u) << "row L5";
  backend->answer(GripperState::kIdle, 0.07);
  cycle();
  gripper.hold();
  gripper.release();
  cycle();
  EXPECT_EQ(backend->written.size(), 2u) << "fingers that stand stay as they are";
}

TEST_F(GripperTest, SilentOrNotReadyIsLost) {
  cycle();
  EXPECT_FALSE(gripper.lost());
  backend->sample.ready = false;
  cycle();
  EXPECT_TRUE(gripper.lost());
  EXPECT_TRUE(gripper.refusal().has_value());
  backend->sample.ready = true;
  backend->silent = true;
  cycle();
  EXPECT_TRUE(gripper.lost());
}

TEST_F(GripperTest, CycleDoesNotAllocate) {
  backend->written.reserve(10);
  cycle();
  gripper.hold();
  takt::test::AllocationGuard guard;
  gripper.begin_cycle(k, k * kMillisecond);
  gripper.propose(0.02, 0.1, 40);
  (void)gripper.check();
  gripper.hand_over();
  gripper.stop();
  gripper.hand_over();
  StateWords words;
  gripper.add_state(words);
  EXPECT_EQ(guard.count(), 0u);
}

TEST(GripperFile, ReadsTheWsg50) {
  const auto gripper = read_gripper("models/wsg50");
  ASSERT_TRUE(gripper) << gripper.error().to_string();
  EXPECT_EQ((*gripper)->stroke, 0.11);
  EXPECT_EQ((*gripper)->force_max, 80.0);
  EXPECT_EQ((*gripper)->cycle, 8 * kMillisecond);
  EXPECT_NEAR((*gripper)->payload.mass, 1.2, 1e-9);
  EXPECT_NEAR((*gripper)->X_MT.translation().z(), 0.1175, 1e-12);
}

TEST(SignalFiles, ReadTheModels) {
  const auto io = read_io("models/io_block");
  ASSERT_TRUE(io) << io.error().to_string();
  EXPECT_EQ((*io)->channels.size(), 20u);
  const auto& first_output = (*io)->channels[8];
  EXPECT_EQ(first_output.name, "do1");
  EXPECT_EQ(first_output.stop, 0.0);
  const auto& slow = (*io)->channels[18];
  EXPECT_EQ(slow.name, "ao1");
  EXPECT_EQ(slow.rate_max, 100.0);
  EXPECT_EQ(slow.unit, "V");
  const auto barrier = read_light_barrier("models/light_barrier");
  ASSERT_TRUE(barrier) << barrier.error().to_string();
  EXPECT_EQ((*barrier)->range_max, 4.0);
  EXPECT_FALSE((*barrier)->measures_range);
  const auto finder = read_range_finder("models/range_finder");
  ASSERT_TRUE(finder) << finder.error().to_string();
  EXPECT_TRUE((*finder)->measures_range);
  EXPECT_EQ((*finder)->range_min, 0.05);
}

/// Writes a device file beside a copy of a model's URDF. @return the diagnostics of the reader
template <class Reader>
Diagnostics wrong(const std::string& model, const Reader& read, const std::string& from, const std::string& to) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "takt_signal_file" / model;
  fs::remove_all(folder);
  fs::create_directories(folder.parent_path());
  fs::copy("models/" + model, folder, fs::copy_options::recursive);
  std::ifstream in(folder / "device.json");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  std::ofstream(folder / "device.json") << text;
  const auto result = read(folder);
  fs::remove_all(folder.parent_path());
  return result ? Diagnostics() : result.error();
}

TEST(SignalFiles, WrongOnesAreReportedWithTheirLocation) {
  EXPECT_THAT(wrong("wsg50", read_gripper, "\"finger_right\"", "\"finger_rigth\""),
              Reports(Code::kUnknownName, "/fingers/1", {"finger_rigth", "finger_right"}));
  EXPECT_THAT(wrong("wsg50", read_gripper, "[5, 80]", "[80, 5]"), Reports(Code::kOutOfRange, "/force_N"));
  EXPECT_THAT(wrong("wsg50", read_gripper, "\"pad_friction\": 0.7,", ""),
              Reports(Code::kMissing, "", {"pad_friction"}));
  EXPECT_THAT(wrong("io_block", read_io, "\"stop\": \"off\"", "\"stop\": 3"),
              Reports(Code::kWrongType, "/digital_outputs/do1/stop", {"3", "hold", "off", "on"}));
  EXPECT_THAT(wrong("io_block", read_io, "\"unit\": \"V\"", "\"unit\": \"volt\""),
              Reports(Code::kInvalidValue, "/analog_inputs/ai1/unit", {"volt"}));
  EXPECT_THAT(wrong("io_block", read_io, "\"stop\": 0", "\"stop\": 11"),
              Reports(Code::kWrongType, "/analog_outputs/ao1/stop", {"11", "hold"}));
  EXPECT_THAT(wrong("io_block", read_io, "\"ai2\"", "\"di2\""),
              Reports(Code::kDuplicate, "/analog_inputs/di2", {"di2"}));
  EXPECT_THAT(wrong("light_barrier", read_light_barrier, "\"range_m\": 4", "\"range_m\": -1"),
              Reports(Code::kOutOfRange, "/range_m", {"-1"}));
  EXPECT_THAT(wrong("range_finder", read_range_finder, "[0.05, 5]", "[5, 0.05]"),
              Reports(Code::kOutOfRange, "/range_m"));
}

}  // namespace
}  // namespace takt::device
