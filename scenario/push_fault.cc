// Fault "push": somebody pushes a body.
#include <algorithm>

#include <fmt/format.h>

#include "scenario/cell_builder.h"
#include "scenario/fault.h"

namespace takt::scenario {
namespace {

class PushFault final : public Fault {
 public:
  PushFault() { duration = kSecond; }

  void add_to(BuiltCell& built, Diagnostics& diagnostics) const override {
    if (built.world->body(body) < 0)
      diagnostics.error(Code::kUnknownName, pointer + "/body", fmt::format("there is no body '{}'", body),
                        "DEVICE/LINK with a link of its model, or an object that moves");
  }
  void begin(FaultContext& context) const override {
    note(context, fmt::format("{} with {:g}, {:g}, {:g} N", body, force.x(), force.y(), force.z()));
    push(context);
  }
  void end(FaultContext& context) const override { push(context); }

  std::string body = {};                            ///< "DEVICE/LINK" or "OBJECT"
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< at its centre of mass, in the world, N

 private:
  /// What all that push the body exert on it.
  void push(FaultContext& context) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Fault* one : context.active) {
      const auto* other = dynamic_cast<const PushFault*>(one);
      if (other != nullptr && other->body == body) sum += other->force;
    }
    context.built.world->push(context.built.world->body(body), sum);
  }
};

const table::Table<PushFault>& push_table() {
  static const auto table = [] {
    table::Table<PushFault> push;
    push.named("body", table::NameOf::kBody, &PushFault::body,
               "Body: DEVICE/LINK with a link of its model (arm/link7; wrist/measuring is the tool side of a sensor), "
               "or an object that is not fixed.")
        .required()
        .vector("force_N", "N", &PushFault::force,
                "Force on the centre of mass in world axes; pushes at the same time add up.")
        .required()
        .value("seconds", table::seconds_type(kFaultDuration), &PushFault::duration, "Duration.")
        .fallback("1");
    return push;
  }();
  return table;
}

}  // namespace

FaultKind push_fault() { return fault_kind<PushFault, push_table>("push", "A person pushes a body."); }

}  // namespace takt::scenario
