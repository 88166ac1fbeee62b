#include "core/device/signal.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/allocation_guard.h"
#include "tests/support/fake_signals.h"

namespace takt::device {
namespace {

using test::FakeInput;
using test::FakeOutput;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

template <class T>
struct Input {
  std::shared_ptr<FakeInput<T>> backend = std::make_shared<FakeInput<T>>();
  SignalInput<T> device{"in", {.unit = "V", .sample_age_max = 5 * kMillisecond}, backend};
};

TEST(SignalInput, GivesTheNewestSampleAndItsAge) {
  Input<bool> in;
  in.backend->sample = {.sequence = 0, .stamp = 2 * kMillisecond, .value = true};
  in.device.begin_cycle(4, 4 * kMillisecond);
  ASSERT_TRUE(in.device.has_sample());
  EXPECT_TRUE(in.device.sample().value);
  EXPECT_EQ(in.device.sample_age(), 2 * kMillisecond);
}

TEST(SignalInput, OldSilentAndNotFiniteIsNoSample) {
  Input<double> in;
  in.backend->sample.value = 1.0;
  in.device.begin_cycle(5, 5 * kMillisecond);
  EXPECT_TRUE(in.device.has_sample());
  in.device.begin_cycle(6, 6 * kMillisecond);
  EXPECT_FALSE(in.device.has_sample()) << "older than sample_age_max";
  in.backend->sample.stamp = 6 * kMillisecond;
  for (const double nothing : {kInfinite, -kInfinite, std::nan("")}) {
    in.backend->sample.value = nothing;
    in.device.begin_cycle(6, 6 * kMillisecond);
    EXPECT_FALSE(in.device.has_sample());
  }
  in.backend->sample.value = 1.0;
  in.backend->silent = true;
  in.device.begin_cycle(6, 6 * kMillisecond);
  EXPECT_FALSE(in.device.has_sample());
}

/// One output and its cycle: propose, check, hand over.
template <class T>
struct Output {
  explicit Output(SignalOutputDescription<T> description) : device("out", description, backend, kMillisecond) {}

  /// @return why the guard tripped, or an empty text
  std::string cycle(std::optional<T> value = {}) {
    device.begin_cycle(k, k * kMillisecond);
    ++k;
    if (value) device.propose(*value);
    const auto trip = device.check();
    device.hand_over();
    return trip ? std::string(trip->view()) : std::string();
  }

  std::shared_ptr<FakeOutput<T>> backend = std::make_shared<FakeOutput<T>>();
  SignalOutput<T> device;
  std::int64_t k = 0;
};

TEST(SignalOutput, KeepsItsValueBetweenAndAfterNets) {
  Output<bool> out({.initial = true});
  out.cycle();
  out.device.hold();
  EXPECT_TRUE(out.device.held());
  out.cycle(false);
  out.cycle();
  out.device.release();
  out.cycle();
  EXPECT_THAT(out.backend->written, ElementsAre(true, false, false, false));
  EXPECT_TRUE(out.device.at_rest());
}

TEST(SignalOutput, StopReactionHoldsOrGoesToItsValue) {
  Output<bool> holds({});
  Output<bool> off({.stop = false});
  for (auto* out : {&holds, &off}) {
    out->cycle();
    out->device.hold();
    out->cycle(true);
    out->device.propose(true);
    out->device.stop();
    out->cycle();
    EXPECT_FALSE(out->device.held());
  }
  EXPECT_THAT(holds.backend->written, ElementsAre(false, true, true));
  EXPECT_THAT(off.backend->written, ElementsAre(false, true, false));
  EXPECT_FALSE(holds.device.stops_in_emergency());
  EXPECT_TRUE(off.device.stops_in_emergency());
}

TEST(SignalOutput, WhatIsProposedInTheCycleOfAStopIsNotSent) {
  Output<bool> out({});
  out.device.begin_cycle(0, 0);
  out.device.hold();
  out.device.propose(true);
  out.device.stop();
  (void)out.device.check();
  out.device.hand_over();
  EXPECT_THAT(out.backend->written, ElementsAre(false));
}

TEST(SignalOutput, GuardRefusesAndNeverClamps) {
  Output<double> out({.unit = "V", .initial = 1.0, .lower = 0.0, .upper = 10.0, .rate_max = 1000.0});
  out.cycle();
  const std::pair<double, const char*> wrong[] = {{std::nan(""), "not finite"},
                                                  {kInfinite, "not finite"},
                                                  {-0.1, "outside [0, 10] V"},
                                                  {10.1, "outside"},
                                                  {2.1, "step of 1.1 V beyond 1 a cycle"}};
  for (const auto& [value, text] : wrong) {
    out.device.hold();
    EXPECT_THAT(out.cycle(value), HasSubstr(text));
    EXPECT_EQ(out.backend->written.back(), 1.0) << "the value before stays";
    EXPECT_FALSE(out.device.held());
  }
  out.device.hold();
  EXPECT_EQ(out.cycle(2.0), "") << "a step of the whole rate is right";
  EXPECT_EQ(out.backend->written.back(), 2.0);
}

TEST(SignalOutput, AnalogStopKeepsItsRate) {
  Output<double> out({.initial = 2.5, .stop = 0.0, .rate_max = 1000.0});
  out.cycle();
  out.device.hold();
  out.device.stop();
  EXPECT_FALSE(out.device.at_rest());
  out.cycle();
  EXPECT_TRUE(out.device.refusal().has_value()) << "no net may take it while it moves";
  out.cycle();
  out.cycle();
  EXPECT_TRUE(out.device.at_rest());
  EXPECT_FALSE(out.device.refusal().has_value());
  out.cycle();
  EXPECT_THAT(out.backend->written, ElementsAre(2.5, 1.5, 0.5, 0.0, 0.0));
}

TEST(SignalOutput, NotReadyIsLostAndSendsNothing) {
  Output<bool> out({});
  out.backend->is_ready = false;
  out.cycle();
  EXPECT_TRUE(out.device.lost());
  EXPECT_TRUE(out.device.refusal().has_value());
  EXPECT_TRUE(out.backend->written.empty());
}

TEST(SignalOutput, StateWordsTellEveryBit) {
  Output<double> a({.initial = 1.0}), b({.initial = std::nextafter(1.0, 2.0)});
  StateWords words_a, words_b;
  a.device.add_state(words_a);
  b.device.add_state(words_b);
  EXPECT_FALSE(std::ranges::equal(words_a.bytes(), words_b.bytes()));
}

}  // namespace
}  // namespace takt::device
