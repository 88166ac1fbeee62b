#pragma once

#include <expected>
#include <functional>
#include <string>

#include "cell/run/cell_scene.h"
#include "serve/access.h"
#include "serve/http_server.h"
#include "serve/picture_maker.h"
#include "serve/served_cell.h"
#include "serve/watch_pool.h"

/// What all kinds of stream have in common. The thread of the server, but for what says otherwise.
namespace takt::serve {

/// What a stream and its parts use of the server. All of it outlives them.
struct StreamServices {
  ServedCell& cell;
  Access& access;
  PictureMaker& pictures;
  std::function<void(const std::string& line)> log;
  /// Has something done on the thread of the server. Any thread.
  std::function<void(std::function<void()> work)> post;
  /// Has something that takes long done on another thread. @return false: there is too much to do
  std::function<bool(std::function<void()> job)> work_elsewhere;
  /// Forgets a net once it has ended.
  std::function<void(rcc::NetId net)> forget_later;
};

/// What all streams look at, once for all.
struct SharedSights {
  CellView view;  ///< as it was when there was news last
  WatchPool watches;
  cell::CellScene scene;
};

/// A client by WebSocket that is told when the cell has news.
class Stream : public SocketUser {
 public:
  virtual void look() = 0;
};

}  // namespace takt::serve
