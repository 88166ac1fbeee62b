#pragma once

#include <compare>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "cell/run/cell_scene.h"
#include "serve/served_cell.h"

namespace takt::serve {

/// A camera of the cell and the size of its pictures, pixels.
struct PictureFormat {
  std::string camera;
  int width = 640, height = 360;
  friend auto operator<=>(const PictureFormat&, const PictureFormat&) = default;
};

/// @return a diagnostic, at `pointer`: the cell has no such camera, and it is not CellCamera::kOverview
[[nodiscard]] Diagnostics check_camera(const cell::CellScene& scene, const std::string& camera,
                                       const std::string& pointer);

/// What a camera saw.
struct CameraPicture {
  std::string png;
  std::int64_t cycle = 0;  ///< number of cycles that the core had run when it was as in the picture
  Nanoseconds time = 0;    ///< of the core, likewise
};

/// The pictures of one camera while somebody watches it: the newest one counts, none is queued. Any thread.
class CameraFeed {
 public:
  /// Wants a picture of the cell as it will be when the maker comes to it.
  void want();
  /// Null: none yet.
  [[nodiscard]] std::shared_ptr<const CameraPicture> newest() const;

 private:
  friend class PictureMaker;
  explicit CameraFeed(class PictureMaker& maker) : maker_(maker) {}
  class PictureMaker& maker_;  ///< with its mutex; outlives it
  bool wanted_ = false;
  std::shared_ptr<const CameraPicture> newest_;
};

/// Draws pictures of a cell on a thread of its own, one at a time. Graphics are started by the first one. The cycle
/// knows nothing of it: what is drawn is the copy of the state that everybody looks at.
class PictureMaker {
 public:
  struct Order {
    PictureFormat format;
    std::function<void(const Result<CameraPicture>& picture)> done;  ///< on the thread of the maker
  };
  /// The cell outlives it.
  explicit PictureMaker(const ServedCell& cell);
  ~PictureMaker();
  PictureMaker(const PictureMaker&) = delete;
  PictureMaker& operator=(const PictureMaker&) = delete;

  /// Any thread. @return false: it is busy with another order
  [[nodiscard]] bool draw(Order order);
  /// The pictures of a camera, shared by all who watch it in the same size; drawn only when one of them wants one. The
  /// camera and the size are possible. Any thread.
  [[nodiscard]] std::shared_ptr<CameraFeed> feed(const PictureFormat& format);
  /// Who is told of a new picture of a feed, on the thread of the maker; empty: nobody. Any thread.
  void on_picture(std::function<void()> listener);

 private:
  friend class CameraFeed;
  void work(const std::stop_token& stop);
  using Quality = cell::CellCamera::Quality;
  [[nodiscard]] Result<CameraPicture> picture(const PictureFormat& format, Quality quality);
  /// One of the feeds that are wanted, each in its turn. Under the mutex.
  [[nodiscard]] std::shared_ptr<CameraFeed> take_wanted(PictureFormat& format);
  void carry_out();
  void draw_feed(CameraFeed& feed, const PictureFormat& format);

  const ServedCell& cell_;
  std::unique_ptr<cell::CellCamera> camera_, live_;  ///< of the thread, for orders and for feeds
  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  std::optional<Order> order_;  ///< until it is carried out
  std::map<PictureFormat, std::weak_ptr<CameraFeed>> feeds_;
  PictureFormat last_;  ///< whose turn was last
  std::mutex listener_mutex_;
  std::function<void()> listener_;
  std::jthread thread_;  ///< last: it uses what is above
};

}  // namespace takt::serve
