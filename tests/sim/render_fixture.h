#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include <mujoco/mujoco.h>

#include "sim/film/renderer.h"
#include "sim/model/mujoco_errors.h"
#include "sim/world/stage.h"

namespace takt::sim {

using ModelPtr = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using DataPtr = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

/// Compiles MJCF; `stage` dresses it first.
inline ModelPtr compile_scene(const std::string& bodies, const StageOptions* stage = nullptr) {
  install_mujoco_handlers();
  char error[1000] = "";
  const std::string xml = "<mujoco><worldbody>" + bodies + "</worldbody></mujoco>";
  const std::unique_ptr<mjSpec, decltype(&mj_deleteSpec)> spec(
      mj_parseXMLString(xml.c_str(), nullptr, error, sizeof(error)), &mj_deleteSpec);
  if (!spec) throw std::runtime_error(error);
  if (stage != nullptr) add_scene_props(spec.get(), *stage);
  ModelPtr model(mj_compile(spec.get(), nullptr), &mj_deleteModel);
  if (!model) throw std::runtime_error(mjs_getError(spec.get()));
  return model;
}

inline DataPtr posed_data(const mjModel* model) {
  DataPtr data(mj_makeData(model), &mj_deleteData);
  pose_for_drawing(model, data.get());
  return data;
}

/// Looks along +y from (0, -4, 1): x goes right and z up in the picture.
inline constexpr const char* kFrontCamera = R"(<camera name="front" pos="0 -4 1" xyaxes="1 0 0 0 0 1" fovy="45"/>)";

inline RenderOptions small_picture() {
  RenderOptions options;
  options.width = 160;
  options.height = 120;
  options.shadow_size = 512;
  return options;
}

/// One picture of the model's initial state.
inline Image draw_once(const mjModel* model, const RenderOptions& options, const CameraView& camera = 0) {
  const DataPtr data = posed_data(model);
  Result<Renderer> renderer = Renderer::create(model, options);
  if (!renderer) throw std::runtime_error(renderer.error().to_string());
  Image image;
  (void)renderer->set_state(data.get());
  if (Result<void> drawn = renderer->draw(camera, options.width, options.height, image); !drawn)
    throw std::runtime_error(drawn.error().to_string());
  return image;
}

}  // namespace takt::sim
