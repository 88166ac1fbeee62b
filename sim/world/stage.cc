#include "sim/world/stage.h"

#include <algorithm>
#include <cmath>

#include <mujoco/mujoco.h>

#include "sim/model/mujoco_errors.h"

namespace takt::sim {
namespace {

void add_sky(mjSpec* spec, const StageOptions& options) {
  mjsTexture* sky = mjs_addTexture(spec, nullptr);
  mjs_setName(sky->element, kStageSky);
  sky->type = mjTEXTURE_SKYBOX;
  sky->builtin = mjBUILTIN_GRADIENT;
  std::ranges::copy(options.sky_top, sky->rgb1);
  std::ranges::copy(options.sky_horizon, sky->rgb2);
  sky->width = 64;
  sky->height = 64;
}

void add_floor(mjSpec* spec, mjsBody* world, const StageOptions& options) {
  mjsMaterial* material = mjs_addMaterial(spec, nullptr);
  mjs_setName(material->element, kStageFloor);
  std::ranges::copy(options.floor_colour, material->rgba);
  material->rgba[3] = 1;
  material->specular = 0.05f;
  material->shininess = 0.1f;
  material->reflectance = 0;

  mjsGeom* floor = mjs_addGeom(world, nullptr);
  mjs_setName(floor->element, kStageFloor);
  floor->type = mjGEOM_PLANE;
  floor->size[0] = floor->size[1] = 0;  // without end
  floor->size[2] = 0.1;
  floor->pos[2] = options.floor_height;
  mjs_setString(floor->material, kStageFloor);
  if (!options.floor_collides) floor->contype = floor->conaffinity = 0;
}

mjsLight* add_light(mjsBody* world, const char* name, const std::array<double, 3>& direction, float brightness) {
  mjsLight* light = mjs_addLight(world, nullptr);
  mjs_setName(light->element, name);
  light->type = mjLIGHT_DIRECTIONAL;
  light->castshadow = false;
  std::ranges::copy(direction, light->dir);
  std::ranges::fill(light->ambient, 0.0f);
  std::ranges::fill(light->specular, 0.0f);
  std::ranges::fill(light->diffuse, brightness);
  return light;
}

// One light makes the shadow, one from the other side keeps the shaded faces readable, one from behind draws edges.
void add_lights(mjsBody* world, const StageOptions& options) {
  const auto& key = options.key_light;
  mjsLight* light = add_light(world, "stage_key", key, 0.72f);
  light->castshadow = true;
  std::ranges::fill(light->specular, 0.35f);
  for (int i = 0; i < 3; ++i) light->pos[i] = options.centre[i] - 2 * options.radius * key[i];
  add_light(world, "stage_fill", {-key[1], key[0], key[2] * 0.45}, 0.16f);
  add_light(world, "stage_back", {-key[0], -key[1], key[2] * 0.6}, 0.12f);
}

void size_view(mjSpec* spec, const StageOptions& options) {
  mjVisual& visual = spec->visual;
  spec->stat.extent = options.radius;
  std::ranges::copy(options.centre, spec->stat.center);
  visual.map.znear = static_cast<float>(std::max(0.005, 0.02 / options.radius));
  visual.map.zfar = static_cast<float>(std::max(20.0, 60.0 / options.radius));
  visual.map.shadowclip = 1;
  visual.map.haze = 0.35f;
  std::ranges::copy(options.sky_horizon, visual.rgba.haze);
  visual.rgba.haze[3] = 1;
  std::ranges::fill(visual.headlight.ambient, 0.26f);
  std::ranges::fill(visual.headlight.diffuse, 0.10f);
  std::ranges::fill(visual.headlight.specular, 0.0f);
  visual.quality.shadowsize = 2048;
  visual.quality.offsamples = 0;
}

}  // namespace

void add_scene_props(mjSpec_* spec, const StageOptions& options) {
  install_mujoco_handlers();
  mjsBody* world = mjs_findBody(spec, "world");
  add_sky(spec, options);
  if (options.floor) add_floor(spec, world, options);
  add_lights(world, options);
  size_view(spec, options);
}

}  // namespace takt::sim
