// Shapes of objects in scenario files: bores, tubes, containers, screws; and the screwdriver in a cell.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/build/cell_builder.h"
#include "tests/cell/described.h"
#include "tests/support/reports.h"

namespace takt::cell::test {
namespace {

/// A scenario with this object, and an arm with a screwdriver.
std::string cell_with(const std::string& object, const std::string& settings = R"({"bit": "M6"})") {
  return R"({"devices": {"arm": {"model": "lwr4plus"}, "driver": {"model": "screwdriver", "on": "arm", "settings": )" +
         settings + R"(}}, "objects": {"thing": )" + object + R"(}, "program": {"do": "wait", "seconds": 1}})";
}

ObjectEntry shaped(const std::string& object) {
  const Description description = parsed(cell_with(object));
  return description.objects.empty() ? ObjectEntry{} : description.objects.front();
}

double distance(const ObjectEntry& entry, const Eigen::Vector3d& p) {
  return world::signed_distance(world::Object{entry.name, entry.parts}, p);
}

TEST(Shapes, ABlockHasItsBores) {
  const ObjectEntry block = shaped(R"({"shape": "box", "size_m": [0.1, 0.1, 0.04], "at": {}, "bores": [
    {"position_m": [0, 0, 0.02], "radius_m": 0.01, "depth_m": 0.03, "chamfer_m": 0.001}, {"thread": "M6"}]})");
  ASSERT_EQ(block.parts.size(), 1u);
  const auto& bores = block.parts[0].bores;
  ASSERT_EQ(bores.size(), 2u);
  EXPECT_EQ(bores[0].radius, 0.01);
  EXPECT_EQ(bores[0].depth, 0.03);
  EXPECT_EQ(bores[0].chamfer, 0.001);
  EXPECT_EQ(bores[0].X_SB.translation().z(), 0.02);
  EXPECT_TRUE(bores[1].through());
  EXPECT_EQ(bores[1].thread, "M6");
}

TEST(Shapes, ATubeIsOpenAtBothEnds) {
  const ObjectEntry tube = shaped(
      R"({"shape": "tube", "radius_m": 0.02, "inner_radius_m": 0.01, "length_m": 0.1, "chamfer_m": 0.002, "at": {}})");
  ASSERT_EQ(tube.parts.size(), 1u);
  EXPECT_EQ(tube.parts[0].chamfer, 0.002);
  for (const double z : {-0.049, 0.0, 0.049}) EXPECT_NEAR(distance(tube, {0.0, 0.0, z}), 0.01, 1e-12) << z;
  EXPECT_NEAR(distance(tube, {0.0, 0.015, 0.0}), -0.005, 1e-12);
}

TEST(Shapes, AContainerHasAFloorAndFourWalls) {
  const ObjectEntry tray = shaped(R"({"shape": "container", "size_m": [0.3, 0.2, 0.1], "wall_m": 0.004,
    "floor_m": 0.006, "at": {}})");
  EXPECT_EQ(tray.parts.size(), 5u);
  EXPECT_NEAR(distance(tray, {0.0, 0.0, -0.044 + 0.003}), 0.003, 1e-12);
  EXPECT_NEAR(distance(tray, {0.145, 0.0, 0.0}), 0.001, 1e-12);
  EXPECT_NEAR(distance(tray, {0.0, -0.095, 0.0}), 0.001, 1e-12);
  EXPECT_NEAR(distance(tray, {0.0, 0.0, 0.06}), std::hypot(0.01, 0.096), 1e-9) << "no lid";
  EXPECT_LT(distance(tray, {0.148, 0.098, 0.0}), 0.0) << "a corner is closed";
  const ObjectEntry two = shaped(R"({"parts": [
    {"shape": "container", "size_m": [0.3, 0.2, 0.1], "wall_m": 0.004, "mass_kg": 0.5},
    {"shape": "sphere", "radius_m": 0.01, "position_m": [0, 0, 0.5], "mass_kg": 0.1}], "at": {}})");
  EXPECT_EQ(two.parts.size(), 6u);
  EXPECT_NEAR(two.mass_kg, 0.6, 1e-12);
  EXPECT_EQ(two.part_pointers[5], "/objects/thing/parts/1");
  const double floor = 0.3 * 0.2 * 0.004, side = 0.2 * 0.004 * 0.096, end = 0.292 * 0.004 * 0.096;
  EXPECT_NEAR(two.part_masses_kg[0], 0.5 * floor / (floor + 2.0 * side + 2.0 * end), 1e-12) << "by its volume";
}

TEST(Shapes, AScrewHasTheSizesOfItsThread) {
  Diagnostics warnings;
  const auto built = build_cell(
      parsed(cell_with(R"({"screw": {"thread": "M6", "length_m": 0.012}, "at": {"position_m": [0.5, 0, 0.5]}})")),
      models(), false, warnings);
  ASSERT_TRUE(built) << built.error().to_string();
  const world::Object& screw = built->cell.objects.at("thing");
  ASSERT_EQ(screw.parts.size(), 2u);
  EXPECT_NEAR(world::signed_distance(screw, {0.004, 0.0, 0.006}), 0.001, 1e-12) << "beside the shank";
  EXPECT_LT(world::signed_distance(screw, {0.004, 0.0, 0.013}), 0.0) << "in the head";
  EXPECT_NEAR(world::signed_distance(screw, {0.0, 0.0, 0.0165}), 0.0015, 1e-12) << "in the socket";
  // 12 mm of 5.35 mm and a head of 10 x 6 mm with a socket of 5.1 mm, 3 mm deep; ISO 4762 gives about 5 g.
  EXPECT_NEAR(screw.mass.mass, 0.0053, 0.0003);
  EXPECT_GT(screw.mass.p_OC.z(), 0.009) << "the head is heavier";
  const auto X_OS = built->cell.frames.pose("thing/socket", "thing");
  ASSERT_TRUE(X_OS) << X_OS.error().to_string();
  EXPECT_TRUE(X_OS->translation().isApprox(Eigen::Vector3d(0.0, 0.0, 0.015)));
  EXPECT_TRUE(X_OS->linear().col(2).isApprox(-Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(built->world->threads().screw_names(), std::vector<std::string>{"thing"});
  for (const char* output : {"driver/turn", "driver/reverse"})
    EXPECT_TRUE(built->cell.digital_outputs.contains(output)) << output;
  for (const char* input : {"driver/torque", "driver/peak_torque", "driver/angle"})
    EXPECT_TRUE(built->cell.analog_inputs.contains(input)) << input;
}

TEST(Shapes, WhatIsWrongIsReportedWhereItIs) {
  const auto form = [](const std::string& object) {
    auto description = parse_description(cell_with(object));
    return description ? Diagnostics{} : description.error();
  };
  using takt::test::Reports;
  EXPECT_THAT(form(R"({"shape": "box", "size_m": [1, 1, 1], "at": {}, "bores": [{"position_m": [0, 0, 0.5]}]})"),
              Reports(Code::kMissing, "/objects/thing/bores/0"));
  EXPECT_THAT(form(R"({"shape": "box", "size_m": [1, 1, 1], "at": {}, "bores": [{"radius_m": 0.1, "thread": "M6"}]})"),
              Reports(Code::kConflict, "/objects/thing/bores/0"));
  EXPECT_THAT(form(R"({"shape": "tube", "radius_m": 0.01, "inner_radius_m": 0.02, "length_m": 0.1, "at": {}})"),
              Reports(Code::kOutOfRange, "/objects/thing/inner_radius_m"));
  EXPECT_THAT(form(R"({"shape": "container", "size_m": [0.1, 0.1, 0.1], "wall_m": 0.06, "at": {}})"),
              Reports(Code::kOutOfRange, "/objects/thing/wall_m"));
  EXPECT_THAT(form(R"({"shape": "sphere", "radius_m": 0.1, "at": {}, "bores": []})"),
              Reports(Code::kUnknownKey, "/objects/thing/bores"));
  EXPECT_THAT(form(R"({"screw": {"thread": "M6", "length_m": 0.01}, "shape": "sphere", "radius_m": 0.1, "at": {}})"),
              Reports(Code::kConflict, "/objects/thing"));

  const auto built = [](const std::string& object, const std::string& settings = R"({"bit": "M6"})") {
    Diagnostics warnings;
    auto cell = build_cell(parsed(cell_with(object, settings)), models(), false, warnings);
    return cell ? Diagnostics{} : cell.error();
  };
  EXPECT_THAT(built(R"({"shape": "box", "size_m": [0.1, 0.1, 0.1], "at": {}, "bores": [{"radius_m": 0.01}]})"),
              Reports(Code::kInvalidValue, "/objects/thing/bores/0"));
  EXPECT_THAT(built(R"({"screw": {"thread": "M66", "length_m": 0.01}, "at": {}})"),
              Reports(Code::kUnknownName, "/objects/thing/screw/thread", {"M66"}));
  EXPECT_THAT(built(R"({"shape": "sphere", "radius_m": 0.1, "at": {}})", R"({"bit": "M7"})"),
              Reports(Code::kUnknownName, "/devices/driver/settings/bit", {"M7"}));
}

}  // namespace
}  // namespace takt::cell::test
