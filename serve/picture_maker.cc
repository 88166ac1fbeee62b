#include "serve/picture_maker.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace takt::serve {

Diagnostics check_camera(const cell::CellScene& scene, const std::string& camera, const std::string& pointer) {
  Diagnostics diagnostics;
  std::vector<std::string> names = scene.cameras();
  names.emplace_back(cell::CellCamera::kOverview);
  if (std::ranges::find(names, camera) == names.end())
    diagnostics.error(Code::kUnknownName, pointer, fmt::format("the cell has no camera '{}'", camera),
                      nearest_choice(camera, names));
  return diagnostics;
}

void CameraFeed::want() {
  {
    const std::lock_guard lock(maker_.mutex_);
    wanted_ = true;
  }
  maker_.wake_.notify_one();
}

std::shared_ptr<const CameraPicture> CameraFeed::newest() const {
  const std::lock_guard lock(maker_.mutex_);
  return newest_;
}

PictureMaker::PictureMaker(const ServedCell& cell)
    : cell_(cell), thread_([this](const std::stop_token& stop) { work(stop); }) {}

PictureMaker::~PictureMaker() = default;

bool PictureMaker::draw(Order order) {
  const std::lock_guard lock(mutex_);
  if (order_) return false;
  order_ = std::move(order);
  wake_.notify_one();
  return true;
}

std::shared_ptr<CameraFeed> PictureMaker::feed(const PictureFormat& format) {
  const std::lock_guard lock(mutex_);
  std::erase_if(feeds_, [](const auto& one) { return one.second.expired(); });
  std::weak_ptr<CameraFeed>& kept = feeds_[format];
  std::shared_ptr<CameraFeed> feed = kept.lock();
  if (feed == nullptr) kept = feed = std::shared_ptr<CameraFeed>(new CameraFeed(*this));
  return feed;
}

void PictureMaker::on_picture(std::function<void()> listener) {
  const std::lock_guard lock(listener_mutex_);
  listener_ = std::move(listener);
}

void PictureMaker::work(const std::stop_token& stop) {
  while (true) {
    bool ordered = false;
    std::shared_ptr<CameraFeed> feed;
    PictureFormat format;
    {
      std::unique_lock lock(mutex_);
      const auto something = [&] {
        ordered = order_.has_value();
        feed = take_wanted(format);
        return ordered || feed != nullptr;
      };
      if (!wake_.wait(lock, stop, something)) break;
    }
    if (ordered) carry_out();
    if (feed != nullptr) draw_feed(*feed, format);
  }
  camera_.reset();  // where they were made
  live_.reset();
}

std::shared_ptr<CameraFeed> PictureMaker::take_wanted(PictureFormat& format) {
  const auto take = [&](auto from, auto to) -> std::shared_ptr<CameraFeed> {
    for (; from != to; ++from) {
      std::shared_ptr<CameraFeed> feed = from->second.lock();
      if (feed == nullptr || !std::exchange(feed->wanted_, false)) continue;
      last_ = format = from->first;
      return feed;
    }
    return nullptr;
  };
  const auto next = feeds_.upper_bound(last_);
  auto feed = take(next, feeds_.end());
  return feed != nullptr ? feed : take(feeds_.begin(), next);
}

void PictureMaker::carry_out() {
  const Order order = *order_;  // nobody else touches it while it is there
  const auto made = picture(order.format, Quality::kFilm);
  {
    const std::lock_guard lock(mutex_);
    order_.reset();
  }
  order.done(made);
}

/// One that cannot be drawn is left out: whoever asks for a single one is told why.
void PictureMaker::draw_feed(CameraFeed& feed, const PictureFormat& format) {
  auto made = picture(format, Quality::kLive);
  if (!made) return;
  {
    const std::lock_guard lock(mutex_);
    feed.newest_ = std::make_shared<const CameraPicture>(std::move(*made));
  }
  const std::lock_guard lock(listener_mutex_);
  if (listener_) listener_();
}

Result<CameraPicture> PictureMaker::picture(const PictureFormat& format, Quality quality) {
  auto& camera = quality == Quality::kLive ? live_ : camera_;
  if (camera == nullptr) {
    auto opened = cell::CellCamera::open(cell_.built(), quality);
    if (!opened) return std::unexpected(opened.error());
    camera = std::move(*opened);
  }
  const CellView view = cell_.view();
  auto png = camera->picture(format.camera, format.width, format.height, view.picture);
  if (!png) return std::unexpected(png.error());
  return CameraPicture{.png = std::move(*png), .cycle = view.cycle, .time = view.time};
}

}  // namespace takt::serve
