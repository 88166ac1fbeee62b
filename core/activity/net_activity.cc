#include "core/activity/net_activity.h"

#include <utility>
#include <vector>

#include "core/device/device.h"
#include "core/net/compiled_net.h"

namespace takt::activity {
namespace {

class NetActivity final : public ActivityModel {
 public:
  NetActivity(const std::string& name, std::vector<std::string> actuators,
              std::shared_ptr<const net::NetDescription> net)
      : ActivityModel(name), actuators_(std::move(actuators)), net_(std::move(net)) {}

  [[nodiscard]] std::vector<std::string> actuators() const override { return actuators_; }

  [[nodiscard]] Result<PlannedActivity> prepare(const PlanningContext&) const override {
    PlannedActivity prepared;
    for (const std::string& actuator : actuators_) prepared.end_states[actuator] = {};
    prepared.touching = {actuators_.begin(), actuators_.end()};  // what it means to do only its author knows
    prepared.net = net_;
    return prepared;
  }

 private:
  std::vector<std::string> actuators_;
  std::shared_ptr<const net::NetDescription> net_;
};

std::vector<std::string> claims_of(const net::NetDescription& description, net::Environment& devices) {
  std::vector<std::string> names;
  const auto net = net::CompiledNet::compile(description, devices);
  if (!net) return names;
  for (const net::Resource* claim : (*net)->claims()) {
    const auto* device = dynamic_cast<const device::Device*>(claim);
    if (device != nullptr) names.push_back(device->name());
  }
  return names;
}

}  // namespace

ActivityPtr net_activity(const std::string& name, std::shared_ptr<const net::NetDescription> net,
                         net::Environment& devices) {
  auto actuators = claims_of(*net, devices);
  return std::make_shared<const NetActivity>(name, std::move(actuators), std::move(net));
}

}  // namespace takt::activity
