// Jogging by a stream: whatever happens to the client, the arm comes to rest, in cycles that the core counts.
#include <algorithm>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "tests/serve/stream_client.h"

namespace takt::serve::test {
namespace {

using namespace std::chrono_literals;

constexpr int kTimeout = 50;  // cycles

/// A cell in lock-step, with a client that jogs its arm.
class JogStreamTest : public testing::Test {
 protected:
  JogStreamTest() : client(served.client()) {
    client.take_lease();
    stream.emplace(served);
  }

  void step(int cycles) { ASSERT_EQ(client.post("/v1/steps", {{"cycles", cycles}}).status, 200); }
  Json jog(const std::string& space, int number = 1) const {
    return {{"op", "jog"},  {"jog", number},  {"fence", client.fence},
            {"arm", "arm"}, {"space", space}, {"timeout_cycles", kTimeout}};
  }
  /// Sends it, and lets time go on until the net runs, or the answer is another one. @return the answer
  Json begin(const Json& message) {
    stream->send(message);
    for (int i = 0; i < 500; ++i) {
      while (const auto came = stream->read(5ms)) {
        const Json json = came->json();
        if (json["op"] == "problem" || json["op"] == "jogging" || json["op"] == "jog_ended") return json;
      }
      step(1);
    }
    return {};
  }
  /// A move, and `cycles` with it; again and again.
  void move(Json velocity, int times, int cycles) {
    velocity["op"] = "move";
    velocity["jog"] = 1;
    for (int i = 0; i < times; ++i) {
      velocity["sequence"] = sequence++;
      stream->send(velocity);
      const Json moved = stream->await("moved");
      ASSERT_FALSE(moved.is_null());
      EXPECT_EQ(moved["sequence"], velocity["sequence"]);
      step(cycles);
    }
  }
  [[nodiscard]] const device::Arm& arm() const { return *served.cell->built().cell.arms.at("arm").device; }
  /// Where the flange is sent, in the base.
  [[nodiscard]] Eigen::Isometry3d flange() const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    kinematics::Jacobian J;
    arm().description().chain->jacobian(arm().set_point().q, X, J);
    return X;
  }
  [[nodiscard]] Eigen::Vector3d tool() const { return flange().translation(); }
  [[nodiscard]] double speed() const { return arm().set_point().dq.norm(); }
  /// Cycles until the arm is at rest and nothing holds it.
  int cycles_to_rest(int most) {
    for (int i = 0; i <= most; ++i) {
      if (arm().at_rest() && !arm().held()) return i;
      step(1);
    }
    ADD_FAILURE() << "not at rest after " << most;
    return most;
  }
  /// What LOAD certifies: cycles from a cancel of the net to rest.
  [[nodiscard]] int braking(rcc::NetId net) const {
    return static_cast<int>(served.cell->core().status(net).cancel_bound_cycles);
  }

  Served served{false};
  Client client;
  std::optional<StreamClient> stream;
  int sequence = 1;
};

TEST_F(JogStreamTest, TheToolMovesAlongTheAxisUntilItIsReleased) {
  const Json begun = begin(jog("tool"));
  ASSERT_EQ(begun["op"], "jogging") << begun.dump();
  const Eigen::Vector3d from = tool();
  move({{"linear", {0, 0, 0.05}}}, 30, 20);
  const Eigen::Vector3d way = tool() - from;
  EXPECT_NEAR(way.z(), 0.05 * 0.6, 0.01);
  EXPECT_LT(std::hypot(way.x(), way.y()), 1e-3);
  move({{"linear", {0, 0, 9.0}}}, 10, 20);
  EXPECT_LT((tool() - from - way).norm(), 0.1 * 0.2 + 1e-3) << "no faster than allowed";
  stream->send({{"op", "unjog"}, {"jog", 1}});
  step(1000);
  const Json ended = stream->await("jog_ended");
  EXPECT_EQ(ended["reason"], "released");
  EXPECT_TRUE(arm().at_rest());
  EXPECT_FALSE(arm().held());
  step(2);
  EXPECT_EQ(client.get(fmt::format("/v1/nets/{}", begun["net"].get<int>())).status, 404) << "its net is forgotten";
}

TEST_F(JogStreamTest, SilenceEndsItInCyclesThatTheCoreCounts) {
  const Json begun = begin(jog("tool"));
  ASSERT_EQ(begun["op"], "jogging");
  move({{"linear", {0, 0.06, 0}}}, 20, 20);
  const double moving = speed();
  ASSERT_GT(moving, 0.01);
  const int bound = braking(begun["net"]);
  step(kTimeout - 20 - 2);  // the last move came 20 cycles ago
  const Eigen::Vector3d before = tool();
  step(1);
  EXPECT_NEAR((tool() - before).norm(), 0.06e-3, 0.01e-3) << "it still goes";
  const int rest = cycles_to_rest(bound);
  EXPECT_LE(rest, bound);
  EXPECT_LT(rest, 500);
  step(2);
  EXPECT_EQ(stream->await("jog_ended")["reason"], "silent");
  const Eigen::Vector3d there = tool();
  stream->send({{"op", "move"}, {"jog", 1}, {"sequence", sequence}, {"linear", {0, 0.06, 0}}});
  EXPECT_EQ(stream->await("problem")["status"], 409) << "it does not begin again by itself";
  step(100);
  EXPECT_EQ(tool(), there);
  EXPECT_EQ(begin(jog("tool"))["op"], "jogging") << "but if it is asked for";
}

TEST_F(JogStreamTest, AClosedConnectionEndsIt) {
  const Json begun = begin(jog("tool"));
  ASSERT_EQ(begun["op"], "jogging");
  move({{"linear", {0.06, 0, 0}}}, 20, 10);
  ASSERT_GT(speed(), 0.01);
  stream->drop();
  for (int i = 0; i < 200 && served.server->connections() > 0; ++i) std::this_thread::sleep_for(5ms);
  step(1);
  EXPECT_LT(cycles_to_rest(500), 500);
  step(3);
  EXPECT_EQ(client.get(fmt::format("/v1/nets/{}", begun["net"].get<int>())).status, 404) << "its net is forgotten";
}

TEST_F(JogStreamTest, SingleJointsMoveByTheirRates) {
  ASSERT_EQ(begin(jog("joints"))["op"], "jogging");
  const device::JointVector from = arm().set_point().q;
  std::vector<double> rates(static_cast<std::size_t>(from.size()));
  rates[2] = 0.1;
  move({{"rates", rates}}, 40, 20);
  device::JointVector way = arm().set_point().q - from;
  EXPECT_NEAR(way[2], 0.1 * 0.8, 0.02);
  way[2] = 0.0;
  EXPECT_LT(way.norm(), 1e-9);
  stream->send({{"op", "move"}, {"jog", 1}, {"sequence", sequence}, {"rates", {0.1}}});
  EXPECT_EQ(stream->await("problem")["status"], 422);
  EXPECT_LT(cycles_to_rest(1000), 1000);
}

TEST_F(JogStreamTest, WhatComesTwiceOrLateMovesNobody) {
  ASSERT_EQ(begin(jog("tool"))["op"], "jogging");
  move({{"linear", {0, 0, 0.0}}}, 5, 5);
  const Eigen::Vector3d from = tool();
  for (const int old : {sequence - 1, 1, 0}) {
    stream->send({{"op", "move"}, {"jog", 1}, {"sequence", old}, {"linear", {0, 0, 0.1}}});
    EXPECT_EQ(stream->await("problem")["status"], 409) << old;
    step(5);
  }
  EXPECT_EQ(tool(), from);
}

TEST_F(JogStreamTest, OnlyTheHolderOfTheLeaseJogs) {
  Json wrong = jog("tool");
  wrong["fence"] = client.fence + 1;
  EXPECT_EQ(begin(wrong)["status"], 409);
  ASSERT_EQ(begin(jog("tool"))["op"], "jogging");
  move({{"linear", {0, 0, 0.05}}}, 10, 10);
  Client other = served.client();
  other.take_lease({{"take_over", true}});
  stream->send({{"op", "move"}, {"jog", 1}, {"sequence", sequence}, {"linear", {0, 0, 0.05}}});
  EXPECT_EQ(stream->await("problem")["status"], 409);
  for (int i = 0; i < 100; ++i) (void)other.post("/v1/steps", {{"cycles", 10}});
  EXPECT_EQ(stream->await("jog_ended")["reason"], "lease");
  EXPECT_TRUE(arm().at_rest());
}

TEST_F(JogStreamTest, StopEndsIt) {
  ASSERT_EQ(begin(jog("tool"))["op"], "jogging");
  move({{"linear", {0, 0, 0.05}}}, 10, 10);
  EXPECT_EQ(client.post("/v1/stop").status, 200);
  step(500);
  EXPECT_EQ(stream->await("jog_ended")["reason"], "stopped");
  EXPECT_TRUE(arm().at_rest());
}

TEST_F(JogStreamTest, WhatCannotBeJoggedIsRefused) {
  Json message = jog("tool");
  message["arm"] = "amr";
  EXPECT_EQ(begin(message)["diagnostics"][0]["code"], "unknown-name");
  message = jog("tool");
  message["in"] = "nowhere";
  EXPECT_EQ(begin(message)["status"], 422);
  message = jog("tool");
  message["timeout_cycles"] = 5;
  message["linear_max_m_s"] = 0;
  EXPECT_EQ(begin(message)["diagnostics"].size(), 2u);
  message = jog("elbow");
  EXPECT_EQ(begin(message)["status"], 422);
  const int held = client.load(Served::motion());
  ASSERT_EQ(client.post(fmt::format("/v1/nets/{}/start", held)).status, 202);
  step(20);
  EXPECT_EQ(begin(jog("tool"))["status"], 409) << "another net has the arm";
  (void)client.post(fmt::format("/v1/nets/{}/cancel", held));
  step(1000);
  ASSERT_EQ(begin(jog("tool", 2))["op"], "jogging");
  EXPECT_EQ(begin(jog("joints", 2))["status"], 409) << "that number runs";
}

TEST_F(JogStreamTest, TheToolMovesAlongItsOwnAxes) {
  Json message = jog("tool");
  message["in"] = "tcp";
  ASSERT_EQ(begin(message)["op"], "jogging");
  const Eigen::Isometry3d X_BF = flange();
  const Eigen::Vector3d axis = X_BF.linear() * arm().tool().X_FT.linear() * Eigen::Vector3d::UnitX();
  move({{"linear", {0.05, 0, 0}}}, 20, 10);
  const Eigen::Vector3d way = flange().translation() - X_BF.translation();
  EXPECT_GT(way.norm(), 0.002);
  EXPECT_NEAR(way.normalized().dot(axis), 1.0, 1e-3);
}

TEST(JogInRealTime, ADroppedConnectionLeavesTheArmAtRest) {
  Served served(true);
  Client client = served.client();
  client.take_lease({{"cycles", 5000}});
  const auto view_of = [&served] { return served.cell->view().arms.at(0); };
  {
    StreamClient stream(served);
    stream.send({{"op", "jog"}, {"jog", 1}, {"fence", client.fence}, {"arm", "arm"}, {"space", "tool"}});
    ASSERT_FALSE(stream.await("jogging").is_null());
    for (int i = 0; i < 20; ++i) {
      stream.send({{"op", "move"}, {"jog", 1}, {"sequence", i}, {"linear", {0, 0, 0.05}}});
      std::this_thread::sleep_for(20ms);
    }
    EXPECT_TRUE(view_of().held);
  }
  for (int i = 0; i < 400 && view_of().held; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_FALSE(view_of().held);
  EXPECT_TRUE(view_of().at_rest);
}

}  // namespace
}  // namespace takt::serve::test
