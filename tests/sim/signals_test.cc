// Terminals, wires and beams of the simulated world.
#include "sim/machines/signals.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sim/cell.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::sim::test {
namespace {

using device::SignalSample;
using takt::test::Reports;
using testing::AllOf;

constexpr Nanoseconds kEnd = 1'000'000'000'000;

SimInputDescription input(const std::string& name, const std::string& source, bool analog = false) {
  SimInputDescription one;
  one.name = name;
  one.source = source;
  one.analog = analog;
  one.upper = 10.0;
  return one;
}

SimOutputDescription output(const std::string& name, bool analog = false, double initial = 0.0) {
  SimOutputDescription one;
  one.name = name;
  one.analog = analog;
  one.initial = initial;
  return one;
}

SimBeamDescription beam(const std::string& name, const std::string& body, bool measures, double range) {
  SimBeamDescription one;
  one.name = name;
  one.body = body;
  one.measures_range = measures;
  one.range_max = range;
  return one;
}

bool level(World& world, const std::string& name) {
  SignalSample<bool> sample;
  EXPECT_TRUE(world.input(name)->read(sample));
  return sample.value;
}

double reading(World& world, const std::string& name) {
  SignalSample<double> sample;
  EXPECT_TRUE(world.input(name)->read(sample));
  return sample.value;
}

/// A post at the origin whose beam goes along x of the world, 0.1 m above the floor; a block slides in front of it.
WorldDescription beam_cell(bool measures, double range) {
  WorldDescription world;
  ObjectDescription post = box("post", {0.02, 0.02, 0.02}, {0, 0, 0.1});
  post.mount.X_P.linear() = Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitY()).toRotationMatrix();
  world.objects.push_back(post);
  world.objects.push_back(box("wall", {0.02, 1, 1}, {1.51, 0, 0.5}));
  world.beams.push_back(beam("beam", "post", measures, range));
  return world;
}

TEST(Wires, InputReadsTheOutputThatItIsWiredTo) {
  WorldDescription description;
  description.outputs = {output("lamp"), output("valve", true, 2.0)};
  description.inputs = {input("lamp back", "lamp"), input("valve back", "valve", true), input("free", "")};
  World world = make(description);
  EXPECT_FALSE(level(world, "lamp back"));
  EXPECT_EQ(reading(world, "valve back"), 2.0);
  world.output("lamp")->write(true);
  world.output("valve")->write(7.5);
  EXPECT_FALSE(level(world, "lamp back")) << "a sample is taken at the end of a cycle";
  ASSERT_TRUE(world.step());
  EXPECT_TRUE(level(world, "lamp back"));
  EXPECT_EQ(reading(world, "valve back"), 7.5);
  EXPECT_FALSE(level(world, "free"));
}

TEST(Wires, ScriptGivesValuesFromTheirTimeOn) {
  WorldDescription description;
  SimInputDescription button = input("button", "");
  button.script = {{3 * kMillisecond, 1.0}, {5 * kMillisecond, 0.0}, {kEnd, 1.0}};
  description.inputs = {button};
  World world = make(description);
  std::string seen;
  for (int k = 0; k < 8; ++k) {
    seen += level(world, "button") ? '1' : '0';
    ASSERT_TRUE(world.step());
  }
  EXPECT_EQ(seen, "00011000");
}

TEST(Wires, AnalogInputRoundsClipsAndIsNoisyAsItsSeedSays) {
  WorldDescription description;
  SimInputDescription coarse = input("coarse", "valve", true);
  coarse.resolution = 0.5;
  SimInputDescription noisy = input("noisy", "valve", true);
  noisy.noise = 0.1;
  description.outputs = {output("valve", true, 3.3)};
  description.inputs = {coarse, noisy};
  World world = make(description), same = make(description);
  EXPECT_EQ(reading(world, "coarse"), 3.5);
  double sum = 0.0, squares = 0.0;
  constexpr int n = 2000;
  for (int k = 0; k < n; ++k) {
    ASSERT_TRUE(world.step());
    ASSERT_TRUE(same.step());
    const double error = reading(world, "noisy") - 3.3;
    EXPECT_EQ(reading(same, "noisy") - 3.3, error);
    sum += error;
    squares += error * error;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.01);
  EXPECT_NEAR(std::sqrt(squares / n), 0.1, 0.01);
  world.output("valve")->write(25.0);
  ASSERT_TRUE(world.step());
  EXPECT_EQ(reading(world, "coarse"), 10.0);
}

TEST(Wires, SamplesComeAtTheirPeriod) {
  WorldDescription description;
  SimInputDescription slow = input("slow", "lamp");
  slow.period = 4 * kMillisecond;
  description.outputs = {output("lamp")};
  description.inputs = {slow};
  World world = make(description);
  world.output("lamp")->write(true);
  for (int k = 1; k <= 4; ++k) {
    ASSERT_TRUE(world.step());
    EXPECT_EQ(level(world, "slow"), k == 4) << k;
  }
}

TEST(Wires, WrongOnesAreFindings) {
  WorldDescription description;
  description.outputs = {output("lamp"), output("lamp")};
  SimInputDescription odd = input("odd", "lamp");
  odd.period = kMillisecond / 2;
  description.inputs = {input("a", "lmap"), input("b", "lamp", true), odd};
  const auto world = World::create(description);
  ASSERT_FALSE(world);
  EXPECT_THAT(world.error(), AllOf(Reports(Code::kDuplicate, "/outputs/lamp", {"lamp"}),
                                   Reports(Code::kUnknownName, "/inputs/a", {"lmap", "lamp"}),
                                   Reports(Code::kUnknownName, "/inputs/b", {"lamp"}),
                                   Reports(Code::kOutOfRange, "/inputs/odd", {"500000", "1000000"})));
}

TEST(Beam, BarrierSeesWhatStandsBeforeItsReflector) {
  WorldDescription description = beam_cell(false, 1.0);
  ObjectDescription ball = box("block", {0.04, 0.04, 0.04}, {0.5, 0, 0.35});
  ball.free = true;
  ball.mass = 0.2;
  description.objects.push_back(ball);
  World world = make(description);
  EXPECT_FALSE(level(world, "beam")) << "the wall stands behind the reflector";
  bool met = false;
  for (int k = 0; k < 400; ++k) {
    ASSERT_TRUE(world.step());
    const double z = world.body_pose(world.body("block")).translation().z();
    if (std::abs(z - 0.1) < 0.019) {
      EXPECT_TRUE(level(world, "beam")) << z;
      met = true;
    }
    if (std::abs(z - 0.1) > 0.021) {
      EXPECT_FALSE(level(world, "beam")) << z;
    }
  }
  EXPECT_TRUE(met) << "it fell through the beam";
}

TEST(Beam, RangeFinderMeasuresToTheFirstSurface) {
  World world = make(beam_cell(true, 3.0));
  EXPECT_NEAR(reading(world, "beam"), 1.5, 1e-9);
  WorldDescription with_block = beam_cell(true, 3.0);
  with_block.objects.push_back(box("block", {0.1, 0.1, 0.1}, {0.8, 0, 0.1}));
  World second = make(with_block);
  EXPECT_NEAR(reading(second, "beam"), 0.75, 1e-9);
}

TEST(Beam, RangeFinderOutOfItsRange) {
  World far = make(beam_cell(true, 1.0));
  EXPECT_EQ(reading(far, "beam"), 1.0) << "nothing in range reads the end of the range";
  WorldDescription near = beam_cell(true, 3.0);
  near.beams[0].range_min = 0.2;
  near.objects.push_back(box("block", {0.1, 0.1, 0.1}, {0.15, 0, 0.1}));
  World world = make(near);
  EXPECT_FALSE(std::isfinite(reading(world, "beam"))) << "too near: there is nothing to measure";
}

TEST(Beam, NoiseHasItsSigmaAndInputsCanBeWiredToIt) {
  WorldDescription description = beam_cell(true, 3.0);
  description.beams[0].noise = 0.001;
  description.inputs = {input("terminal", "beam", true)};
  World world = make(description);
  double squares = 0.0;
  constexpr int n = 2000;
  for (int k = 0; k < n; ++k) {
    ASSERT_TRUE(world.step());
    squares += std::pow(reading(world, "beam") - 1.5, 2);
    EXPECT_EQ(reading(world, "terminal"), reading(world, "beam"));
  }
  EXPECT_NEAR(std::sqrt(squares / n), 0.001, 1e-4);
}

TEST(Beam, ContinuesBitForBitAndDoesNotAllocate) {
  WorldDescription description = beam_cell(true, 3.0);
  description.beams[0].noise = 0.001;
  World world = make(description);
  const Snapshot snapshot = world.save();
  ASSERT_TRUE(world.step());
  const double first = reading(world, "beam");
  ASSERT_TRUE(world.restore(snapshot));
  ASSERT_TRUE(world.step());
  EXPECT_EQ(reading(world, "beam"), first);
  takt::test::AllocationGuard guard;
  for (int k = 0; k < 100; ++k) (void)world.step();
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::sim::test
