// What objects do to each other stands in the recording.
#include <cmath>

#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "record/recording.h"
#include "tests/cell/runs.h"
#include "tests/support/scratch_folder.h"

namespace takt::cell::object_forces_test {
namespace {

constexpr const char* kFall = R"({"time_limit_s": 5,
  "devices": {"arm": {"model": "lwr4plus", "at": {"in": "world"}}},
  "objects": {
    "slab": {"shape": "box", "size_m": [0.2, 0.2, 0.1], "at": {"in": "world", "position_m": [1, 0, 0.05]}},
    "cube": {"shape": "box", "size_m": [0.05, 0.05, 0.05], "mass_kg": 2, "fixed": false,
             "at": {"in": "world", "position_m": [1, 0, 0.15]}}},
  "program": {"do": "sequence", "steps": [{"do": "wait", "seconds": 2}]}})";

TEST(ObjectForces, AreInTheRecordingWhereTheyChange) {
  const takt::test::ScratchFolder folder("object_forces");
  RunOptions options;
  options.record = folder / "fall.mcap";
  const test::Ran ran = test::run_kept(test::parsed(kFall), options);
  ASSERT_EQ(ran.report.verdict, Verdict::kPassed) << ran.report.diagnostics.to_string();
  const auto recording = record::Recording::open(options.record);
  ASSERT_TRUE(recording);
  const auto forces = recording->table(record::kObjectForceTopic);
  ASSERT_TRUE(forces) << forces.error().to_string();
  ASSERT_GT(forces->time.size(), 1u);
  EXPECT_LT(forces->time.size(), 60u) << "nothing is written while it lies";
  const int slab = ran.built().world->body("slab"), cube = ran.built().world->body("cube");
  const bool slab_first = slab < cube;
  double blow = 0.0;
  for (const double force : forces->values[7]) blow = std::max(blow, std::isfinite(force) ? std::abs(force) : 0.0);
  EXPECT_GT(blow, 100.0) << "it falls 25 mm";
  EXPECT_EQ(forces->values[0].back(), std::min(slab, cube));
  EXPECT_EQ(forces->values[1].back(), std::max(slab, cube));
  EXPECT_NEAR(forces->values[4].back(), 0.1, 1e-3) << "m, where they touch";
  EXPECT_NEAR(forces->values[7].back(), (slab_first ? 1.0 : -1.0) * 2.0 * 9.81, 0.3);
}

}  // namespace
}  // namespace takt::cell::object_forces_test
