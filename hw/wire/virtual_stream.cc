#include "hw/wire/virtual_stream.h"

#include <algorithm>
#include <utility>

namespace takt::hw {

std::size_t VirtualPipe::send(std::span<const std::byte> bytes) {
  bytes = bytes.first(std::min(bytes.size(), kWindow - size_));
  const std::size_t accepted = bytes.size();
  while (!bytes.empty()) {
    std::size_t size = bytes.size();
    if (timing_->piece > 0) size = std::min<std::size_t>(size, 1 + timing_->random.bits() % timing_->piece);
    place(bytes.first(size));
    bytes = bytes.subspan(size);
  }
  return accepted;
}

void VirtualPipe::place(std::span<const std::byte> bytes) {
  pieces_.push_back({{bytes.begin(), bytes.end()}, next_slot()});
  size_ += bytes.size();
}

Nanoseconds VirtualPipe::next_slot() {
  if (timing_->cut) return kNever;
  return last_arrival_ = std::max(last_arrival_, timing_->arrival());
}

std::size_t VirtualPipe::receive(std::span<std::byte> buffer) {
  std::size_t taken = 0;
  while (taken < buffer.size() && readable()) {
    std::vector<std::byte>& front = pieces_.front().bytes;
    const std::size_t size = std::min(front.size(), buffer.size() - taken);
    std::copy_n(front.begin(), size, buffer.begin() + static_cast<std::ptrdiff_t>(taken));
    front.erase(front.begin(), front.begin() + static_cast<std::ptrdiff_t>(size));
    if (front.empty()) pieces_.pop_front();
    taken += size;
  }
  size_ -= taken;
  return taken;
}

void VirtualPipe::end() {
  if (!std::exchange(ending_, true)) end_ = next_slot();
}

void VirtualPipe::release() {
  for (Piece& piece : pieces_)
    if (piece.arrival == kNever) piece.arrival = next_slot();
  if (ending_ && end_ == kNever) end_ = next_slot();
}

Nanoseconds VirtualPipe::next_arrival() const { return pieces_.empty() ? end_ : pieces_.front().arrival; }

VirtualStream::VirtualStream(std::shared_ptr<VirtualStreamTiming> timing, std::shared_ptr<VirtualPipe> in,
                             std::shared_ptr<VirtualPipe> out, const Endpoint& local, const Endpoint& remote,
                             Nanoseconds opens, bool refused)
    : timing_(std::move(timing)),
      in_(std::move(in)),
      out_(std::move(out)),
      local_(local),
      remote_(remote),
      opens_(opens),
      refused_(refused) {}

StreamLink::State VirtualStream::state() {
  if (state_ == State::kConnecting && timing_->now() >= opens_) {
    state_ = refused_ ? State::kFailed : State::kOpen;
    if (refused_) error_ = "Connection refused";
  }
  if (state_ == State::kOpen && in_->ended()) state_ = State::kEnded;
  return state_;
}

std::size_t VirtualStream::send(std::span<const std::byte> bytes) {
  if (state() != State::kOpen && state_ != State::kEnded) return 0;
  if (!out_->abandoned()) return out_->send(bytes);
  if (state_ == State::kOpen) return 0;  // what the peer sent before it closed is received first
  error_ = "Connection reset by peer";
  state_ = State::kFailed;
  return 0;
}

std::size_t VirtualStream::receive(std::span<std::byte> buffer) {
  return state() == State::kOpen ? in_->receive(buffer) : 0;
}

bool VirtualStream::wait(Nanoseconds) {
  const State before = state_;
  return state() != before || in_->readable();
}

void VirtualStream::close() {
  out_->end();
  in_->abandon();
  if (state_ == State::kFailed) return;
  error_ = "closed here";
  state_ = State::kFailed;
}

}  // namespace takt::hw
