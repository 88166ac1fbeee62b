#include "sim/model/mujoco_errors.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <string_view>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

// A warning may come from inside mj_step: the text goes into fixed storage, so that nothing is allocated there.
struct WarningStore {
  std::atomic<std::uint64_t> count = 0;
  std::mutex mutex;
  char last[1024] = {};
};

WarningStore& warning_store() {
  static WarningStore store;
  return store;
}

void keep_warning(std::string_view text) {
  WarningStore& store = warning_store();
  store.count.fetch_add(1, std::memory_order_relaxed);
  const std::unique_lock lock(store.mutex, std::try_to_lock);
  if (!lock) return;  // counted all the same
  const std::size_t length = std::min(text.size(), sizeof(store.last) - 1);
  std::memcpy(store.last, text.data(), length);
  store.last[length] = '\0';
}

void on_message(const mjLogMessage* message) {
  if (message->level == mjLOG_ERROR) {
    std::string text = message->subject;
    if (message->body != nullptr && *message->body != '\0') text += std::string(": ") + message->body;
    throw MujocoError(text);
  }
  if (message->level == mjLOG_WARNING) keep_warning(message->subject);
}

}  // namespace

void install_mujoco_handlers() {
  static const bool installed = [] {
    mju_setLogHandler(&on_message);
    return true;
  }();
  (void)installed;
}

MujocoWarnings mujoco_warnings() {
  WarningStore& store = warning_store();
  const std::lock_guard lock(store.mutex);
  return {store.count.load(std::memory_order_relaxed), store.last};
}

}  // namespace takt::sim
