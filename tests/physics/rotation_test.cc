// Free rotation: energy and angular momentum stay, and the motion is the one of Euler's equations.
#include <cmath>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "tests/physics/parts.h"

namespace takt::sim::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The inertia of a body about its centre of mass, in the axes of its frame, as the physics has it.
Matrix3d inertia_of(const World& world, const std::string& body) {
  const mjModel& model = *world.physics_model();
  const int number = world.body(body);
  const double* q = model.body_iquat + 4 * number;
  const Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  return R * Vector3d(model.body_inertia + 3 * number).asDiagonal() * R.transpose();
}

struct Conserved {
  Vector3d momentum;    ///< angular, in the world, about the centre of mass
  double energy = 0.0;  ///< of the rotation
};

Conserved conserved(const World& world, const Matrix3d& I) {
  const Spin spin = spin_of(world, "part");
  return {spin.R_WB * (I * spin.w_B), 0.5 * spin.w_B.dot(I * spin.w_B)};
}

/// A world without gravity in which the part turns with about `speed`, about an axis that is none of its own.
World tumbling(const ObjectDescription& object, double speed) {
  WorldDescription description;
  description.physics.gravity.setZero();
  description.objects.push_back(object);
  World world = built(description);
  const Vector3d w = speed * Vector3d(0.6, 0.64, 0.48);
  const double pushed = 0.01;
  world.push(world.body("part"), Vector3d::Zero(), inertia_of(world, "part") * w / pushed);
  run_for(world, pushed);
  world.push(world.body("part"), Vector3d::Zero());
  run_for(world, 0.001);
  return world;
}

ObjectDescription rod(double aspect) {
  const double thick = 0.004;
  return part("part", kinematics::Box{{aspect * thick, 1.5 * thick, thick}}, 0.01, {0.0, 0.0, 1.0});
}

/// Three shapes around a frame that is far from the centre of mass.
ObjectDescription compound() {
  ObjectDescription object = part("part", kinematics::Box{{0.1, 0.02, 0.03}}, 0.0, {0.0, 0.0, 1.0});
  object.shapes.front().mass = 0.3;
  object.shapes.push_back({.shape = kinematics::Sphere{0.02}, .mass = 0.5});
  object.shapes.back().X_OG.translation() = Vector3d(0.08, 0.03, -0.02);
  object.shapes.push_back({.shape = kinematics::Cylinder{0.01, 0.08}, .mass = 0.2});
  object.shapes.back().X_OG.translation() = Vector3d(0.05, 0.1, 0.06);
  object.mass = 1.0;
  return object;
}

void expect_conserved(const ObjectDescription& object, const char* what) {
  World world = tumbling(object, 30.0);
  const Matrix3d I = inertia_of(world, "part");
  const Conserved before = conserved(world, I);
  ASSERT_GT(spin_of(world, "part").w_B.norm(), 20.0) << what;
  double momentum = 0.0, energy = 0.0;
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_TRUE(world.step()) << what;
    const Conserved now = conserved(world, I);
    momentum = std::max(momentum, (now.momentum - before.momentum).norm() / before.momentum.norm());
    energy = std::max(energy, std::abs(now.energy - before.energy) / before.energy);
  }
  EXPECT_LT(momentum, 1e-4) << what;
  EXPECT_LT(energy, 1e-4) << what;
}

TEST(Rotation, EnergyAndAngularMomentumStayForTenSeconds) {
  expect_conserved(rod(1.0), "cube");
  expect_conserved(rod(3.0), "box");
  expect_conserved(rod(10.0), "key");
  expect_conserved(rod(50.0), "needle");
  expect_conserved(part("part", kinematics::Cylinder{0.05, 0.002}, 0.1, {0.0, 0.0, 1.0}), "disc");
  expect_conserved(compound(), "compound");
}

TEST(Rotation, TheCentreOfMassOfATumblingBodyGoesStraightOn) {
  WorldDescription description;
  description.objects.push_back(compound());
  World world = built(description);
  const int body = world.body("part");
  const auto centre = [&] { return Vector3d(world.physics_data()->xipos + 3 * body); };
  world.push(body, {20.0, 0.0, 0.0}, {3.0, 2.0, 4.0});
  run_for(world, 0.02);
  world.push(body, Vector3d::Zero());
  run_for(world, 0.001);
  const Vector3d begin = centre();
  run_for(world, 0.001);
  const Vector3d step = centre() - begin;
  run_for(world, 0.999);
  // Semi-implicit steps of a fall: n of them add n (n - 1) / 2 times g h^2 to n times the first.
  const double n = 1000.0, h = 0.001;
  const Vector3d expected = begin + n * step - Vector3d(0, 0, 0.5 * n * (n - 1.0) * kGravity * h * h);
  EXPECT_LT((centre() - expected).norm(), 1e-6);
}

/// Euler's equations by Runge and Kutta's rule with steps of 10 us: nothing of the simulation is in it.
Spin integrated(Spin spin, const Matrix3d& I, double seconds) {
  struct Rate {
    Matrix3d R;
    Vector3d w;
  };
  const Matrix3d inverse = I.inverse();
  const auto rate = [&](const Spin& at) -> Rate {
    Matrix3d S;
    S << 0, -at.w_B.z(), at.w_B.y(), at.w_B.z(), 0, -at.w_B.x(), -at.w_B.y(), at.w_B.x(), 0;
    return {at.R_WB * S, inverse * (I * at.w_B).cross(at.w_B)};
  };
  const auto ahead = [](const Spin& at, const Rate& by, double h) -> Spin {
    return {at.R_WB + h * by.R, at.w_B + h * by.w};
  };
  const double h = 1e-5;
  for (int i = 0; i < static_cast<int>(std::lround(seconds / h)); ++i) {
    const Rate a = rate(spin), b = rate(ahead(spin, a, h / 2)), c = rate(ahead(spin, b, h / 2)),
               d = rate(ahead(spin, c, h));
    spin = {spin.R_WB + h / 6 * (a.R + 2 * b.R + 2 * c.R + d.R), spin.w_B + h / 6 * (a.w + 2 * b.w + 2 * c.w + d.w)};
  }
  return spin;
}

TEST(Rotation, TurnsAsEulersEquationsSay) {
  for (const ObjectDescription& object : {rod(3.0), rod(50.0), compound()}) {
    World world = tumbling(object, 15.0);
    const Matrix3d I = inertia_of(world, "part");
    const Spin truth = integrated(spin_of(world, "part"), I, 2.0);
    run_for(world, 2.0);
    const Spin turned = spin_of(world, "part");
    EXPECT_LT(Eigen::AngleAxisd(truth.R_WB.transpose() * turned.R_WB).angle(), 0.01);  // of 30 rad
    EXPECT_LT((truth.w_B - turned.w_B).norm(), 0.01 * truth.w_B.norm());
  }
}

/// A steel part 5 x 5 x 50 mm, as it once gained energy in free fall until the run ended.
TEST(Rotation, AKeyThatFallsGainsNoEnergy) {
  WorldDescription description;
  description.objects.push_back(ground());
  ObjectDescription key = part("key", kinematics::Box{{0.05, 0.005, 0.005}}, 0.01, {0.0, 0.0, 0.443175254788602});
  const double degree = M_PI / 180.0;
  key.mount.X_P.linear() = (Eigen::AngleAxisd(-154.29285110152898 * degree, Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(2.7773257470622923 * degree, Vector3d::UnitY()) *
                            Eigen::AngleAxisd(-49.56238806345965 * degree, Vector3d::UnitX()))
                               .toRotationMatrix();
  description.objects.push_back(key);
  World world = built(description);
  const double before = world.energy();
  for (int i = 0; i < 3000; ++i) {
    ASSERT_TRUE(world.step()) << world.divergence();
    ASSERT_LT(world.energy(), 1.001 * before) << "at " << to_seconds(world.time()) << " s";
  }
}

/// How many of each series run: all by hand, a sample in the gate.
int sample_of(int all) {
  const char* wanted = std::getenv("TAKT_DROPS");
  return wanted == nullptr ? std::max(1, all / 50) : std::min(all, std::atoi(wanted));
}

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Eigen::Quaterniond turned() {
    std::normal_distribution<double> normal;
    Eigen::Quaterniond q(normal(random_), normal(random_), normal(random_), normal(random_));
    return q.normalized();
  }

 private:
  std::mt19937_64 random_;
};

/// Runs and looks at the energy: springs of contacts can only take of it.
void expect_no_gain(World& world, double seconds, const std::string& what) {
  const double before = world.energy();
  const int steps = static_cast<int>(std::lround(1000.0 * seconds));
  for (int i = 0; i < steps; ++i) {
    ASSERT_TRUE(world.step()) << what << ": " << world.divergence();
    ASSERT_LT(world.energy(), before + 1e-3 * std::abs(before)) << what << ", at " << i << " ms";
  }
}

TEST(Drops, SlenderPartsGainNoEnergyAndDivergeNever) {
  const int drops = sample_of(1000);
  for (int drop = 0; drop < drops; ++drop) {
    Dice dice(static_cast<unsigned>(drop) + 1u);
    WorldDescription description;
    description.objects.push_back(ground());
    for (int i = 0; i < 10; ++i) {
      const double thick = dice.between(0.002, 0.006), length = dice.between(5.0, 15.0) * thick;
      const double mass = 7850.0 * thick * thick * length;
      const Vector3d at(0.2 * (i % 5), 0.2 * (i / 5), dice.between(0.2, 0.8));
      const ObjectShape shape = i % 2 == 0 ? ObjectShape(kinematics::Box{{length, thick, thick}})
                                           : ObjectShape(kinematics::Cylinder{0.5 * thick, length});
      ObjectDescription rod = part("rod" + std::to_string(i), shape, mass, at);
      rod.mount.X_P.linear() = dice.turned().toRotationMatrix();
      description.objects.push_back(rod);
    }
    World world = built(description);
    expect_no_gain(world, 2.0, "drop " + std::to_string(drop));
  }
}

TEST(Drops, BinsOfMixedPartsGainNoEnergyAndDivergeNever) {
  const int bins = sample_of(50);
  for (int bin = 0; bin < bins; ++bin) {
    Dice dice(static_cast<unsigned>(bin) + 5001u);
    WorldDescription description;
    description.objects.push_back(ground());
    for (int wall = 0; wall < 4; ++wall) {
      ObjectDescription side;
      side.name = "wall" + std::to_string(wall);
      const bool along_x = wall < 2;
      const double sign = wall % 2 == 0 ? 1.0 : -1.0;
      side.shapes.push_back({.shape = kinematics::Box{along_x ? Vector3d(0.3, 0.02, 0.3) : Vector3d(0.02, 0.3, 0.3)}});
      side.mount.X_P.translation() = along_x ? Vector3d(0, sign * 0.14, 0.15) : Vector3d(sign * 0.14, 0, 0.15);
      description.objects.push_back(side);
    }
    for (int i = 0; i < 36; ++i) {
      const double radius = dice.between(0.005, 0.012), length = dice.between(0.02, 0.06);
      ObjectShape shape = kinematics::Cylinder{radius, length};
      if (i % 3 == 1) shape = kinematics::Box{{length, radius, 2.0 * radius}};
      if (i % 3 == 2) shape = kinematics::Sphere{radius};
      const Vector3d at(0.08 * (i % 3 - 1), 0.08 * (i / 3 % 3 - 1), 0.08 + 0.08 * (i / 9));
      ObjectDescription one = part("part" + std::to_string(i), shape, dice.between(0.005, 0.1), at);
      one.mount.X_P.linear() = dice.turned().toRotationMatrix();
      description.objects.push_back(one);
    }
    World world = built(description);
    expect_no_gain(world, 2.0, "bin " + std::to_string(bin));
  }
}

TEST(Divergence, NamesTheBody) {
  WorldDescription description;
  description.objects.push_back(ground());
  description.objects.push_back(part("steady", kinematics::Sphere{0.05}, 1.0, {1.0, 0.0, 0.05}));
  description.objects.push_back(part("thrown", kinematics::Sphere{0.05}, 1.0, {0.0, 0.0, 1.0}));
  World world = built(description);
  run_for(world, 0.01);
  world.push(world.body("thrown"), {1e14, 0.0, 0.0});
  bool goes_on = true;
  for (int i = 0; i < 10 && goes_on; ++i) goes_on = world.step();
  ASSERT_FALSE(goes_on);
  EXPECT_NE(world.divergence().find("'thrown'"), std::string::npos) << world.divergence();
}

}  // namespace
}  // namespace takt::sim::test
