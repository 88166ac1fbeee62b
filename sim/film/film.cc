#include "sim/film/film.h"

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <ctime>
#include <deque>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include "core/base/last_catch.h"
#include "sim/film/film_encoder.h"
#include "sim/model/mujoco_errors.h"

namespace takt::sim {
namespace {

// What a picture depends on; equal states in a row are drawn once.
struct PoseState {
  std::vector<double> qpos, mocap_pos, mocap_quat, lamps;
  std::string camera;
  CameraView view;
  Marks marks;
};

bool same_picture(const PoseState& a, const PoseState& b) {
  return a.camera == b.camera && a.qpos == b.qpos && a.mocap_pos == b.mocap_pos && a.mocap_quat == b.mocap_quat &&
         a.lamps == b.lamps && a.marks == b.marks;
}

// A frame on its way: pushed, drawn (or a repetition of the one before), written.
struct Frame {
  PoseState state;
  Overlay overlay;
  bool repeats = false;
  bool taken = false;
  bool drawn = false;
  Image picture;
};

// What a drawing thread owns.
struct Worker {
  Renderer renderer;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data;
  Image inset;
};

double thread_cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

Result<CameraView> resolve_camera(const mjModel* model, const FilmOptions& options, std::string_view name,
                                  const std::string& pointer) {
  const CameraView free = options.free_camera.value_or(overview_camera(model));
  if (name.empty()) return free;
  const Result<int> index = find_camera(model, name, pointer);
  if (index) return CameraView(*index);
  if (name == kFittingCamera) return free;
  return std::unexpected(index.error());
}

void check_size(const RenderOptions& render, Diagnostics& diagnostics) {
  const auto check = [&](const char* pointer, int value) {
    if (value < 64 || value > 4096) {
      diagnostics.error(Code::kOutOfRange, pointer, fmt::format("{} pixels are out of range", value),
                        "Choose 64 to 4096");
    } else if (value % 2 != 0) {
      diagnostics.error(Code::kOutOfRange, pointer, fmt::format("{} is odd, and video needs even sizes", value),
                        fmt::format("Choose {} or {}", value - 1, value + 1));
    }
  };
  check("/render/width", render.width);
  check("/render/height", render.height);
}

// Opens the file, or creates and removes one, so that a path that cannot be written shows before the run and not after
// it, and nothing is left where something else is refused.
void check_path(const std::filesystem::path& path, Diagnostics& diagnostics) {
  if (path.extension() != ".mp4") {
    diagnostics.error(Code::kInvalidValue, "/path", fmt::format("'{}' does not end in .mp4", path.string()),
                      "Name an .mp4 file");
    return;
  }
  // A FIFO without a reader would wait for one for ever.
  int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
  const bool created = file < 0 && errno == ENOENT;
  if (created) file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) {
    diagnostics.error(Code::kFileNotWritable, "/path",
                      fmt::format("cannot write '{}': {}", path.string(), std::strerror(errno)));
    return;
  }
  ::close(file);
  if (created) ::unlink(path.c_str());
}

void check_cameras(const mjModel* model, const FilmOptions& options, Diagnostics& diagnostics) {
  const auto check = [&](const std::string& name, const std::string& pointer) {
    if (const auto view = resolve_camera(model, options, name, pointer); !view) diagnostics.append(view.error());
  };
  for (std::size_t i = 0; i < options.cuts.size(); ++i) {
    const std::string pointer = fmt::format("/cuts/{}", i);
    check(options.cuts[i].camera, pointer + "/camera");
    if (i > 0 && options.cuts[i].from < options.cuts[i - 1].from)
      diagnostics.error(Code::kOutOfRange, pointer + "/from", "is earlier than the cut before it",
                        "Sort the cuts by time");
  }
  if (!options.inset_camera.empty()) check(options.inset_camera, "/inset_camera");
}

}  // namespace

Diagnostics check_film(const mjModel_* model, const FilmOptions& options) {
  Diagnostics diagnostics;
  check_size(options.render, diagnostics);
  const auto in_range = [&](const char* pointer, int value, int low, int high) {
    if (value < low || value > high)
      diagnostics.error(Code::kOutOfRange, pointer, fmt::format("{} is out of range", value),
                        fmt::format("Choose {} to {}", low, high));
  };
  in_range("/fps", options.fps, 1, kMostFps);
  in_range("/workers", options.workers, 1, 16);
  in_range("/queue_frames", options.queue_frames, 1, 256);
  check_cameras(model, options, diagnostics);
  check_path(options.path, diagnostics);
  return diagnostics;
}

class Film::Impl {
 public:
  Impl(const mjModel* model, const FilmOptions& options) : model_(model), options_(options) {
    if (options_.cuts.empty()) {
      const char* first = model->ncam > 0 ? mj_id2name(model, mjOBJ_CAMERA, 0) : nullptr;
      options_.cuts.push_back({0, first != nullptr ? first : ""});
    }
    if (!options_.inset_camera.empty()) inset_ = *resolve_camera(model, options_, options_.inset_camera, "");
  }

  ~Impl() { (void)close(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<void> start() {
    if (options_.overlay) {
      Result<OverlayPainter> painter = OverlayPainter::create(options_.render.width, options_.render.height);
      if (!painter) return std::unexpected(painter.error());
      painter_ = std::move(*painter);
    }
    Result<FilmEncoder> encoder =
        FilmEncoder::start(options_.ffmpeg, options_.path, options_.render.width, options_.render.height, options_.fps);
    if (!encoder) return std::unexpected(encoder.error());
    encoder_ = std::move(*encoder);
    return guarded("no threads to make the film", [this] {
      Result<void> started = start_workers();
      if (started) writer_ = std::jthread([this] { write_frames(); });
      return started;
    });
  }

  Nanoseconds next_time() const { return options_.begin + pushed_ * kSecond / options_.fps; }

  Result<void> set_camera(std::string_view camera) {
    Result<CameraView> view = resolve_camera(model_, options_, camera, "");
    if (!view) return std::unexpected(view.error());
    chosen_camera_ = std::string(camera);
    return {};
  }

  bool has_room() const {
    const std::lock_guard lock(mutex_);
    return failed_ || static_cast<int>(frames_.size()) < options_.queue_frames;
  }

  Result<void> push(const mjData* data, const Overlay& overlay, const Marks& marks) {
    PoseState state;
    state.marks = marks;
    state.qpos.assign(data->qpos, data->qpos + model_->nq);
    state.mocap_pos.assign(data->mocap_pos, data->mocap_pos + 3 * model_->nmocap);
    state.mocap_quat.assign(data->mocap_quat, data->mocap_quat + 4 * model_->nmocap);
    state.lamps.assign(data->userdata, data->userdata + model_->nuserdata);
    return push(std::move(state), overlay);
  }

  Result<void> push(std::span<const double> qpos, std::span<const double> lamps, const Overlay& overlay,
                    const Marks& marks) {
    if (static_cast<mjtSize>(qpos.size()) != model_->nq)
      return failure(Code::kWrongSize, "",
                     fmt::format("the state has {} positions, the model {}", qpos.size(), model_->nq));
    PoseState state;
    state.marks = marks;
    state.qpos.assign(qpos.begin(), qpos.end());
    state.lamps.assign(static_cast<std::size_t>(model_->nuserdata), 0.0);
    std::copy_n(lamps.begin(), std::min(lamps.size(), state.lamps.size()), state.lamps.begin());
    return push(std::move(state), overlay);
  }

  Result<void> push(PoseState state, const Overlay& overlay) {
    state.camera = chosen_camera_ ? *chosen_camera_ : camera_at(overlay.time);
    state.view = *resolve_camera(model_, options_, state.camera, "");
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return failed_ || static_cast<int>(frames_.size()) < options_.queue_frames; });
    if (failed_) return std::unexpected(diagnostics_);
    if (closing_) return failure(Code::kNotPossibleNow, "", "the film has been closed");
    Frame& frame = frames_.emplace_back();
    frame.overlay = overlay;
    if (frame.overlay.title.empty()) frame.overlay.title = options_.title;
    if (frame.overlay.camera.empty())
      frame.overlay.camera = state.camera.empty() ? std::string(kFittingCamera) : state.camera;
    frame.repeats = pushed_ > 0 && same_picture(state, last_state_);
    if (frame.repeats) {
      frame.taken = frame.drawn = true;
    } else {
      last_state_ = state;
      frame.state = std::move(state);
      ++report_.drawn;
    }
    ++pushed_;
    changed_.notify_all();
    return {};
  }

  Result<FilmReport> close() {
    if (closed_) return *closed_;
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
      changed_.notify_all();
    }
    workers_.clear();  // joins
    writer_ = {};
    Result<void> finished;
    // A film that is not whole does not replace what was there.
    if (failed_ || pushed_ == 0) encoder_.reset();
    if (encoder_) finished = encoder_->finish();
    report_.frames = pushed_;
    if (failed_) {
      closed_ = std::unexpected(diagnostics_);
    } else if (pushed_ == 0) {
      closed_ = failure(Code::kNotPossibleNow, "/path", "the film has no frame");
    } else if (!finished) {
      closed_ = std::unexpected(finished.error());
    } else {
      closed_ = report_;
    }
    return *closed_;
  }

 private:
  std::string camera_at(Nanoseconds time) const {
    std::string camera = options_.cuts.front().camera;
    for (const CameraCut& cut : options_.cuts)
      if (cut.from <= time) camera = cut.camera;
    return camera;
  }

  // Every worker makes its graphics context in its own thread and says whether that worked.
  Result<void> start_workers() {
    std::vector<std::future<Result<void>>> ready;
    for (int i = 0; i < options_.workers; ++i) {
      std::promise<Result<void>> promise;
      ready.push_back(promise.get_future());
      workers_.emplace_back([this, promise = std::move(promise)]() mutable { work(std::move(promise)); });
    }
    Result<void> all;
    for (auto& one : ready) {
      Result<void> started = one.get();
      if (!started && all) all = started;
    }
    return all;
  }

  void work(std::promise<Result<void>> promise) {
    std::optional<Worker> made;
    const Result<void> started = guarded("the pictures cannot be drawn", [&] { return make_worker(made); });
    promise.set_value(started);
    if (!started) return;
    Worker& worker = *made;
    while (Frame* frame = take_frame()) {
      const double begin = thread_cpu_seconds();
      Result<void> drawn = guarded("a picture could not be drawn", [&] { return draw(worker, *frame); });
      const std::lock_guard lock(mutex_);
      if (!drawn) fail(drawn.error());
      frame->drawn = true;
      report_.render_cpu_s += thread_cpu_seconds() - begin;
      changed_.notify_all();
    }
  }

  Result<void> make_worker(std::optional<Worker>& made) const {
    Result<Renderer> renderer = Renderer::create(model_, options_.render);
    if (!renderer) return std::unexpected(renderer.error());
    mjData* data = mj_makeData(model_);
    if (data == nullptr) return failure(Code::kSystem, "", "no memory for a copy of the state");
    made.emplace(Worker{std::move(*renderer), {data, &mj_deleteData}, {}});
    return {};
  }

  // The last catch of a thread: what went wrong ends the film with its reason, not the process.
  template <class Work>
  static Result<void> guarded(const char* what, const Work& work) {
    try {
      return work();
    } catch (...) {
      return failure(Code::kInternal, "", fmt::format("{}: {}", what, exception_text()));
    }
  }

  // The next frame that nobody draws yet; null when there will be none. References into a deque survive its growth.
  Frame* take_frame() {
    std::unique_lock lock(mutex_);
    Frame* frame = nullptr;
    changed_.wait(lock, [&] {
      const auto found = std::ranges::find(frames_, false, &Frame::taken);
      frame = found != frames_.end() && !failed_ ? &*found : nullptr;
      return frame != nullptr || closing_ || failed_;
    });
    if (frame == nullptr) return nullptr;
    frame->taken = true;
    if (!spare_.empty()) {
      frame->picture = std::move(spare_.back());
      spare_.pop_back();
    }
    return frame;
  }

  Result<void> draw(Worker& worker, Frame& frame) {
    const PoseState& state = frame.state;
    std::ranges::copy(state.qpos, worker.data->qpos);
    std::ranges::copy(state.mocap_pos, worker.data->mocap_pos);
    std::ranges::copy(state.mocap_quat, worker.data->mocap_quat);
    std::ranges::copy(state.lamps, worker.data->userdata);
    Result<void> done = mujoco_call("", [&] { pose_for_drawing(model_, worker.data.get()); });
    if (done) done = worker.renderer.set_marks(state.marks);
    if (done) done = worker.renderer.set_state(worker.data.get());
    const int width = options_.render.width, height = options_.render.height;
    if (done) done = worker.renderer.draw(state.view, width, height, frame.picture);
    if (!done || !inset_) return done;
    done = worker.renderer.draw(*inset_, width * 3 / 10, height * 3 / 10, worker.inset);
    const int border = std::max(1, height / 360), margin = height / 36;
    const int top = margin + (options_.overlay ? height * 38 / 720 : 0);
    if (done) paste(worker.inset, frame.picture, width - worker.inset.width - margin, top, border);
    return done;
  }

  void write_frames() {
    const Result<void> written = guarded("the film could not be written", [&] { return write_all_frames(); });
    if (written) return;
    const std::lock_guard lock(mutex_);
    fail(written.error());
  }

  // Takes the frames in order, whoever drew them, and hands them to ffmpeg.
  Result<void> write_all_frames() {
    Image last, canvas;
    while (true) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] {
        return failed_ || (!frames_.empty() && frames_.front().drawn) || (closing_ && frames_.empty());
      });
      if (failed_ || frames_.empty()) return {};
      Frame& frame = frames_.front();
      if (!frame.repeats) {
        std::swap(last, frame.picture);
        if (frame.picture.width > 0) spare_.push_back(std::move(frame.picture));
      }
      const Overlay overlay = std::move(frame.overlay);
      frames_.pop_front();
      changed_.notify_all();
      lock.unlock();

      const Image* picture = &last;
      if (painter_) {
        canvas = last;
        painter_->draw(overlay, canvas);
        picture = &canvas;
      }
      if (Result<void> written = encoder_->write(*picture); !written) return written;
    }
  }

  // With the mutex held. The first failure is the one that is told.
  void fail(const Diagnostics& diagnostics) {
    if (!failed_) diagnostics_ = diagnostics;
    failed_ = true;
    changed_.notify_all();
  }

  const mjModel* model_;
  FilmOptions options_;
  std::optional<CameraView> inset_;
  std::optional<std::string> chosen_camera_;
  std::optional<OverlayPainter> painter_;
  std::optional<FilmEncoder> encoder_;
  PoseState last_state_;
  std::int64_t pushed_ = 0;
  std::optional<Result<FilmReport>> closed_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Frame> frames_;
  std::vector<Image> spare_;
  bool closing_ = false;
  bool failed_ = false;
  Diagnostics diagnostics_;
  FilmReport report_;
  std::vector<std::jthread> workers_;
  std::jthread writer_;
};

Film::Film(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Film::Film(Film&&) noexcept = default;
Film& Film::operator=(Film&&) noexcept = default;
Film::~Film() = default;

Result<Film> Film::open(const mjModel_* model, const FilmOptions& options) {
  if (Diagnostics diagnostics = check_film(model, options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  auto impl = std::make_unique<Impl>(model, options);
  if (Result<void> started = impl->start(); !started) return std::unexpected(started.error());
  return Film(std::move(impl));
}

bool Film::has_room() const { return impl_->has_room(); }

Result<void> Film::push(const mjData_* data, const Overlay& overlay, const Marks& marks) {
  return impl_->push(data, overlay, marks);
}

Result<void> Film::push(std::span<const double> qpos, std::span<const double> lamps, const Overlay& overlay,
                        const Marks& marks) {
  return impl_->push(qpos, lamps, overlay, marks);
}

Nanoseconds Film::next_time() const { return impl_->next_time(); }
Result<void> Film::set_camera(std::string_view camera) { return impl_->set_camera(camera); }
Result<FilmReport> Film::close() { return impl_->close(); }

Result<FilmReport> film_from_states(const mjModel_* model, std::span<const FilmState> states,
                                    const FilmOptions& options) {
  if (states.empty()) return failure(Code::kFileNotReadable, "", "the recording has no state to show");
  Result<Film> film = Film::open(model, options);
  if (!film) return std::unexpected(film.error());
  const Nanoseconds begin = states.front().time, end = states.back().time;
  for (std::size_t next = 0; begin + film->next_time() <= end;) {
    const Nanoseconds now = begin + film->next_time();
    while (next + 1 < states.size() && states[next + 1].time <= now) ++next;
    Overlay overlay = states[next].overlay;
    overlay.time = now;
    if (Result<void> pushed = film->push(states[next].qpos, states[next].lamps, overlay, states[next].marks); !pushed)
      break;  // close() tells why
  }
  return film->close();
}

}  // namespace takt::sim
