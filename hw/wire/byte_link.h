#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hw/wire/network.h"

namespace takt::hw {

/// A connection of a byte stream with what waits to be sent. One thread.
class ByteLink {
 public:
  using State = StreamLink::State;

  ByteLink() = default;
  /// Of a connection that was accepted.
  explicit ByteLink(std::unique_ptr<StreamLink> link) : link_(std::move(link)) {}

  /// @return why it cannot even be tried.
  [[nodiscard]] Result<void> connect(Network& network, const Endpoint& remote) {
    auto link = network.connect(remote);
    if (!link) return std::unexpected(link.error());
    link_ = std::move(*link);
    out_.clear();
    return {};
  }
  void close() { link_.reset(); }
  [[nodiscard]] State state() const { return link_ == nullptr ? State::kFailed : link_->state(); }
  [[nodiscard]] bool open() const { return state() == State::kOpen; }
  [[nodiscard]] std::string error() const { return link_ == nullptr ? "not connected" : link_->error(); }
  [[nodiscard]] bool wait(Nanoseconds timeout) { return link_ != nullptr && link_->wait(timeout); }

  void send(std::string_view bytes) {
    out_.append(bytes);
    flush();
  }
  void flush() {
    if (link_ != nullptr && !out_.empty()) out_.erase(0, link_->send(std::as_bytes(std::span(out_))));
  }
  /// Bytes that the other end has not taken yet.
  [[nodiscard]] std::size_t waiting() const { return out_.size(); }
  /// Calls with each piece that has come.
  template <class Take>
  void receive(const Take& take) {
    if (link_ == nullptr) return;
    for (int i = 0; i < kMostPieces; ++i) {
      const std::size_t count = link_->receive(buffer_);
      if (count == 0) return;
      take(std::string_view(reinterpret_cast<const char*>(buffer_.data()), count));
    }
  }

 private:
  static constexpr int kMostPieces = 64;

  std::unique_ptr<StreamLink> link_;
  std::string out_;
  std::array<std::byte, 4096> buffer_;
};

}  // namespace takt::hw
