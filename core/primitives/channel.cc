// Family "channel": values into and out of running nets, and from one to another (row O5).
#include "core/device/channel.h"

#include <fmt/format.h>

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
                                     .doc = "what is written; null is written as null",
                                     .on_null = OnNull::kHandled})),
        channel_(setup.device<Channel>("channel", Channel::kind_of(kValueType<T>), "the channel that is written")) {
    setup.claims("channel");
  }

  Findings prepare() override {
    Findings findings;
    if (channel_->description().writer != ChannelDescription::Writer::kNet) {
      findings.error("/channel", fmt::format("'{}' is written from outside, not by nets", channel_->name()),
                     "a channel that is declared with writer \"net\"");
    }
    return findings;
  }

  void update(const Cycle&) override { channel_->put(value_); }

 private:
  In<T> value_;
  Channel* channel_;
};

TAKT_PRIMITIVE_FOR_ALL(Input, "channel",
                       "Reads a channel: the newest value from outside, or what another net wrote in the cycle before. "
                       "The first cycle is like any other.");
TAKT_PRIMITIVE_FOR_ALL(Output, "channel",
                       "Writes a channel, which the net then holds alone; all nets read the value in the next cycle. "
                       "While its fragment rests, nothing is written and the value ages.");

}  // namespace
}  // namespace takt::primitives
