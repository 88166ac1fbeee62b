// The MuJoCo model and the chain that control computes with come from the same URDF and must be the same machine.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <map>

#include "core/base/random.h"
#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

WorldDescription lwr_alone() {
  WorldDescription world;
  world.robots.push_back(lwr());
  return world;
}

/// A scratch copy of the plant's state to evaluate at any position.
class Scratch {
 public:
  explicit Scratch(const World& world)
      : model_(world.physics_model()), data_(mj_copyData(nullptr, model_, world.physics_data())) {}
  ~Scratch() { mj_deleteData(data_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  void set(const JointVector& q) {
    std::copy_n(q.data(), q.size(), data_->qpos);
    mj_forward(model_, data_);
  }
  [[nodiscard]] Pose pose(int body) const {
    Pose X = Pose::Identity();
    X.translation() = Eigen::Map<const Eigen::Vector3d>(data_->xpos + 3 * body);
    X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->xmat + 9 * body);
    return X;
  }
  [[nodiscard]] int contacts() const { return data_->ncon; }
  [[nodiscard]] Eigen::MatrixXd mass_matrix() const {
    Eigen::MatrixXd M(model_->nv, model_->nv);
    mj_fullM(model_, data_, M.data());
    return M;
  }

 private:
  const mjModel* model_;
  mjData* data_;
};

JointVector random_position(const kinematics::Chain& chain, Random& random) {
  JointVector q(chain.joint_count());
  for (int i = 0; i < chain.joint_count(); ++i) q[i] = random.uniform(chain.lower()[i], chain.upper()[i]);
  return q;
}

/// Each arm of models/: what MuJoCo makes of its URDF against what the core makes of it, at 1000 random positions.
class EveryArm : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const auto read = device::read_arm(std::filesystem::path("models") / GetParam());
    ASSERT_TRUE(read);
    arm_ = *read;
    description_.robots.push_back(arm_body("arm", *arm_, {}));
  }
  std::shared_ptr<const device::ArmDescription> arm_;
  WorldDescription description_;
};

TEST_P(EveryArm, PoseOfFlangeEqualsChainEverywhere) {
  Pose X_WB(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  X_WB.translation() << 0.3, -0.2, 0.8;
  description_.robots[0].mount.X_P = X_WB;
  const World world = make(description_);
  Scratch scratch(world);
  const int flange = world.body("arm/" + arm_->flange_link);
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = random_position(*arm_->chain, random);
    scratch.set(q);
    const Pose expected = X_WB * arm_->chain->forward(q);
    ASSERT_LT((scratch.pose(flange).matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST_P(EveryArm, MassMatrixEqualsChainPlusArmatureEverywhere) {
  const World world = make(description_);
  Scratch scratch(world);
  Random random(8);
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = random_position(*arm_->chain, random);
    scratch.set(q);
    Eigen::MatrixXd M = scratch.mass_matrix();
    for (int j = 0; j < q.size(); ++j) M(j, j) -= description_.robots[0].joints[static_cast<std::size_t>(j)].armature;
    ASSERT_LT((M - arm_->chain->mass_matrix(q)).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST_P(EveryArm, WeighsWhatItsDataSheetSays) {
  const std::map<std::string, double> published_kg = {{"lwr4plus", 16.0}, {"ur5", 18.4}, {"tx90", 111.0}};
  const double expected = published_kg.at(GetParam());
  const World world = make(description_);
  EXPECT_NEAR(mj_getTotalmass(world.physics_model()), expected, 0.03 * expected);
  EXPECT_NEAR(arm_->chain->total_mass(), expected, 0.03 * expected);
}

INSTANTIATE_TEST_SUITE_P(Models, EveryArm, testing::Values("lwr4plus", "ur5", "tx90"),
                         [](const auto& param) { return std::string(param.param); });

TEST(Model, NoMassIsLostAtTheBaseOrBehindFixedJoints) {
  WorldDescription description = lwr_alone();
  add_probe(description);
  const World world = make(description);
  double expected = 0.0;
  for (const auto& robot : description.robots) expected += robot.model->total_mass();
  EXPECT_NEAR(mj_getTotalmass(world.physics_model()), expected, 1e-9);
  EXPECT_GT(world.body("arm/base"), 0);
  EXPECT_GT(world.body("probe/tcp"), world.body("sensor/tool"));
}

TEST(Model, MountedPartsStandWhereTheirUrdfsSay) {
  WorldDescription description = lwr_alone();
  add_probe(description);
  const World world = make(description);
  Pose X_FT = Pose::Identity();
  X_FT.translation().z() = 0.0433 + 0.01 + 0.11;  // sensor, plate, stylus
  const Pose expected = lwr_chain().forward(lwr_home()) * X_FT;
  EXPECT_LT((world.body_pose(world.body("probe/tcp")).matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Model, PicturesShowTheSameBodiesAtTheSamePlaces) {
  WorldDescription description = lwr_alone();
  add_probe(description);
  description.arms.push_back(lwr_controller());
  World world = make(description);
  JointVector goal = lwr_home();
  goal[0] += 0.05;
  hold(world, goal, 100);
  const mjModel* model = world.model();
  ASSERT_EQ(model->nbody, world.physics_model()->nbody);
  EXPECT_GT(model->ngeom, world.physics_model()->ngeom);
  mjData* drawn = mj_copyData(nullptr, model, world.data());
  mj_kinematics(model, drawn);
  for (int body = 0; body < static_cast<int>(model->nbody); ++body) {
    EXPECT_STREQ(mj_id2name(model, mjOBJ_BODY, body), mj_id2name(world.physics_model(), mjOBJ_BODY, body));
    const Eigen::Vector3d at = Eigen::Map<const Eigen::Vector3d>(drawn->xpos + 3 * body);
    EXPECT_LT((at - world.body_pose(body).translation()).norm(), 1e-12);
  }
  mj_deleteData(drawn);
}

TEST(Model, NothingTouchesAtHomeOrOnTheWayDown) {
  // Links that overlap at their joints must not push each other, also where the arm may touch itself.
  for (const bool self_collision : {false, true}) {
    WorldDescription description = lwr_alone();
    add_probe(description);
    description.robots[0].self_collision = self_collision;
    const World world = make(description);
    EXPECT_EQ(world.physics_data()->ncon, 0) << self_collision;
  }
}

TEST(Model, AnArmTouchesItselfOnlyWhereItMay) {
  const kinematics::Chain chain = lwr_chain();
  for (const bool self_collision : {false, true}) {
    WorldDescription description = lwr_alone();
    add_probe(description);
    description.robots[0].self_collision = self_collision;
    const World world = make(description);
    Scratch scratch(world);
    Random random(9);
    int touching = 0;
    for (int i = 0; i < 20000; ++i) {
      scratch.set(random_position(chain, random));
      touching += scratch.contacts() > 0 ? 1 : 0;
    }
    EXPECT_EQ(touching > 0, self_collision);
  }
}

TEST(Model, UndrivenPlantKeepsItsEnergy) {
  // A wrong inertia tensor, axis or integrator shows as energy from nowhere.
  WorldDescription description = lwr_alone();
  description.physics.integrator = Integrator::kRungeKutta4;
  for (auto& joint : description.robots[0].joints) {
    joint.armature = 0.01;
    joint.coulomb = joint.viscous = 0.0;
  }
  description.robots[0].stop_margin = 100.0;  // stops take energy
  const JointVector start = (JointVector(7) << 0, 0.4, 0, -0.5, 0, 0.3, 0).finished();
  description.robots[0].q.assign(start.begin(), start.end());
  description.physics.gravity << 0, 0, 9.81;  // upside down: the upright arm swings without meeting its stops
  World world = make(description);
  const double begin = world.energy();
  for (int i = 0; i < 10'000; ++i) ASSERT_TRUE(world.step());
  EXPECT_GT((Eigen::Map<const Eigen::VectorXd>(world.physics_data()->qvel, 7).norm()), 0.01) << "the test needs motion";
  EXPECT_LT(std::abs(world.energy() - begin), 1e-3);
}

}  // namespace
}  // namespace takt::sim::test
