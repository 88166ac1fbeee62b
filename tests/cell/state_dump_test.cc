// Row D4: the first cycle, block, port and bit in which two runs differ.
#include "cell/replay/state_dump.h"

#include <cmath>
#include <cstring>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "cell/run/session.h"
#include "record/compare.h"

namespace takt::cell::state_dump_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const device::ModelLibrary& models() {
  static const device::ModelLibrary library({"models"});
  return library;
}

std::string scenario_with(double z) {
  auto json = nlohmann::json::parse(R"({"devices": {"arm": {"model": "lwr4plus"}}, "program": {"do": "sequence",
      "steps": [{"do": "wait", "seconds": 0.05}, {"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0]}}]}})");
  json["program"]["steps"][1]["to"]["by_m"][2] = z;
  return json.dump();
}

struct Disturbance {
  std::int64_t cycle = -1;
  std::function<void(BuiltCell&)> act;
};

std::filesystem::path recorded(const std::string& text, const std::string& name, const Disturbance& disturbance = {}) {
  auto description = parse_description(text);
  EXPECT_TRUE(description);
  auto session = Session::create(std::move(*description), models());
  EXPECT_TRUE(session);
  RunOptions options;
  options.record = std::filesystem::path(testing::TempDir()) / name;
  options.record_blocks = true;
  options.after_cycle = [&](BuiltCell& built) {
    if (built.core->cycle() == disturbance.cycle) disturbance.act(built);
    return true;
  };
  (void)(*session)->run(options);
  return options.record;
}

std::string bit_of(const std::filesystem::path& a, const std::filesystem::path& b, std::uint64_t cycle) {
  const auto ra = record::Recording::open(a), rb = record::Recording::open(b);
  const auto bit = find_bit(*ra, *rb, cycle, models());
  if (!bit) return bit.error().to_string();
  return *bit ? to_string(**bit) : "equal";
}

double next(double value) { return std::nextafter(value, 2 * value); }

TEST(StateDump, RowD4TheFirstBitThatDiffersIsNamed) {
  const auto a = recorded(scenario_with(0.01), "bit_a.mcap");
  const auto b = recorded(scenario_with(0.01 + 1e-12), "bit_b.mcap");
  const auto comparison = record::compare_recordings(a, b);
  ASSERT_TRUE(comparison);
  ASSERT_TRUE(comparison->first_difference);
  EXPECT_GE(comparison->first_difference->cycle, 50u) << "equal while it waits";
  EXPECT_EQ(comparison->first_difference->block.substr(0, 4), "net ");
  const std::string bit = bit_of(a, b, comparison->first_difference->cycle);
  EXPECT_THAT(bit, AllOf(StartsWith("net 'up', port "), HasSubstr(": bit "), HasSubstr(" against ")));
  EXPECT_EQ(bit_of(a, a, 60), "equal");
}

TEST(StateDump, RowD4ABlockThatWasDisturbedIsNamedByTheRecording) {
  const auto a = recorded(scenario_with(0.01), "calm.mcap");
  const auto b = recorded(scenario_with(0.01), "disturbed.mcap",
                          {20, [](BuiltCell& built) {
                             mjData* data = const_cast<mjData*>(built.world->physics_data());
                             data->qpos[2] = next(data->qpos[2] + 1e-3);
                           }});
  const auto comparison = record::compare_recordings(a, b);
  ASSERT_TRUE(comparison && comparison->first_difference);
  EXPECT_EQ(comparison->first_difference->cycle, 20u);
  EXPECT_FALSE(comparison->first_difference->block.empty());
  EXPECT_THAT(record::to_text(*comparison), HasSubstr(comparison->first_difference->block));
  // What was done by hand is in no scenario.
  EXPECT_THAT(bit_of(a, b, 20), AllOf(StartsWith("B: "), HasSubstr("[incompatible]"), HasSubstr("cycle 20")));
}

/// Flips the lowest bit of one place and asks which it was.
TEST(StateDump, RowD4EachFlippedBitIsFound) {
  auto description = parse_description(scenario_with(0.01));
  auto session = Session::create(std::move(*description), models());
  ASSERT_TRUE(session);
  std::vector<DumpedBlock> blocks;
  RunOptions options;
  options.keep_blocks = true;
  options.after_cycle = [&](BuiltCell& built) {
    if (built.core->cycle() == 60) blocks = dump_state(built);
    return blocks.empty();
  };
  (void)(*session)->run(options);
  std::size_t nets = 0, devices = 0, state = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool net = blocks[i].name.starts_with("net "), device = blocks[i].name.starts_with("device ");
    for (const DumpedBlock::Place& place : blocks[i].places) {
      auto other = blocks;
      other[i].bytes[place.offset] ^= std::byte{1};
      const auto found = first_difference(blocks, other);
      ASSERT_TRUE(found);
      EXPECT_EQ(found->block, blocks[i].name);
      EXPECT_EQ(found->place, place.name);
      EXPECT_EQ(found->bit, 0);
      EXPECT_EQ(found->a ^ found->b, 1u);
      (net ? nets : device ? devices : state) += 1;
    }
  }
  EXPECT_GT(nets, 20u);
  EXPECT_GT(devices, 20u);
  EXPECT_GT(state, 14u);
  auto less = blocks;
  less.pop_back();
  EXPECT_EQ(to_string(*first_difference(blocks, less)), "simulation: simulation against nothing");
}

}  // namespace
}  // namespace takt::cell::state_dump_test
