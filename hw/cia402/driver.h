#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hw/cia402/client.h"

namespace takt::hw::cia402 {

/// An arm of drives on a field bus, as the core sees it; how time goes on is what its two kinds differ in.
class Backend : public device::ArmDriver {
 public:
  Backend(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<FieldBus> bus,
          const Clock& clock)
      : client_(request, options, std::move(bus), clock), cycle_(options.cycle), core_period_(request.core_period) {}

  void set_held(bool held) override { client_.set_held(held); }
  bool read(device::ArmSample& sample) override { return client_.read(sample); }
  void write(const device::ArmSetPoint& set_point) override { client_.write(set_point); }
  /// Drives have no payload: what they carry is the business of their own loops.
  void set_payload(const device::PayloadSetting& /*payload*/) override {}
  void brake() override { client_.brake(); }
  void reset() override { client_.reset(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return client_.fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override {
    const device::AgentTiming& agent = client_.timing();
    return {.cycle = cycle_,
            .sample_age = cycle_ + bus_time_ + core_period_,
            .driver_delay = agent.driver_delay(),
            .dead_time = agent.dead_time()};
  }
  [[nodiscard]] device::ConnectionCounts connection() const override {
    const device::AgentReport& report = client_.agent().report();
    return {report.samples, report.dry, report.drift};
  }
  [[nodiscard]] std::vector<std::string> news() override { return client_.news(); }
  [[nodiscard]] std::string refusal() const override { return client_.refusal(); }
  [[nodiscard]] Client& client() { return client_; }

 protected:
  Client client_;
  Nanoseconds cycle_, core_period_;
  Nanoseconds bus_time_ = kMillisecond;  ///< from SYNC until all inputs are there, at most
};

/// The driver on the machine's network: a thread keeps the cycle of the bus. The destructor stops the drives by their
/// quick stop and waits up to half a second for it.
class Driver final : public Backend {
 public:
  /// @param priority  of SCHED_FIFO, where permitted; 0: leave the scheduling alone
  Driver(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<FieldBus> bus,
         const Clock& clock, int priority = 85);
  ~Driver() override { thread_ = {}; }
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

 private:
  void serve(const std::stop_token& stop, int priority);
  void pass_cycle(Nanoseconds& begins);
  std::jthread thread_;
};

}  // namespace takt::hw::cia402
