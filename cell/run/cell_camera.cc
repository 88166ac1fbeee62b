#include "cell/run/cell_camera.h"

#include <algorithm>
#include <utility>

#include <mujoco/mujoco.h>

#include "sim/film/renderer.h"

namespace takt::cell {
namespace {

constexpr int kShadowTexels = 1024;

}  // namespace

void copy_picture_state(const sim::World& world, PictureState& state) {
  const auto positions = world.positions();
  state.positions.assign(positions.begin(), positions.end());
  if (world.lamps().empty()) return;
  const double* burning = world.data()->userdata;
  state.lamps.assign(burning, burning + world.lamps().size());
}

struct CellCamera::Impl {
  Impl(std::shared_ptr<sim::World> kept, sim::Renderer made, bool looked_at_once)
      : world(std::move(kept)),
        data(mj_makeData(world->model()), &mj_deleteData),
        renderer(std::move(made)),
        fast(looked_at_once) {}

  std::shared_ptr<sim::World> world;  ///< keeps the model
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data;
  sim::Renderer renderer;
  sim::Image image;
  bool fast;  ///< of sim::png_of()
};

CellCamera::CellCamera(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CellCamera::~CellCamera() = default;

Result<std::unique_ptr<CellCamera>> CellCamera::open(const BuiltCell& built, Quality quality) {
  const bool live = quality == Quality::kLive;
  auto renderer = sim::Renderer::create(
      built.world->model(),
      {.width = kMostWidth, .height = kMostHeight, .shadow_size = live ? 0 : kShadowTexels, .smooth_edges = !live});
  if (!renderer) return std::unexpected(renderer.error());
  return std::unique_ptr<CellCamera>(new CellCamera(std::make_unique<Impl>(built.world, std::move(*renderer), live)));
}

Result<std::string> CellCamera::picture(std::string_view camera, int width, int height, const PictureState& state) {
  const mjModel* model = impl_->world->model();
  mjData* data = impl_->data.get();
  const std::string name(camera);
  sim::CameraView view = sim::overview_camera(model);
  if (camera != kOverview || mj_name2id(model, mjOBJ_CAMERA, name.c_str()) >= 0) {
    const auto found = sim::find_camera(model, camera, "");
    if (!found) return std::unexpected(found.error());
    view = *found;
  }
  std::copy_n(state.positions.begin(), std::min<std::size_t>(state.positions.size(), model->nq), data->qpos);
  std::copy_n(state.lamps.begin(), std::min<std::size_t>(state.lamps.size(), model->nuserdata), data->userdata);
  sim::pose_for_drawing(model, data);
  if (auto set = impl_->renderer.set_state(data); !set) return std::unexpected(set.error());
  if (auto drawn = impl_->renderer.draw(view, width, height, impl_->image); !drawn)
    return std::unexpected(drawn.error());
  return sim::png_of(impl_->image, impl_->fast);
}

}  // namespace takt::cell
