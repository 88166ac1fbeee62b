#include "core/kinematics/robot_model.h"

#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/kinematics/chain.h"
#include "tests/core/kinematics/robots.h"
#include "tests/support/scratch_folder.h"

namespace takt::kinematics {
namespace {

using ::testing::HasSubstr;

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
std::string errors(const std::string& xml) {
  const auto model = RobotModel::parse(xml, ".");
  EXPECT_FALSE(model) << xml;
  return model ? std::string() : model.error().to_string();
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
  EXPECT_THAT(model->warnings.to_string(), HasSubstr("r.urdf:line 17: warning: joint 'to_b': the axis has length 2"));
}

TEST(RobotModel, UnknownWordsAreWarnings) {
  const auto model = RobotModel::parse(robot("<link name='a'><colision/></link><gazebo><anything/></gazebo>"), ".");
  ASSERT_TRUE(model) << model.error().to_string();
  EXPECT_EQ(model->warnings.list().size(), 1u);
  EXPECT_THAT(model->warnings.to_string(), HasSubstr("line 2: warning: unknown element 'colision' is ignored"));
  EXPECT_THAT(model->warnings.to_string(), HasSubstr("collision"));
}

// --- what is refused, each with its text -----------------------------------------------------------------------------

struct Bad {
  const char* what;
  std::string xml;
  std::vector<std::string> words;
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
      {"empty", "", {"no XML element"}},
      {"no XML", "hello", {"text outside of the root element"}},
      {"root", "<robt/>", {"the root element is <robt>", "<robot>"}},
      {"truncated tag", "<robot name='r'><link na", {"attribute 'na' of <link> has no value"}},
      {"truncated value", "<robot name='r", {"the value of 'name' has no end", "truncated"}},
      {"truncated tree", "<robot name='r'>\n<link name='a'>\n", {"the file ends inside <link> of line 2", "truncated"}},
      {"truncated comment", "<robot name='r'><!-- ", {"comment without end"}},
      {"crossed tags", "<robot name='r'><link></robot></link>", {"</robot> closes <link> of line 1"}},
      {"extra end", "<robot name='r'/></robot>", {"</robot> closes nothing"}},
      {"two robots", "<robot name='r'/><robot name='r'/>", {"a second root element"}},
      {"unquoted", "<robot name=r/>", {"not quoted"}},
      {"attribute twice", "<robot name='r' name='s'/>", {"duplicate attribute 'name'"}},
      {"entity", "<robot name='&x;'/>", {"unknown entity '&x;"}},
      {"doctype", "<!DOCTYPE robot [<!ENTITY x 'y'>]><robot name='r'/>", {"line 1", "DOCTYPE", "not allowed"}},
      {"encoding", "<?xml version='1.0' encoding='utf-16'?><robot name='r'/>", {"encoding other than UTF-8"}},
      {"not text", std::string("<robot name='r\0'/>", 18), {"byte 0x00 is not text"}},
      {"no UTF-8", "<robot name='\xff'/>", {"byte 0xff is not text"}},
      {"no name", "<robot><link name='a'/></robot>", {"the robot has no name"}},
      {"no link", robot(""), {"the robot has no link"}},
      {"nameless link", robot("<link/>"), {"line 2", "a link has no name"}},
      {"link twice", robot("<link name='a'/>\n<link name='a'/>"), {"line 3", "a second link 'a'"}},
      {"no mass", inertial("", good_inertia), {"link 'a': <inertial> has no <mass>"}},
      {"negative mass", inertial("<mass value='-1'/>", good_inertia), {"link 'a': value of <mass> is -1 kg", "> 0"}},
      {"zero mass", inertial("<mass value='0'/>", good_inertia), {"value of <mass> is 0 kg", "leave <inertial> out"}},
      {"NaN mass", inertial("<mass value='nan'/>", good_inertia), {"value of <mass> is 'nan'", "finite"}},
      {"huge mass", inertial("<mass value='1e300'/>", good_inertia), {"value of <mass> is '1e300'", "at most"}},
      {"out of range", inertial("<mass value='1e999'/>", good_inertia), {"value of <mass> is '1e999'", "finite"}},
      {"unit in mass", inertial("<mass value='1kg'/>", good_inertia), {"value of <mass> is '1kg'", "a number"}},
      {"no inertia", inertial(good_mass, ""), {"<inertial> has no <inertia>"}},
      {"half an inertia",
       inertial(good_mass, "<inertia ixx='1' iyy='1' ixy='0' ixz='0' iyz='0'/>"),
       {"<inertia> has no izz"}},
      {"indefinite",
       inertial(good_mass, "<inertia ixx='1' iyy='1' izz='1' ixy='2' ixz='0' iyz='0'/>"),
       {"principal moments are -1, 1, 3", "positive definite"}},
      {"triangle",
       inertial(good_mass, "<inertia ixx='1' iyy='1' izz='3' ixy='0' ixz='0' iyz='0'/>"),
       {"principal moments are 1, 1, 3", "triangle rule"}},
      {"infinite place",
       robot("<link name='a'><visual><origin xyz='0 inf 0'/><geometry><sphere radius='1'/></geometry>"
             "</visual></link>"),
       {"xyz of <origin> is 'inf'"}},
      {"two numbers",
       robot("<link name='a'><visual><origin xyz='0 0'/><geometry><sphere radius='1'/></geometry>"
             "</visual></link>"),
       {"xyz of <origin> has 2 numbers", "(3)"}},
      {"no shape", shape(""), {"<geometry> holds 0 shapes"}},
      {"two shapes", shape("<sphere radius='1'/><sphere radius='1'/>"), {"holds 2 shapes"}},
      {"unknown shape", shape("<cilinder/>"), {"unknown shape <cilinder>", "cylinder"}},
      {"flat box", shape("<box size='1 0 1'/>"), {"size of <box> is 0 m", "> 0"}},
      {"no radius", shape("<sphere/>"), {"<sphere> has no radius"}},
      {"no filename", shape("<mesh/>"), {"<mesh> has no filename"}},
      {"missing mesh", shape("<mesh filename='no/such.stl'/>"), {"there is no mesh file 'no/such.stl'"}},
      {"a mesh that nobody reads",
       shape("<mesh filename='README.md'/>"),
       {"'README.md' is of a kind that is not read", ".stl or .obj", "takt new robot"}},
      {"xacro",
       "<robot name='r'><xacro:property name='a' value='1'/><link name='a'/></robot>",
       {"<xacro:property>: this is a xacro file", "xacro FILE.urdf.xacro > FILE.urdf"}},
      {"package", shape("<mesh filename='package://x/y.stl'/>"), {"package://x/y.stl", "URI", "relative"}},
      {"mesh outside", shape("<mesh filename='../../etc/passwd'/>"), {"'../../etc/passwd' leaves its folder"}},
      {"absolute mesh", shape("<mesh filename='/etc/passwd'/>"), {"'/etc/passwd' is not allowed"}},
      {"material",
       robot("<material name='grey'><color rgba='0 0 0 1'/></material><link name='a'><visual><geometry>"
             "<sphere radius='1'/></geometry><material name='gray'/></visual></link>"),
       {"material 'gray' is not defined", "grey"}},
      {"colour",
       robot("<material name='m'><color rgba='0 0 2 1'/></material><link name='a'/>"),
       {"rgba of <color> is 2", "0 to 1"}},
      {"material twice",
       robot("<material name='m'><color rgba='0 0 1 1'/></material>"
             "<material name='m'><color rgba='0 1 1 1'/></material><link name='a'/>"),
       {"a second definition of material 'm'"}},
      {"no type", robot(two_links + joint("", "")), {"joint 'j' has no type"}},
      {"unknown type", robot(two_links + joint("type='revolut'", "")), {"type 'revolut'", "revolute"}},
      {"floating", robot(two_links + joint("type='floating'", "")), {"type 'floating' is not supported"}},
      {"planar", robot(two_links + joint("type='planar'", "")), {"type 'planar' is not supported"}},
      {"mimic", robot(two_links + joint("type='revolute'", limit + "<mimic joint='j'/>")), {"mimic joints"}},
      {"no limit", robot(two_links + joint("type='revolute'", "")), {"joint 'j' (revolute) has no <limit>"}},
      {"half a limit",
       robot(two_links + joint("type='revolute'", "<limit velocity='1' effort='1'/>")),
       {"<limit> has no lower", "<limit> has no upper"}},
      {"reversed",
       robot(two_links + joint("type='revolute'", "<limit lower='1' upper='-1' velocity='1' effort='1'/>")),
       {"lower 1 is not below upper -1"}},
      {"no speed",
       robot(two_links + joint("type='revolute'", "<limit lower='-1' upper='1' velocity='0' effort='1'/>")),
       {"velocity of <limit> is 0 rad/s"}},
      {"zero axis", robot(two_links + joint("type='revolute'", limit + "<axis xyz='0 0 0'/>")), {"the axis is zero"}},
      {"damping",
       robot(two_links + joint("type='revolute'", limit + "<dynamics damping='-1'/>")),
       {"damping of <dynamics> is -1", ">= 0"}},
      {"joint twice",
       robot(two_links + "<link name='c'/>" + joint("type='fixed'", "") +
             "<joint name='j' type='fixed'><parent link='b'/><child link='c'/></joint>"),
       {"a second joint 'j'"}},
      {"no parent",
       robot("<link name='a'/><joint name='j' type='fixed'><child link='a'/></joint>"),
       {"<joint> has no <parent>"}},
      {"unknown parent",
       robot("<link name='arm'/><joint name='j' type='fixed'><parent link='amr'/><child link='arm'/>"
             "</joint>"),
       {"parent link 'amr' does not exist", "arm"}},
      {"two parents",
       robot("<link name='a'/><link name='b'/><link name='c'/><joint name='j' type='fixed'><parent link='a'/>"
             "<child link='c'/></joint><joint name='k' type='fixed'><parent link='b'/><child link='c'/></joint>"),
       {"link 'c' has a second parent", "2 links have no parent: 'a', 'b'"}},
      {"loop",
       robot("<link name='root'/>" + two_links + joint("type='fixed'", "") +
             "<joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint>"),
       {"the joints form a loop"}},
      {"self",
       robot("<link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='a'/></joint>"),
       {"the joints form a loop: 'a' <- 'a'"}},
      {"two roots", robot(two_links), {"2 links have no parent: 'a', 'b'"}},
  };
}

TEST(RobotModel, EveryBadFileGetsAClearError) {
  for (const Bad& bad : bad_files()) {
    SCOPED_TRACE(bad.what);
    const std::string text = errors(bad.xml);
    for (const std::string& word : bad.words) EXPECT_THAT(text, HasSubstr(word));
    EXPECT_THAT(text, HasSubstr("line ")) << "every error names its line";
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
  EXPECT_THAT(missing.error().to_string(), HasSubstr("none.urdf"));
  const auto empty = RobotModel::load(folder.path() / "empty.urdf");
  ASSERT_FALSE(empty);
  EXPECT_THAT(empty.error().to_string(), HasSubstr("empty.urdf:line 1: error: no XML element"));
  EXPECT_FALSE(RobotModel::load(folder.path())) << "a folder";
}

// --- hostile input ---------------------------------------------------------------------------------------------------

TEST(RobotModel, DeepWideAndLongFilesAreBounded) {
  std::string deep = "<robot name='r'>";
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_THAT(errors(deep), HasSubstr("lies deeper than 64"));
  EXPECT_THAT(errors(robot(std::string(5u << 20, ' '))), HasSubstr("bytes"));
  std::string many;
  for (int i = 0; i < 1001; ++i) many += fmt::format("<link name='l{}'/>", i);
  EXPECT_THAT(errors(robot(many)), HasSubstr("1001 links"));
  std::string wide = "<link name='a'";
  for (int i = 0; i < 1000; ++i) wide += fmt::format(" a{}='1'", i);
  EXPECT_THAT(errors(robot(wide + "/>")), HasSubstr("more than 64 attributes"));
  std::string elements;
  for (int i = 0; i < 200'000; ++i) elements += "<a/>";
  EXPECT_THAT(errors(robot(elements)), HasSubstr("more than 100000 elements"));
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
