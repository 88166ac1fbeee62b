#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "sim/film/overlay.h"
#include "sim/film/renderer.h"
#include "sim/model/marks.h"

struct mjModel_;
struct mjData_;

namespace takt::sim {

/// From `from` on the film shows `camera` (until the next cut).
struct CameraCut {
  Nanoseconds from = 0;
  std::string camera;  ///< name in the model; empty or kFittingCamera: a free camera that shows everything
};

/// The free camera's name, unless the model has a camera of that name.
inline constexpr std::string_view kFittingCamera = "fit";

/// Pictures per second of a film, at most.
inline constexpr int kMostFps = 120;

struct FilmOptions {
  std::filesystem::path path;             ///< of the MP4 file; overwritten
  int fps = 25;                           ///< frames per second, 1 ... 120
  Nanoseconds begin = 0;                  ///< time of the first frame
  std::string title;                      ///< in the overlay
  std::vector<CameraCut> cuts;            ///< sorted by time; none: the model's first camera, else a free one
  std::string inset_camera;               ///< a second camera, drawn small in the upper right; empty: none
  std::optional<FreeCamera> free_camera;  ///< that shows everything; nothing: overview_camera() of the model
  bool overlay = true;
  int workers = 2;                ///< threads that draw, 1 ... 16; the pictures do not depend on it
  int queue_frames = 8;           ///< frames in flight before push() waits
  std::string ffmpeg = "ffmpeg";  ///< program, looked up in PATH
  RenderOptions render;           ///< size and quality; width and height must be even
};

/// All that is wrong with `options` for `model`, without starting anything. Pointers name the option ("/path").
[[nodiscard]] Diagnostics check_film(const mjModel_* model, const FilmOptions& options);

/// What a finished film is.
struct FilmReport {
  std::int64_t frames = 0;
  std::int64_t drawn = 0;   ///< frames that were rendered; the others repeat a state that had not changed
  double render_cpu_s = 0;  ///< CPU seconds of all workers
};

/// Turns states of a simulation into a video file while the simulation runs. The simulation pushes; workers, each with
/// a Renderer and an mjData of its own, draw copies of the state; one thread puts them in order, adds the overlay and
/// feeds ffmpeg. The film never touches the simulation's mjData outside push(), and no picture depends on timing.
/// Thread: push() and close() from one thread at a time. Realtime: push() copies qpos, mocap poses and lamps and may
/// wait while the queue is full, so it belongs outside a real-time cycle.
class Film {
 public:
  /// Checks everything first (sizes, cameras, folder, ffmpeg) and reports all diagnostics at once; pointers are names
  /// of FilmOptions ("/path", "/render/width").
  /// @param model  stays alive and unchanged as long as the Film
  [[nodiscard]] static Result<Film> open(const mjModel_* model, const FilmOptions& options);
  Film(Film&&) noexcept;
  Film& operator=(Film&&) noexcept;
  /// Closes the film if close() has not been called; errors are lost then.
  ~Film();

  /// Time of the next frame; call push() with the first state at or after it.
  [[nodiscard]] Nanoseconds next_time() const;

  /// Shows `camera` from the next frame on, in place of the cuts; empty: the free camera.
  [[nodiscard]] Result<void> set_camera(std::string_view camera);

  /// push() would not wait: the queue has room.
  [[nodiscard]] bool has_room() const;

  /// Adds the state of `data` as the next frame. `overlay.time` decides about cuts; `overlay.title` and
  /// `overlay.camera` are filled in by the film where they are empty.
  /// @return diagnostics if drawing or encoding has failed meanwhile; the film is then at its end
  [[nodiscard]] Result<void> push(const mjData_* data, const Overlay& overlay, const Marks& marks = {});
  /// The same from a recording: `qpos` as in the model, mocap poses at their defaults, `lamps` in the order of
  /// World::lamps() (those that are missing do not burn).
  [[nodiscard]] Result<void> push(std::span<const double> qpos, std::span<const double> lamps, const Overlay& overlay,
                                  const Marks& marks = {});

  /// Waits for all frames and for ffmpeg, and checks that the file is there. Calling it twice gives the same report.
  [[nodiscard]] Result<FilmReport> close();

 private:
  class Impl;
  explicit Film(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A state of a recording.
struct FilmState {
  Nanoseconds time = 0;
  std::vector<double> qpos;  ///< as in the model
  Overlay overlay;
  std::vector<double> lamps = {};  ///< in the order of World::lamps()
  Marks marks = {};
};

/// A film from recorded states (sorted by time): each frame shows the newest state at or before its time. Its first
/// frame is of the first state, whatever FilmOptions::begin.
[[nodiscard]] Result<FilmReport> film_from_states(const mjModel_* model, std::span<const FilmState> states,
                                                  const FilmOptions& options);

}  // namespace takt::sim
