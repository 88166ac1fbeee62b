#include "serve/watch_pool.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::serve {

void SharedWatch::set_every(const void* user, int every) {
  if (every > 0) {
    users_[user] = every;
  } else {
    users_.erase(user);
  }
  int least = 0;
  for (const auto& [one, wanted] : users_) least = least == 0 ? wanted : std::min(least, wanted);
  watch_->set_every(least);
}

Result<std::shared_ptr<SharedWatch>> WatchPool::open(rcc::NetId net, const std::string& port) {
  std::erase_if(watches_, [](const auto& one) { return one.second.expired(); });
  if (const auto found = watches_.find({net, port}); found != watches_.end()) {
    auto shared = found->second.lock();
    if (shared != nullptr && !shared->ended()) return shared;
  }
  if (watches_.size() >= kMost)
    return failure(Code::kNotPossibleNow, "", fmt::format("{} values are watched", watches_.size()),
                   "End some monitors");
  auto watch = net != 0 ? core_.watch(net, port, {.every = 0}) : core_.watch(port, {.every = 0});
  if (!watch) return std::unexpected(std::move(watch.error()));
  auto shared = std::make_shared<SharedWatch>(core_, std::move(*watch));
  watches_[{net, port}] = shared;
  return shared;
}

}  // namespace takt::serve
