#pragma once

#include <string>
#include <thread>

#include "core/device/arm_agent.h"

namespace takt::device {

/// The wire to an arm, as a driver sees it. Used by one thread. An exception out of it ends the session with the device
/// (ArmAgent::fail), and is reported.
class ArmLink {
 public:
  virtual ~ArmLink() = default;
  /// Waits for the next packet. @return false if none came within `timeout`.
  virtual bool receive(ArmPacket& packet, Nanoseconds timeout) = 0;
  virtual void send(const ArmAnswer& answer) = 0;
};

/// The thread of an agent on hardware: waits for packets and answers them, on the device's clock, until it is
/// destroyed. If the device falls silent there is nothing to answer; the core sees it by the age of the sample.
/// Whatever is thrown in it ends there.
class AgentThread {
 public:
  /// `agent` and `link` must outlive it. Realtime: setup.
  /// @param priority  of SCHED_FIFO, where permitted; 0: leave the scheduling alone
  /// @param arm  its name, for messages
  AgentThread(ArmAgent& agent, ArmLink& link, int priority = 85, std::string arm = "arm");
  AgentThread(const AgentThread&) = delete;
  AgentThread& operator=(const AgentThread&) = delete;

 private:
  std::jthread thread_;
};

}  // namespace takt::device
