#pragma once

#include <thread>

#include "hw/modbus/client.h"
#include "hw/wire/posix_network.h"

namespace takt::hw::modbus {

/// What a back end is made of, in the order in which it has to be made: the cycle's image before who serves it.
struct ImageOwner {
  ImageOwner(const device::IoDescription& io, std::function<void()> on_cycle) : image(io, std::move(on_cycle)) {}
  CycleImage image;
};

/// An I/O block as the core sees it; how time goes on is what its two kinds differ in.
class Backend : protected ImageOwner, public device::IoDriver {
 public:
  Backend(const ClientOptions& options, const device::IoRequest& request, Network& network, const Clock& clock,
          std::function<void()> on_cycle = {})
      : ImageOwner(*request.description, std::move(on_cycle)), client_(options, request, image, network, clock) {}

  [[nodiscard]] const device::IoTerminals& terminals() const override { return image.terminals(); }
  [[nodiscard]] bool ready() const override { return image.inputs().ready; }
  [[nodiscard]] std::string fault_text() const override {
    return image.inputs().sequence + image.inputs().fault > 0
               ? Client::fault_text(image.inputs().fault)
               : Client::fault_text(static_cast<std::uint32_t>(Fault::kNotConnected));
  }
  void reset() override { client_.reset(); }
  [[nodiscard]] std::string refusal() const override { return client_.refusal(); }
  [[nodiscard]] std::vector<std::string> news() override { return client_.news(); }
  [[nodiscard]] Client& client() { return client_; }

 protected:
  Client client_;
};

/// What the thread needs before the driver is made.
struct OwnNetwork {
  PosixNetwork posix;
};

/// The driver on the machine's network, with its thread. Outputs keep their last values when it ends, until the
/// coupler's watchdog switches them off.
class Driver final : private OwnNetwork, public Backend {
 public:
  Driver(const ClientOptions& options, const device::IoRequest& request, const Clock& clock);
  ~Driver() override;
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

 private:
  void serve(const std::stop_token& stop);
  const Clock& clock_;
  std::jthread thread_;
};

}  // namespace takt::hw::modbus
