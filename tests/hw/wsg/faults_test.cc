// What goes wrong between driver and gripper: cables, processes, faults, other clients. In virtual time, by seed.
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/hw/wsg/twin_rig.h"

namespace takt::hw::wsg::faults_test {
namespace {

using device::GripperState;

/// The canonical gripper over a twin, cycle by cycle.
struct Bench {
  explicit Bench(bool with_part, const TwinOptions& options = ideal_wire(), std::uint64_t seed = 1)
      : rig(with_part, options, seed), gripper("gripper", rig.description, rig.backend) {}

  void cycle() {
    gripper.begin_cycle(k, k * kMillisecond);
    ++k;
    if (gripper.held() && gripper.lost()) {  // as the core does: its net is aborted
      gripper.stop();
      wanted.reset();
    }
    if (wanted) gripper.propose(wanted->width, wanted->speed, wanted->force);
    (void)gripper.check();
    gripper.hand_over();
    rig.advance();
    for (std::string& line : twin().news()) news += line + "\n";
  }
  /// @return false: it did not come to that
  bool until(const std::function<bool()>& done, int cycles = 5000) {
    for (int i = 0; i < cycles; ++i) {
      if (done()) return true;
      cycle();
    }
    return done();
  }
  bool connect() {
    if (!until([this] { return gripper.ready(); })) return false;
    gripper.hold();
    return true;
  }
  bool go(double width, double force = 40.0) {
    wanted = device::GripperSetPoint{.sequence = 0, .width = width, .speed = 0.1, .force = force};
    cycle();
    return until([this] { return gripper.ready() && gripper.at_rest(); });
  }
  Twin& twin() { return *rig.twin; }
  [[nodiscard]] GripperState state() const { return gripper.sample().state; }
  [[nodiscard]] std::string why() const { return rig.twin->fault_text(gripper.sample().fault); }

  TwinRig rig;
  device::Gripper gripper;
  std::optional<device::GripperSetPoint> wanted;
  std::int64_t k = 0;
  std::string news;
};

TEST(WsgFaults, APartThatIsLostIsReported) {
  Bench bench(true);
  ASSERT_TRUE(bench.connect());
  ASSERT_TRUE(bench.go(0.0));
  ASSERT_EQ(bench.state(), GripperState::kHolding);
  bench.rig.machine->remove_part();
  EXPECT_TRUE(bench.until([&] { return bench.state() == GripperState::kLost; }, 100));
  ASSERT_TRUE(bench.go(0.08));
  EXPECT_EQ(bench.state(), GripperState::kIdle);
}

TEST(WsgFaults, AnotherForceOnTheSamePartMovesNothing) {
  Bench bench(true);
  ASSERT_TRUE(bench.connect());
  ASSERT_TRUE(bench.go(0.0, 20.0));
  const auto motions = bench.twin().client().counts().motions;
  ASSERT_TRUE(bench.go(0.0, 60.0));
  bench.until([] { return false; }, 50);
  EXPECT_EQ(bench.twin().client().counts().motions, motions);
  EXPECT_EQ(bench.state(), GripperState::kHolding);
  EXPECT_NEAR(bench.rig.machine->command().force, 60.0, 1e-3);
  EXPECT_NEAR(bench.gripper.sample().force, 60.0, 1e-3);
}

TEST(WsgFaults, AFrozenDriverLetsTheFingersArriveAndLosesNothing) {
  Bench bench(false);
  ASSERT_TRUE(bench.connect());
  bench.wanted = device::GripperSetPoint{.width = 0.02, .speed = 0.1, .force = 40.0};
  bench.until([] { return false; }, 50);
  bench.twin().frozen = true;
  bench.until([] { return false; }, 2000);
  EXPECT_FALSE(bench.gripper.ready()) << "samples are too old";
  bench.twin().frozen = false;
  EXPECT_TRUE(bench.until([&] { return bench.gripper.ready(); }, 2000)) << bench.why();
  EXPECT_NEAR(bench.rig.machine->width(), 0.02, 1e-3);
}

TEST(WsgFaults, ACableThatIsPulledWhileAPartIsHeldKeepsThePartAndWaitsForAReset) {
  Bench bench(true);
  ASSERT_TRUE(bench.connect());
  ASSERT_TRUE(bench.go(0.0));
  ASSERT_EQ(bench.state(), GripperState::kHolding);
  const auto told = bench.rig.machine->command().sequence;
  bench.twin().network().set_cut(true);
  EXPECT_TRUE(bench.until([&] { return !bench.gripper.ready(); }, 500)) << "silence";
  bench.until([] { return false; }, 1000);
  EXPECT_NE(bench.why().find("connection"), std::string::npos) << bench.why();
  bench.twin().network().set_cut(false);
  EXPECT_TRUE(bench.until([&] { return bench.why().find("FAST STOP") != std::string::npos; }, 3000)) << bench.why();
  bench.until([] { return false; }, 2000);
  EXPECT_FALSE(bench.gripper.ready()) << "nothing begins anew by itself";
  EXPECT_EQ(bench.rig.machine->command().sequence, told) << "the fingers were told nothing";
  bench.twin().reset();
  EXPECT_TRUE(bench.until([&] { return bench.gripper.ready(); }, 100)) << bench.why();
  bench.until([] { return false; }, 200);
  EXPECT_EQ(bench.rig.machine->command().sequence, told) << "a reset moves nothing either: the part is held";
  EXPECT_EQ(bench.state(), GripperState::kHolding);
  bench.gripper.hold();
  ASSERT_TRUE(bench.go(0.08));
  EXPECT_NEAR(bench.rig.machine->width(), 0.08, 1e-3);
}

TEST(WsgFaults, AGripperThatRestartsIsFoundAgainAndDoesNotMove) {
  Bench bench(false);
  ASSERT_TRUE(bench.connect());
  bench.wanted = device::GripperSetPoint{.width = 0.0, .speed = 0.02, .force = 40.0};
  bench.until([] { return false; }, 100);
  bench.twin().emulator().restart();
  EXPECT_TRUE(bench.until([&] { return !bench.gripper.ready(); }, 1000));
  EXPECT_TRUE(bench.until([&] { return bench.gripper.ready(); }, 3000)) << bench.why() << bench.news;
  const double width = bench.rig.machine->width();
  bench.until([] { return false; }, 2000);
  EXPECT_NEAR(bench.rig.machine->width(), width, 1e-6);
  EXPECT_GT(width, 0.05);
}

TEST(WsgFaults, AFaultOfTheHardwareEndsReadinessUntilItIsAcknowledged) {
  Bench bench(false);
  ASSERT_TRUE(bench.connect());
  bench.twin().emulator().set_fault(kPowerFault);
  EXPECT_TRUE(bench.until([&] { return !bench.gripper.ready(); }, 50));
  EXPECT_NE(bench.why().find("power"), std::string::npos);
  bench.twin().reset();
  EXPECT_TRUE(bench.until([&] { return bench.gripper.ready(); }, 100)) << bench.why();
}

TEST(WsgFaults, FingersThatAreNotReferencedAreHomedOnlyWhenAsked) {
  TwinOptions options = ideal_wire();
  options.emulator.referenced = false;
  Bench refused(false, options);
  EXPECT_FALSE(refused.connect());
  EXPECT_NE(refused.why().find("home"), std::string::npos) << refused.why();
  EXPECT_EQ(refused.rig.machine->command().sequence, 0u);
  options.client.home = true;
  Bench homed(false, options);
  EXPECT_TRUE(homed.connect()) << homed.why();
  EXPECT_NEAR(homed.rig.machine->width(), homed.rig.description->stroke, 1e-3);
}

TEST(WsgFaults, AnotherGripperIsRefusedWithBothFigures) {
  TwinOptions options = ideal_wire();
  Bench bench(false, options);
  VirtualClock clock;
  VirtualNetwork network(clock, 1);
  auto large = std::make_shared<device::GripperDescription>(*bench.rig.description);
  large->stroke = 0.21;
  Emulator emulator({}, large, network, std::make_shared<test::KinematicGripper>(0.21, 0.0));
  ASSERT_TRUE(emulator.listen(options.client.remote));
  Client client(options.client, {"gripper", bench.rig.description, kMillisecond, 1}, network, clock);
  device::GripperSample sample;
  for (int i = 0; i < 100; ++i) {
    clock.set(i * kMillisecond);
    emulator.advance(i * kMillisecond);
    client.poll();
  }
  ASSERT_TRUE(client.read(sample));
  EXPECT_FALSE(sample.ready);
  EXPECT_EQ(sample.fault, static_cast<std::uint32_t>(Fault::kWrongGripper));
  const auto news = client.news();
  ASSERT_FALSE(news.empty());
  EXPECT_NE(news.back().find("210.0"), std::string::npos) << news.back();
  EXPECT_NE(news.back().find("110.0"), std::string::npos) << news.back();
}

TEST(WsgFaults, WhoAnswersOtherwiseIsNoGripper) {
  VirtualClock clock;
  VirtualNetwork network(clock, 1);
  auto listener = network.listen({kLoopback, kPort});
  auto description = std::make_shared<const device::GripperDescription>(test::fake_gripper_description());
  Client client({}, {"gripper", description, kMillisecond, 1}, network, clock);
  std::unique_ptr<StreamLink> peer;
  Random random(3);
  for (int i = 0; i < 5000; ++i) {
    clock.set(i * kMillisecond);
    client.poll();
    if (auto link = (*listener)->accept()) peer = std::move(link);
    std::string noise(random.bits() % 40, '\0');
    for (char& byte : noise) byte = static_cast<char>(random.bits());
    if (i % 3 == 0) append_packet(noise, 0x53, "\0\0nonsense");
    if (peer) (void)peer->send(std::as_bytes(std::span(noise)));
  }
  device::GripperSample sample;
  EXPECT_FALSE(client.read(sample) && sample.ready);
}

/// A stroke of work with a wire that is cut, a driver that freezes and a gripper that restarts, at moments drawn by
/// seed. Whatever happens: what is reported as reached is reached, nothing moves after a fault without a reset, and the
/// next work succeeds.
TEST(WsgFaults, ThousandsOfThemInVirtualTime) {
  int faults = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    TwinOptions options = ideal_wire();
    options.faults.wire.jitter = 2 * kMillisecond;
    options.faults.stream_piece = 1 + seed % 20;
    Bench bench(seed % 2 == 0, options, seed);
    ASSERT_TRUE(bench.connect()) << seed;
    Random random(seed);
    for (int round = 0; round < 20; ++round) {
      const bool open = round % 2 == 0;
      bench.wanted = device::GripperSetPoint{.width = open ? 0.1 : 0.0, .speed = 0.4, .force = 40.0};
      bench.until([] { return false; }, static_cast<int>(random.bits() % 400));
      switch (random.bits() % 4) {
        case 0:
          bench.twin().network().set_cut(true);
          bench.until([] { return false; }, static_cast<int>(random.bits() % 600));
          bench.twin().network().set_cut(false);
          break;
        case 1:
          bench.twin().frozen = true;
          bench.until([] { return false; }, static_cast<int>(random.bits() % 600));
          bench.twin().frozen = false;
          break;
        case 2:
          bench.twin().emulator().restart();
          break;
        default:
          bench.twin().emulator().set_fault(kFingerFault);
      }
      ++faults;
      bench.until([] { return false; }, 1200);
      bench.twin().reset();
      bench.until([] { return false; }, 50);
      bench.gripper.hold();
      ASSERT_TRUE(bench.go(open ? 0.1 : 0.0))
          << "seed " << seed << " round " << round << ": " << bench.why() << bench.news;
      const bool met = !open && seed % 2 == 0;
      ASSERT_EQ(bench.state(), met ? GripperState::kHolding : GripperState::kIdle)
          << "seed " << seed << " round " << round;
      ASSERT_NEAR(bench.rig.machine->width(), open ? 0.1 : met ? TwinRig::kPart : 0.0, 1e-3) << seed;
    }
  }
  EXPECT_EQ(faults, 1200);
}

TEST(WsgFaults, TheSameSeedGivesTheSameRun) {
  const auto run = [](std::uint64_t seed) {
    TwinOptions options = ideal_wire();
    options.faults.wire.jitter = 5 * kMillisecond;
    options.faults.stream_piece = 3;
    Bench bench(true, options, seed);
    EXPECT_TRUE(bench.connect());
    EXPECT_TRUE(bench.go(0.0));
    EXPECT_TRUE(bench.go(0.1));
    return std::vector<std::byte>(bench.twin().state().begin(), bench.twin().state().end());
  };
  EXPECT_EQ(run(5), run(5));
  EXPECT_NE(run(5), run(6));
}

}  // namespace
}  // namespace takt::hw::wsg::faults_test
