#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/device/driver.h"
#include "hw/modbus/map.h"
#include "hw/modbus/protocol/frame.h"
#include "hw/wire/byte_link.h"
#include "hw/wire/network.h"

namespace takt::hw::modbus {

/// Settings of a coupler.
struct CouplerOptions {
  MapOptions map;
  /// With so long no request from anybody, its outputs go to 0 until they are written again; 0: never.
  Nanoseconds watchdog = kSecond;
};

/// A bus coupler with terminals on Modbus TCP, around terminals that do what they are told. One thread.
class Coupler final : public device::ControllerEmulator {
 public:
  static constexpr std::size_t kMostClients = 20;

  /// @param network  outlives the coupler @param machine  all terminals of the description
  Coupler(const CouplerOptions& options, std::shared_ptr<const device::IoDescription> description, Network& network,
          device::IoTerminals machine);
  /// Opens the port. Realtime: setup.
  [[nodiscard]] Result<void> listen(const Endpoint& local);

  void advance(Nanoseconds now) override;
  /// Reads the inputs, writes the outputs.
  void look(Nanoseconds now);
  /// Accepts clients and answers what they have sent.
  void serve(Nanoseconds now);
  [[nodiscard]] std::vector<std::string> news() override;

  /// Cuts all clients off, as a coupler does that restarts; outputs go to 0.
  void restart();
  [[nodiscard]] std::size_t clients() const { return clients_.size(); }
  [[nodiscard]] bool watchdog_expired() const { return expired_; }
  [[nodiscard]] const std::vector<std::uint16_t>& coils() const { return coils_; }
  [[nodiscard]] const std::vector<std::uint16_t>& holding_registers() const { return holding_registers_; }
  /// The answer to a request.
  [[nodiscard]] std::string answer(std::string_view pdu);

 private:
  struct Client {
    ByteLink link;
    FrameParser parser;
  };
  void serve(Client& client, Nanoseconds now);
  [[nodiscard]] bool is_own(std::uint8_t unit) const;
  void clear_outputs();
  [[nodiscard]] std::vector<std::uint16_t>& table_of(Function function);
  [[nodiscard]] std::uint16_t first_of(Function function) const;

  CouplerOptions options_;
  std::shared_ptr<const device::IoDescription> description_;
  TerminalMap map_;
  Network& network_;
  device::IoTerminals machine_;
  std::unique_ptr<StreamListener> listener_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<std::uint16_t> coils_, discrete_inputs_, input_registers_, holding_registers_;
  Nanoseconds heard_at_ = 0;
  bool heard_ = false, expired_ = false;
  std::vector<std::string> news_;
};

}  // namespace takt::hw::modbus
