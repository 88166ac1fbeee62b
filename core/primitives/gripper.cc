// Family "device": the canonical gripper.
#include "core/device/gripper.h"

#include "core/net/format_text.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;
using device::Gripper;

class GripperCommand final : public Primitive {
 public:
  explicit GripperCommand(Setup& setup)
      : width_(setup.in<Real>("width", {.unit = "m", .doc = "where the fingers go", .on_null = OnNull::kStop})),
        speed_(setup.in<Real>("speed", {.unit = "m/s", .doc = "of the width, at most", .on_null = OnNull::kStop})),
        force_(
            setup.in<Real>("force", {.unit = "N", .doc = "sum over the fingers, at most", .on_null = OnNull::kStop})),
        gripper_(setup.device<Gripper>("device", Gripper::kKind, "the gripper that is driven")) {
    setup.claims("device");
  }

  void update(const Cycle& cycle) override {
    if (width_.null() || speed_.null() || force_.null()) {
      const Text text = format_text("{}: the command is null", gripper_->name());
      return cycle.signals->fail_with(Cause::Code::kNullInput, text.view(), cycle.index);
    }
    gripper_->propose(*width_, *speed_, *force_);
  }

 private:
  In<Real> width_, speed_, force_;
  Gripper* gripper_;
};

class GripperState final : public Primitive {
 public:
  explicit GripperState(Setup& setup)
      : width_(setup.out<Real>("width", {.unit = "m", .doc = "between the pads, measured", .may_be_null = true})),
        speed_(
            setup.out<Real>("speed", {.unit = "m/s", .doc = "of the width; opening is positive", .may_be_null = true})),
        force_(setup.out<Real>("force",
                               {.unit = "N", .doc = "sum over the fingers; closing is positive", .may_be_null = true})),
        moving_(
            setup.out<Boolean>("moving", {.doc = "moving, or the command is not answered yet", .may_be_null = true})),
        holding_(setup.out<Boolean>("holding", {.doc = "a part is held", .may_be_null = true})),
        lost_(setup.out<Boolean>("lost", {.doc = "the part that was held is gone", .may_be_null = true})),
        open_(setup.out<Boolean>("open", {.doc = "is at its largest width", .may_be_null = true})),
        closed_(setup.out<Boolean>("closed", {.doc = "is closed, with nothing between the pads", .may_be_null = true})),
        ready_(setup.out<Boolean>("ready", {.doc = "the gripper accepts commands; never null"})),
        age_(setup.out<Real>("age", {.unit = "s", .doc = "age of the sample", .may_be_null = true})),
        end_tolerance_(setup.parameter<Real>("end_tolerance", 0.001,
                                             {.unit = "m", .doc = "of open and closed", .range = "(0,inf)"})),
        gripper_(setup.device<Gripper>("device", Gripper::kKind, "the gripper that is read")) {}

  void update(const Cycle&) override {
    ready_.set(gripper_->ready());
    if (!gripper_->has_sample()) return set_null();
    const device::GripperSample& sample = gripper_->sample();
    width_.set(sample.width);
    speed_.set(sample.speed);
    force_.set(sample.force);
    // Before the answer the sample's state is that of the command before.
    const bool answered = gripper_->answered();
    const bool idle = answered && sample.state == device::GripperState::kIdle;
    moving_.set(!answered || sample.state == device::GripperState::kMoving);
    holding_.set(answered && sample.state == device::GripperState::kHolding);
    lost_.set(answered && sample.state == device::GripperState::kLost);
    open_.set(idle && sample.width >= gripper_->description().stroke - end_tolerance_);
    closed_.set(idle && sample.width <= end_tolerance_);
    age_.set(to_seconds(gripper_->sample_age()));
  }

 private:
  void set_null() {
    for (Out<Real>* port : {&width_, &speed_, &force_, &age_}) port->set_null();
    for (Out<Boolean>* port : {&moving_, &holding_, &lost_, &open_, &closed_}) port->set_null();
  }

  Out<Real> width_, speed_, force_;
  Out<Boolean> moving_, holding_, lost_, open_, closed_, ready_;
  Out<Real> age_;
  double end_tolerance_;
  Gripper* gripper_;
};

TAKT_PRIMITIVE(
    GripperCommand, "device",
    "Commands width, speed and force of a gripper, which the net then holds alone; the guard decides. The same "
    "command again changes nothing. Null at any input fails the net; the stop reaction keeps the grip.");
TAKT_PRIMITIVE(GripperState, "device",
               "The newest sample of a gripper. Null until the first sample and when the newest is older than the "
               "device allows.");

}  // namespace
}  // namespace takt::primitives
