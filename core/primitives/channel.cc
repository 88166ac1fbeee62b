// Family "channel": values into and out of running nets, and from one to another (row O5).
#include "core/device/channel.h"

#include <fmt/format.h>

#include "core/kinematics/pose_error.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "core/primitives/payload_types.h"

namespace takt::primitives {
namespace {

using namespace net;
using device::Channel;
using device::ChannelDescription;

template <class T>
class Input final : public Primitive {
 public:
  explicit Input(Setup& setup)
      : value_(setup.out<T>("value", {.unit = free_unit<T>(),
                                      .frame = free_frame<T>(),
                                      .doc = "the channel's value of this cycle; null before the first without an "
                                             "initial one, and when it is older than the channel allows",
                                      .may_be_null = true})),
        age_(setup.out<Real>("age", {.unit = "s",
                                     .doc = "since the cycle in which the value came or was written; null before",
                                     .may_be_null = true})),
        channel_(setup.device<Channel>("channel", Channel::kind_of(kValueType<T>), "the channel that is read")) {}

  void update(const Cycle&) override {
    const Slot<T>& slot = channel_->template slot<T>();
    if (slot.null != 0) {
      value_.set_null();
    } else {
      value_.set(slot.value);
    }
    const auto age = channel_->age();
    if (!age) return age_.set_null();
    age_.set(to_seconds(*age));
  }

 private:
  Out<T> value_;
  Out<Real> age_;
  const Channel* channel_;
};

template <class T>
class Output final : public Primitive {
 public:
  explicit Output(Setup& setup)
      : value_(setup.in<T>("value", {.unit = free_unit<T>(),
                                     .frame = free_frame<T>(),
                                     .doc = "value to write; null is written as null",
                                     .on_null = OnNull::kHandled})),
        channel_(setup.device<Channel>("channel", Channel::kind_of(kValueType<T>), "the channel that is written")) {
    setup.claims("channel");
  }

  Diagnostics prepare() override {
    Diagnostics diagnostics;
    if (channel_->description().writer != ChannelDescription::Writer::kNet) {
      diagnostics.error(Code::kInvalidValue, "/channel",
                        fmt::format("'{}' is written from outside, not by nets", channel_->name()),
                        "Declare the channel with writer \"net\"");
    }
    return diagnostics;
  }

  void update(const Cycle&) override { channel_->put(value_); }

 private:
  In<T> value_;
  Channel* channel_;
};

class FrameChannelTwist final : public Primitive {
 public:
  explicit FrameChannelTwist(Setup& setup)
      : twist_(setup.out<Twist>(
            "twist", {.unit = "m/s,rad/s",
                      .frame = "A",
                      .doc = "of the frame's origin, in the axes in which the poses are given; null until two values "
                             "came, while one of them is null, and while they are older than age_max",
                      .may_be_null = true})),
        channel_(setup.device<Channel>("channel", Channel::kind_of(ValueType::kFrame), "the channel that is read")),
        age_max_(setup.parameter<Real>(
            "age_max", {.unit = "s",
                        .doc = "of the newest value, and between the two; longer says nothing about now",
                        .range = "(0,1e6]",
                        .example = "0.1"})) {}

  void update(const Cycle&) override {
    const Slot<Frame>&now = channel_->slot<Frame>(), &before = channel_->previous<Frame>();
    const double interval = to_seconds(channel_->interval());
    const auto age = channel_->age();
    const bool known = now.null == 0 && before.null == 0 && age && interval > 0.0;
    if (!known || interval > age_max_ || to_seconds(*age) > age_max_) return twist_.set_null();
    const kinematics::Vector6 way = kinematics::pose_error(before.value, now.value);
    twist_.set(Twist{.linear = way.head<3>() / interval, .angular = way.tail<3>() / interval});
  }

 private:
  Out<Twist> twist_;
  const Channel* channel_;
  double age_max_;
};

TAKT_PRIMITIVE(
    FrameChannelTwist, "channel",
    "How fast moves what a channel of poses places: from its last two values and the time between the cycles "
    "in which they came, so a channel that is slower than the cycle gives no peaks. It is the mean over "
    "that time, half of it late. The first cycle is like any other.");
TAKT_PRIMITIVE_FOR_ALL(Input, "channel",
                       "Reads a channel: the newest value from outside, or what another net wrote in the cycle before. "
                       "The first cycle is like any other.");
TAKT_PRIMITIVE_FOR_ALL(Output, "channel",
                       "Writes a channel, which the net then holds alone; all nets read the value in the next cycle. "
                       "While its fragment rests, nothing is written and the value ages.");

}  // namespace
}  // namespace takt::primitives
