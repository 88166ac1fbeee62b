// Shapes of objects in scenario files: bores, tubes, gears, containers, screws; and the screwdriver in a cell.
#include <cmath>
#include <numbers>

#include <fmt/format.h>
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

ObjectEntry gear_of(int teeth) {
  return shaped(
      fmt::format(R"({{"shape": "gear", "module_m": 0.001, "teeth": {}, "width_m": 0.01, "bore_radius_m": 0.005,
    "bore_chamfer_m": 0.0005, "hub_radius_m": 0.0075, "hub_length_m": 0.008, "at": {{}}}})",
                  teeth));
}

TEST(Shapes, AGearHasTeethHubAndBore) {
  const ObjectEntry gear = gear_of(20);
  EXPECT_NEAR(distance(gear, {0.0, 0.0, 0.0}), 0.005, 1e-12) << "the bore";
  EXPECT_NEAR(distance(gear, {0.0, 0.0, 0.012}), 0.005, 1e-12) << "it goes through the hub";
  EXPECT_LT(distance(gear, {0.0, 0.006, 0.012}), 0.0) << "the hub is on the side of z";
  EXPECT_GT(distance(gear, {0.0, 0.006, -0.006}), 0.0);
  // A tooth at x, a gap half a pitch on; both are as wide as half the pitch on the pitch circle of 10 mm.
  const auto at = [&](double radius, double angle) {
    return distance(gear, {radius * std::cos(angle), radius * std::sin(angle), 0.0});
  };
  const double pitch = 2.0 * std::numbers::pi / 20;
  EXPECT_LT(at(0.0105, 0.02), 0.0);
  EXPECT_GT(at(0.0095, 0.5 * pitch), 0.0003);
  EXPECT_GT(at(0.0111, 0.0), 0.0) << "the tips lie on 11 mm";
  EXPECT_LT(at(0.0085, 0.5 * pitch), 0.0) << "the roots on 8.75 mm";
  EXPECT_NEAR(at(0.01, 0.25 * pitch), 0.0, 8e-5) << "a flank, flat where an involute is not";
}

/// Corners of the teeth, in the frame of the gear.
std::vector<Eigen::Vector3d> corners_of(const ObjectEntry& gear) {
  std::vector<Eigen::Vector3d> corners;
  for (const world::Object::Part& part : gear.parts) {
    const auto* box = std::get_if<world::Box>(&part.shape);
    if (!box) continue;
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        corners.push_back(part.X_OS * Eigen::Vector3d(x * box->size.x(), y * box->size.y(), 0.0));
  }
  return corners;
}

TEST(Shapes, TwoGearsMeshAllTheWayRound) {
  const ObjectEntry large = gear_of(40), small = gear_of(20);
  const double apart = 0.0305;  // half a millimetre more than the pitch circles, which is play
  const auto corners = corners_of(small);
  for (int i = 0; i < 24; ++i) {
    const double turned = i * 2.0 * std::numbers::pi / 40 / 24;
    // The large one has a gap towards the small one's tooth at first, and they turn against each other.
    const Eigen::Isometry3d X_WL(Eigen::AngleAxisd(std::numbers::pi / 40 + turned, Eigen::Vector3d::UnitZ()));
    const Eigen::Isometry3d X_WS = Eigen::Translation3d(apart, 0.0, 0.0) *
                                   Eigen::AngleAxisd(std::numbers::pi - 2.0 * turned, Eigen::Vector3d::UnitZ());
    double least = 1.0;
    for (const Eigen::Vector3d& corner : corners)
      least = std::min(least, distance(large, X_WL.inverse() * X_WS * corner));
    EXPECT_GT(least, 0.0) << turned;
    EXPECT_LT(least, 0.0005) << "the teeth reach into each other";
  }
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
  const auto gear = [&](const std::string& keys) {
    return form(R"({"shape": "gear", "module_m": 0.001, "width_m": 0.01, "at": {}, )" + keys + "}");
  };
  EXPECT_THAT(gear(R"("teeth": 20, "bore_radius_m": 0.009)"),
              Reports(Code::kOutOfRange, "/objects/thing/bore_radius_m"));
  EXPECT_THAT(gear(R"("teeth": 20, "bore_radius_m": -0.005)"),
              Reports(Code::kOutOfRange, "/objects/thing/bore_radius_m"));
  EXPECT_THAT(gear(R"("teeth": 20, "bore_radius_m": 0.005, "hub_radius_m": 0.009)"),
              Reports(Code::kOutOfRange, "/objects/thing/hub_radius_m"));
  EXPECT_THAT(gear(R"("teeth": 8, "bore_radius_m": 0.001)"), Reports(Code::kOutOfRange, "/objects/thing/teeth"));
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
