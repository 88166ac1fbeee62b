#pragma once

#include <thread>

#include "hw/wire/posix_network.h"
#include "hw/wsg/client.h"

namespace takt::hw::wsg {

/// A gripper as the core sees it; how time goes on is what its two kinds differ in.
class Backend : public device::GripperDriver {
 public:
  Backend(const ClientOptions& options, const device::GripperRequest& request, Network& network, const Clock& clock)
      : client_(options, request, network, clock) {}

  bool read(device::GripperSample& sample) override { return client_.read(sample); }
  void write(const device::GripperSetPoint& set_point) override { client_.write(set_point); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return Client::fault_text(fault); }
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

/// The driver on the machine's network, with its thread. The destructor says good-bye: the gripper keeps what it holds.
class Driver final : private OwnNetwork, public Backend {
 public:
  Driver(const ClientOptions& options, const device::GripperRequest& request, const Clock& clock);
  ~Driver() override;
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

 private:
  void serve(const std::stop_token& stop);
  std::jthread thread_;
};

}  // namespace takt::hw::wsg
