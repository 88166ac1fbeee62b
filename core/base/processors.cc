#include "core/base/processors.h"

#include <pthread.h>
#include <sched.h>

#include <cstddef>

namespace takt {

bool has_processor(int processor) {
  if (processor < 0 || processor >= CPU_SETSIZE) return false;
  // Only a thread that is bound to it shows that it is there; the binding of the caller is put back.
  cpu_set_t before;
  if (pthread_getaffinity_np(pthread_self(), sizeof before, &before) != 0) return false;
  const bool there = run_on_processor(processor);
  return pthread_setaffinity_np(pthread_self(), sizeof before, &before) == 0 && there;
}

bool run_on_processor(int processor) {
  if (processor < 0 || processor >= CPU_SETSIZE) return false;
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(static_cast<std::size_t>(processor), &only);
  return pthread_setaffinity_np(pthread_self(), sizeof only, &only) == 0;
}

bool keep_off_processor(int processor) {
  if (processor < 0 || processor >= CPU_SETSIZE) return false;
  cpu_set_t allowed;
  if (pthread_getaffinity_np(pthread_self(), sizeof allowed, &allowed) != 0) return false;
  if (!CPU_ISSET(static_cast<std::size_t>(processor), &allowed)) return true;  // isolated ones are not among them
  CPU_CLR(static_cast<std::size_t>(processor), &allowed);
  return CPU_COUNT(&allowed) > 0 && pthread_setaffinity_np(pthread_self(), sizeof allowed, &allowed) == 0;
}

}  // namespace takt
