// Milliseconds per 720p frame, stage by stage: what the film costs (docs/film.md, "Speed"). CPU time counts, not wall
// time.
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/film/film.h"
#include "sim/film/film_encoder.h"
#include "sim/film/overlay.h"
#include "sim/film/render_shapes.h"
#include "sim/film/renderer.h"
#include "sim/model/mujoco_errors.h"
#include "sim/world/stage.h"
#include "tests/support/scratch_folder.h"

namespace takt::sim {
namespace {

// Two arms of seven links, 600 triangles a link, over a table: about the size of the largest scenario.
std::string scene_text() {
  std::string arms;
  for (const double x : {-0.45, 0.45}) {
    arms += fmt::format(R"(<body pos="{} 0 0.75">)", x);
    for (int i = 0; i < 7; ++i)
      arms += fmt::format(R"(<body pos="0 0 0.18"><joint axis="{}"/><geom type="mesh" mesh="link" rgba="{} 1"/>)",
                          i % 2 == 0 ? "0 0 1" : "0 1 0", i % 2 == 0 ? ".95 .45 .1" : ".75 .77 .8");
    for (int i = 0; i < 8; ++i) arms += "</body>";
  }
  return R"(<mujoco><asset>
    <mesh name="link" builtin="supersphere" params="18 0.6 0.8" scale="0.075 0.075 0.13"/></asset><worldbody>
    <camera name="main" pos="1.9 -1.7 1.9" xyaxes="0.67 0.74 0 -0.35 0.31 0.88"/>
    <geom type="box" size="0.9 0.5 0.03" pos="0 0 0.72" rgba=".7 .7 .68 1"/>)" +
         arms + "</worldbody></mujoco>";
}

mjModel* scene() {
  static mjModel* const model = [] {
    install_mujoco_handlers();
    std::array<char, 1000> error{};
    mjSpec* spec = mj_parseXMLString(scene_text().c_str(), nullptr, error.data(), error.size());
    if (spec == nullptr) throw std::runtime_error(error.data());
    add_scene_props(spec, {});
    mjModel* compiled = mj_compile(spec, nullptr);
    if (compiled == nullptr) throw std::runtime_error(mjs_getError(spec));
    mj_deleteSpec(spec);
    return compiled;
  }();
  return model;
}

void move(mjData* data, std::int64_t step) {
  for (int i = 0; i < scene()->nq; ++i) data->qpos[i] = 0.5 * std::sin(0.03 * static_cast<double>(step) + i);
}

// One picture, shadows and smoothing as told by the arguments.
void draw(benchmark::State& state) {
  RenderOptions options;
  options.shadow_size = static_cast<int>(state.range(0));
  options.smooth_edges = state.range(1) != 0;
  Result<Renderer> renderer = Renderer::create(scene(), options);
  if (!renderer) return state.SkipWithError(renderer.error().to_string().c_str());
  mjData* data = mj_makeData(scene());
  Image image;
  std::int64_t step = 0;
  for (auto _ : state) {
    move(data, ++step);
    pose_for_drawing(scene(), data);
    (void)renderer->set_state(data);
    (void)renderer->draw(0, options.width, options.height, image);
  }
  state.counters["triangles"] = triangle_count(scene());
  mj_deleteData(data);
}
BENCHMARK(draw)
    ->ArgNames({"shadow", "smooth"})
    ->Args({0, 0})
    ->Args({1024, 0})
    ->Args({2048, 0})
    ->Args({2048, 1})
    ->Unit(benchmark::kMillisecond);

Image any_picture() {
  Image image;
  image.resize(1280, 720);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = static_cast<std::uint8_t>(i / 1000);
  return image;
}

void overlay(benchmark::State& state) {
  Result<OverlayPainter> painter = OverlayPainter::create(1280, 720);
  if (!painter) return state.SkipWithError(painter.error().to_string().c_str());
  Overlay text;
  text.title = "Two arms join two workpieces";
  text.step = "approach / lin to the hole";
  text.force_N = 12;
  text.force_limit_N = 15;
  Image image = any_picture();
  for (auto _ : state) painter->draw(text, image);
}
BENCHMARK(overlay)->Unit(benchmark::kMillisecond);

void yuv(benchmark::State& state) {
  const Image image = any_picture();
  std::vector<std::uint8_t> planes;
  for (auto _ : state) to_yuv420(image, planes);
}
BENCHMARK(yuv)->Unit(benchmark::kMillisecond);

// A film of 100 frames, ffmpeg included; the argument is the number of workers. 40 ms of wall time a frame keep up.
void film(benchmark::State& state) {
  FilmOptions options;
  const takt::test::ScratchFolder folder;
  options.path = folder / "film.mp4";
  options.workers = static_cast<int>(state.range(0));
  mjData* data = mj_makeData(scene());
  constexpr int kFrames = 100;
  for (auto _ : state) {
    Result<Film> running = Film::open(scene(), options);
    if (!running) return state.SkipWithError(running.error().to_string().c_str());
    for (int i = 0; i < kFrames; ++i) {
      move(data, i);
      Overlay text;
      text.time = running->next_time();
      (void)running->push(data, text);
    }
    if (const auto report = running->close(); report)
      state.counters["render_cpu_ms_per_frame"] = 1e3 * report->render_cpu_s / kFrames;
  }
  state.SetItemsProcessed(state.iterations() * kFrames);
  mj_deleteData(data);
}
BENCHMARK(film)->Arg(1)->Arg(2)->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace takt::sim

BENCHMARK_MAIN();
