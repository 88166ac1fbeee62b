// What the check of motions says (core/collision) against MuJoCo, which knows the same cell another way: its own model
// of arms and bodies, its own distances, sampled so densely that nothing passes between two looks.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/base/random.h"
#include "core/collision/cell_shapes.h"
#include "core/collision/motion_check.h"
#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

/// Arms that move and bodies around them, as the simulation has them and as the check has them.
struct OracleCell {
  WorldDescription world;
  collision::CellShapes shapes;

  [[nodiscard]] collision::Scene& scene() { return shapes.scene; }
  [[nodiscard]] const collision::Scene& scene() const { return shapes.scene; }
};

void add_arm(OracleCell& cell, const std::string& name, const device::ArmDescription& arm, const Pose& X_WB) {
  cell.world.robots.push_back(arm_body(name, arm, {"", X_WB}));
  EXPECT_TRUE(cell.scene().add_robot(name, *cell.world.robots.back().model, -1, X_WB).empty());
}

/// One of four kinds, somewhere around the origin and turned.
void add_body(OracleCell& cell, int number, Random& random) {
  const double turn = random.uniform(-std::numbers::pi, std::numbers::pi), away = random.uniform(0.45, 1.3);
  Pose X_WO(Eigen::Translation3d(away * std::cos(turn), away * std::sin(turn), random.uniform(-0.2, 1.3)));
  const Eigen::Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.1, 1));
  X_WO.rotate(Eigen::AngleAxisd(random.uniform(-3, 3), axis.normalized()));
  const double a = random.uniform(0.01, 0.06), b = random.uniform(0.02, 0.15), c = random.uniform(0.002, 0.1);
  ObjectDescription object = box("body " + std::to_string(number), {a, b, c}, {0, 0, 0});
  object.mount.X_P = X_WO;
  world::Object::Part part{.shape = world::Box{{a, b, c}}};
  if (number % 4 == 1) {
    object.shapes.front().shape = kinematics::Cylinder{a, b};
    part.shape = world::Cylinder{a, b};
  } else if (number % 4 == 2) {
    object.shapes.front().shape = kinematics::Sphere{a};
    part.shape = world::Sphere{a};
  } else if (number % 4 == 3) {
    object.shapes.front().shape = Capsule{a, b};
    part.shape = world::Capsule{a, b};
  }
  cell.world.objects.push_back(object);
  cell.scene().add_object(object.name, {part}, -1, X_WO);
}

/// All joints at once, at rest at both ends.
struct Swing {
  std::vector<double> from, change;

  [[nodiscard]] collision::Trajectory trajectory() const {
    collision::Trajectory motion{.duration = 1.0, .at = {}};
    for (std::size_t j = 0; j < from.size(); ++j) {
      motion.joints.push_back(static_cast<int>(j));
      motion.acceleration.push_back(6.0 * std::abs(change[j]));
    }
    motion.at = [*this](double time, std::vector<double>& q) {
      const double share = time * time * (3.0 - 2.0 * time);
      for (std::size_t j = 0; j < from.size(); ++j) q[j] = from[j] + share * change[j];
    };
    return motion;
  }
};

/// The least distance of an arm to anything but itself during a swing, by MuJoCo.
class Oracle {
 public:
  Oracle(const OracleCell& cell) : world_(make(cell.world)), model_(*world_.physics_model()) {
    data_ = mj_makeData(&model_);
    for (const std::string& joint : cell.scene().joints()) {
      const int number = mj_name2id(&model_, mjOBJ_JOINT, joint.c_str());
      EXPECT_GE(number, 0) << joint;
      addresses_.push_back(model_.jnt_qposadr[number]);
    }
    for (int a = 0; a < model_.ngeom; ++a)
      for (int b = a + 1; b < model_.ngeom; ++b)
        if (is_solid(a) && is_solid(b) && owner(a) != owner(b) && (moves(a) || moves(b))) pairs_.emplace_back(a, b);
  }
  ~Oracle() { mj_deleteData(data_); }
  Oracle(const Oracle&) = delete;
  Oracle& operator=(const Oracle&) = delete;

  /// m; looks lie so close that no point moves further than 0.1 mm, or than half of the distance, from one to the next.
  double least_distance(const Swing& swing) {
    constexpr double kReach = 1.9, kFine = 1e-4;  // m
    double fastest = 0.0;
    for (const double change : swing.change) fastest += 1.5 * kReach * std::abs(change);
    double least = 1.0;
    for (double time = 0.0; time <= 1.0 && least > 0.0;) {
      const double share = time * time * (3.0 - 2.0 * time);
      for (std::size_t j = 0; j < addresses_.size(); ++j)
        data_->qpos[addresses_[j]] = swing.from[j] + share * swing.change[j];
      mj_kinematics(&model_, data_);
      const double now = distance();
      least = std::min(least, now);
      time += std::max(kFine, 0.5 * now) / fastest;
    }
    return least;
  }

 private:
  [[nodiscard]] bool is_solid(int geom) const {
    // MuJoCo has no distance to a plane.
    if (model_.geom_type[geom] == mjGEOM_PLANE) return false;
    return model_.geom_contype[geom] != 0 || model_.geom_conaffinity[geom];
  }
  [[nodiscard]] bool moves(int geom) const { return model_.body_weldid[model_.geom_bodyid[geom]] != 0; }
  [[nodiscard]] std::string owner(int geom) const {
    const char* name = mj_id2name(&model_, mjOBJ_BODY, model_.geom_bodyid[geom]);
    const std::string body = name != nullptr ? name : "";
    return body.substr(0, body.find('/'));
  }
  double distance() {
    double least = 0.5;
    for (const auto& [a, b] : pairs_) {
      const Eigen::Map<const Eigen::Vector3d> p_a(data_->geom_xpos + 3 * a), p_b(data_->geom_xpos + 3 * b);
      const double apart = model_.geom_rbound[a] == 0.0 || model_.geom_rbound[b] == 0.0
                               ? 0.0
                               : (p_a - p_b).norm() - model_.geom_rbound[a] - model_.geom_rbound[b];
      if (apart < least) least = std::min(least, mj_geomDistance(&model_, data_, a, b, least, nullptr));
    }
    return least;
  }

  World world_;
  const mjModel& model_;
  mjData* data_;
  std::vector<int> addresses_;              ///< of the joints, in the order of the scene
  std::vector<std::pair<int, int>> pairs_;  ///< of geoms
};

/// Random motions of three robots among 50 bodies, every third with a second arm that moves in the same
/// space: nothing that MuJoCo sees touch is missed, and what is reported comes within the margin. TAKT_MOTIONS=10000
/// tries that many.
TEST(CollisionOracle, MujocoFindsNothingThatIsMissedAndNothingIsReportedBeyondTheMargin) {
  const char* wanted = std::getenv("TAKT_MOTIONS");
  const int motions = wanted != nullptr ? std::atoi(wanted) : 60;
  constexpr int kPerCell = 10;
  const std::array<std::string, 3> arms{"lwr4plus", "ur5", "tx90"};
  Random random(1726);
  int hit = 0, free = 0;
  for (int number = 0; hit + free < motions; ++number) {
    OracleCell cell;
    const auto arm = device::read_arm("models/" + arms[static_cast<std::size_t>(number % 3)]);
    ASSERT_TRUE(arm.has_value());
    add_arm(cell, "arm", **arm, Pose::Identity());
    if (number % 3 == 2) add_arm(cell, "other", **arm, Pose(Eigen::Translation3d(0.9, 0.3, 0.0)));
    const int bodies = number % 2 == 0 ? 50 : 12;
    for (int i = 0; i < bodies; ++i) add_body(cell, i, random);
    cell.scene().find_pairs_that_never_meet();
    Oracle oracle(cell);
    for (int i = 0; i < kPerCell; ++i) {
      Swing swing;
      for (std::size_t j = 0; j < cell.scene().joints().size(); ++j) {
        swing.from.push_back(random.uniform(-1.6, 1.6));
        swing.change.push_back(random.uniform(-0.3, 0.3));
      }
      collision::CheckOptions options{.margin = 1e-3, .rule = {}, .bodies = {}};
      options.rule = [&](int a, int b) -> collision::PairRule {
        const bool own = cell.scene().body(a).owner == cell.scene().body(b).owner;
        return {.kind = own ? collision::PairRule::Kind::kIgnored : collision::PairRule::Kind::kApart};
      };
      const auto hits = check_motion(cell.scene(), cell.scene().start(), swing.trajectory(), options);
      const double least = oracle.least_distance(swing);
      constexpr double kBetweenLooks = 1e-4, kRounding = 1e-5;  // m; of MuJoCo's distances
      if (least < -kRounding) {
        EXPECT_FALSE(hits.empty()) << "cell " << number << ", motion " << i << ": " << least;
      }
      if (!hits.empty()) {
        EXPECT_LE(least, options.margin + kBetweenLooks)
            << "cell " << number << ", motion " << i << ": " << cell.scene().body(hits.front().a).name << " and "
            << cell.scene().body(hits.front().b).name;
      }
      (hits.empty() ? free : hit) += 1;
    }
  }
  EXPECT_GT(hit, motions / 5);
  EXPECT_GT(free, motions / 5);
}

}  // namespace
}  // namespace takt::sim::test
