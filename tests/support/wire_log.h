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
#include "hw/wire/stream_link.h"

/// A log of a driver: when it had its turn, all that came over its wire, all that it sent, and all that the core did
/// with it, in order. A second driver that gets the same has to do the same, to the bit.
namespace takt::test {

struct WireLog {
  /// The driver had its turn: what follows on the wire happened in it.
  enum class Turn : std::uint8_t {
    kServe,       ///< it takes what has come, and answers
    kBeginCycle,  ///< of a bus whose clock it is
    kEnd          ///< it was destroyed
  };
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
  // Of streams: numbers count the connections that were begun.
  struct Connected {
    hw::Endpoint to;
  };
  struct StreamState {
    std::size_t stream = 0;
    hw::StreamLink::State state = hw::StreamLink::State::kConnecting;
  };
  struct StreamReceived {
    std::size_t stream = 0;
    std::vector<std::byte> bytes;  ///< none: the driver looked, and nothing was there
  };
  struct StreamSent {
    std::size_t stream = 0;
    std::vector<std::byte> bytes;
    std::size_t accepted = 0;
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
  using What = std::variant<Turn, Received, NothingReceived, Sent, Connected, StreamState, StreamReceived, StreamSent,
                            Call, Read, Reset>;
  struct Event {
    Nanoseconds time = 0;  ///< of the clock
    What what;
  };

  void note(const Clock& clock, What what) { events.push_back({clock.now(), std::move(what)}); }
  std::vector<Event> events;
};

/// Goes through a log while it is played; one for all that plays it. A test fails where the driver does something else.
class LogReader {
 public:
  explicit LogReader(const WireLog& log) : log_(log) {}

  [[nodiscard]] bool at_end() const { return at_ >= log_.events.size(); }
  [[nodiscard]] const WireLog::Event& here() const { return log_.events[at_]; }
  [[nodiscard]] std::size_t number() const { return at_; }
  void pass() { ++at_; }
  /// The next event, if it is of this type, which is passed then. Null: something else comes.
  template <class What>
  const What* accept() {
    const What* what = at_end() ? nullptr : std::get_if<What>(&here().what);
    if (what != nullptr) pass();
    return what;
  }
  /// The same where nothing else may come: else the test has failed, and the log is at its end.
  template <class What>
  const What* expect() {
    const What* what = accept<What>();
    if (what == nullptr) {
      ADD_FAILURE() << "the log has something else at event " << at_;
      at_ = log_.events.size();
    }
    return what;
  }

 private:
  const WireLog& log_;
  std::size_t at_ = 0;
};

/// Writes down what goes over a link.
class RecordingLink final : public hw::DatagramLink {
 public:
  RecordingLink(std::unique_ptr<hw::DatagramLink> link, const Clock& clock, WireLog& log)
      : link_(std::move(link)), clock_(clock), log_(log) {}

  bool send(std::span<const std::byte> datagram, const hw::Endpoint& to) override {
    const bool accepted = link_->send(datagram, to);
    log_.note(clock_, WireLog::Sent{{datagram.begin(), datagram.end()}, to, accepted});
    return accepted;
  }
  std::optional<Received> receive(std::span<std::byte> buffer) override {
    const auto received = link_->receive(buffer);
    if (!received) {
      log_.note(clock_, WireLog::NothingReceived{});
      return received;
    }
    const auto bytes = buffer.first(std::min(received->size, buffer.size()));
    log_.note(clock_, WireLog::Received{{bytes.begin(), bytes.end()}, received->from});
    return received;
  }
  bool wait(Nanoseconds timeout) override { return link_->wait(timeout); }
  [[nodiscard]] hw::Endpoint local() const override { return link_->local(); }
  [[nodiscard]] hw::DatagramCounts counts() const override { return link_->counts(); }

 private:
  std::unique_ptr<hw::DatagramLink> link_;
  const Clock& clock_;
  WireLog& log_;
};

/// Plays a log to whoever receives, and holds what is sent against it.
class ReplayedLink final : public hw::DatagramLink {
 public:
  ReplayedLink(LogReader& log, const hw::Endpoint& local) : log_(log), local_(local) {}

  bool send(std::span<const std::byte> datagram, const hw::Endpoint& to) override {
    const std::size_t number = log_.number();
    const auto* sent = log_.expect<WireLog::Sent>();
    if (sent == nullptr) return false;
    EXPECT_TRUE(std::ranges::equal(sent->bytes, datagram)) << "event " << number << " of the log";
    EXPECT_EQ(sent->to, to);
    return sent->accepted;
  }
  std::optional<Received> receive(std::span<std::byte> buffer) override {
    if (log_.accept<WireLog::NothingReceived>() != nullptr) return std::nullopt;
    const auto* received = log_.expect<WireLog::Received>();
    if (received == nullptr) return std::nullopt;
    std::ranges::copy(received->bytes, buffer.begin());
    return Received{received->bytes.size(), received->from};
  }
  bool wait(Nanoseconds /*timeout*/) override { return true; }
  [[nodiscard]] hw::Endpoint local() const override { return local_; }
  [[nodiscard]] hw::DatagramCounts counts() const override { return {}; }

 private:
  LogReader& log_;
  hw::Endpoint local_;
};

/// Stands between the core and a driver, and writes down what the core does.
class RecordedCalls final : public device::ArmBackend {
 public:
  /// @param pass_cycle  what read() begins with: it makes time go on
  RecordedCalls(std::shared_ptr<device::ArmBackend> driver, std::function<void()> pass_cycle, const Clock& clock,
                WireLog& log)
      : driver_(std::move(driver)), pass_cycle_(std::move(pass_cycle)), clock_(clock), log_(log) {}

  bool read(device::ArmSample& sample) override {
    pass_cycle_();
    const bool any = driver_->read(sample);
    log_.note(clock_, WireLog::Read{any, sample});
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
  void set_payload(const device::PayloadSetting& payload) override {
    call([payload](device::ArmBackend& arm) { arm.set_payload(payload); });
  }
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
    log_.note(clock_, WireLog::Call{make});
    make(*driver_);
  }
  std::shared_ptr<device::ArmBackend> driver_;
  std::function<void()> pass_cycle_;
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
  LogReader& log;              ///< as of its links
  VirtualClock& clock;         ///< the driver's
  device::ArmBackend& driver;  ///< whose read() makes no time go on
  std::function<void(WireLog::Turn)> turn;
  std::function<void()> reset = [] {};
  int reads = 0, turns = 0;  ///< for who wants to know that there was something to compare

  void play() {
    while (!log.at_end() && !testing::Test::HasFailure()) {
      clock.set(log.here().time);
      if (const auto* one = log.accept<WireLog::Turn>()) {
        ++turns;
        turn(*one);
      } else if (const auto* call = log.accept<WireLog::Call>()) {
        call->make(driver);
      } else if (log.accept<WireLog::Reset>() != nullptr) {
        reset();
      } else if (const auto* read = log.expect<WireLog::Read>()) {
        compare(*read);
      }
    }
  }

 private:
  void compare(const WireLog::Read& read) {
    ++reads;
    device::ArmSample sample;
    EXPECT_EQ(driver.read(sample), read.any) << "event " << log.number() - 1;
    EXPECT_TRUE(!read.any || same(sample, read.sample)) << "event " << log.number() - 1;
  }
};

}  // namespace takt::test
