// Lamps in pictures: they burn while there is something on their wire.
#include <unistd.h>

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/film/film.h"
#include "sim/world/world.h"
#include "tests/sim/render_fixture.h"
#include "tests/support/reports.h"
#include "tests/support/scratch_folder.h"

namespace takt::sim {
namespace {

/// A cube that is lit by an output, and beside it one of the same colour that is not.
WorldDescription two_cubes() {
  WorldDescription world;
  world.outputs.push_back({.name = "io/lamp", .pointer = {}});
  for (const double side : {-1.0, 1.0}) {
    ObjectDescription cube;
    cube.name = side < 0.0 ? "lamp" : "plain";
    cube.mount.X_P.translation() = Eigen::Vector3d(0.5 * side, 0.0, 1.0);
    cube.shapes.push_back(
        {.shape = kinematics::Box{Eigen::Vector3d::Constant(0.6)}, .rgba = Eigen::Vector4d(0.9, 0.2, 0.1, 1.0)});
    if (side < 0.0) cube.lit_by = "io/lamp";
    world.objects.push_back(cube);
  }
  CameraDescription camera;
  camera.name = "front";
  camera.mount.X_P = look_at({0.0, -4.0, 1.0}, {0.0, 0.0, 1.0});
  world.cameras.push_back(camera);
  return world;
}

World made(const WorldDescription& description) {
  auto world = World::create(description, [](mjSpec& spec) { add_scene_props(&spec, {}); });
  if (!world) throw std::runtime_error(world.error().to_string());
  return std::move(*world);
}

/// Red of the middle of a cube's face.
int red(const Image& image, double share_of_width) {
  const auto x = static_cast<std::size_t>(share_of_width * image.width);
  const std::size_t y = static_cast<std::size_t>(image.height) / 2;
  return image.rgba[4 * (y * static_cast<std::size_t>(image.width) + x)];
}

Image picture(const World& world) {
  const DataPtr data = posed_data(world.model());
  std::copy_n(world.data()->userdata, world.model()->nuserdata, data->userdata);
  auto renderer = Renderer::create(world.model(), small_picture());
  if (!renderer) throw std::runtime_error(renderer.error().to_string());
  Image image;
  (void)renderer->set_state(data.get());
  (void)renderer->draw(0, 160, 120, image);
  return image;
}

TEST(Lamp, BurnsWhileItsOutputIsOn) {
  World world = made(two_cubes());
  EXPECT_THAT(world.lamps(), testing::ElementsAre("io/lamp"));
  const double kLamp = 0.36, kPlain = 0.64;
  const Image off = picture(world);
  static_cast<device::SignalOutputBackend<bool>*>(world.output("io/lamp"))->write(true);
  const Image on = picture(world);
  EXPECT_LT(red(off, kLamp), red(off, kPlain) - 20) << "a cold lens is darker than paint of its colour";
  EXPECT_GT(red(on, kLamp), red(on, kPlain) + 20);
  EXPECT_EQ(red(on, kPlain), red(off, kPlain));
  static_cast<device::SignalOutputBackend<bool>*>(world.output("io/lamp"))->write(false);
  EXPECT_EQ(picture(world).rgba, off.rgba);
}

TEST(Lamp, ChangesPicturesAndNothingElse) {
  const World lit = made(two_cubes());
  WorldDescription without = two_cubes();
  without.objects[0].lit_by.clear();
  const World plain = made(without);
  EXPECT_TRUE(plain.lamps().empty());
  const auto a = lit.state_bytes(), b = plain.state_bytes();
  EXPECT_TRUE(std::ranges::equal(a, b)) << "the physics knows nothing of light";
}

TEST(Lamp, AnUnknownWireIsReportedWithTheNearestName) {
  WorldDescription world = two_cubes();
  world.objects[0].lit_by = "io/lmap";
  const auto refused = World::create(world);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(), takt::test::Reports(Code::kUnknownName, "/objects/lamp", {"io/lmap", "io/lamp"}));
}

/// Standing pictures are drawn once; a lamp that goes on is no standing picture.
TEST(Lamp, TheFilmDrawsAnewWhenALampChanges) {
  World world = made(two_cubes());
  FilmOptions options;
  const takt::test::ScratchFolder folder;
  options.path = folder / "film.mp4";
  options.render.width = 160;
  options.render.height = 120;
  auto film = Film::open(world.model(), options);
  ASSERT_TRUE(film) << film.error().to_string();
  auto* output = static_cast<device::SignalOutputBackend<bool>*>(world.output("io/lamp"));
  for (const bool on : {false, false, true, true, false}) {
    output->write(on);
    ASSERT_TRUE(film->push(world.data(), {}));
  }
  const auto report = film->close();
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_EQ(report->frames, 5);
  EXPECT_EQ(report->drawn, 3);
}

}  // namespace
}  // namespace takt::sim
