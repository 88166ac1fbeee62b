// A screwdriver drives screws of all sizes: torque, pitch, seat. Figures: docs/benchmarks.md,
// "Screws".
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/base/random.h"
#include "core/device/screwdriver.h"
#include "sim/machines/screwdriver.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

using Eigen::Vector3d;

struct DrivenSize {
  const char* name;
  double pitch, major, pitch_diameter, minor, run_down, head_diameter, head_height, socket_width, socket_depth;
  double clutch;  ///< Nm
};
// ISO 261, ISO 724, ISO 4762; run-down torque as models/threads.json.
constexpr DrivenSize kDriven[] = {{"M3", 0.0005, 0.003, 0.002675, 0.002459, 0.01, 0.0055, 0.003, 0.0025, 0.0013, 0.5},
                                  {"M4", 0.0007, 0.004, 0.003545, 0.003242, 0.02, 0.007, 0.004, 0.003, 0.002, 0.8},
                                  {"M5", 0.0008, 0.005, 0.00448, 0.004134, 0.04, 0.0085, 0.005, 0.004, 0.0025, 1.0},
                                  {"M6", 0.001, 0.006, 0.00535, 0.004917, 0.06, 0.01, 0.006, 0.005, 0.003, 1.5},
                                  {"M8", 0.00125, 0.008, 0.007188, 0.006647, 0.12, 0.013, 0.008, 0.006, 0.004, 2.5}};
constexpr double kBitEnd = 0.19;        // m, from the mount of the model, its spring at rest
constexpr double kPressed = 0.008;      // m, of the spring's travel at the begin: 8 N
constexpr double kTravel = 0.003;       // m, of the screw until its head rests
constexpr double kSpindleSpeed = 12.0;  // rad/s

double chamfer_of(const DrivenSize& size) { return 0.6 * (size.major - size.minor); }

/// As the material "fastener".
ContactParameters fastener_surface() {
  ContactParameters made;
  made.stiffness = 3e6;
  made.damping = 600.0;
  made.friction = 0.12;
  made.own_stiffness = made.own_friction = true;
  return made;
}

ObjectDescription threaded_block(const DrivenSize& size) {
  ObjectDescription block = box("block", {0.05, 0.05, 0.03}, {0.0, 0.0, -0.015});
  world::Bore bore{.radius = 0.5 * size.minor, .depth = 0.02, .chamfer = chamfer_of(size), .thread = size.name};
  bore.X_SB.translation().z() = 0.015;
  block.shapes[0].bores.push_back(bore);
  block.contact = fastener_surface();
  return block;
}

/// T: the end of its shank, z to its head.
ObjectDescription driven_screw(const DrivenSize& size, const Pose& X_WT) {
  const double length = kTravel + chamfer_of(size);
  ObjectDescription screw;
  screw.name = "screw";
  screw.free = true;
  const double area = 0.25 * std::numbers::pi * 7850.0;
  screw.mass = area * (size.major * size.major * length + size.head_diameter * size.head_diameter * size.head_height);
  screw.contact = fastener_surface();
  screw.shapes.push_back({.shape = kinematics::Cylinder{0.5 * size.major, length}, .chamfer = chamfer_of(size)});
  screw.shapes.push_back({.shape = kinematics::Cylinder{0.5 * size.head_diameter, size.head_height}});
  screw.shapes[0].X_OG.translation().z() = 0.5 * length;
  screw.shapes[1].X_OG.translation().z() = length + 0.5 * size.head_height;
  world::Bore socket{.radius = 0.5 * size.socket_width, .depth = size.socket_depth};
  socket.X_SB.translation().z() = 0.5 * size.head_height;
  screw.shapes[1].bores.push_back(socket);
  screw.screw =
      ScrewDescription{.thread = {size.name, size.pitch, size.major, size.pitch_diameter, size.run_down, 0.12}};
  screw.mount.X_P = X_WT;
  return screw;
}

/// The model with a bit for this size, its end at E, z to the screw.
RobotDescription driver_at(const DrivenSize& size, const Pose& X_WE) {
  auto with_bit = std::make_shared<kinematics::RobotModel>(*model("screwdriver"));
  for (auto& shape : std::ranges::find(with_bit->links, "bit", &kinematics::Link::name)->collisions)
    std::get<kinematics::Cylinder>(shape.shape).radius = 0.48 * size.socket_width;
  RobotDescription driver;
  driver.name = "driver";
  driver.model = with_bit;
  driver.mount.X_P = X_WE * Eigen::Translation3d(0.0, 0.0, kPressed - kBitEnd);
  driver.q = {kPressed, 0.0};
  driver.joints.push_back({.joint = "spindle", .armature = 5e-6});
  driver.joints.push_back({.joint = "slide", .spring = JointSpring{.stiffness = 800, .damping = 8, .preload = 2}});
  driver.bits.insert("bit");
  driver.chamfers["bit"] = 0.1 * size.socket_width;
  return driver;
}

/// In the mouth of its thread.
Pose straight(const DrivenSize& size) {
  Pose X_WT = Pose::Identity();
  X_WT.translation().z() = -chamfer_of(size);
  return X_WT;
}

/// A fixed screwdriver presses a screw down with 8 N, along the screw's axis.
/// @param X_WT   of the end of the shank   @param wobble  of the screw in the bit
WorldDescription driver_over_thread(const DrivenSize& size, const Pose& X_WT, Nanoseconds timestep = kMillisecond / 2,
                                    const Eigen::AngleAxisd& wobble = {0.0, Vector3d::UnitX()}) {
  WorldDescription world;
  world.physics.timestep = timestep;
  world.objects.push_back(threaded_block(size));
  world.objects.push_back(driven_screw(size, X_WT * wobble));
  const double socket = kTravel + chamfer_of(size) + size.head_height - size.socket_depth;
  const Eigen::AngleAxisd down(std::numbers::pi, Vector3d::UnitX());
  world.robots.push_back(driver_at(size, X_WT * Eigen::Translation3d(0.0, 0.0, socket) * Pose(down)));
  world.devices.push_back({.name = "driver",
                           .pointer = {},
                           .extend = {},
                           .make = [](const mjModel_& model, const WorldDescription& description) {
                             const auto figures = device::read_screwdriver("models/screwdriver");
                             return SimScrewdriver::make(model, description, "driver", **figures);
                           }});
  return world;
}

class DrivenScrew {
 public:
  explicit DrivenScrew(const DrivenSize& size) : DrivenScrew(size, driver_over_thread(size, straight(size))) {}
  DrivenScrew(const DrivenSize& size, const WorldDescription& description)
      : world(make(description)),
        driver(dynamic_cast<SimScrewdriver&>(*world.device("driver"))),
        body_(world.body("screw")) {
    driver.torque_limit.write(size.clutch);
    driver.speed.write(kSpindleSpeed);
    driver.turn.write(true);
  }

  World world;
  SimScrewdriver& driver;

  [[nodiscard]] ThreadEvent::Kind state() const { return world.threads().state_of(0); }
  [[nodiscard]] double turns() const { return world.threads().turned(0) / (2.0 * std::numbers::pi); }
  [[nodiscard]] double height() const { return world.body_pose(body_).translation().z(); }
  /// m/s and rad/s.
  [[nodiscard]] Vector3d velocity() const { return Eigen::Map<const Vector3d>(rates()); }
  [[nodiscard]] Vector3d spin() const { return Eigen::Map<const Vector3d>(rates() + 3); }
  [[nodiscard]] double torque() const { return *driver.torque.wire(); }

 private:
  [[nodiscard]] const double* rates() const {
    return world.physics_data()->qvel + world.physics_model()->body_dofadr[body_];
  }
  int body_;
};

TEST(Screwdriver, TightensEachSizeToItsClutchAndByItsPitch) {
  for (const DrivenSize& size : kDriven) {
    DrivenScrew screw(size);
    // It centres itself in its first turn; once its head rests it is stretched.
    std::optional<double> first_turns, first_height;
    double turns = 0.0, height = 0.0, running = 0.0;
    int samples = 0;
    for (int i = 0; i < 10000 && *screw.driver.clutch.wire() == 0.0; ++i) {
      ASSERT_TRUE(screw.world.step()) << size.name;
      if (screw.state() != ThreadEvent::Kind::kCaught || screw.turns() < 1.2) continue;
      if (!first_turns) first_turns = screw.turns(), first_height = screw.height();
      turns = screw.turns(), height = screw.height();
      if (turns > 3.0) continue;
      running += screw.torque();
      ++samples;
    }
    ASSERT_TRUE(first_turns) << size.name;
    EXPECT_EQ(screw.state(), ThreadEvent::Kind::kSeated) << size.name;
    const double peak = *screw.driver.peak_torque.wire();
    const double pitch = (*first_height - height) / (turns - *first_turns);
    std::printf("%s  clutch %.2f Nm  peak %.3f Nm (%+.1f %%)  pitch %.4f mm (%+.2f %%)  running %.3f Nm\n", size.name,
                size.clutch, peak, 100.0 * (peak / size.clutch - 1.0), 1e3 * pitch, 100.0 * (pitch / size.pitch - 1.0),
                running / samples);
    EXPECT_NEAR(peak, size.clutch, 0.05 * size.clutch) << size.name;
    EXPECT_NEAR(pitch, size.pitch, 0.01 * size.pitch) << size.name;
    // The bearing of the spindle takes 0.2 mNm at this speed.
    EXPECT_NEAR(running / samples, size.run_down, 0.05 * size.run_down + 0.002) << size.name;
  }
}

/// The sensor in the mouth of the holder: a screw at the bit, held or not; none while the bit is in no socket.
TEST(Screwdriver, TellsWhetherAScrewIsAtTheBit) {
  const DrivenSize& size = kDriven[3];
  DrivenScrew screw(size);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(screw.world.step());
  EXPECT_EQ(*screw.driver.screw_present.wire(), 1.0);
  WorldDescription alone = driver_over_thread(size, straight(size));
  alone.objects[1].mount.X_P.translation().x() += 0.05;
  DrivenScrew none(size, alone);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(none.world.step());
  EXPECT_EQ(*none.driver.screw_present.wire(), 0.0);
}

double crossing_lean_of(const DrivenSize& size) { return std::atan(0.5 * size.pitch / size.major); }

Eigen::AngleAxisd lean_towards(double direction, double angle) {
  return {angle, Vector3d(std::cos(direction), std::sin(direction), 0.0)};
}

/// Beside its thread, up to three times as oblique as a crossed one, and loose in the bit: it may wedge, slip off or be
/// caught, and is never thrown.
TEST(Screwdriver, AScrewHeldAskewIsNotThrown) {
  for (const DrivenSize& size : kDriven) {
    for (int seed = 0; seed < 16; ++seed) {
      Random random(static_cast<std::uint64_t>(seed), "askew");
      const auto direction = [&] { return random.uniform(0.0, 2.0 * std::numbers::pi); };
      const double off = random.uniform(0.0, 0.5 * size.major), where = direction();
      const double lean = random.uniform(0.0, 3.0 * crossing_lean_of(size));
      Pose X_WT = Pose::Identity();
      X_WT.translation() =
          Vector3d(off * std::cos(where), off * std::sin(where), 0.3 * size.pitch + 0.5 * lean * size.minor);
      X_WT.linear() = lean_towards(direction(), lean).toRotationMatrix();
      const Eigen::AngleAxisd wobble = lean_towards(direction(), random.uniform(0.0, 0.08));
      const Nanoseconds timestep = seed % 2 == 0 ? kMillisecond : kMillisecond / 2;
      DrivenScrew screw(size, driver_over_thread(size, X_WT, timestep, wobble));
      double fastest = 0.0, most_spin = 0.0;
      for (int i = 0; i < 1500; ++i) {
        ASSERT_TRUE(screw.world.step()) << size.name << ", seed " << seed << ", cycle " << i;
        fastest = std::max(fastest, screw.velocity().norm());
        most_spin = std::max(most_spin, screw.spin().norm());
      }
      // 8 N move the bit with 120 g by 0.5 m/s within its travel; the spindle turns with 12 rad/s.
      EXPECT_LT(fastest, 1.0) << size.name << ", seed " << seed;
      EXPECT_LT(most_spin, 150.0) << size.name << ", seed " << seed;
    }
  }
}

/// In the mouth of its thread, pressed down and turned by a bit that leans with it. Sizes take turns.
DrivenScrew screw_set_at(const DrivenSize& size, int seed, double least_lean, double largest_lean) {
  Random random(static_cast<std::uint64_t>(seed), "set at a lean");
  const double lean = random.uniform(least_lean, largest_lean) * crossing_lean_of(size);
  Pose X_WT = straight(size);
  X_WT.translation().z() += 0.5 * lean * size.minor;
  X_WT.linear() = lean_towards(random.uniform(0.0, 2.0 * std::numbers::pi), lean).toRotationMatrix();
  const Nanoseconds timestep = seed % 2 == 0 ? kMillisecond : kMillisecond / 2;
  return DrivenScrew(size, driver_over_thread(size, X_WT, timestep));
}

TEST(Screwdriver, AScrewSetAskewIsCaughtCrossedAndNoticedWithinAQuarterTurn) {
  for (const DrivenSize& size : kDriven) {
    for (int seed = 0; seed < 24; ++seed) {
      DrivenScrew screw = screw_set_at(size, seed, 1.3, 1.8);
      for (int i = 0; i < 3000 && screw.turns() < 0.25; ++i) {
        ASSERT_TRUE(screw.world.step()) << size.name << ", seed " << seed;
        if (screw.state() == ThreadEvent::Kind::kCrossed && screw.torque() > 2.0 * size.run_down) break;
      }
      EXPECT_EQ(screw.state(), ThreadEvent::Kind::kCrossed) << size.name << ", seed " << seed;
      EXPECT_GT(screw.torque(), 2.0 * size.run_down) << size.name << ", seed " << seed;
      EXPECT_LT(screw.turns(), 0.25) << size.name << ", seed " << seed;
    }
  }
}

TEST(Screwdriver, AScrewSetNearlyStraightGoesIn) {
  for (const DrivenSize& size : kDriven) {
    for (int seed = 0; seed < 24; ++seed) {
      DrivenScrew screw = screw_set_at(size, seed, 0.0, 0.5);
      for (int i = 0; i < 3000 && screw.turns() < 1.0; ++i)
        ASSERT_TRUE(screw.world.step()) << size.name << ", seed " << seed;
      EXPECT_EQ(screw.state(), ThreadEvent::Kind::kCaught) << size.name << ", seed " << seed;
      EXPECT_GE(screw.turns(), 1.0) << size.name << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace takt::sim::test
