#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace takt::hw::rtde {

/// One client of one interface of an emulated controller, without its transport. One thread.
class Session {
 public:
  /// With more than this waiting to be sent a client does not read: what is periodic is left out, never queued.
  static constexpr std::size_t kBacklog = 1u << 14;

  virtual ~Session() = default;
  /// The client has sent this.
  virtual void receive(std::string_view bytes) = 0;
  /// A frame of the controller is over.
  virtual void end_frame() {}
  /// What is to be sent; whoever sends takes it from the front.
  std::string& out() { return out_; }
  /// The connection ends when all has been sent.
  [[nodiscard]] bool closing() const { return closing_; }

 protected:
  void close() { closing_ = true; }
  [[nodiscard]] bool reads() const { return out_.size() < kBacklog; }

 private:
  std::string out_;
  bool closing_ = false;
};

/// An interface of a controller: makes a session for each client.
class Service {
 public:
  virtual ~Service() = default;
  virtual std::unique_ptr<Session> open() = 0;
};

}  // namespace takt::hw::rtde
