// What a picture shows beside the scene, and the camera that fits a cell.
#include "sim/model/marks.h"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "sim/film/film.h"
#include "tests/sim/render_fixture.h"

namespace takt::sim::marks_test {
namespace {

constexpr int kWidth = 160, kHeight = 120;

/// A grey wall in front of the camera, and a slide behind which nothing is.
constexpr const char* kWall = R"(<geom type="box" size=".5 .05 .5" pos="0 0 1" rgba=".5 .5 .5 1"/>)";
constexpr const char* kSlider = R"(<body name="robot/cart"><joint name="slide" type="slide" axis="1 0 0"/>
    <geom type="box" size=".2 .2 .2" pos="-1 0 1" rgba="1 0 0 1"/></body>
    <body name="other"><joint type="slide" axis="1 0 0"/><geom type="box" size=".1 .1 .1" pos="0 0 .2"/></body>)";

Image drawn(const mjModel* model, const Marks& marks) {
  const DataPtr data = posed_data(model);
  Result<Renderer> renderer = Renderer::create(model, small_picture());
  EXPECT_TRUE(renderer && renderer->set_marks(marks) && renderer->set_state(data.get()));
  Image image;
  EXPECT_TRUE(renderer->draw(0, kWidth, kHeight, image));
  return image;
}

ModelPtr scene(const char* bodies) {
  const StageOptions stage;
  return compile_scene(std::string(kFrontCamera) + bodies, &stage);
}

int green_pixels(const Image& image) {
  int count = 0;
  for (int i = 0; i < image.width * image.height; ++i) {
    const std::uint8_t* p = image.pixel(i % image.width, i / image.width);
    count += p[1] > 1.6 * p[0] && p[1] > 1.6 * p[2] ? 1 : 0;
  }
  return count;
}

Mark green(double y, bool on_top, Mark::Shape shape = Mark::Shape::kRod) {
  const auto depth = static_cast<float>(y);
  return {.shape = shape,
          .from = {-0.3F, depth, 1},
          .to = {0.3F, depth, 1},
          .radius = 0.05F,
          .rgba = {0, 1, 0, 1},
          .on_top = on_top};
}

TEST(Marks, AreHiddenByTheSceneUnlessTheyAreOnTop) {
  const ModelPtr model = scene(kWall);
  EXPECT_EQ(green_pixels(drawn(model.get(), {})), 0);
  EXPECT_GT(green_pixels(drawn(model.get(), {.shapes = {green(-0.5, false)}, .ghost = {}})), 100);
  EXPECT_EQ(green_pixels(drawn(model.get(), {.shapes = {green(0.5, false)}, .ghost = {}})), 0);
  EXPECT_GT(green_pixels(drawn(model.get(), {.shapes = {green(0.5, true)}, .ghost = {}})), 60);
}

TEST(Marks, AnArrowIsThickAtItsTip) {
  const ModelPtr model = scene(kWall);
  const Image image = drawn(model.get(), {.shapes = {green(-0.5, true, Mark::Shape::kArrow)}, .ghost = {}});
  std::array<int, 2> halves{};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t* p = image.pixel(x, y);
      if (p[1] > 1.6 * p[0] && p[1] > 1.6 * p[2]) ++halves[x < kWidth / 2 ? 0 : 1];
    }
  EXPECT_GT(halves[0], 10);
  EXPECT_GT(halves[1], halves[0]) << "from left to right";
}

TEST(Marks, WhatHasNoLengthOrNoNumbersIsLeftOut) {
  const ModelPtr model = scene(kWall);
  Mark none = green(-0.5, true);
  none.to = none.from;
  Mark nowhere = green(-0.5, true);
  nowhere.to[0] = std::nanf("");
  EXPECT_EQ(green_pixels(drawn(model.get(), {.shapes = {none, nowhere}, .ghost = {}})), 0);
  EXPECT_GT(green_pixels(drawn(model.get(), {.shapes = std::vector<Mark>(10'000, green(-0.5, true)), .ghost = {}})), 60)
      << "more than fit";
}

TEST(Marks, AGhostShowsItsBodiesOnceMoreAndNothingElse) {
  const ModelPtr model = scene(kSlider);
  Marks marks;
  marks.ghost.qpos = {2, 1};
  const Image plain = drawn(model.get(), {});
  EXPECT_EQ(drawn(model.get(), marks), plain) << "no body of it is shown";
  marks.ghost.bodies = {false, true, false};
  const Image ghostly = drawn(model.get(), marks);
  std::array<int, 2> changed{};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (std::abs(ghostly.pixel(x, y)[0] - plain.pixel(x, y)[0]) > 12) ++changed[x < kWidth / 2 ? 0 : 1];
  EXPECT_EQ(changed[0], 0) << "the machine itself is as it was";
  EXPECT_GT(changed[1], 50);
  Result<Renderer> renderer = Renderer::create(model.get(), small_picture());
  ASSERT_TRUE(renderer);
  EXPECT_FALSE(renderer->set_marks({.shapes = {}, .ghost = {.qpos = {1}, .bodies = {}}}));
}

/// Where a point is in the picture of a free camera: -1 to 1 in both directions, from its definition.
std::array<double, 2> seen_by(const FreeCamera& camera, const Eigen::Vector3d& point, double aspect) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double a = camera.azimuth * kDegree, e = camera.elevation * kDegree;
  const Eigen::Vector3d forward(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  const Eigen::Vector3d right(std::sin(a), -std::cos(a), 0), up = right.cross(forward);
  const Eigen::Vector3d from = Eigen::Vector3d(camera.look_at.data()) - camera.distance * forward;
  const double depth = (point - from).dot(forward), half = depth * std::tan(22.5 * kDegree);
  return {(point - from).dot(right) / (half * aspect), (point - from).dot(up) / half};
}

TEST(FittingCamera, ShowsAllOfTheCellAndLittleMore) {
  for (const double aspect : {16.0 / 9.0, 0.5}) {
    for (const double size : {0.05, 1.0, 20.0}) {
      const std::string text = std::to_string(size);
      const ModelPtr model =
          scene((R"(<geom type="box" size=")" + text + " " + text + " " + text + R"(" pos="3 -2 1"/>)").c_str());
      const DataPtr data = posed_data(model.get());
      const FreeCamera camera = fitting_camera(model.get(), data.get(), aspect);
      double widest = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const auto side = [&](int bit) { return (corner & bit) != 0 ? size : -size; };
        const auto seen = seen_by(camera, Eigen::Vector3d(3 + side(1), -2 + side(2), 1 + side(4)), aspect);
        widest = std::max({widest, std::abs(seen[0]), std::abs(seen[1])});
      }
      EXPECT_LT(widest, 0.85) << size;
      EXPECT_GT(widest, 0.7) << size;
    }
  }
}

TEST(FittingCamera, ACellOfAFloorAloneIsSeenAsBefore) {
  const ModelPtr model = scene("");
  const DataPtr data = posed_data(model.get());
  EXPECT_EQ(fitting_camera(model.get(), data.get(), 1).distance, overview_camera(model.get()).distance);
}

TEST(CameraFrom, StandsAtTheEyeAndLooksAtTheTarget) {
  for (const std::array<double, 3>& eye : {std::array{1.6, -1.1, 1.5}, {-2.0, 0.0, 0.9}, {0.3, 0.0, 5.0}}) {
    const FreeCamera camera = camera_from(eye, {0.3, 0, 0.9});
    const double a = camera.azimuth * std::numbers::pi / 180, e = camera.elevation * std::numbers::pi / 180;
    EXPECT_NEAR(camera.look_at[0] - camera.distance * std::cos(e) * std::cos(a), eye[0], 1e-9);
    EXPECT_NEAR(camera.look_at[1] - camera.distance * std::cos(e) * std::sin(a), eye[1], 1e-9);
    EXPECT_NEAR(camera.look_at[2] - camera.distance * std::sin(e), eye[2], 1e-9);
  }
}

}  // namespace
}  // namespace takt::sim::marks_test
