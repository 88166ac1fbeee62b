#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/clock.h"
#include "core/device/backend.h"
#include "hw/wire/datagram_link.h"

/// A log of a driver: all that came over its wire, all that it sent, and all that the core did with it, in order. A
/// second driver that gets the same has to do the same, to the bit.
namespace takt::test {

struct WireLog {
  struct Received {
    std::vector<std::byte> bytes;
    hw::Endpoint from;
  };
  struct NothingReceived {};  ///< the driver looked, and nothing was there
  struct Sent {
    std::vector<std::byte> bytes;
    hw::Endpoint to;
    bool accepted = true;
  };
  /// A call of the core, to be made again; a read() with what came of it.
  struct Call {
    std::function<void(device::ArmBackend&)> make;
  };
  struct Read {
    bool any = false;
    device::ArmSample sample;
  };
  /// What an operator did.
  struct Reset {};
  using What = std::variant<Received, NothingReceived, Sent, Call, Read, Reset>;
  struct Event {
    Nanoseconds time = 0;  ///< of the clock
    What what;
  };
  std::vector<Event> events;
};

/// Writes down what goes over a link.
class RecordingLink final : public hw::DatagramLink {
 public:
  RecordingLink(std::unique_ptr<hw::DatagramLink> link, const Clock& clock, WireLog& log)
      : link_(std::move(link)), clock_(clock), log_(log) {}

  bool send(std::span<const std::byte> datagram, const hw::Endpoint& to) override {
    const bool accepted = link_->send(datagram, to);
    note(WireLog::Sent{{datagram.begin(), datagram.end()}, to, accepted});
    return accepted;
  }
  std::optional<Received> receive(std::span<std::byte> buffer) override {
    const auto received = link_->receive(buffer);
    if (!received) {
      note(WireLog::NothingReceived{});
      return received;
    }
    const auto bytes = buffer.first(std::min(received->size, buffer.size()));
    note(WireLog::Received{{bytes.begin(), bytes.end()}, received->from});
    return received;
  }
  bool wait(Nanoseconds timeout) override { return link_->wait(timeout); }
  [[nodiscard]] hw::Endpoint local() const override { return link_->local(); }
  [[nodiscard]] hw::DatagramCounts counts() const override { return link_->counts(); }

 private:
  void note(WireLog::What what) { log_.events.push_back({clock_.now(), std::move(what)}); }
  std::unique_ptr<hw::DatagramLink> link_;
  const Clock& clock_;
  WireLog& log_;
};

/// Plays a log to whoever receives, and holds what is sent against it. One of a log, until it is at its end.
class ReplayedLink final : public hw::DatagramLink {
 public:
  /// @param at  the next event of the log; shared with who makes the core's calls
  ReplayedLink(const WireLog& log, std::size_t& at, const hw::Endpoint& local) : log_(log), at_(at), local_(local) {}

  bool send(std::span<const std::byte> datagram, const hw::Endpoint& to) override {
    const auto* sent = next<WireLog::Sent>();
    if (sent == nullptr) return false;
    EXPECT_TRUE(std::ranges::equal(sent->bytes, datagram)) << "event " << at_ - 1 << " of the log";
    EXPECT_EQ(sent->to, to);
    return sent->accepted;
  }
  std::optional<Received> receive(std::span<std::byte> buffer) override {
    if (at_ < log_.events.size() && std::holds_alternative<WireLog::NothingReceived>(log_.events[at_].what)) {
      ++at_;
      return std::nullopt;
    }
    const auto* received = next<WireLog::Received>();
    if (received == nullptr) return std::nullopt;
    std::ranges::copy(received->bytes, buffer.begin());
    return Received{received->bytes.size(), received->from};
  }
  bool wait(Nanoseconds /*timeout*/) override { return true; }
  [[nodiscard]] hw::Endpoint local() const override { return local_; }
  [[nodiscard]] hw::DatagramCounts counts() const override { return {}; }

 private:
  template <class Event>
  const Event* next() {
    const Event* event = at_ < log_.events.size() ? std::get_if<Event>(&log_.events[at_].what) : nullptr;
    if (event == nullptr) {
      ADD_FAILURE() << "the log has something else at event " << at_;
      at_ = log_.events.size();
      return nullptr;
    }
    ++at_;
    return event;
  }
  const WireLog& log_;
  std::size_t& at_;
  hw::Endpoint local_;
};

/// Stands between the core and a driver, and writes down what the core does.
class RecordedCalls final : public device::ArmBackend {
 public:
  RecordedCalls(std::shared_ptr<device::ArmBackend> driver, const Clock& clock, WireLog& log)
      : driver_(std::move(driver)), clock_(clock), log_(log) {}

  bool read(device::ArmSample& sample) override {
    const bool any = driver_->read(sample);
    log_.events.push_back({clock_.now(), WireLog::Read{any, sample}});
    return any;
  }
  void set_held(bool held) override {
    call([held](device::ArmBackend& arm) { arm.set_held(held); });
  }
  void write(const device::ArmSetPoint& set_point) override {
    call([set_point](device::ArmBackend& arm) { arm.write(set_point); });
  }
  void write_compliance(const device::Compliance& compliance) override {
    call([compliance](device::ArmBackend& arm) { arm.write_compliance(compliance); });
  }
  void change_mode(device::ControlMode mode) override {
    call([mode](device::ArmBackend& arm) { arm.change_mode(mode); });
  }
  void set_payload(const device::PayloadSetting& payload) override { driver_->set_payload(payload); }
  void set_tool(const device::ToolSetting& tool) override {
    call([tool](device::ArmBackend& arm) { arm.set_tool(tool); });
  }
  void brake() override {
    call([](device::ArmBackend& arm) { arm.brake(); });
  }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return driver_->fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override { return driver_->timing(); }

 private:
  void call(std::function<void(device::ArmBackend&)> make) {
    log_.events.push_back({clock_.now(), WireLog::Call{make}});
    make(*driver_);
  }
  std::shared_ptr<device::ArmBackend> driver_;
  const Clock& clock_;
  WireLog& log_;
};

inline bool same(const device::ArmSample& a, const device::ArmSample& b) {
  return a.sequence == b.sequence && a.stamp == b.stamp && a.q == b.q && a.dq == b.dq && a.tau == b.tau &&
         a.tau_external == b.tau_external && a.commanded == b.commanded && a.mode == b.mode &&
         a.changing_mode == b.changing_mode && a.braked == b.braked && a.ready == b.ready && a.fault == b.fault;
}

/// Plays a log to a second driver.
struct LogPlayer {
  const WireLog& log;
  VirtualClock& clock;
  std::size_t& at;              ///< as of its ReplayedLink
  device::ArmBackend& driver;   ///< whose read() makes no time go on
  std::function<void()> serve;  ///< lets the driver receive until nothing is there
  std::function<void()> reset;
  int reads = 0, serves = 0;  ///< for who wants to know that there was something to compare

  void play() {
    while (at < log.events.size() && !testing::Test::HasFailure()) {
      const WireLog::Event& event = log.events[at];
      clock.set(event.time);
      if (const auto* call = std::get_if<WireLog::Call>(&event.what)) {
        ++at;
        call->make(driver);
      } else if (const auto* read = std::get_if<WireLog::Read>(&event.what)) {
        ++at;
        ++reads;
        device::ArmSample sample;
        EXPECT_EQ(driver.read(sample), read->any) << "event " << at;
        EXPECT_TRUE(!read->any || same(sample, read->sample)) << "event " << at;
      } else if (std::holds_alternative<WireLog::Reset>(event.what)) {
        ++at;
        reset();
      } else if (std::holds_alternative<WireLog::Sent>(event.what)) {
        ADD_FAILURE() << "the driver sent nothing at event " << at;
      } else {
        ++serves;
        serve();
      }
    }
  }
};

}  // namespace takt::test
