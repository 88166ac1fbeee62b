// The whole stack, from a net to the plant: the same push moves a compliant arm and a stiff one with a sensor alike.
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "cell/build/cell_builder.h"
#include "cell/run/session.h"
#include "core/base/json.h"
#include "core/kinematics/chain.h"
#include "core/net/description.h"

namespace takt::cell::compliance_test {
namespace {

using Json = nlohmann::ordered_json;

/// A cell with an arm and a sensor on its flange, run by hand: cycle for cycle, with somebody who pushes the tool.
class CellTest : public testing::Test {
 protected:
  void build(const std::string& arm) {
    const device::ModelLibrary models({"models"});
    const auto description = parse_description(R"({"devices": {"arm": {"model": ")" + arm +
                                               R"("}, "wrist": {"model": "ft_gamma", "on": "arm"},
        "probe": {"model": "probe_ball", "on": "wrist"}}, "program": {"do": "wait", "seconds": 1}})");
    ASSERT_TRUE(description) << description.error().to_string();
    Diagnostics warnings;
    auto built = build_cell(*description, models, false, warnings);
    ASSERT_TRUE(built) << built.error().to_string();
    cell_ = std::make_unique<BuiltCell>(std::move(*built));
    cycles(100);
  }

  void cycles(int count) {
    for (int i = 0; i < count; ++i) {
      cell_->core->step();
      apply_push();
      ASSERT_TRUE(cell_->world->step());
    }
  }

  /// What the surroundings exert on the tool from now on, N in the world.
  void push(const Eigen::Vector3d& force) { force_ = force; }
  /// Where it is pushed, and how that place moves.
  [[nodiscard]] Eigen::Vector3d tip() const {
    return cell_->world->body_pose(cell_->world->body(pushed_)).translation();
  }

  /// m/N along a direction: computed torque holds each joint with inertia times natural frequency squared.
  [[nodiscard]] double softness_of_the_loops(const Eigen::Vector3d& along) const {
    const device::Arm& arm = *cell_->core->find_arm("arm");
    const device::ArmDescription& model = arm.description();
    Eigen::Isometry3d X;
    kinematics::Jacobian J;
    model.chain->jacobian(arm.sample().q, X, J);
    kinematics::JointMatrix M = model.chain->mass_matrix(arm.sample().q, cell_->world->arm("arm")->payload());
    M.diagonal() += model.armature;
    kinematics::Vector6 unit = kinematics::Vector6::Zero();
    unit.head<3>() = along;
    const kinematics::JointVector torque = J.transpose() * unit;
    const kinematics::JointVector w2 = model.natural_frequency.cwiseProduct(model.natural_frequency);
    return unit.dot(J * kinematics::JointVector(M.ldlt().solve(torque)).cwiseQuotient(w2));
  }

  rcc::NetId start(const Json& json) {
    const auto net = net::net_from_json(json);
    EXPECT_TRUE(net) << net.error().to_string();
    const auto id = net ? cell_->core->load(*net) : Result<rcc::NetId>(0);
    EXPECT_TRUE(id) << id.error().to_string();
    cell_->core->start(id.value_or(0));
    cycles(3);
    EXPECT_EQ(cell_->core->state(*id), rcc::NetState::kRunning);
    return *id;
  }
  static Json net_file(const std::string& name) {
    const auto json = read_json("scenarios/nets/" + name);
    EXPECT_TRUE(json);
    return json.value_or(Json::object());
  }
  static Json& parameters_of(Json& net, const std::string& id) {
    for (Json& primitive : net["primitives"])
      if (primitive["id"] == id) return primitive["parameters"];
    throw std::runtime_error("no primitive " + id);
  }

  std::unique_ptr<BuiltCell> cell_;
  std::string pushed_ = "probe/tcp";

 private:
  void apply_push() { cell_->world->push(cell_->world->body(pushed_), force_); }
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();
};

TEST_F(CellTest, ACompliantArmGivesWayTenMillimetresToTwentyNewtons) {
  build("lwr4plus");
  cell_->core->change_mode("arm", device::ControlMode::kCartesianImpedance);
  cycles(600);
  Json net = net_file("press_softly.net.json");
  parameters_of(net, "push")["wrench"]["force"] = {0, 0, 0};
  parameters_of(net, "robot")["stiffness"] = {2000, 2000, 2000};
  parameters_of(net, "time_is_up")["delay"] = 100.0;
  const auto id = start(net);
  cycles(500);
  const Eigen::Vector3d before = tip();
  push(Eigen::Vector3d(0, 20, 0));
  cycles(3000);
  EXPECT_NEAR((tip() - before).y(), 0.010, 0.0005);
  EXPECT_EQ(cell_->core->state(id), rcc::NetState::kRunning);
  cell_->core->abort(id);
  push(Eigen::Vector3d::Zero());
  cycles(3000);
  EXPECT_LT((tip() - before).norm(), 0.001) << "after a stop it stays compliant and comes back";
}

TEST_F(CellTest, AStiffArmWithASensorAndAnAdmittanceGivesWayAlike) {
  build("ur5");
  pushed_ = "wrist/measuring";  // with a long lever the wrist's own drives would give way too
  const auto id = start(net_file("admittance.net.json"));
  cycles(700);  // the tare
  for (const Eigen::Vector3d& force : {Eigen::Vector3d(0, 20, 0), Eigen::Vector3d(0, 0, 20)}) {
    const Eigen::Vector3d before = tip();
    push(force);
    cycles(3000);
    const Eigen::Vector3d way = tip() - before;
    EXPECT_NEAR(way.norm(), 0.010, 0.0005) << way.transpose();
    EXPECT_NEAR(way.dot(force.normalized()), 0.010, 0.0005) << way.transpose();
    // The joints' own loops give way by more than that tolerance: the net has taken them into account.
    EXPECT_GT(softness_of_the_loops(force.normalized()) * force.norm(), 0.0006);
    push(Eigen::Vector3d::Zero());
    cycles(3000);
    EXPECT_LT((tip() - before).norm(), 0.0005);
  }
  EXPECT_EQ(cell_->core->status(id).state, rcc::NetState::kRunning) << cell_->core->status(id).cause.text.view();
}

/// How far 20 N along y push the tool away from its line while a step of a program moves or holds it, m.
double way_under_a_push(const std::string& step) {
  const auto description = parse_description(
      R"({"devices": {"arm": {"model": "lwr4plus"}, "wrist": {"model": "ft_gamma", "on": "arm"}}, "program":
      {"do": "sequence", "steps": [{"do": "control_mode", "mode": "cartesian_impedance"}, )" +
      step + R"(]}, "expectations": [{"kind": "limits"}],
      "faults": [{"at_s": 2, "do": "push", "body": "wrist/measuring", "force_N": [0, 20, 0], "seconds": 2}]})");
  EXPECT_TRUE(description) << description.error().to_string();
  static const device::ModelLibrary models({"models"});
  auto session = Session::create(*description, models);
  EXPECT_TRUE(session) << session.error().to_string();
  if (!session) return 0.0;
  double before = 0.0, pushed = 0.0;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    const sim::World& world = *built.world;
    const double y = world.body_pose(world.body("wrist/measuring")).translation().y();
    if (built.core->time() == 2 * kSecond) before = y;
    if (built.core->time() == 4 * kSecond) pushed = y;
    return true;
  };
  const RunReport report = (*session)->run(options);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  return pushed - before;
}

TEST(ComplianceOfSteps, ASofterStepGivesWayMoreUnderTheSamePush) {
  for (const std::string& step : {std::string(R"({"do": "hold", "seconds": 4.5)"),
                                  std::string(R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "velocity_m_s": 0.025)")}) {
    SCOPED_TRACE(step);
    for (const double stiffness : {4000.0, 1000.0, 400.0}) {
      const double way =
          way_under_a_push(step + R"(, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": )" +
                           std::to_string(stiffness) + "}}");
      EXPECT_NEAR(way, 20.0 / stiffness, 0.15 * 20.0 / stiffness) << stiffness << " N/m";
    }
  }
}

}  // namespace
}  // namespace takt::cell::compliance_test
