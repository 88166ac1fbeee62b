// Cells as models of MuJoCo: MuJoCo alone, reading the written file, has every body where takt has it.
#include "tools/export_mjcf.h"

#include <fstream>
#include <iterator>
#include <memory>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "cell/build/simulated_cell.h"
#include "sim/model/mujoco_errors.h"
#include "sim/world/world.h"
#include "tests/support/scratch_folder.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

const device::ModelLibrary& library() {
  static const device::ModelLibrary models(std::vector<fs::path>{"models"});
  return models;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The world of a scenario as takt simulates it.
struct Truth {
  explicit Truth(const fs::path& scenario) {
    const auto description = cell::read_description(scenario);
    Diagnostics diagnostics;
    const device::ModelLibrary models = library().beside(scenario);
    const cell::LoadedCell loaded(*description, models, diagnostics);
    for (const auto& [name, mount] : cell::mounted_frames(loaded))
      frames[name] = loaded.frames.truth.pose(name).value_or(Eigen::Isometry3d::Identity());
    auto made = sim::World::create(cell::simulate(loaded, models, diagnostics).world);
    EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.to_string();
    if (made) world = std::make_unique<sim::World>(std::move(*made));
  }
  std::map<std::string, Eigen::Isometry3d> frames;
  std::unique_ptr<sim::World> world;
};

/// The exported file, as MuJoCo reads it, at the keyframe of the start.
struct Exported {
  explicit Exported(const fs::path& file) {
    sim::install_mujoco_handlers();
    char error[1000] = "";
    model.reset(mj_loadXML(file.c_str(), nullptr, error, sizeof error));
    EXPECT_TRUE(model) << error;
    if (!model) return;
    data.reset(mj_makeData(model.get()));
    mj_resetDataKeyframe(model.get(), data.get(), mj_name2id(model.get(), mjOBJ_KEY, "start"));
    mj_kinematics(model.get(), data.get());
  }
  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
};

Eigen::Isometry3d pose_of(const double* position, const double* rotation) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Map<const Eigen::Vector3d>(position);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation);
  return X;
}

void expect_same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const std::string& what) {
  EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), 1e-9) << what;
}

/// Servos hold the arms where they are.
void expect_standing(mjModel& model, mjData& data) {
  mj_resetDataKeyframe(&model, &data, 0);
  const std::vector<double> start(data.qpos, data.qpos + model.nq);
  const auto before = sim::mujoco_warnings().count;
  while (data.time < 1.0) mj_step(&model, &data);
  EXPECT_EQ(sim::mujoco_warnings().count, before) << sim::mujoco_warnings().last;
  for (int i = 0; i < model.nu; ++i) {
    const int joint = model.actuator_trnid[2 * i];
    EXPECT_NEAR(data.qpos[model.jnt_qposadr[joint]], start[static_cast<std::size_t>(model.jnt_qposadr[joint])], 0.02)
        << mj_id2name(&model, mjOBJ_JOINT, joint);
  }
}

class ExportMjcf : public testing::TestWithParam<const char*> {
 protected:
  test::ScratchFolder folder{"mjcf"};
};

TEST_P(ExportMjcf, EverythingIsWhereItIsInTheCellAndStays) {
  const fs::path scenario = GetParam();
  const auto report = export_mjcf({.scenario = scenario, .out = folder.path()}, library());
  ASSERT_TRUE(report) << report.error().to_string();
  const Truth truth(scenario);
  ASSERT_TRUE(truth.world);
  const Exported exported(report->files.front());
  ASSERT_TRUE(exported.model);
  const auto names = truth.world->body_names();
  ASSERT_EQ(static_cast<int>(names.size()), exported.model->nbody);
  const mjModel& physics = *truth.world->physics_model();
  for (int body = 1; body < exported.model->nbody; ++body) {
    const std::string& name = names[static_cast<std::size_t>(body)];
    const int there = mj_name2id(exported.model.get(), mjOBJ_BODY, name.c_str());
    ASSERT_GE(there, 0) << name;
    expect_same(truth.world->body_pose(body), pose_of(exported.data->xpos + 3 * there, exported.data->xmat + 9 * there),
                name);
    EXPECT_NEAR(physics.body_mass[body], exported.model->body_mass[there], 1e-9) << name;
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(physics.body_inertia[3 * body + i], exported.model->body_inertia[3 * there + i],
                  1e-9 + 1e-6 * physics.body_inertia[3 * body + i])
          << name;
  }
  ASSERT_LE(truth.world->model()->ngeom, exported.model->ngeom);
  ASSERT_FALSE(truth.frames.empty());
  for (const auto& [name, X_WF] : truth.frames) {
    const int site = mj_name2id(exported.model.get(), mjOBJ_SITE, ("frame/" + name).c_str());
    ASSERT_GE(site, 0) << name;
    expect_same(X_WF, pose_of(exported.data->site_xpos + 3 * site, exported.data->site_xmat + 9 * site), name);
  }
  expect_standing(*exported.model, *exported.data);
  const auto again = export_mjcf({.scenario = scenario, .out = folder / "again"}, library());
  ASSERT_TRUE(again);
  ASSERT_EQ(report->files.size(), again->files.size());
  for (std::size_t i = 0; i < report->files.size(); ++i)
    EXPECT_TRUE(text_of(report->files[i]) == text_of(again->files[i])) << report->files[i];
}

INSTANTIATE_TEST_SUITE_P(Scenarios, ExportMjcf,
                         testing::Values("scenarios/touch.json", "scenarios/factory2020.json", "scenarios/pick.json",
                                         "scenarios/screw.json", "scenarios/tool_change.json", "scenarios/mobile.json"),
                         [](const auto& one) { return fs::path(one.param).stem().string(); });

TEST(ExportMjcfErrors, ACellThatIsWrongIsRefusedAndNothingIsWritten) {
  const test::ScratchFolder folder("mjcf");
  const fs::path file = folder / "x.json";
  std::ofstream(file) << R"({"devices": {"arm": {"model": "lwr4pluss", "at": {"in": "world"}}},
          "program": {"do": "wait", "seconds": 1}})";
  const auto report = export_mjcf({.scenario = file, .out = folder / "out"}, library());
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().list().front().pointer, "/devices/arm/model");
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(ExportMjcfErrors, AFileIsNoFolder) {
  const test::ScratchFolder folder("mjcf");
  std::ofstream(folder / "out") << "x";
  const auto report = export_mjcf({.scenario = "scenarios/touch.json", .out = folder / "out"}, library());
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().list().front().code, Code::kFileNotWritable);
}

}  // namespace
}  // namespace takt::tools
