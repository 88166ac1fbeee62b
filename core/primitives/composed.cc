// Family "device": composed devices.
#include <vector>

#include "core/device/composed_device.h"
#include "core/device/device.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;
using device::ComposedDevice;

class Reservation final : public Primitive {
 public:
  explicit Reservation(Setup& setup)
      : ready_(setup.out<Boolean>("ready", {.doc = "every part can be driven"})),
        whole_(setup.device<ComposedDevice>("device", ComposedDevice::kKind, "what is held")) {
    setup.claims("device");
  }

  Diagnostics prepare() override {
    for (const Resource* part : whole_->leaves())
      if (const auto* actuator = dynamic_cast<const device::Actuator*>(part)) actuators_.push_back(actuator);
    return {};
  }

  void update(const Cycle&) override {
    bool ready = true;
    for (const device::Actuator* actuator : actuators_) ready = ready && !actuator->lost();
    ready_.set(ready);
  }

 private:
  Out<Boolean> ready_;
  ComposedDevice* whole_;
  std::vector<const device::Actuator*> actuators_;
};

TAKT_PRIMITIVE(Reservation, "device",
               "Holds a composed device as a whole without driving it: while the net runs no other net may hold any of "
               "its parts, which stay as they are. The first cycle is like any other.");

}  // namespace
}  // namespace takt::primitives
