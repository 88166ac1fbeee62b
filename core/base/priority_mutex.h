#pragma once

#include <cstdlib>

#include <pthread.h>

namespace takt {

/// A mutex between a real-time thread and others (BasicLockable): whoever has it runs with the highest priority of
/// those that wait for it (priority inheritance), so that the real-time thread waits for the protected work only, not
/// for everything of middle priority. Any thread. Realtime: cyclic, bounded by what others do while they have it.
class PriorityMutex {
 public:
  PriorityMutex() {
    pthread_mutexattr_t attributes;
    const bool made = pthread_mutexattr_init(&attributes) == 0 &&
                      pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT) == 0 &&
                      pthread_mutex_init(&mutex_, &attributes) == 0;
    if (!made) std::abort();
    pthread_mutexattr_destroy(&attributes);
  }
  ~PriorityMutex() { pthread_mutex_destroy(&mutex_); }
  PriorityMutex(const PriorityMutex&) = delete;
  PriorityMutex& operator=(const PriorityMutex&) = delete;

  void lock() { pthread_mutex_lock(&mutex_); }
  bool try_lock() { return pthread_mutex_trylock(&mutex_) == 0; }
  void unlock() { pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_{};
};

}  // namespace takt
