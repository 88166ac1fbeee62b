#include "hw/fri/driver.h"

#include <pthread.h>

namespace takt::hw::fri {
namespace {

constexpr Nanoseconds kLook = 20 * kMillisecond;    // how long the thread takes to see that it is to end
constexpr Nanoseconds kLeave = 500 * kMillisecond;  // for KRL to stop: 40 of its cycles

}  // namespace

Driver::Driver(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<DatagramLink> link,
               const Clock& clock, int priority)
    : Backend(request, options, std::move(link), clock) {
  wire_time_ = kMillisecond;
  thread_ = std::jthread([this, priority](const std::stop_token& stop) { serve(stop, priority); });
}

void Driver::serve(const std::stop_token& stop, int priority) {
  if (priority > 0) {
    const sched_param parameters{.sched_priority = priority};
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // refused: it runs without
  }
  while (!stop.stop_requested()) {
    if (client_.wait(kLook)) client_.serve();
  }
  const Nanoseconds end = MonotonicClock::machine_time() + kLeave;
  while (!client_.leave() && MonotonicClock::machine_time() < end) (void)client_.wait(kLook);
}

}  // namespace takt::hw::fri
