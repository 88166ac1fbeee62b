#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/device/channel.h"
#include "core/device/device.h"
#include "core/net/primitive.h"
#include "core/rcc/net_state.h"

namespace takt::rcc {

/// What nets can hold, each by one net at a time. Places are fixed before the first step.
class ResourceTable {
 public:
  struct Place {
    net::Resource* resource = nullptr;
    std::string name;
    device::Actuator* actuator = nullptr;  ///< the same, if it is driven
    device::Channel* channel = nullptr;    ///< the same, if it is a channel
    NetId owner = 0;                       ///< 0: free
  };

  /// Realtime: setup.
  int add(std::string name, net::Resource& resource) {
    places_.push_back({.resource = &resource,
                       .name = std::move(name),
                       .actuator = dynamic_cast<device::Actuator*>(&resource),
                       .channel = dynamic_cast<device::Channel*>(&resource)});
    return static_cast<int>(places_.size()) - 1;
  }
  [[nodiscard]] int place_of(const net::Resource* resource) const {
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (places_[i].resource == resource) return static_cast<int>(i);
    return -1;
  }
  [[nodiscard]] Place& operator[](int place) { return places_[static_cast<std::size_t>(place)]; }
  [[nodiscard]] const Place& at(int place) const { return places_[static_cast<std::size_t>(place)]; }
  [[nodiscard]] std::vector<Place>& all() { return places_; }

 private:
  std::vector<Place> places_;
};

}  // namespace takt::rcc
