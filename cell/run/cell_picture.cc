#include "cell/run/cell_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <mujoco/mujoco.h>

#include "sim/film/renderer.h"

namespace takt::cell {
namespace {

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using State = std::unique_ptr<mjData, decltype(&mj_deleteData)>;
using Colour = std::array<float, 3>;

constexpr Colour kFirstColour{0.9f, 0.05f, 0.05f}, kSecondColour{0.05f, 0.2f, 0.95f};
constexpr int kWidth = 1280, kHeight = 720;

/// All bodies grey but these two.
void mark(mjModel& model, int first, int second) {
  for (int geom = 0; geom < static_cast<int>(model.ngeom); ++geom) {
    const int body = model.geom_bodyid[geom];
    if (body == 0) continue;  // the stage
    float* rgba = model.geom_rgba + 4 * geom;
    const float grey = 0.35f + 0.35f * (0.3f * rgba[0] + 0.6f * rgba[1] + 0.1f * rgba[2]);
    const Colour colour = body == first ? kFirstColour : body == second ? kSecondColour : Colour{grey, grey, grey};
    std::ranges::copy(colour, rgba);
    model.geom_matid[geom] = -1;
  }
}

int body_of(const mjModel& model, const std::string& name) { return mj_name2id(&model, mjOBJ_BODY, name.c_str()); }

void write_pose(const Eigen::Isometry3d& X, double* position, double* quaternion) {
  const Eigen::Quaterniond R(X.linear());
  std::copy_n(X.translation().data(), 3, position);
  quaternion[0] = R.w();
  quaternion[1] = R.x();
  quaternion[2] = R.y();
  quaternion[3] = R.z();
}

/// Puts joints and objects where the shapes have them.
void pose(const collision::CellShapes& shapes, const collision::State& state, mjModel& model, mjData& data) {
  for (std::size_t j = 0; j < shapes.scene.joints().size(); ++j) {
    const int joint = mj_name2id(&model, mjOBJ_JOINT, shapes.scene.joints()[j].c_str());
    if (joint >= 0) data.qpos[model.jnt_qposadr[joint]] = state.q[j];
  }
  collision::Poses poses;
  shapes.scene.place(state, poses);
  for (const std::string& object : shapes.objects) {
    const int number = shapes.scene.root_of(object);
    const int body = number < 0 ? -1 : body_of(model, shapes.scene.body(number).name);
    if (body < 0) continue;
    const Eigen::Isometry3d& X_WO = poses[static_cast<std::size_t>(number)];
    if (model.body_jntnum[body] > 0) {
      double* qpos = data.qpos + model.jnt_qposadr[model.body_jntadr[body]];
      write_pose(X_WO, qpos, qpos + 3);
    } else if (model.body_parentid[body] == 0) {
      write_pose(X_WO, model.body_pos + 3 * body, model.body_quat + 4 * body);
    }
  }
}

/// The middle of what is drawn of a body, in the world, and the radius of the ball about it.
struct Extent {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius = 0.1;
};
Extent extent_of(const mjModel& model, const mjData& data, int body) {
  Eigen::AlignedBox3d box;
  for (int geom = 0; geom < static_cast<int>(model.ngeom); ++geom) {
    if (model.geom_bodyid[geom] != body) continue;
    const Eigen::Map<const Eigen::Vector3d> p(data.geom_xpos + 3 * geom);
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(std::max(model.geom_rbound[geom], 0.01));
    box.extend(Eigen::AlignedBox3d(p - reach, p + reach));
  }
  if (box.isEmpty()) return {};
  return {box.center(), 0.5 * box.diagonal().norm()};
}

/// Of both colours the one that shows on fewer pixels.
int marked_pixels(const sim::Image& image) {
  int red = 0, blue = 0;
  for (std::size_t i = 0; i + 3 < image.rgba.size(); i += 4) {
    const int r = image.rgba[i], g = image.rgba[i + 1], b = image.rgba[i + 2];
    red += r > 2 * g + 20 && r > 2 * b + 20 ? 1 : 0;
    blue += b > 2 * r + 20 && b > g + 40 ? 1 : 0;
  }
  return std::min(red, blue);
}

/// From around both bodies: where they hide each other least.
Result<sim::FreeCamera> best_camera(sim::Renderer& renderer, const Extent& first, const Extent& second) {
  const Extent& small = first.radius < second.radius ? first : second;
  sim::FreeCamera best;
  std::copy_n(small.middle.data(), 3, best.look_at.begin());
  best.distance = std::clamp(6.0 * small.radius, 1.2, 3.0);
  int most = -1;
  sim::Image image;
  for (const double elevation : {-20.0, -45.0}) {
    for (double azimuth = 15.0; azimuth < 360.0; azimuth += 30.0) {
      sim::FreeCamera camera = best;
      camera.azimuth = azimuth;
      camera.elevation = elevation;
      if (auto drawn = renderer.draw(camera, kWidth / 8, kHeight / 8, image); !drawn)
        return std::unexpected(drawn.error());
      const int pixels = marked_pixels(image);
      if (pixels <= most) continue;
      most = pixels;
      best = camera;
    }
  }
  return best;
}

}  // namespace

Result<void> draw_cell(const BuiltCell& built, const activity::FoundCollision* collision,
                       const std::filesystem::path& file) {
  if (file.extension() != ".png")
    return failure(Code::kInvalidValue, "--image", "'" + file.string() + "' is not a .png file", "Name a file OUT.png");
  const Model model(mj_copyModel(nullptr, built.world->model()), mj_deleteModel);
  const State data(mj_copyData(nullptr, built.world->model(), built.world->data()), mj_deleteData);
  int first = -1, second = -1;
  if (collision != nullptr) {
    pose(*built.cell.shapes, collision->state, *model, *data);
    first = body_of(*model, collision->a);
    second = body_of(*model, collision->b);
    mark(*model, first, second);
  }
  sim::pose_for_drawing(model.get(), data.get());
  auto renderer = sim::Renderer::create(model.get(), {.width = kWidth, .height = kHeight, .shadow_size = 2048});
  if (!renderer) return std::unexpected(renderer.error());
  if (auto set = renderer->set_state(data.get()); !set) return set;
  sim::FreeCamera camera = sim::overview_camera(model.get());
  if (first >= 0 && second >= 0) {
    auto near = best_camera(*renderer, extent_of(*model, *data, first), extent_of(*model, *data, second));
    if (!near) return std::unexpected(near.error());
    camera = *near;
  }
  sim::Image image;
  if (auto drawn = renderer->draw(camera, kWidth, kHeight, image); !drawn) return drawn;
  return sim::write_png(image, file);
}

}  // namespace takt::cell
