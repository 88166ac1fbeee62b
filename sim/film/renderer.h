#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "core/base/diagnostics.h"
#include "sim/film/camera_view.h"
#include "sim/film/render_image.h"
#include "sim/model/marks.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// What a picture costs and shows. The defaults are the ones of the film.
struct RenderOptions {
  int width = 1280;          ///< pixels, 16 ... 4096; the largest picture that draw() is asked for
  int height = 720;          ///< pixels, 16 ... 4096
  int shadow_size = 1024;    ///< side of the shadow map in texels, 256 ... 8192; 0: no shadows
  bool smooth_edges = true;  ///< smooths stair steps (about 3 ms at 720p)
  int max_geoms = 4000;      ///< geoms in one picture; more are left out with a MuJoCo warning
  bool show_sites = false;
};

/// Index of the camera `name`; the diagnostic lists the cameras there are. Realtime: setup.
[[nodiscard]] Result<int> find_camera(const mjModel_* model, std::string_view name, const std::string& pointer);

/// A free camera that shows the whole model.
[[nodiscard]] FreeCamera overview_camera(const mjModel_* model);

/// A free camera in the same direction that fits all that is drawn, but for an endless floor, into a picture of
/// `aspect` (width / height), with a margin. @param posed  data of the model after pose_for_drawing()
/// Realtime: setup.
[[nodiscard]] FreeCamera fitting_camera(const mjModel_* model, const mjData_* posed, double aspect);

/// A free camera at `eye` that looks at `target`, m in world; they are not the same point.
[[nodiscard]] FreeCamera camera_from(const std::array<double, 3>& eye, const std::array<double, 3>& target);

/// Brings the positions of all bodies, geoms, cameras and lights of `data` up to date with qpos and mocap poses;
/// touches neither velocities nor forces. For the renderer's own copy of the state, never for a running simulation. May
/// throw MujocoError.
void pose_for_drawing(const mjModel_* model, mjData_* data);

/// Draws states of one model into pictures, without a display, on the CPU (OSMesa). Same state, camera and size: same
/// bytes, whichever Renderer of the process draws them. docs/film.md says why it does not use mjr_render.
/// Owns its graphics context and everything in it. Thread: the one that made it, for every call; several Renderers may
/// live in several threads. Realtime: setup.
class Renderer {
 public:
  /// @param model  stays alive and unchanged as long as the Renderer
  /// @return diagnostics if a size is out of range or OpenGL cannot be started
  [[nodiscard]] static Result<Renderer> create(const mjModel_* model, const RenderOptions& options);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// Takes over the state that the next pictures show. `data` is one of the model, posed by pose_for_drawing or by
  /// mj_forward; it must stay alive until the last draw() of this state, and is not changed.
  [[nodiscard]] Result<void> set_state(mjData_* data);

  /// What the next pictures show beside the scene, from the next set_state() on; its shapes count as geoms
  /// (RenderOptions::max_geoms). @return diagnostics: positions of the ghost that are not the model's
  [[nodiscard]] Result<void> set_marks(const Marks& marks);

  /// Draws the state as `camera` sees it. `image` is resized to width x height, which must not exceed the options'.
  [[nodiscard]] Result<void> draw(const CameraView& camera, int width, int height, Image& image);

  /// The OpenGL implementation at work, for reports: "llvmpipe (LLVM 15.0.6, 256 bits)".
  [[nodiscard]] std::string implementation() const;

 private:
  class Impl;
  explicit Renderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::sim
