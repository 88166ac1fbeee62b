#include "hw/wsg/driver.h"

#include <chrono>

#include <pthread.h>

namespace takt::hw::wsg {
namespace {

constexpr int kThreadPriority = 82;                    // of SCHED_FIFO, where permitted: below the drivers of arms
constexpr Nanoseconds kLookAround = 2 * kMillisecond;  // longest time between two looks at what the core wants

}  // namespace

Driver::Driver(const ClientOptions& options, const device::GripperRequest& request, const Clock& clock)
    : Backend(options, request, posix, clock), thread_([this](const std::stop_token& stop) { serve(stop); }) {}

Driver::~Driver() {
  thread_.request_stop();
  thread_.join();
}

void Driver::serve(const std::stop_token& stop) {
  const sched_param parameters{.sched_priority = kThreadPriority};
  (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // refused: it runs without
  while (!stop.stop_requested()) {
    client_.poll();
    const Nanoseconds before = MonotonicClock::machine_time();
    client_.wait(kLookAround);
    // A link that is not open does not wait.
    const Nanoseconds left = kLookAround - (MonotonicClock::machine_time() - before);
    if (!client_.connected() && left > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(left));
  }
  client_.leave();
}

}  // namespace takt::hw::wsg
