// Fault "push": somebody pushes a body.
#include <fmt/format.h>

#include "cell/faults/fault_kinds.h"

namespace takt::cell {
namespace {

class PushFault final : public Fault {
 public:
  explicit PushFault(FaultReader& from) : body_(from.text("body")), force_(from.vector("force_N")) {
    duration = from.duration(1.0);
    if (!body_.empty() && from.built.world->body(body_) < 0)
      from.diagnostics().error(Code::kUnknownName, from.at("body"), fmt::format("there is no body '{}'", body_),
                               "Name DEVICE/LINK with a link of its model, or an object that moves");
  }
  void begin(FaultScene& scene) override {
    scene.note("push", fmt::format("{} with {:g}, {:g}, {:g} N", body_, force_.x(), force_.y(), force_.z()));
    scene.pushes.add(this, scene.built.world->body(body_), force_);
  }
  void end(FaultScene& scene) override { scene.pushes.remove(this); }

 private:
  std::string body_;
  Eigen::Vector3d force_;  ///< at the centre of mass, in the world, N
};

}  // namespace

FaultKind push_fault() {
  return fault_kind<PushFault>(
      "push", Concerns::kMachine,
      {"A person pushes a body.",
       {text_key("body",
                 "DEVICE/LINK with a link of its model (arm/link7; wrist/measuring is the tool side of a "
                 "sensor), or an object that is not fixed.",
                 1),
        vector_key("force_N", "N", "Force on the centre of mass in world axes (pushes at the same time add up)."),
        duration_key("1")}});
}

}  // namespace takt::cell
