#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <vector>

#include "core/device/agent_thread.h"

namespace takt::test {

/// A wire between the thread of a device and that of an agent. Any thread.
class QueueLink final : public device::ArmLink {
 public:
  bool receive(device::ArmPacket& packet, Nanoseconds timeout) override {
    std::unique_lock lock(mutex_);
    const bool some = changed_.wait_for(lock, std::chrono::nanoseconds(timeout), [this] { return !packets_.empty(); });
    if (!some) return false;
    packet = packets_.front();
    packets_.pop_front();
    return true;
  }
  void send(const device::ArmAnswer& answer) override {
    const std::lock_guard lock(mutex_);
    answers_.push_back(answer);
  }

  void put(const device::ArmPacket& packet) {
    {
      const std::lock_guard lock(mutex_);
      packets_.push_back(packet);
    }
    changed_.notify_one();
  }
  /// All answers so far.
  [[nodiscard]] std::vector<device::ArmAnswer> answers() const {
    const std::lock_guard lock(mutex_);
    return answers_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<device::ArmPacket> packets_;
  std::vector<device::ArmAnswer> answers_;
};

}  // namespace takt::test
