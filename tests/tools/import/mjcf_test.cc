// Models in MuJoCo's format: what becomes of them moves as MuJoCo moves them.
#include "tools/import/mjcf.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <memory>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/base/random.h"
#include "core/device/device_file.h"
#include "core/kinematics/chain.h"
#include "tests/support/scratch_folder.h"
#include "tools/import/import_robot.h"

namespace takt::tools {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;
using Eigen::Vector3d;

const fs::path kArm = "tests/tools/foreign/mjcf/arm_with_hand.xml";

std::string plain(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

/// MuJoCo on its own, reading the same file.
struct Reference {
  explicit Reference(const fs::path& file) {
    char error[500] = "";
    model.reset(mj_loadXML(file.c_str(), nullptr, error, sizeof error));
    if (!model) throw std::runtime_error(error);
    data.reset(mj_makeData(model.get()));
  }
  /// Of the joint with that name, as the importer writes it.
  [[nodiscard]] int joint(const std::string& name) const {
    for (int i = 0; i < model->njnt; ++i)
      if (const char* own = mj_id2name(model.get(), mjOBJ_JOINT, i); own != nullptr && plain(own) == name) return i;
    return -1;
  }
  [[nodiscard]] Isometry3d pose(int body) const {
    Isometry3d X = Isometry3d::Identity();
    X.translation() = Eigen::Map<const Vector3d>(data->xpos + 3 * body);
    X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * body);
    return X;
  }

  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
};

std::map<std::string, Isometry3d> link_poses(const kinematics::RobotModel& robot,
                                             const std::map<std::string, double>& q) {
  std::map<std::string, Isometry3d> X_B{{robot.root().name, Isometry3d::Identity()}};
  for (const kinematics::Joint& joint : robot.joints) {
    Isometry3d X = X_B.at(joint.parent) * joint.X_PJ;
    const double at = q.contains(joint.name) ? q.at(joint.name) : 0.0;
    if (joint.type == kinematics::JointType::kPrismatic) X.translate(at * joint.axis);
    if (joint.type != kinematics::JointType::kPrismatic && joint.type != kinematics::JointType::kFixed)
      X.rotate(Eigen::AngleAxisd(at, joint.axis));
    X_B.emplace(joint.child, X);
  }
  return X_B;
}

class MjcfTest : public testing::Test {
 protected:
  [[nodiscard]] Result<ImportReport> import(const fs::path& file, const std::string& name = "arm") const {
    ImportOptions options;
    options.name = name;
    options.file = file;
    options.out = folder / "models";
    return import_robot(options);
  }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
    return folder / name;
  }
  /// The first error of a file that is refused.
  [[nodiscard]] Diagnostic refused(const fs::path& file) const {
    const auto made = import(file);
    EXPECT_FALSE(made);
    EXPECT_FALSE(fs::exists(folder / "models/arm"));
    return made ? Diagnostic() : made.error().list().front();
  }

  test::ScratchFolder folder{"mjcf"};
};

const ImportNote* note_of(const ImportReport& report, const std::string& key) {
  const auto found =
      std::ranges::find_if(report.notes, [&](const ImportNote& one) { return one.key.starts_with(key); });
  return found == report.notes.end() ? nullptr : &*found;
}

std::string model_of(const std::string& bodies, const std::string& rest = {}) {
  return "<mujoco>\n<worldbody>\n" + bodies + "\n</worldbody>\n" + rest + "\n</mujoco>\n";
}

std::string arm_of(const std::string& inside) {
  return R"(<body name="base"><geom size="0.1" mass="1"/>
<body name="a"><joint name="j1" range="-90 90"/><geom size="0.1" mass="1"/>
<body name="b" pos="0 0 0.3"><joint name="j2" axis="0 1 0" range="-90 90"/><geom size="0.1" mass="1"/>
<body name="c" pos="0 0 0.3"><joint name="j3" axis="0 1 0" range="-90 90"/><geom size="0.1" mass="1"/>)" +
         inside + "</body></body></body></body>";
}

TEST_F(MjcfTest, BodiesAreWhereMujocoHasThem) {
  const auto report = import(kArm);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_EQ(report->joints, (std::vector<std::string>{"waist", "shoulder", "elbow", "roll", "tilt", "spin"}));
  EXPECT_EQ(report->flange, "attachment_site");
  const auto robot = kinematics::RobotModel::load(report->folder / "arm.urdf");
  ASSERT_TRUE(robot);
  const Reference mujoco(kArm);
  Random random(1, "postures");
  int compared = 0;
  for (int k = 0; k < 200; ++k) {
    std::map<std::string, double> q;
    for (const std::string& joint : report->joints) q[joint] = random.uniform(-3.0, 3.0);
    for (const auto& [joint, at] : q) {
      ASSERT_GE(mujoco.joint(joint), 0) << joint;
      mujoco.data->qpos[mujoco.model->jnt_qposadr[mujoco.joint(joint)]] = at;
    }
    mj_kinematics(mujoco.model.get(), mujoco.data.get());
    const auto X_B = link_poses(*robot, q);
    const Isometry3d X_WB = mujoco.pose(mj_name2id(mujoco.model.get(), mjOBJ_BODY, "Base"));
    for (int body = 1; body < mujoco.model->nbody; ++body) {
      const auto link = X_B.find(plain(mj_id2name(mujoco.model.get(), mjOBJ_BODY, body)));
      if (link == X_B.end()) continue;
      ++compared;
      const Isometry3d difference = (X_WB.inverse() * mujoco.pose(body)).inverse() * link->second;
      EXPECT_LT(difference.translation().norm(), 1e-9) << link->first;
      EXPECT_LT((difference.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-9) << link->first;
    }
    const int site = mj_name2id(mujoco.model.get(), mjOBJ_SITE, "attachment_site");
    const Vector3d flange = X_WB.inverse() * Eigen::Map<const Vector3d>(mujoco.data->site_xpos + 3 * site);
    EXPECT_LT((flange - X_B.at("attachment_site").translation()).norm(), 1e-9);
  }
  EXPECT_EQ(compared, 200 * 8);
}

TEST_F(MjcfTest, MassesAreThoseOfMujoco) {
  const auto report = import(kArm);
  ASSERT_TRUE(report);
  const auto robot = kinematics::RobotModel::load(report->folder / "arm.urdf");
  ASSERT_TRUE(robot);
  const auto chain = kinematics::Chain::create(*robot, report->base, report->flange);
  ASSERT_TRUE(chain);
  const Reference mujoco(kArm);
  const int base = mj_name2id(mujoco.model.get(), mjOBJ_BODY, "Base");
  constexpr double kBetween = 1e-4;  // of the link between the two joints of the wrist
  EXPECT_NEAR(robot->total_mass(), mujoco.model->body_subtreemass[base] + kBetween, 1e-9);
  Random random(2, "postures");
  for (int k = 0; k < 50; ++k) {
    kinematics::JointVector q(6);
    for (int i = 0; i < 6; ++i) q[i] = random.uniform(-1.5, 1.5);
    std::vector<int> dofs;
    for (int i = 0; i < 6; ++i) {
      const int joint = mujoco.joint(report->joints[static_cast<std::size_t>(i)]);
      mujoco.data->qpos[mujoco.model->jnt_qposadr[joint]] = q[i];
      dofs.push_back(mujoco.model->jnt_dofadr[joint]);
    }
    mj_forward(mujoco.model.get(), mujoco.data.get());
    const int nv = mujoco.model->nv;
    Eigen::MatrixXd M(nv, nv);
    mj_fullM(mujoco.model.get(), mujoco.data.get(), M.data());
    const auto own = chain->mass_matrix(q);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        const auto a = dofs[static_cast<std::size_t>(i)], b = dofs[static_cast<std::size_t>(j)];
        const double armature = i == j ? mujoco.model->dof_armature[a] : 0.0;
        EXPECT_NEAR(own(i, j), M(a, b) - armature, 1.5 * kBetween) << i << ", " << j;
      }
    }
  }
}

TEST_F(MjcfTest, ClassesAndDefaultsBecomeLimitsAndFigures) {
  const auto report = import(kArm);
  ASSERT_TRUE(report);
  const auto robot = kinematics::RobotModel::load(report->folder / "arm.urdf");
  ASSERT_TRUE(robot);
  constexpr double kDegree = M_PI / 180.0;
  const std::map<std::string, double> upper = {{"waist", 170}, {"shoulder", 120}, {"elbow", 150},
                                               {"roll", 170},  {"tilt", 110},     {"spin", 170}};
  const std::map<std::string, double> effort = {{"waist", 200}, {"shoulder", 200}, {"elbow", 80},
                                                {"roll", 30},   {"tilt", 20},      {"spin", 12}};
  for (const auto& [name, degrees] : upper) {
    const kinematics::Joint& joint = *robot->joint(name);
    EXPECT_NEAR(joint.upper, degrees * kDegree, 1e-12) << name;
    EXPECT_NEAR(joint.effort, effort.at(name), 1e-12) << name;
    EXPECT_NEAR(joint.damping, 0.5, 1e-12);
    EXPECT_NEAR(joint.friction, 0.3, 1e-12);
  }
  EXPECT_NEAR(robot->joint("spin")->velocity, 2.5, 1e-12);
  const auto arm = device::read_arm(report->folder);
  ASSERT_TRUE(arm) << arm.error().to_string();
  const std::vector<double> home = {0.1, 0.5, 0.9, 0.1, -0.6, 0.0};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR((*arm)->home[i], home[static_cast<std::size_t>(i)], 1e-6);
    EXPECT_NEAR((*arm)->armature[i], 0.2, 1e-12);
  }
}

TEST_F(MjcfTest, MeshesKeepTheirScaleAndPlace) {
  const auto report = import(kArm);
  ASSERT_TRUE(report);
  const auto robot = kinematics::RobotModel::load(report->folder / "arm.urdf");
  ASSERT_TRUE(robot);
  // The bar is 0.2 x 0.06 x 0.06 m, its file begins at its end, and its origin is moved to its middle (refpos).
  const auto box_of = [&](const std::string& link) {
    const kinematics::Geometry& seen = robot->link(link)->visuals.front();
    const auto& mesh = std::get<kinematics::Mesh>(seen.shape);
    const auto file = read_mesh(mesh.path);
    return file->box.transformed(seen.X_LG);
  };
  EXPECT_LT((box_of("fore").min() - Vector3d(0, -0.03, -0.03)).norm(), 1e-6);
  EXPECT_LT((box_of("fore").max() - Vector3d(0.4, 0.03, 0.03)).norm(), 1e-6);
  // eulerseq zyx: 90 degrees about y raise it.
  EXPECT_LT((box_of("turret").sizes() - Vector3d(0.06, 0.06, 0.2)).norm(), 1e-6);
  EXPECT_LT(box_of("turret").center().norm(), 1e-6);
}

TEST_F(MjcfTest, WhatIsNotTakenIsSaidWithItsPlace) {
  const auto report = import(kArm);
  ASSERT_TRUE(report);
  for (const char* key : {"tendon 'fingers' (drives.xml line 12)", "equality 'strut' (drives.xml line 19)",
                          "equality 'both fingers' (drives.xml line 18)", "actuator 'grip' (drives.xml line 9)",
                          "actuator 'waist' (drives.xml line 3)", "keyframe 'stretched' (line 85)",
                          "joint 'right_finger'", "joint 'left_finger'", "joint 'joint_8'"})
    EXPECT_NE(note_of(*report, key), nullptr) << key;
  const auto left_out = [&](const std::string& what) {
    return std::ranges::any_of(report->notes, [&](const ImportNote& one) {
      return one.key == "left out" && one.value.find(what) != std::string::npos;
    });
  };
  for (const char* what : {"1 <sensor>", "1 <contact>", "1 <camera>", "1 <light>", "1 <option>",
                           "1 shininess of material", "1 geom of the world"})
    EXPECT_TRUE(left_out(what)) << what;
  EXPECT_FALSE(left_out("damping"));
}

TEST_F(MjcfTest, AHomeOutsideTheRangeIsNotUsed) {
  const auto file = write("x.xml", model_of(arm_of(""), R"(<keyframe><key name="home" qpos="2 0 0"/></keyframe>)"));
  const auto report = import(file);
  ASSERT_TRUE(report) << report.error().to_string();
  const ImportNote* note = note_of(*report, "keyframe 'home'");
  ASSERT_NE(note, nullptr);
  const auto arm = device::read_arm(report->folder);
  ASSERT_TRUE(arm);
  EXPECT_LT((*arm)->home[0], 1.6);
}

TEST_F(MjcfTest, ABallBesideTheArmIsLeftOut) {
  const auto file = write(
      "x.xml",
      model_of(arm_of(
          R"(<body name="bob" pos="0.2 0 0"><joint name="ball" type="ball"/><geom size="0.05" mass="0.1"/></body>)")));
  const auto report = import(file);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_NE(note_of(*report, "joint 'ball'"), nullptr);
  const auto robot = kinematics::RobotModel::load(report->folder / "arm.urdf");
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->link("bob"), nullptr);
}

TEST_F(MjcfTest, AnAttachedModelIsTakenWithWhatItLacks) {
  write("tool.xml", model_of("<body name=\"rod\" pos=\"0 0 0.05\"><geom size=\"0.02\" mass=\"0.2\" "
                             "solref=\"0.01 1\"/></body>"));
  const auto file =
      write("x.xml", "<mujoco>\n<asset><model name=\"tool\" file=\"tool.xml\"/></asset>\n<worldbody>\n" +
                         arm_of("<attach model=\"tool\" body=\"rod\" prefix=\"own_\"/>") + "</worldbody>\n</mujoco>\n");
  const auto report = import(file);
  ASSERT_TRUE(report) << report.error().to_string();
  const auto robot = kinematics::RobotModel::load(report->folder / "arm.urdf");
  ASSERT_TRUE(robot);
  ASSERT_NE(robot->link("own_rod"), nullptr);
  EXPECT_NEAR(robot->link("own_rod")->inertial->mass, 0.2, 1e-12);
  EXPECT_TRUE(
      std::ranges::any_of(report->notes, [](const ImportNote& one) { return one.value == "1 solref of geom"; }));
}

TEST_F(MjcfTest, TextThatIsNoXmlIsRefusedWithItsLine) {
  const Diagnostic error = refused(write("x.xml", "<mujoco>\n<worldbody>\n<body>\n</worldbody></mujoco>"));
  EXPECT_EQ(error.code, Code::kSyntax);
  EXPECT_TRUE(error.pointer.starts_with("line ")) << error.pointer;
}

TEST_F(MjcfTest, AMeshThatIsMissingIsRefusedWhereItIsNamed) {
  write("parts.xml", "<mujoco>\n<asset>\n<mesh name=\"m\" file=\"no.stl\"/>\n</asset>\n</mujoco>\n");
  const Diagnostic error =
      refused(write("x.xml", model_of(R"(<geom type="mesh" mesh="m"/>)", R"(<include file="parts.xml"/>)")));
  EXPECT_EQ(error.code, Code::kNotFound);
  EXPECT_EQ(fs::path(error.file).filename(), "parts.xml");
  EXPECT_EQ(error.pointer, "line 3");
}

TEST_F(MjcfTest, FilesThatIncludeEachOtherAreRefused) {
  write("b.xml", "<mujoco>\n\n<include file=\"x.xml\"/></mujoco>");
  const Diagnostic error = refused(write("x.xml", "<mujoco><include file=\"b.xml\"/></mujoco>"));
  EXPECT_EQ(error.code, Code::kDuplicate);
  EXPECT_EQ(fs::path(error.file).filename(), "b.xml");
  EXPECT_EQ(error.pointer, "line 3");
}

TEST_F(MjcfTest, AFileThatIsIncludedAndNotThereIsRefused) {
  const Diagnostic error = refused(write("x.xml", "<mujoco>\n<include file=\"none.xml\"/></mujoco>"));
  EXPECT_EQ(error.code, Code::kNotFound);
  EXPECT_EQ(error.pointer, "line 2");
}

TEST_F(MjcfTest, AClassThatIsNotThereIsRefused) {
  const Diagnostic error = refused(write("x.xml", model_of("<body>\n<geom class=\"nope\" size=\"1\"/></body>")));
  EXPECT_EQ(error.code, Code::kUnknownName);
  EXPECT_EQ(error.pointer, "line 4");
}

TEST_F(MjcfTest, AWordThatIsNoneIsRefusedInAnIncludedFileToo) {
  write("parts.xml", "<mujoco>\n<worldbody>\n<bodi name=\"q\"/>\n</worldbody>\n</mujoco>\n");
  const Diagnostic error = refused(write("x.xml", model_of("", "<include file=\"parts.xml\"/>")));
  EXPECT_EQ(error.code, Code::kUnknownKey);
  EXPECT_EQ(fs::path(error.file).filename(), "parts.xml");
  EXPECT_EQ(error.pointer, "line 3");
}

TEST_F(MjcfTest, WithoutJointsThereIsNoArm) {
  const Diagnostic error = refused(write("x.xml", model_of("<body><geom size=\"0.1\"/></body>")));
  EXPECT_EQ(error.code, Code::kInvalidValue);
}

TEST_F(MjcfTest, ABodyThatCannotBeIsRefused) {
  const Diagnostic error =
      refused(write("x.xml", model_of("<body name=\"b\">\n<joint/><inertial mass=\"1\" pos=\"0 0 0\" "
                                      "diaginertia=\"1 1 9\"/></body>")));
  EXPECT_EQ(error.code, Code::kInvalidModel);
}

}  // namespace
}  // namespace takt::tools
