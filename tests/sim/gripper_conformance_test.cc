// The grippers of the models folder in MuJoCo, under the suite that every gripper must pass.
#include "tests/support/gripper_conformance.h"

#include "core/device/device_file.h"
#include "sim/model/from_model.h"
#include "tests/sim/cell.h"

namespace takt::sim::test {
namespace {

using takt::test::GripperConformance;
using takt::test::GripperRig;
using takt::test::GripperUnderTest;

/// A gripper that looks down at a table, its tool centre point in the middle of a part of 40 mm.
class MujocoRig final : public GripperRig {
 public:
  MujocoRig(const std::string& model, bool with_part) {
    const auto read = device::read_gripper("models/" + model);
    if (!read) throw std::runtime_error(read.error().to_string());
    description = *read;
    part_width = with_part ? 0.04 : 0.0;
    Mount mount;
    mount.X_P.translation().z() = 0.02 + description->X_MT.translation().z();
    mount.X_P.linear() = Eigen::AngleAxisd(std::acos(-1.0), Eigen::Vector3d::UnitX()).toRotationMatrix();
    WorldDescription cell;
    cell.robots.push_back(gripper_body("gripper", *description, mount, description->stroke));
    cell.grippers.push_back(simulated_gripper("gripper", "gripper", *description));
    cell.objects.push_back(box("table", {1, 1, 0.02}, {0, 0, -0.01}));
    if (with_part) {
      ObjectDescription part = box("part", {0.04, 0.04, 0.04}, {0, 0, 0.02});
      part.free = true;
      part.mass = 0.5;
      cell.objects.push_back(part);
    }
    world_ = std::make_shared<World>(make(cell));
    backend = std::shared_ptr<device::GripperBackend>(world_, world_->gripper("gripper"));
  }
  void advance() override { ASSERT_TRUE(world_->step()); }

 private:
  std::shared_ptr<World> world_;
};

INSTANTIATE_TEST_SUITE_P(Mujoco, GripperConformance,
                         testing::Values(GripperUnderTest{
                             "Wsg50", [](bool part) { return std::make_unique<MujocoRig>("wsg50", part); }}),
                         takt::test::name_of_gripper);

}  // namespace
}  // namespace takt::sim::test
