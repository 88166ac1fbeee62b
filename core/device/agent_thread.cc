#include "core/device/agent_thread.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <fmt/format.h>
#include <pthread.h>

#include "core/base/last_catch.h"

namespace takt::device {

namespace {

constexpr Nanoseconds kLook = 50 * kMillisecond;  // how long a thread without packets takes to see that it is to end

/// What the thread does, for the message of its last catch.
struct AgentTask {
  const std::string& arm;
  const char* doing = "begin";
  std::uint64_t sequence = 0;  // of the newest packet

  /// Reports the exception that is being handled. Allocates nothing.
  void report_failure() const {
    std::array<char, 160> text;
    const auto end = fmt::format_to_n(text.data(), text.size(), "{} of the I/O agent of '{}', newest packet {}", doing,
                                      arm, sequence);
    report_exception({text.data(), std::min(end.size, text.size())});
  }
};

void serve_packet(ArmAgent& agent, ArmLink& link, AgentTask& task) {
  ArmPacket packet;
  task.doing = "receive";
  if (!link.receive(packet, kLook)) return;
  task.sequence = packet.sample.sequence;
  task.doing = "answer";
  const auto answer = agent.answer(packet);
  task.doing = "send";
  if (answer) link.send(*answer);
}

/// The last catch of the thread: a packet that cannot be served ends the session with the device, not the process. The
/// arm is not ready then, its device is not answered and stops by itself, and a new session may begin.
void serve(const std::stop_token& stop, ArmAgent& agent, ArmLink& link, const std::string& arm) {
  AgentTask task{.arm = arm};
  RareReport report;
  while (!stop.stop_requested()) {
    try {
      serve_packet(agent, link, task);
    } catch (...) {
      if (report.next()) task.report_failure();
      (void)run_caught("end the session of an I/O agent", [&agent] { agent.fail(); });
      // A driver that fails at once, each time, leaves the machine to others.
      std::this_thread::sleep_for(std::chrono::nanoseconds(kLook));
    }
  }
}

void take_priority(int priority) {
  if (priority <= 0) return;
  const sched_param parameters{.sched_priority = priority};
  (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // refused: it runs without
}

}  // namespace

AgentThread::AgentThread(ArmAgent& agent, ArmLink& link, int priority, std::string arm)
    : thread_([&agent, &link, priority, arm = std::move(arm)](const std::stop_token& stop) {
        take_priority(priority);
        serve(stop, agent, link, arm);
      }) {}

}  // namespace takt::device
