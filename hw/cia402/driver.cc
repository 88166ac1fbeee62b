#include "hw/cia402/driver.h"

#include <algorithm>

#include <pthread.h>

namespace takt::hw::cia402 {
namespace {

constexpr Nanoseconds kLeave = 500 * kMillisecond;  // for a quick stop from full speed

}  // namespace

Driver::Driver(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<FieldBus> bus,
               const Clock& clock, int priority)
    : Backend(request, options, std::move(bus), clock) {
  thread_ = std::jthread([this, priority](const std::stop_token& stop) { serve(stop, priority); });
}

/// One cycle of the bus. A thread that is late by cycles leaves them out: SYNC never comes in bunches.
void Driver::pass_cycle(Nanoseconds& begins) {
  client_.begin_cycle();
  begins += cycle_;
  for (;;) {
    const Nanoseconds left = begins - MonotonicClock::machine_time();
    if (left <= 0) break;
    client_.wait(left);
    client_.poll();
  }
  begins = std::max(begins, MonotonicClock::machine_time() - cycle_ / 2);
}

void Driver::serve(const std::stop_token& stop, int priority) {
  if (priority > 0) {
    const sched_param parameters{.sched_priority = priority};
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // refused: it runs without
  }
  Nanoseconds begins = MonotonicClock::machine_time();
  while (!stop.stop_requested()) pass_cycle(begins);
  const Nanoseconds end = MonotonicClock::machine_time() + kLeave;
  while (!client_.leave() && MonotonicClock::machine_time() < end) pass_cycle(begins);
}

}  // namespace takt::hw::cia402
