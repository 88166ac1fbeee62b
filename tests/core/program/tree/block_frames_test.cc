// Frames that steps make and that end with their sequence.
#include "app/interfaces/frame_handle.h"
#include "tests/core/activity/fixture.h"
#include "tests/support/reports.h"

namespace takt::program {
namespace {

using takt::test::Reports;
using testing::AllOf;

class BlockFramesTest : public test::ActivityTest {
 protected:
  static std::string wait(int cycles) { return R"({"do": "wait", "seconds": )" + std::to_string(0.001 * cycles) + "}"; }
};

constexpr const char* kMoveOnce = R"({"do": "ptp", "to": {"joints_deg": [10, 0, 0, -90, 0, 90, 0]}})";

/// A sequence with frames of its own.
std::string with_frames(const std::string& frames, const std::string& steps, int times = 1) {
  return R"({"do": "sequence", "times": )" + std::to_string(times) + R"(, "frames": )" + frames + R"(, "steps": [)" +
         steps + "]}";
}
constexpr const char* kMakeHere = R"({"do": "set_frame", "as": "here", "in": "block", "position_m": [0, 0, 0.1]})";
constexpr const char* kGoHere = R"({"do": "ptp", "name": "there", "to": {"in": "here", "position_m": [0, 0, 0]}})";

TEST_F(BlockFramesTest, EndWithTheirSequence) {
  ASSERT_EQ(run(with_frames(R"(["here"])", std::string(kMakeHere) + "," + kGoHere, 2)), operations::Progress::kDone)
      << diagnostics.to_string();
  EXPECT_FALSE(fake.cell.frames.contains("here"));
  const Eigen::Vector3d wanted = fake.cell.frames.pose("block")->translation() + Eigen::Vector3d(0, 0, 0.1);
  EXPECT_LT((fake.tool_in_world(fake.q()).translation() - wanted).norm(), 1e-6) << "it was there meanwhile";
  ASSERT_EQ(run(kMakeHere), operations::Progress::kDone);
  EXPECT_TRUE(fake.cell.frames.contains("here")) << "one that no block has declared stays";
}

TEST_F(BlockFramesTest, EndHoweverTheirSequenceEnds) {
  const std::string failing = with_frames(R"(["here"])", std::string(kMakeHere) + R"(, {"do": "fail", "text": "no"})");
  EXPECT_EQ(run(failing), operations::Progress::kFailed);
  EXPECT_FALSE(fake.cell.frames.contains("here"));
  const std::string waiting = with_frames(R"(["here"])", std::string(kMakeHere) + "," + wait(500));
  EXPECT_EQ(run(good(waiting),
                [this](int cycle, ProgramRunner& runner) {
                  if (cycle == 100) {
                    EXPECT_TRUE(fake.cell.frames.contains("here"));
                    runner.cancel();
                  }
                }),
            operations::Progress::kDone);
  EXPECT_FALSE(fake.cell.frames.contains("here"));
}

TEST_F(BlockFramesTest, OneThatHasEndedIsFoundBeforeTheRun) {
  const Diagnostics found = wrong(sequence(with_frames(R"(["here"])", kMakeHere) + "," + kGoHere));
  EXPECT_THAT(found, Reports(Code::kUnknownName, "/program/steps/1/to", {"here"}));
}

TEST_F(BlockFramesTest, AreTheirSequencesOwn) {
  EXPECT_THAT(wrong(with_frames(R"(["block", "a/b", ""])", kMoveOnce)),
              AllOf(Reports(Code::kInvalidName, "/program/frames/0"), Reports(Code::kInvalidName, "/program/frames/1"),
                    Reports(Code::kInvalidName, "/program/frames/2")));
  EXPECT_THAT(wrong(with_frames(R"(["here", "here"])", kMoveOnce)), Reports(Code::kDuplicate, "/program/frames/1"));
  EXPECT_THAT(wrong(with_frames(R"(["here"])", with_frames(R"(["here"])", kMoveOnce))),
              Reports(Code::kDuplicate, "/program/steps/0/frames/0"));
  const std::string own = with_frames(R"(["here"])", wait(1));
  EXPECT_THAT(wrong(R"({"do": "parallel", "branches": [)" + own + "," + own + "]}"),
              Reports(Code::kDuplicate, "/program/branches/1"));
  EXPECT_THAT(wrong(sequence(std::string(kMakeHere) + "," + own)),
              Reports(Code::kConflict, "/program/steps/1/frames/0"));
  EXPECT_THAT(wrong(sequence(own + "," + own)), testing::ResultOf([](const auto& d) { return d.has_errors(); }, false))
      << "one after the other they may have the same";
}

TEST_F(BlockFramesTest, InCppTheyEndWithTheirScope) {
  activity::Runtime program(fake.core, fake.cell, [this] { fake.step(); });
  program.step();
  const app::Frame block(program, "block");
  {
    const app::ScopedFrame here(block.offset(0, 0, 0.1), "here");
    EXPECT_NEAR(here.frame().in("block").translation().z(), 0.1, 1e-12);
    ASSERT_TRUE(fake.cell.frames.contains("here"));
    EXPECT_THROW(app::ScopedFrame(block, "here"), activity::ActivityError);
    EXPECT_TRUE(fake.cell.frames.contains("here")) << "it is still the first one's";
  }
  EXPECT_FALSE(fake.cell.frames.contains("here"));
}

}  // namespace
}  // namespace takt::program
