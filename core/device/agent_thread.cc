#include "core/device/agent_thread.h"

#include <pthread.h>

namespace takt::device {

namespace {

constexpr Nanoseconds kLook = 50 * kMillisecond;  // how long a thread without packets takes to see that it is to end

void serve(const std::stop_token& stop, ArmAgent& agent, ArmLink& link, int priority) {
  if (priority > 0) {
    const sched_param parameters{.sched_priority = priority};
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // refused: it runs without
  }
  ArmPacket packet;
  while (!stop.stop_requested()) {
    if (!link.receive(packet, kLook)) continue;
    if (const auto answer = agent.answer(packet)) link.send(*answer);
  }
}

}  // namespace

AgentThread::AgentThread(ArmAgent& agent, ArmLink& link, int priority)
    : thread_([&agent, &link, priority](const std::stop_token& stop) { serve(stop, agent, link, priority); }) {}

}  // namespace takt::device
