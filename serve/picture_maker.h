#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "serve/served_cell.h"

namespace takt::serve {

/// Draws pictures of a cell on a thread of its own, one at a time. Graphics are started by the first one.
class PictureMaker {
 public:
  struct Order {
    std::string camera;
    int width = 640, height = 360;                             ///< pixels
    std::function<void(const Result<std::string>& png)> done;  ///< on the thread of the maker
  };
  /// The cell outlives it.
  explicit PictureMaker(const ServedCell& cell);
  ~PictureMaker();
  PictureMaker(const PictureMaker&) = delete;
  PictureMaker& operator=(const PictureMaker&) = delete;

  /// Any thread. @return false: it is busy
  [[nodiscard]] bool draw(Order order);

 private:
  void work(const std::stop_token& stop);
  [[nodiscard]] Result<std::string> picture(const Order& order);

  const ServedCell& cell_;
  std::unique_ptr<cell::CellCamera> camera_;  ///< of the thread
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::optional<Order> order_;  ///< until it is carried out
  std::jthread thread_;         ///< last: it uses what is above
};

}  // namespace takt::serve
