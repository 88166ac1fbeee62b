#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hw/wire/network.h"

namespace takt::hw::rtde {

/// The program of the URCap "External Control": when it is played, the controller asks a client on another machine for
/// its text. Nothing waits. One thread. Realtime: setup.
class ExternalControl {
 public:
  static constexpr std::string_view kPath = "/programs/external_control.urp";

  /// @param network  outlives it; null: nothing can be asked @param client  of the installation; null: there is none
  ExternalControl(hw::Network* network, const std::optional<hw::Endpoint>& client)
      : network_(network), client_(client) {}

  /// There is such a program.
  [[nodiscard]] bool installed() const { return client_.has_value(); }
  /// Asks for the text, in place of one that was asked for before. @return false: no connection can be begun
  bool begin(Nanoseconds now);
  void cancel() { link_.reset(); }
  /// Once in each frame. @return once for each begin() that is not cancelled: the whole program, or why there is none
  [[nodiscard]] std::optional<Result<std::string>> poll(Nanoseconds now);

 private:
  [[nodiscard]] Result<std::string> failed(std::string_view why);
  void exchange();

  hw::Network* network_;
  std::optional<hw::Endpoint> client_;
  std::unique_ptr<hw::StreamLink> link_;
  std::string out_, body_;
  Nanoseconds deadline_ = 0;
};

}  // namespace takt::hw::rtde
