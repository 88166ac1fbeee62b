#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "hw/wire/network.h"
#include "tests/support/wire_log.h"

/// Logs of drivers that speak over streams (tests/support/wire_log.h).
namespace takt::test {

/// Writes down what goes over a stream.
class RecordingStream final : public hw::StreamLink {
 public:
  RecordingStream(std::unique_ptr<hw::StreamLink> link, std::size_t number, const Clock& clock, WireLog& log)
      : link_(std::move(link)), number_(number), clock_(clock), log_(log) {}

  State state() override {
    const State state = link_->state();
    log_.note(clock_, WireLog::StreamState{number_, state});
    return state;
  }
  std::size_t send(std::span<const std::byte> bytes) override {
    const std::size_t accepted = link_->send(bytes);
    log_.note(clock_, WireLog::StreamSent{number_, {bytes.begin(), bytes.end()}, accepted});
    return accepted;
  }
  std::size_t receive(std::span<std::byte> buffer) override {
    const std::size_t count = link_->receive(buffer);
    const auto bytes = buffer.first(count);
    log_.note(clock_, WireLog::StreamReceived{number_, {bytes.begin(), bytes.end()}});
    return count;
  }
  bool wait(Nanoseconds timeout) override { return link_->wait(timeout); }
  void close() override { link_->close(); }
  [[nodiscard]] hw::Endpoint local() const override { return link_->local(); }
  [[nodiscard]] hw::Endpoint remote() const override { return link_->remote(); }
  [[nodiscard]] std::string error() const override { return link_->error(); }

 private:
  std::unique_ptr<hw::StreamLink> link_;
  std::size_t number_;
  const Clock& clock_;
  WireLog& log_;
};

/// Writes down what a driver does with the connections that it makes on another network.
class RecordingNetwork final : public hw::Network {
 public:
  RecordingNetwork(hw::Network& network, const Clock& clock, WireLog& log)
      : network_(network), clock_(clock), log_(log) {}

  Result<std::unique_ptr<hw::DatagramLink>> open_datagrams(const hw::Endpoint& local) override {
    return network_.open_datagrams(local);
  }
  Result<std::unique_ptr<hw::StreamListener>> listen(const hw::Endpoint& local) override {
    return network_.listen(local);
  }
  Result<std::unique_ptr<hw::StreamLink>> connect(const hw::Endpoint& remote) override {
    auto link = network_.connect(remote);
    if (!link) return link;
    log_.note(clock_, WireLog::Connected{remote});
    return std::make_unique<RecordingStream>(std::move(*link), connected_++, clock_, log_);
  }

 private:
  hw::Network& network_;
  const Clock& clock_;
  WireLog& log_;
  std::size_t connected_ = 0;
};

/// Plays a stream of a log to whoever receives, and holds what is sent against it.
class ReplayedStream final : public hw::StreamLink {
 public:
  ReplayedStream(LogReader& log, std::size_t number, const hw::Endpoint& remote)
      : log_(log), number_(number), remote_(remote) {}

  State state() override {
    const auto* state = next<WireLog::StreamState>();
    return state == nullptr ? State::kFailed : state->state;
  }
  std::size_t send(std::span<const std::byte> bytes) override {
    const std::size_t number = log_.number();
    const auto* sent = next<WireLog::StreamSent>();
    if (sent == nullptr) return 0;
    EXPECT_TRUE(std::ranges::equal(sent->bytes, bytes)) << "event " << number << " of the log";
    return sent->accepted;
  }
  std::size_t receive(std::span<std::byte> buffer) override {
    const auto* received = next<WireLog::StreamReceived>();
    if (received == nullptr) return 0;
    std::ranges::copy(received->bytes, buffer.begin());
    return received->bytes.size();
  }
  bool wait(Nanoseconds /*timeout*/) override { return true; }
  void close() override {}
  [[nodiscard]] hw::Endpoint local() const override { return {}; }
  [[nodiscard]] hw::Endpoint remote() const override { return remote_; }
  [[nodiscard]] std::string error() const override { return "as it was recorded"; }

 private:
  /// Of this stream.
  template <class What>
  const What* next() {
    const auto* what = log_.expect<What>();
    EXPECT_TRUE(what == nullptr || what->stream == number_) << "event " << log_.number() - 1 << " of the log";
    return what;
  }
  LogReader& log_;
  std::size_t number_;
  hw::Endpoint remote_;
};

/// Gives the connections of a log to a second driver.
class ReplayedNetwork final : public hw::Network {
 public:
  explicit ReplayedNetwork(LogReader& log) : log_(log) {}

  Result<std::unique_ptr<hw::DatagramLink>> open_datagrams(const hw::Endpoint& /*local*/) override { return refuse(); }
  Result<std::unique_ptr<hw::StreamListener>> listen(const hw::Endpoint& /*local*/) override { return refuse(); }
  Result<std::unique_ptr<hw::StreamLink>> connect(const hw::Endpoint& remote) override {
    const auto* connected = log_.expect<WireLog::Connected>();
    if (connected == nullptr) return refuse();
    EXPECT_EQ(connected->to, remote);
    return std::make_unique<ReplayedStream>(log_, connected_++, remote);
  }

 private:
  static std::unexpected<Diagnostics> refuse() { return failure(Code::kSystem, "", "not in the log", ""); }
  LogReader& log_;
  std::size_t connected_ = 0;
};

}  // namespace takt::test
