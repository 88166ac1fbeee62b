#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <vector>

#include "core/base/clock.h"
#include "core/base/random.h"
#include "hw/wire/stream_link.h"

namespace takt::hw {

/// When what is sent now arrives, and in which pieces: what all streams of a virtual network share.
struct VirtualStreamTiming {
  const Clock* clock = nullptr;
  Random random{0};
  Nanoseconds transport = 0, jitter = 0;
  std::size_t piece = 0;  ///< longest, bytes; 0: as sent
  bool cut = false;

  [[nodiscard]] Nanoseconds now() const { return clock->read().machine; }
  [[nodiscard]] Nanoseconds arrival() {
    return now() + transport + static_cast<Nanoseconds>(random.unit() * static_cast<double>(jitter));
  }
};

/// One direction of a virtual stream. Bytes keep their order; the sender may have kWindow bytes on their way.
class VirtualPipe {
 public:
  static constexpr std::size_t kWindow = 65'536;
  static constexpr Nanoseconds kNever = std::numeric_limits<Nanoseconds>::max();

  explicit VirtualPipe(std::shared_ptr<VirtualStreamTiming> timing) : timing_(std::move(timing)) {}

  std::size_t send(std::span<const std::byte> bytes);
  std::size_t receive(std::span<std::byte> buffer);
  /// The sender sends no more.
  void end();
  /// The receiver is gone: nothing more is accepted.
  void abandon() { abandoned_ = true; }
  /// The cable is plugged in again: what waited leaves now.
  void release();

  [[nodiscard]] bool abandoned() const { return abandoned_; }
  [[nodiscard]] bool readable() const { return !pieces_.empty() && pieces_.front().arrival <= timing_->now(); }
  /// All has been received, and the end has arrived.
  [[nodiscard]] bool ended() const { return pieces_.empty() && end_ <= timing_->now(); }
  [[nodiscard]] Nanoseconds next_arrival() const;

 private:
  struct Piece {
    std::vector<std::byte> bytes;
    Nanoseconds arrival = 0;
  };
  void place(std::span<const std::byte> bytes);
  /// Not before what was sent before; never while the cable is cut.
  [[nodiscard]] Nanoseconds next_slot();

  std::shared_ptr<VirtualStreamTiming> timing_;
  std::deque<Piece> pieces_;
  std::size_t size_ = 0;  // of all pieces
  Nanoseconds last_arrival_ = 0;
  Nanoseconds end_ = kNever;
  bool ending_ = false, abandoned_ = false;
};

/// One end of a virtual stream.
class VirtualStream final : public StreamLink {
 public:
  /// @param opens  when the connection is there @param refused  nobody listens: it fails then
  VirtualStream(std::shared_ptr<VirtualStreamTiming> timing, std::shared_ptr<VirtualPipe> in,
                std::shared_ptr<VirtualPipe> out, const Endpoint& local, const Endpoint& remote, Nanoseconds opens,
                bool refused);
  ~VirtualStream() override { close(); }
  VirtualStream(const VirtualStream&) = delete;
  VirtualStream& operator=(const VirtualStream&) = delete;

  State state() override;
  std::size_t send(std::span<const std::byte> bytes) override;
  std::size_t receive(std::span<std::byte> buffer) override;
  bool wait(Nanoseconds timeout) override;
  void close() override;
  [[nodiscard]] Endpoint local() const override { return local_; }
  [[nodiscard]] Endpoint remote() const override { return remote_; }
  [[nodiscard]] std::string error() const override { return error_; }

 private:
  std::shared_ptr<VirtualStreamTiming> timing_;
  std::shared_ptr<VirtualPipe> in_, out_;
  Endpoint local_, remote_;
  Nanoseconds opens_;
  bool refused_;
  State state_ = State::kConnecting;
  std::string error_;
};

}  // namespace takt::hw
