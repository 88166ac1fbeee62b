#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/device/driver.h"
#include "core/emulation/state_hash.h"
#include "hw/io/image.h"
#include "hw/modbus/map.h"
#include "hw/modbus/protocol/frame.h"
#include "hw/wire/byte_link.h"

namespace takt::hw::modbus {

/// How a coupler is reached.
struct ClientOptions {
  Endpoint remote{kLoopback, kPort};
  MapOptions map;
  Nanoseconds cycle = 10 * kMillisecond;     ///< from one exchange to the next
  Nanoseconds timeout = 200 * kMillisecond;  ///< for an answer; then the connection is taken to be broken
};

/// Causes of a block that is not ready (InputImage::fault).
enum class Fault : std::uint32_t { kNone = 0, kNotConnected = 0x4D42'0001, kStarting, kRefused, kInterrupted, kLost };

/// What was measured of a driver; counters only grow.
struct ClientCounts {
  std::uint64_t exchanges = 0;  ///< that were complete
  std::uint64_t connections = 0;
  std::uint64_t strange = 0;  ///< answers to nothing that was asked
};

/// The driver of an I/O block on Modbus TCP, without its thread: in each cycle it writes all outputs and reads all
/// inputs, one request at a time. After a connection that broke the coupler may have switched its outputs off: they are
/// not written again before reset(). poll() is called by one thread.
class Client {
 public:
  /// @param image, network, clock  outlive the client
  Client(const ClientOptions& options, const device::IoRequest& request, CycleImage& image, Network& network,
         const Clock& clock);

  // -- Any thread ----------------------------------------------------------------------------------------------------
  void reset() { reset_ = true; }
  [[nodiscard]] static std::string fault_text(std::uint32_t fault);
  [[nodiscard]] std::vector<std::string> news();
  /// As of DeviceDriver.
  [[nodiscard]] std::string refusal() const;

  // -- The driver's thread -------------------------------------------------------------------------------------------
  void poll();
  /// Until something comes, at most `timeout` ns.
  void wait(Nanoseconds timeout) { (void)link_.wait(timeout); }
  [[nodiscard]] bool connected() const { return link_.open(); }
  /// When poll() has something to do though nothing comes, on the core's clock.
  [[nodiscard]] Nanoseconds next_due() const { return asked_ < requests_.size() ? due_ + options_.timeout : due_; }
  [[nodiscard]] const ClientCounts& counts() const { return counts_; }
  void add_state(emulation::StateHash& hash) const;

 private:
  void keep_connected(Nanoseconds now);
  void lose(Nanoseconds now, const std::string& why);
  void begin_exchange(Nanoseconds now);
  void ask(Nanoseconds now);
  void handle(const Frame& frame, Nanoseconds now);
  void take(const Request& request);
  void complete(Nanoseconds now);
  void publish();
  [[nodiscard]] Fault fault() const;
  void tell(std::string line);
  /// Tells it, and keeps it until the device is tried again; empty: it is.
  void keep_refusal(std::string why);

  ClientOptions options_;
  std::shared_ptr<const device::IoDescription> description_;
  TerminalMap map_;
  CycleImage& image_;
  Network& network_;
  const Clock& clock_;

  std::atomic<bool> reset_ = false;
  mutable std::mutex news_mutex_;  // of news_ and refusal_ alone: the cycle never takes it
  std::vector<std::string> news_;
  std::string refusal_;

  ByteLink link_;
  FrameParser parser_;
  bool open_ = false;  // and said so
  Nanoseconds next_try_ = 0;
  Nanoseconds due_ = 0;            // of the next exchange; of the request that was sent last
  std::vector<Request> requests_;  // of an exchange
  std::size_t asked_ = 0;          // the request that waits for its answer; requests_.size(): none does
  std::uint16_t transaction_ = 0;
  std::vector<std::uint16_t> values_;
  Nanoseconds began_ = 0, inputs_asked_ = 0;
  bool complete_ = false;     // one exchange was, in this connection
  bool interrupted_ = false;  // a connection broke since the last reset
  bool refused_ = false;
  InputImage inputs_;
  ClientCounts counts_;
};

}  // namespace takt::hw::modbus
