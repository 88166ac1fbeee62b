#include "serve/picture_maker.h"

#include <utility>

namespace takt::serve {

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

void PictureMaker::work(const std::stop_token& stop) {
  while (true) {
    Order order;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return order_.has_value(); })) break;
      order = *order_;
    }
    const auto png = picture(order);
    {
      const std::lock_guard lock(mutex_);
      order_.reset();
    }
    order.done(png);
  }
  camera_.reset();  // where it was made
}

Result<std::string> PictureMaker::picture(const Order& order) {
  if (camera_ == nullptr) {
    auto opened = cell::CellCamera::open(cell_.built());
    if (!opened) return std::unexpected(opened.error());
    camera_ = std::move(*opened);
  }
  return camera_->picture(order.camera, order.width, order.height, cell_.view().picture);
}

}  // namespace takt::serve
