#include "core/kinematics/robot_model.h"

#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/kinematics/chain.h"
#include "tests/core/kinematics/robots.h"
#include "tests/support/reports.h"
#include "tests/support/scratch_folder.h"

namespace takt::kinematics {
namespace {

using takt::test::Reports;
using takt::test::Warns;

/// A folder of its own for one test, removed at its end.
class Folder {
 public:
  Folder() { std::filesystem::create_directories(folder_ / "meshes"); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

 private:
  takt::test::ScratchFolder folder_;
};

std::string robot(const std::string& body) { return "<robot name='r'>\n" + body + "\n</robot>\n"; }

std::string joint(const std::string& attributes, const std::string& inside) {
  return fmt::format("<joint name='j' {}><parent link='a'/><child link='b'/>{}</joint>", attributes, inside);
}

/// All diagnostics as one text; fails the test if there is no error.
Diagnostics errors(const std::string& xml) {
  const auto model = RobotModel::parse(xml, ".");
  EXPECT_FALSE(model) << xml;
  return model ? Diagnostics() : model.error();
}

// --- what is read ----------------------------------------------------------------------------------------------------

TEST(RobotModel, HoldsEverythingTheFileSays) {
  const Folder folder;
  folder.write("meshes/part.stl", "solid");
  folder.write("r.urdf", R"(<?xml version="1.0" encoding="utf-8"?>
<!-- a comment with <markup> and a DOCTYPE -->
<robot name="r">
  <material name="grey"><color rgba="0.1 0.2 0.3 0.4"/></material>
  <link name="z_root">
    <inertial>
      <origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><mass value="2.5"/>
      <inertia ixx="2" ixy="0.1" ixz="0.2" iyy="3" iyz="0.3" izz="4"/>
    </inertial>
    <visual name="shell"><origin xyz="0 0 1"/><geometry><mesh filename="meshes/part.stl" scale="1 -1 2"/></geometry>
      <material name="grey"/></visual>
    <visual><geometry><box size="1 2 3"/></geometry><material name="red"><color rgba="1 0 0 1"/></material></visual>
    <collision><geometry><cylinder radius="0.5" length="2"/></geometry></collision>
    <collision><geometry><sphere radius="0.25"/></geometry></collision>
  </link>
  <link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <joint name="to_b" type="prismatic"><parent link="z_root"/><child link="b"/><axis xyz="0 0 2"/>
    <limit lower="-0.5" upper="1" velocity="2" effort="3"/></joint>
  <joint name="to_a" type="revolute"><parent link="z_root"/><child link="a"/><origin xyz="1 0 0" rpy="0.1 0.2 0.3"/>
    <limit lower="-1" upper="+1.5e0" velocity="2" effort="3"/><dynamics damping="0.5" friction="0.25"/></joint>
  <joint name="to_c" type="continuous"><parent link="b"/><child link="c"/></joint>
  <joint name="to_d" type="fixed"><parent link="a"/><child link="d"/></joint>
</robot>)");
  const auto model = RobotModel::load(folder.path() / "r.urdf");
  ASSERT_TRUE(model) << model.error().to_string();
  EXPECT_EQ(model->name, "r");
  std::vector<std::string> order;
  for (const Link& link : model->links) order.push_back(link.name);
  EXPECT_THAT(order, ::testing::ElementsAre("z_root", "b", "c", "a", "d")) << "parents first, siblings as in the file";
  for (std::size_t i = 0; i < model->joints.size(); ++i) EXPECT_EQ(model->joints[i].child, model->links[i + 1].name);

  const Link& root = model->root();
  ASSERT_TRUE(root.inertial);
  EXPECT_EQ(root.inertial->mass, 2.5);
  EXPECT_EQ(root.inertial->I_C(1, 2), 0.3);
  EXPECT_EQ(root.inertial->I_C(2, 1), 0.3);
  EXPECT_LT((root.inertial->X_LC * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-15);
  ASSERT_EQ(root.visuals.size(), 2u);
  const auto& mesh = std::get<Mesh>(root.visuals[0].shape);
  EXPECT_TRUE(std::filesystem::equivalent(mesh.path, folder.path() / "meshes/part.stl"));
  EXPECT_EQ(mesh.name, "meshes/part.stl");
  EXPECT_EQ(mesh.scale, Eigen::Vector3d(1, -1, 2));
  EXPECT_EQ(root.visuals[0].name, "shell");
  EXPECT_EQ(root.visuals[0].material, "grey");
  EXPECT_LT((root.visuals[0].rgba - Eigen::Vector4d(0.1, 0.2, 0.3, 0.4)).norm(), 1e-7);
  EXPECT_EQ(std::get<Box>(root.visuals[1].shape).size, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(root.visuals[1].rgba, Eigen::Vector4d(1, 0, 0, 1));
  EXPECT_EQ(std::get<Cylinder>(root.collisions[0].shape).length, 2.0);
  EXPECT_EQ(std::get<Sphere>(root.collisions[1].shape).radius, 0.25);

  const Joint& slide = *model->joint("to_b");
  EXPECT_EQ(slide.type, JointType::kPrismatic);
  EXPECT_EQ(slide.axis, Eigen::Vector3d::UnitZ()) << "normalised";
  EXPECT_EQ(slide.lower, -0.5);
  const Joint& turn = *model->joint_above("a");
  EXPECT_EQ(turn.upper, 1.5);
  EXPECT_EQ(turn.velocity, 2.0);
  EXPECT_EQ(turn.effort, 3.0);
  EXPECT_EQ(turn.damping, 0.5);
  EXPECT_EQ(turn.friction, 0.25);
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_LT((turn.X_PJ.linear() - R).norm(), 1e-15);
  EXPECT_TRUE(std::isinf(model->joint("to_c")->upper));
  EXPECT_TRUE(std::isinf(model->joint("to_c")->velocity));
  EXPECT_EQ(model->joint_above("z_root"), nullptr);
  EXPECT_EQ(model->link("nobody"), nullptr);
  EXPECT_EQ(model->total_mass(), 2.5);
  // The length of the axis is worth a word, no more.
  EXPECT_THAT(model->warnings, Warns(Code::kInvalidValue, "line 17", {"to_b", "2"}));
}

TEST(RobotModel, UnknownWordsAreWarnings) {
  const auto model = RobotModel::parse(robot("<link name='a'><colision/></link><gazebo><anything/></gazebo>"), ".");
  ASSERT_TRUE(model) << model.error().to_string();
  EXPECT_EQ(model->warnings.list().size(), 1u);
  EXPECT_THAT(model->warnings, Warns(Code::kUnsupported, "line 2", {"colision"}));
  EXPECT_THAT(model->warnings, Warns(Code::kUnsupported, "line 2", {"collision"}));
}

// --- what is refused, each with its text -----------------------------------------------------------------------------

struct Bad {
  const char* what;
  std::string xml;
  std::vector<takt::test::Expected> expected;
};

std::vector<Bad> bad_files() {
  const std::string two_links = "<link name='a'/><link name='b'/>\n";
  const auto inertial = [](const std::string& mass, const std::string& inertia) {
    return robot("<link name='a'><inertial>" + mass + inertia + "</inertial></link>");
  };
  const std::string good_mass = "<mass value='1'/>";
  const std::string good_inertia = "<inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>";
  const auto shape = [](const std::string& text) {
    return robot("<link name='a'><visual><geometry>" + text + "</geometry></visual></link>");
  };
  const std::string limit = "<limit lower='-1' upper='1' velocity='1' effort='1'/>";
  return {
      {"empty", "", {{Code::kSyntax, "line 1"}}},
      {"no XML", "hello", {{Code::kSyntax, "line 1"}}},
      {"root", "<robt/>", {{Code::kSyntax, "line 1"}}},
      {"truncated tag", "<robot name='r'><link na", {{Code::kSyntax, "line 1", {"na"}}}},
      {"truncated value", "<robot name='r", {{Code::kSyntax, "line 1", {"name"}}}},
      {"truncated tree", "<robot name='r'>\n<link name='a'>\n", {{Code::kSyntax, "line 3"}}},
      {"truncated comment", "<robot name='r'><!-- ", {{Code::kSyntax, "line 1"}}},
      {"crossed tags", "<robot name='r'><link></robot></link>", {{Code::kSyntax, "line 1", {"1"}}}},
      {"extra end", "<robot name='r'/></robot>", {{Code::kSyntax, "line 1"}}},
      {"two robots", "<robot name='r'/><robot name='r'/>", {{Code::kSyntax, "line 1"}}},
      {"unquoted", "<robot name=r/>", {{Code::kSyntax, "line 1"}}},
      {"attribute twice", "<robot name='r' name='s'/>", {{Code::kSyntax, "line 1", {"name"}}}},
      {"entity", "<robot name='&x;'/>", {{Code::kSyntax, "line 1"}}},
      {"doctype", "<!DOCTYPE robot [<!ENTITY x 'y'>]><robot name='r'/>", {{Code::kSyntax, "line 1", {"DOCTYPE"}}}},
      {"encoding", "<?xml version='1.0' encoding='utf-16'?><robot name='r'/>", {{Code::kSyntax, "line 1", {"8"}}}},
      {"not text", std::string("<robot name='r\0'/>", 18), {{Code::kSyntax, "line 1"}}},
      {"no UTF-8", "<robot name='\xff'/>", {{Code::kSyntax, "line 1"}}},
      {"no name", "<robot><link name='a'/></robot>", {{Code::kMissing, "line 1"}}},
      {"no link", robot(""), {{Code::kMissing, "line 1"}}},
      {"nameless link", robot("<link/>"), {{Code::kMissing, "line 2"}}},
      {"link twice", robot("<link name='a'/>\n<link name='a'/>"), {{Code::kDuplicate, "line 3", {"a"}}}},
      {"no mass", inertial("", good_inertia), {{Code::kMissing, "line 2", {"a"}}}},
      {"negative mass",
       inertial("<mass value='-1'/>", good_inertia),
       {{Code::kOutOfRange, "line 2", {"a", "-1", "0"}}}},
      {"zero mass", inertial("<mass value='0'/>", good_inertia), {{Code::kOutOfRange, "line 2", {"0"}}}},
      {"NaN mass", inertial("<mass value='nan'/>", good_inertia), {{Code::kSyntax, "line 2", {"nan", "finite"}}}},
      {"huge mass", inertial("<mass value='1e300'/>", good_inertia), {{Code::kOutOfRange, "line 2", {"1e300"}}}},
      {"out of range",
       inertial("<mass value='1e999'/>", good_inertia),
       {{Code::kSyntax, "line 2", {"1e999", "finite"}}}},
      {"unit in mass", inertial("<mass value='1kg'/>", good_inertia), {{Code::kSyntax, "line 2", {"1kg"}}}},
      {"no inertia", inertial(good_mass, ""), {{Code::kMissing, "line 2"}}},
      {"half an inertia",
       inertial(good_mass, "<inertia ixx='1' iyy='1' ixy='0' ixz='0' iyz='0'/>"),
       {{Code::kMissing, "line 2"}}},
      {"indefinite",
       inertial(good_mass, "<inertia ixx='1' iyy='1' izz='1' ixy='2' ixz='0' iyz='0'/>"),
       {{Code::kInvalidValue, "line 2", {"-1", "1", "3"}}}},
      {"triangle",
       inertial(good_mass, "<inertia ixx='1' iyy='1' izz='3' ixy='0' ixz='0' iyz='0'/>"),
       {{Code::kInvalidValue, "line 2", {"1", "3"}}}},
      {"infinite place",
       robot("<link name='a'><visual><origin xyz='0 inf 0'/><geometry><sphere radius='1'/></geometry>"
             "</visual></link>"),
       {{Code::kSyntax, "line 2", {"inf"}}}},
      {"two numbers",
       robot("<link name='a'><visual><origin xyz='0 0'/><geometry><sphere radius='1'/></geometry>"
             "</visual></link>"),
       {{Code::kWrongSize, "line 2", {"2", "3"}}}},
      {"no shape", shape(""), {{Code::kWrongSize, "line 2", {"0"}}}},
      {"two shapes", shape("<sphere radius='1'/><sphere radius='1'/>"), {{Code::kWrongSize, "line 2", {"2"}}}},
      {"unknown shape", shape("<cilinder/>"), {{Code::kInvalidValue, "line 2", {"<cilinder>", "cylinder"}}}},
      {"flat box", shape("<box size='1 0 1'/>"), {{Code::kOutOfRange, "line 2", {"0"}}}},
      {"no radius", shape("<sphere/>"), {{Code::kMissing, "line 2"}}},
      {"no filename", shape("<mesh/>"), {{Code::kMissing, "line 2"}}},
      {"missing mesh", shape("<mesh filename='no/such.stl'/>"), {{Code::kNotFound, "line 2", {"no/such.stl"}}}},
      {"a mesh that nobody reads",
       shape("<mesh filename='README.md'/>"),
       {{Code::kUnsupported, "line 2", {"README.md"}}}},
      {"xacro",
       "<robot name='r'><xacro:property name='a' value='1'/><link name='a'/></robot>",
       {{Code::kSyntax, "line 1"}}},
      {"package",
       shape("<mesh filename='package://x/y.stl'/>"),
       {{Code::kInvalidValue, "line 2", {"URI", "relative"}}}},
      {"mesh outside",
       shape("<mesh filename='../../etc/passwd'/>"),
       {{Code::kFileNotReadable, "line 2", {"../../etc/passwd"}}}},
      {"absolute mesh", shape("<mesh filename='/etc/passwd'/>"), {{Code::kFileNotReadable, "line 2", {"/etc/passwd"}}}},
      {"material",
       robot("<material name='grey'><color rgba='0 0 0 1'/></material><link name='a'><visual><geometry>"
             "<sphere radius='1'/></geometry><material name='gray'/></visual></link>"),
       {{Code::kUnknownName, "line 2", {"gray", "grey"}}}},
      {"colour",
       robot("<material name='m'><color rgba='0 0 2 1'/></material><link name='a'/>"),
       {{Code::kOutOfRange, "line 2", {"2", "0", "1"}}}},
      {"material twice",
       robot("<material name='m'><color rgba='0 0 1 1'/></material>"
             "<material name='m'><color rgba='0 1 1 1'/></material><link name='a'/>"),
       {{Code::kDuplicate, "line 2", {"m"}}}},
      {"no type", robot(two_links + joint("", "")), {{Code::kMissing, "line 3", {"j"}}}},
      {"unknown type",
       robot(two_links + joint("type='revolut'", "")),
       {{Code::kUnsupported, "line 3", {"revolut", "revolute"}}}},
      {"floating", robot(two_links + joint("type='floating'", "")), {{Code::kUnsupported, "line 3", {"floating"}}}},
      {"planar", robot(two_links + joint("type='planar'", "")), {{Code::kUnsupported, "line 3", {"planar"}}}},
      {"mimic",
       robot(two_links + joint("type='revolute'", limit + "<mimic joint='j'/>")),
       {{Code::kUnsupported, "line 3"}}},
      {"no limit", robot(two_links + joint("type='revolute'", "")), {{Code::kMissing, "line 3", {"j"}}}},
      {"half a limit",
       robot(two_links + joint("type='revolute'", "<limit velocity='1' effort='1'/>")),
       {{Code::kMissing, "line 3"}}},
      {"reversed",
       robot(two_links + joint("type='revolute'", "<limit lower='1' upper='-1' velocity='1' effort='1'/>")),
       {{Code::kOutOfRange, "line 3", {"1", "-1"}}}},
      {"no speed",
       robot(two_links + joint("type='revolute'", "<limit lower='-1' upper='1' velocity='0' effort='1'/>")),
       {{Code::kOutOfRange, "line 3", {"0"}}}},
      {"zero axis",
       robot(two_links + joint("type='revolute'", limit + "<axis xyz='0 0 0'/>")),
       {{Code::kOutOfRange, "line 3"}}},
      {"damping",
       robot(two_links + joint("type='revolute'", limit + "<dynamics damping='-1'/>")),
       {{Code::kOutOfRange, "line 3", {"-1", "0"}}}},
      {"joint twice",
       robot(two_links + "<link name='c'/>" + joint("type='fixed'", "") +
             "<joint name='j' type='fixed'><parent link='b'/><child link='c'/></joint>"),
       {{Code::kDuplicate, "line 3", {"j"}}}},
      {"no parent",
       robot("<link name='a'/><joint name='j' type='fixed'><child link='a'/></joint>"),
       {{Code::kMissing, "line 2"}}},
      {"unknown parent",
       robot("<link name='arm'/><joint name='j' type='fixed'><parent link='amr'/><child link='arm'/>"
             "</joint>"),
       {{Code::kUnknownName, "line 2", {"amr", "arm"}}}},
      {"two parents",
       robot("<link name='a'/><link name='b'/><link name='c'/><joint name='j' type='fixed'><parent link='a'/>"
             "<child link='c'/></joint><joint name='k' type='fixed'><parent link='b'/><child link='c'/></joint>"),
       {{Code::kDuplicate, "line 2", {"c"}}, {Code::kInvalidValue, "line 1", {"a", "b", "2"}}}},
      {"loop",
       robot("<link name='root'/>" + two_links + joint("type='fixed'", "") +
             "<joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint>"),
       {{Code::kInvalidValue, "line 2"}}},
      {"self",
       robot("<link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='a'/></joint>"),
       {{Code::kInvalidValue, "line 2", {"a"}}}},
      {"two roots", robot(two_links), {{Code::kInvalidValue, "line 1", {"a", "b", "2"}}}},
  };
}

TEST(RobotModel, WhatOnlyTheLibraryRefusesHasACodeToo) {
  EXPECT_THAT(errors("<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='revolute'>"
                     "<parent link='a'/><child link='b'/><limit lower='-1' upper='1' velocity='1' effort='1'/>"
                     "<safety_controller soft_lower_limit='x'/></joint></robot>"),
              Reports(Code::kInvalidModel, "", {"soft_lower_limit", "x"}));
}

TEST(RobotModel, EveryBadFileGetsAClearError) {
  for (const Bad& bad : bad_files()) {
    SCOPED_TRACE(bad.what);
    const Diagnostics text = errors(bad.xml);
    for (const takt::test::Expected& one : bad.expected) EXPECT_THAT(text, Reports(one));
    for (const Diagnostic& one : text.list()) EXPECT_TRUE(one.pointer.starts_with("line ")) << to_string(one);
  }
}

TEST(RobotModel, AllErrorsAtOnce) {
  const auto model = RobotModel::parse(
      robot("<link name='a'><inertial><mass value='-1'/><inertia ixx='1' iyy='1' izz='9' ixy='0' ixz='0' iyz='0'/>"
            "</inertial></link>\n<link name='b'><visual><geometry><mesh "
            "filename='none.stl'/></geometry></visual></link>\n" +
            joint("type='revolute'", "<axis xyz='0 0 0'/>")),
      ".");
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().list().size(), 5u) << model.error().to_string();
}

TEST(RobotModel, MissingAndEmptyFilesAreNamed) {
  const Folder folder;
  folder.write("empty.urdf", "");
  const auto missing = RobotModel::load(folder.path() / "none.urdf");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error(), Reports(Code::kNotFound, ""));
  const auto empty = RobotModel::load(folder.path() / "empty.urdf");
  ASSERT_FALSE(empty);
  EXPECT_THAT(empty.error(), Reports(Code::kSyntax, "line 1"));
  EXPECT_FALSE(RobotModel::load(folder.path())) << "a folder";
}

// --- hostile input ---------------------------------------------------------------------------------------------------

TEST(RobotModel, DeepWideAndLongFilesAreBounded) {
  std::string deep = "<robot name='r'>";
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_THAT(errors(deep), Reports(Code::kSyntax, "line 1", {"64"}));
  EXPECT_THAT(errors(robot(std::string(5u << 20, ' '))), Reports(Code::kSyntax, "line 1", {"bytes"}));
  std::string many;
  for (int i = 0; i < 1001; ++i) many += fmt::format("<link name='l{}'/>", i);
  EXPECT_THAT(errors(robot(many)), Reports(Code::kTooLarge, "line 1", {"1001"}));
  std::string wide = "<link name='a'";
  for (int i = 0; i < 1000; ++i) wide += fmt::format(" a{}='1'", i);
  EXPECT_THAT(errors(robot(wide + "/>")), Reports(Code::kSyntax, "line 2", {"64"}));
  std::string elements;
  for (int i = 0; i < 200'000; ++i) elements += "<a/>";
  EXPECT_THAT(errors(robot(elements)), Reports(Code::kSyntax, "line 2", {"100000"}));
}

TEST(RobotModel, LongChainOfLinksIsNoProblem) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += fmt::format("<link name='l{}'/>", i);
  for (int i = 1; i < 1000; ++i)
    text += fmt::format("<joint name='j{0}' type='fixed'><parent link='l{1}'/><child link='l{0}'/></joint>", i, i - 1);
  const auto model = RobotModel::parse(robot(text), ".");
  ASSERT_TRUE(model) << model.error().to_string();
  EXPECT_EQ(model->links.size(), 1000u);
}

TEST(RobotModel, EveryTruncationOfAFileIsRefused) {
  const std::string whole = test::lwr_urdf();
  const std::size_t end = whole.rfind('>');
  for (std::size_t length = 0; length < end; length += 7)
    EXPECT_FALSE(RobotModel::parse(whole.substr(0, length), ".")) << length;
}

TEST(RobotModel, FlippedBytesNeverCrashAndNeverPassNonsense) {
  const std::string whole = test::lwr_urdf();
  Random random(3, "flips");
  int accepted = 0;
  for (int round = 0; round < 4000; ++round) {
    std::string broken = whole;
    const int flips = 1 + static_cast<int>(random.bits() % 4);
    for (int i = 0; i < flips; ++i) {
      char& byte = broken[random.bits() % broken.size()];
      byte = static_cast<char>(random.bits() % 3 == 0 ? random.bits() % 256
                                                      : static_cast<unsigned char>(byte) ^ (1u << (random.bits() % 7)));
    }
    const auto model = RobotModel::parse(broken, ".");
    if (!model) {
      EXPECT_TRUE(model.error().has_errors());
      continue;
    }
    ++accepted;
    EXPECT_EQ(model->joints.size() + 1, model->links.size());
    EXPECT_TRUE(std::isfinite(model->total_mass()));
    if (const auto chain = Chain::create(*model, "base", "flange"); chain) {
      const JointVector zero = JointVector::Zero(chain->joint_count());
      EXPECT_TRUE(chain->forward(zero).matrix().allFinite());
    }
  }
  EXPECT_GT(accepted, 100) << "flips in digits and texts leave a valid file: both ways are tried";
}

TEST(RobotModel, UrdfdomIsSilent) {
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  (void)errors("<robot name='r' version='7.0'><link name='a'/></robot>");
  const std::string printed = ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(printed, "");
}

}  // namespace
}  // namespace takt::kinematics
