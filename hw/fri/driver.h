#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hw/fri/client.h"

namespace takt::hw::fri {

/// An arm behind FRI, as the core sees it; how time goes on is what its two kinds differ in.
class Backend : public device::ArmDriver {
 public:
  Backend(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<DatagramLink> link,
          const Clock& clock)
      : client_(request, options, std::move(link), clock), cycle_(options.cycle), core_period_(request.core_period) {}

  void set_held(bool held) override { client_.set_held(held); }
  bool read(device::ArmSample& sample) override { return client_.read(sample); }
  void write(const device::ArmSetPoint& set_point) override { client_.write(set_point); }
  void write_compliance(const device::Compliance& compliance) override { client_.write_compliance(compliance); }
  void change_mode(device::ControlMode mode) override { client_.change_mode(mode); }
  /// FRI carries no payload: KRL has its own. The tool is needed for poses.
  void set_payload(const device::PayloadSetting& /*payload*/) override {}
  void set_tool(const device::ToolSetting& tool) override { client_.set_tool(tool); }
  void brake() override { client_.brake(); }
  void reset() override { client_.reset(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return Client::fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override {
    const device::AgentTiming& agent = client_.timing();
    return {.cycle = cycle_,
            .sample_age = cycle_ + wire_time_ + core_period_,
            .driver_delay = agent.driver_delay(),
            .dead_time = agent.dead_time()};
  }
  [[nodiscard]] device::ConnectionCounts connection() const override {
    const device::AgentReport& report = client_.agent().report();
    return {report.samples, report.dry, report.drift};
  }
  [[nodiscard]] std::vector<std::string> news() override { return client_.news(); }
  [[nodiscard]] device::ForceTorqueBackend* force_torque() override { return &wrench_; }
  [[nodiscard]] std::optional<Nanoseconds> packet_time() const override { return client_.agent().report().packet_time; }

  [[nodiscard]] const Client& client() const { return client_; }

 protected:
  Client client_;
  Nanoseconds cycle_, core_period_;
  Nanoseconds wire_time_ = 0;  ///< that a datagram takes at most

 private:
  /// The controller's estimate of the wrench at the tool.
  struct WrenchBackend final : device::ForceTorqueBackend {
    explicit WrenchBackend(Backend& owner) : arm(owner) {}
    bool read(device::WrenchSample& sample) override { return arm.client_.read_wrench(sample); }
    [[nodiscard]] device::BackendTiming timing() const override { return arm.timing(); }
    Backend& arm;
  };
  WrenchBackend wrench_{*this};
};

/// The driver on a machine's network: a thread answers the controller. Whoever destroys it should have stopped the arm;
/// the destructor asks KRL for monitor state and waits up to half a second for it.
class Driver final : public Backend {
 public:
  /// @param priority  of SCHED_FIFO, where permitted; 0: leave the scheduling alone
  Driver(const device::DriverRequest& request, const ClientOptions& options, std::unique_ptr<DatagramLink> link,
         const Clock& clock, int priority = 85);
  ~Driver() override { thread_ = {}; }
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

 private:
  void serve(const std::stop_token& stop, int priority);
  std::jthread thread_;
};

}  // namespace takt::hw::fri
