// The smallest distance between bodies, in a net.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "core/collision/body_pair.h"
#include "core/net/example.h"
#include "tests/core/primitives/environment.h"
#include "tests/support/primitive_harness.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using Json = nlohmann::ordered_json;

class DistanceTest : public testing::Test {
 protected:
  [[nodiscard]] PrimitiveHarness primitive(Json parameters) {
    parameters["solids"] = "cell_solids";
    parameters["arms"] = {"arm"};
    return PrimitiveHarness("SmallestDistance", std::move(parameters),
                            {.environment = &devices, .unlinked = {"q_2", "q_3", "q_4"}});
  }
  /// All pairs, without bounds or memory.
  [[nodiscard]] double distance_at(const device::JointVector& q) const {
    const collision::CellShapes& shapes = devices.solids->shapes();
    collision::State state = shapes.scene.start();
    for (Eigen::Index j = 0; j < q.size(); ++j)
      state.q[static_cast<std::size_t>(shapes.arms.at("arm").joints[static_cast<std::size_t>(j)])] = q[j];
    collision::Poses poses;
    shapes.scene.place(state, poses);
    double least = 1e9;
    const int block = shapes.scene.find("block");
    for (int body = 0; body < block; ++body)
      if (!shapes.scene.body(body).parts.empty())
        least = std::min(least, collision::distance(shapes.scene, poses, body, block));
    return least;
  }

  DeviceEnvironment devices;
  const device::JointVector home = devices.arm->description().home;
};

/// Between postures, as an arm moves: near the block, in it and away.
TEST_F(DistanceTest, IsThatOfTheNearestPairAndNeverMore) {
  PrimitiveHarness nearest = primitive(Json::parse(R"({"pairs": [["arm", "block"]]})"));
  Random random(5);
  int touches = 0;
  for (int motion = 0; motion < 20; ++motion) {
    device::JointVector from = home, to = home;
    for (Eigen::Index j = 0; j < home.size(); ++j) {
      from[j] = random.uniform(-1.5, 1.5);
      to[j] = random.uniform(-1.5, 1.5);
    }
    for (int cycle = 0; cycle <= 100; ++cycle) {
      const device::JointVector q = from + 0.01 * cycle * (to - from);
      nearest.set("q_1", net::JointArray(q)).step();
      const auto got = nearest.get<net::Real>("distance");
      ASSERT_TRUE(got);
      const double expected = distance_at(q);
      EXPECT_LE(*got, expected + 1e-9);
      EXPECT_GE(*got, expected - 1e-4) << motion << ", " << cycle;
      touches += expected <= 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(touches, 10) << "some have to touch";
}

TEST_F(DistanceTest, LooksAtWhatItIsToldOnly) {
  PrimitiveHarness all = primitive(Json::parse(R"({"pairs": [["arm", "block"]]})"));
  const std::string base = devices.solids->shapes().scene.body(0).name;
  PrimitiveHarness one = primitive({{"pairs", Json::array({Json::array({base, "block"})})}});
  all.set("q_1", net::JointArray(home)).step();
  one.set("q_1", net::JointArray(home)).step();
  EXPECT_GT(*one.get<net::Real>("distance"), *all.get<net::Real>("distance"));
}

TEST_F(DistanceTest, ObjectsAreWhereTheyAreSaidToBe) {
  net::Frame away = net::Frame::Identity();
  away.translation() << 0.0, 0.0, 50.0;
  Json parameters = Json::parse(R"({"pairs": [["arm", "block"]], "placed": {"objects": {"block": {"on": ""}}}})");
  parameters["placed"]["objects"]["block"]["pose"] = net::value_to_json(away);
  PrimitiveHarness moved = primitive(std::move(parameters));
  moved.set("q_1", net::JointArray(home)).step();
  EXPECT_GT(*moved.get<net::Real>("distance"), 40.0);
}

TEST_F(DistanceTest, UnknownNamesAreRefusedAtLoad) {
  const auto refused = [this](const char* text) {
    const Json parameters = Json::parse(text);
    net::NetDescription net = net::example_net(*net::Registry::global().find("SmallestDistance"));
    for (net::PrimitiveDescription& one : net.primitives)
      if (one.type == "SmallestDistance") one.parameters.update(parameters);
    return net::CompiledNet::compile(net, devices);
  };
  EXPECT_THAT(refused(R"({"pairs": [["arm", "blok"]]})"), ReportsAnywhere(Code::kUnknownName, {"blok", "block"}));
  EXPECT_THAT(refused(R"({"arms": ["am"]})"), ReportsAnywhere(Code::kUnknownName, {"am", "arm"}));
  EXPECT_THAT(refused(R"({"arms": []})"), ReportsAnywhere(Code::kWrongSize));
  EXPECT_THAT(refused(R"({"pairs": "all"})"), ReportsAnywhere(Code::kWrongType));
}

}  // namespace
}  // namespace takt::test
