#include "sim/film/renderer.h"

#include <array>
#include <cmath>
#include <set>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "core/base/random.h"
#include "tests/sim/render_fixture.h"
#include "tests/support/random_runs.h"
#include "tests/support/reports.h"

namespace takt::sim {
namespace {

struct Pixel {
  int r, g, b;
};

// The pixel of a point in the world as the front camera sees it, by hand: f = height / 2 / tan(fovy / 2).
Pixel at(const Image& image, double x, double y, double z) {
  const double f = image.height / 2.0 / std::tan(22.5 * 3.14159265358979 / 180), depth = y + 4;
  const auto column = static_cast<int>(image.width / 2.0 + f * x / depth);
  const auto row = static_cast<int>(image.height / 2.0 - f * (z - 1) / depth);
  const std::uint8_t* p = image.pixel(column, row);
  return {p[0], p[1], p[2]};
}

bool is_red(Pixel p) { return p.r > 2 * p.g && p.r > 2 * p.b && p.r > 60; }
bool is_blue(Pixel p) { return p.b > 2 * p.r && p.b > 60; }

ModelPtr dressed(const std::string& bodies) {
  const StageOptions stage;
  return compile_scene(kFrontCamera + bodies, &stage);
}

TEST(Renderer, PutsThingsWhereTheCameraSeesThem) {
  const ModelPtr model = dressed(R"(<geom type="box" size=".2 .2 .2" pos="1 0 1.8" rgba="1 0 0 1"/>
                                    <geom type="sphere" size=".2" pos="-1 0 0.5" rgba="0 0 1 1"/>)");
  const Image image = draw_once(model.get(), small_picture());
  EXPECT_TRUE(is_red(at(image, 1, -0.2, 1.8)));
  EXPECT_TRUE(is_blue(at(image, -1, -0.2, 0.5)));
  EXPECT_FALSE(is_red(at(image, -1, 0, 1.8)));
  EXPECT_FALSE(is_blue(at(image, 1, 0, 0.5)));
}

TEST(Renderer, DrawsEveryShapeAndNotTheHiddenGroups) {
  const std::array shapes = {R"(type="box" size=".2 .2 .2")", R"(type="sphere" size=".2")",
                             R"(type="cylinder" size=".2 .2")", R"(type="capsule" size=".2 .1")",
                             R"(type="ellipsoid" size=".2 .1 .3")"};
  std::string bodies;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (const int group : {2, 3})
      bodies += fmt::format(R"(<geom {} pos="{} 0 {}" group="{}" rgba="1 0 0 1"/>)", shapes[i],
                            0.5 * (static_cast<double>(i) - 2), group == 2 ? 1.5 : 0.6, group);
  const Image image = draw_once(dressed(bodies).get(), small_picture());
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(is_red(at(image, 0.5 * (i - 2), 0, 1.5))) << i;
    EXPECT_FALSE(is_red(at(image, 0.5 * (i - 2), 0, 0.6))) << i;
  }
}

TEST(Renderer, NearHidesFarInWhateverOrderTheyStand) {
  const std::string near = R"(<geom type="box" size=".3 .1 .3" pos="0 -1 1" rgba="1 0 0 1"/>)";
  const std::string far = R"(<geom type="box" size=".6 .1 .6" pos="0 1 1" rgba="0 0 1 1"/>)";
  for (const std::string& bodies : {near + far, far + near})
    EXPECT_TRUE(is_red(at(draw_once(dressed(bodies).get(), small_picture()), 0, -1, 1)));
}

TEST(Renderer, GlassLetsThroughWhatStandsBehind) {
  const std::string behind = R"(<geom type="box" size=".6 .1 .6" pos="0 1 1" rgba="0 0 1 1"/>)";
  const auto centre = [&](const std::string& front) {
    return at(draw_once(dressed(front + behind).get(), small_picture()), 0, -1, 1);
  };
  const Pixel bare = centre(""), glass = centre(R"(<geom type="box" size=".3 .1 .3" pos="0 -1 1" rgba="1 0 0 .4"/>)");
  EXPECT_TRUE(is_blue(bare));
  EXPECT_GT(glass.r, bare.r + 40);
  EXPECT_GT(glass.b, 60);
}

TEST(Renderer, APictureDoesNotDependOnTheOneBefore) {
  const ModelPtr model = dressed(R"(<geom type="box" size=".3 .3 .3" pos="0.3 0 1" euler="10 20 30"/>)");
  const DataPtr data = posed_data(model.get());
  Result<Renderer> renderer = Renderer::create(model.get(), small_picture());
  ASSERT_TRUE(renderer);
  const Image fresh = draw_once(model.get(), small_picture());
  for (double x = 0; x < 3; x += 0.37) {
    FreeCamera elsewhere;
    elsewhere.look_at = {x, 1.7 * x, 0.3};
    Image image;
    ASSERT_TRUE(renderer->set_state(data.get()));
    ASSERT_TRUE(renderer->draw(elsewhere, 160, 120, image));
    ASSERT_TRUE(renderer->set_state(data.get()));
    ASSERT_TRUE(renderer->draw(0, 160, 120, image));
    EXPECT_EQ(image, fresh) << x;
  }
}

/// A world of which a little moves at a time; in the end everything has, also what is transparent, on top, or a light.
TEST(Renderer, WhatIsNotDrawnAnewIsAsIfItWere) {
  const ModelPtr model = dressed(R"(<light name="lamp" pos="1 -1 3" dir="0 0 -1"/>
      <geom type="box" size=".8 .4 .05" pos="0 0 .4" rgba=".6 .6 .6 1"/>
      <body pos="-.6 0 1"><joint type="slide" axis="1 0 0"/><geom type="box" size=".1 .1 .2" rgba="1 0 0 1"/>
        <body pos="0 0 .4"><joint type="hinge" axis="0 1 0"/>
          <geom type="capsule" size=".05 .3" rgba="0 0 1 1"/></body></body>
      <body pos=".3 -.3 .6"><joint type="slide" axis="0 0 1"/><geom type="sphere" size=".12" rgba="0 1 0 .4"/></body>
      <body pos=".5 .2 1.2"><joint type="slide" axis="0 1 0"/><geom type="cylinder" size=".08 .1"/></body>)");
  const DataPtr data = posed_data(model.get());
  Result<Renderer> kept = Renderer::create(model.get(), small_picture());
  ASSERT_TRUE(kept);
  Random random(takt::test::RandomRuns(1).first_seed, "renderer");
  Marks marks;
  for (int step = 0; step < 60; ++step) {
    const auto joint = static_cast<int>(random.uniform(0, model->nq));
    if (step % 4 != 3) data->qpos[joint] = random.uniform(-0.4, 0.4);
    if (step % 7 == 6) data->qpos[0] = random.uniform(-3.0, 3.0);
    if (step == 30) model->light_active[0] = 0;
    if (step == 40) model->geom_rgba[4 * (model->ngeom - 1)] = 0.2F;
    if (step % 5 == 4) {
      const auto x = static_cast<float>(random.uniform(-0.5, 0.5));
      marks.shapes.push_back({.shape = Mark::Shape::kRod,
                              .from = {x, 0, 0.5F},
                              .to = {x, 0, 1.5F},
                              .radius = 0.01F,
                              .rgba = {0, 1, 0, 1},
                              .on_top = step % 2 == 0});
      if (marks.shapes.size() > 4) marks.shapes.erase(marks.shapes.begin());
    }
    pose_for_drawing(model.get(), data.get());
    Result<Renderer> fresh = Renderer::create(model.get(), small_picture());
    ASSERT_TRUE(fresh);
    for (const CameraView& camera : {CameraView(0), CameraView(FreeCamera{.look_at = {0, 0, 0.7}})}) {
      std::array<Image, 2> pictures;
      for (Result<Renderer>* one : {&fresh, &kept}) {
        ASSERT_TRUE((*one)->set_marks(marks) && (*one)->set_state(data.get()));
        ASSERT_TRUE((*one)->draw(camera, 160, 120, pictures[one == &kept ? 1 : 0]));
      }
      ASSERT_EQ(pictures[0], pictures[1]) << "step " << step;
    }
  }
}

TEST(Renderer, AFloatingBoxShadesTheFloorBelowIt) {
  StageOptions stage;
  stage.key_light = {0, 0, -1};
  const ModelPtr model =
      compile_scene(std::string(kFrontCamera) + R"(<geom type="box" size=".5 .5 .05" pos="0 0 1.5"/>)", &stage);
  RenderOptions options = small_picture();
  const Pixel shaded = at(draw_once(model.get(), options), 0, 0, 0);
  options.shadow_size = 0;
  const Pixel lit = at(draw_once(model.get(), options), 0, 0, 0);
  EXPECT_LT(shaded.g, lit.g - 25);
}

TEST(Renderer, LitFloorShowsNoAcne) {
  const ModelPtr model = dressed("");
  RenderOptions options = small_picture();
  const Image with = draw_once(model.get(), options);
  options.shadow_size = 0;
  EXPECT_EQ(with, draw_once(model.get(), options));
}

TEST(Renderer, SameStateSameBytesInAnyThreadAndDifferentStatesDiffer) {
  const ModelPtr model =
      dressed(R"(<body pos="0 0 1"><joint axis="0 1 0"/><geom type="capsule" size=".1 .4"/></body>)");
  const DataPtr data = posed_data(model.get());
  Result<Renderer> renderer = Renderer::create(model.get(), small_picture());
  ASSERT_TRUE(renderer) << renderer.error().to_string();
  std::vector<Image> pictures;
  for (const double q : {0.0, 0.5, 0.0}) {
    data->qpos[0] = q;
    pose_for_drawing(model.get(), data.get());
    ASSERT_TRUE(renderer->set_state(data.get()));
    ASSERT_TRUE(renderer->draw(0, 160, 120, pictures.emplace_back()));
  }
  EXPECT_EQ(pictures[0], pictures[2]);
  EXPECT_NE(pictures[0], pictures[1]);
  std::set<std::uint32_t> colours;
  for (int i = 0; i < 160 * 120; ++i)
    colours.insert(*reinterpret_cast<std::uint32_t*>(pictures[0].pixel(i % 160, i / 160)));
  EXPECT_GT(colours.size(), 100u);

  std::vector<Image> others(2);
  {
    std::vector<std::jthread> threads;
    for (Image& other : others) threads.emplace_back([&] { other = draw_once(model.get(), small_picture()); });
  }
  EXPECT_EQ(others[0], pictures[0]);
  EXPECT_EQ(others[1], pictures[0]);
}

TEST(Renderer, SeveralViewsOfOneStateAndSizesBelowTheLargest) {
  const ModelPtr model = dressed(R"(<geom type="box" size=".2 .2 .2" pos="0 0 1" rgba="1 0 0 1"/>)");
  const DataPtr data = posed_data(model.get());
  Result<Renderer> renderer = Renderer::create(model.get(), small_picture());
  ASSERT_TRUE(renderer);
  ASSERT_TRUE(renderer->set_state(data.get()));
  Image large, small, free, again;
  ASSERT_TRUE(renderer->draw(0, 160, 120, large));
  ASSERT_TRUE(renderer->draw(0, 80, 60, small));
  EXPECT_EQ(small.width, 80);
  EXPECT_TRUE(is_red(at(small, 0, -0.2, 1)));
  ASSERT_TRUE(renderer->draw(overview_camera(model.get()), 160, 120, free));
  EXPECT_NE(free, large);
  ASSERT_TRUE(renderer->draw(0, 160, 120, again));
  EXPECT_EQ(again, large);
}

TEST(Renderer, ASpotLightThrowsItsShadowAwayFromItself) {
  const ModelPtr model = compile_scene(std::string(kFrontCamera) +
                                       R"(<light pos="-1.5 0 3" dir="0.5 0 -1" cutoff="60" castshadow="true"/>
      <geom type="plane" size="6 6 .1"/><geom type="box" size=".2 .2 .2" pos="-.5 0 1" rgba="1 0 0 1"/>)");
  const Image image = draw_once(model.get(), small_picture());
  EXPECT_GT(at(image, -0.5, -0.2, 1).r, 1.5 * at(image, -0.5, -0.2, 1).g);
  // The ray from (-1.5, 0, 3) through the box meets the floor at (0, 0, 0).
  EXPECT_LT(at(image, 0, 0, 0).g, at(image, -1, 0, 0).g - 20);
  EXPECT_LT(at(image, 0, 0, 0).g, at(image, 1, 0, 0).g - 20);
}

TEST(Renderer, SaysWhatIsWrongWithItsInput) {
  const ModelPtr model = dressed("");
  RenderOptions options;
  options.width = 0;
  options.height = 100'000;
  options.shadow_size = 7;
  const Result<Renderer> bad = Renderer::create(model.get(), options);
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().list().size(), 3u);
  EXPECT_THAT(bad.error(), takt::test::Reports(Code::kOutOfRange, "/height", {"100000", "16", "4096"}));

  const DataPtr data = posed_data(model.get());
  Result<Renderer> renderer = Renderer::create(model.get(), small_picture());
  ASSERT_TRUE(renderer);
  Image image;
  EXPECT_FALSE(renderer->draw(0, 160, 120, image)) << "no state yet";
  ASSERT_TRUE(renderer->set_state(data.get()));
  EXPECT_FALSE(renderer->draw(1, 160, 120, image));
  EXPECT_FALSE(renderer->draw(0, 320, 240, image));
  EXPECT_TRUE(renderer->draw(0, 160, 120, image));

  const Result<int> camera = find_camera(model.get(), "frnt", "/camera");
  ASSERT_FALSE(camera);
  EXPECT_TRUE(camera.error().to_string().find("front") != std::string::npos);
}

}  // namespace
}  // namespace takt::sim
