#include "hw/modbus/driver.h"

#include <algorithm>
#include <chrono>

#include <pthread.h>

namespace takt::hw::modbus {
namespace {

constexpr int kThreadPriority = 82;                     // of SCHED_FIFO, where permitted: below the drivers of arms
constexpr Nanoseconds kLongestWait = 2 * kMillisecond;  // a reset is to be noticed
constexpr Nanoseconds kShortestWait = kMillisecond / 20;

}  // namespace

Driver::Driver(const ClientOptions& options, const device::IoRequest& request, const Clock& clock)
    : Backend(options, request, posix, clock),
      clock_(clock),
      thread_([this](const std::stop_token& stop) { serve(stop); }) {}

Driver::~Driver() {
  thread_.request_stop();
  thread_.join();
}

void Driver::serve(const std::stop_token& stop) {
  const sched_param parameters{.sched_priority = kThreadPriority};
  (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // refused: it runs without
  while (!stop.stop_requested()) {
    client_.poll();
    const Nanoseconds wait = std::clamp(client_.next_due() - clock_.now(), kShortestWait, kLongestWait);
    if (client_.connected()) {
      client_.wait(wait);
    } else {
      std::this_thread::sleep_for(std::chrono::nanoseconds(wait));
    }
  }
}

}  // namespace takt::hw::modbus
