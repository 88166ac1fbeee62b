// Family "path": the path clock and the time law that it drives (rows P1, P2).
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/motion/path_clock.h"
#include "core/motion/time_law.h"
#include "core/net/registry.h"
#include "core/net/setup.h"

namespace takt::primitives {
namespace {

using namespace net;

class PathClock final : public Primitive {
 public:
  explicit PathClock(Setup& setup)
      : target_rate_(setup.in<Real>(
            "target_rate",
            {.unit = "1", .doc = "desired rate: 1 = as planned, 0 = stop on the path", .on_null = OnNull::kHandled})),
        begin_time_(setup.in<Real>("begin_time", begin("s", "path time that it begins at; null: 0"))),
        begin_rate_(setup.in<Real>("begin_rate", begin("1", "rate that it begins with; null: 1"))),
        begin_rate_derivative_(
            setup.in<Real>("begin_rate_derivative", begin("1/s", "change of the rate at the begin; null: 0"))),
        time_(setup.out<Real>("time", {.unit = "s", .doc = "path time after this cycle, in [0, duration]"})),
        rate_(setup.out<Real>("rate", {.unit = "1", .doc = "path time per time"})),
        rate_derivative_(setup.out<Real>("rate_derivative", {.unit = "1/s", .doc = "change of the rate"})),
        at_end_(setup.out<Boolean>("at_end", {.doc = "path time is exactly the duration"})),
        standstill_(setup.out<Boolean>("standstill", {.doc = "rate and its change are exactly 0"})),
        duration_(setup.parameter<Real>(
            "duration", {.unit = "s", .doc = "planned duration", .range = "[0,inf)", .example = "1.0"})),
        retraceable_(setup.parameter<Boolean>("retraceable", false, {.doc = "rates down to -1 are allowed"})),
        in_motion_(setup.parameter<Boolean>(
            "in_motion", false,
            {.doc = "the law does not begin at rest: no jump of the rate there, no backwards motion"})),
        bounds_json_(
            setup.json("bounds", {.doc = "{\"acceleration_max\": 1/s, \"jerk_max\": 1/s^2, \"stop\": what a stop may "
                                         "use on each part of the path, optional} from the plan",
                                  .example = R"({"acceleration_max": 4.0, "jerk_max": 80.0})"})),
        law_json_(given(setup.optional_json(
            "law", {.doc = "the law of TimeLaw; null: stops keep to acceleration_max and jerk_max alone"}))) {
    setup.costs(60.0);
  }

  Diagnostics prepare() override {
    auto bounds = motion::clock_bounds_from_json(bounds_json_, "/bounds");
    if (!bounds) return std::move(bounds.error());
    if (law_json_.is_null() || bounds->stop.empty()) {
      clock_.emplace(*bounds, duration_, retraceable_, in_motion_);
    } else {
      const auto law = motion::time_law_from_json(law_json_, "/law");
      if (!law) return law.error();
      if (law->duration() != duration_) return lasts_otherwise(law->duration());
      clock_.emplace(*bounds, *law, retraceable_, in_motion_);
    }
    clock_at_start_ = clock_;
    return {};
  }

  [[nodiscard]] double stop_time_bound() const override { return clock_->stop_time_bound(); }

  void update(const Cycle& cycle) override {
    if (cycle.first) begin();
    const auto& state = clock_->update(cycle.stop_requested ? 0.0 : target_rate_.value_or(0.0), cycle.dt);
    time_.set(state.tau);
    rate_.set(state.rate);
    rate_derivative_.set(state.rate_change);
    at_end_.set(clock_->at_end());
    standstill_.set(clock_->at_rest());
  }

 private:
  static nlohmann::ordered_json given(const nlohmann::ordered_json* json) {
    return json != nullptr ? *json : nlohmann::ordered_json();
  }
  [[nodiscard]] Diagnostics lasts_otherwise(double law_s) const {
    Diagnostics diagnostics;
    diagnostics.error(Code::kInvalidValue, "/law", fmt::format("the law lasts {} s, the clock {} s", law_s, duration_),
                      "Give both the same duration");
    return diagnostics;
  }
  static PortSpec begin(std::string_view unit, std::string_view doc) {
    return {.unit = unit, .doc = doc, .on_null = OnNull::kHandled, .optional = true};
  }
  /// Of another clock, whose motion this one goes on with.
  void begin() {
    clock_ = clock_at_start_;
    if (begin_time_.null() && begin_rate_.null()) return;
    clock_->reset({.tau = begin_time_.value_or(0.0),
                   .rate = begin_rate_.value_or(1.0),
                   .rate_change = begin_rate_derivative_.value_or(0.0)});
  }

  In<Real> target_rate_, begin_time_, begin_rate_, begin_rate_derivative_;
  Out<Real> time_, rate_, rate_derivative_;
  Out<Boolean> at_end_, standstill_;
  double duration_;
  bool retraceable_, in_motion_;
  nlohmann::ordered_json bounds_json_;
  nlohmann::ordered_json law_json_;  ///< may be null
  std::optional<motion::PathClock> clock_, clock_at_start_;
};

class TimeLaw final : public Primitive {
 public:
  explicit TimeLaw(Setup& setup)
      : time_(setup.in<Real>("time", {.unit = "s", .doc = "path time"})),
        rate_(setup.in<Real>("rate", {.unit = "1", .doc = "path time per time"})),
        rate_derivative_(setup.in<Real>("rate_derivative", {.unit = "1/s", .doc = "change of the rate"})),
        s_(setup.out<Real>("s", {.unit = "1", .doc = "path parameter, 0 at the start, 1 at the end"})),
        ds_(setup.out<Real>("ds", {.unit = "1/s", .doc = "its first derivative with respect to real time"})),
        dds_(setup.out<Real>("dds", {.unit = "1/s^2", .doc = "its second derivative with respect to real time"})),
        law_json_(setup.json("law", {.doc = "[[duration in s, jerk in 1/s^3], ...] from the plan",
                                     .example = "[[0.25, 32.0], [0.5, -32.0], [0.25, 32.0]]"})) {
    setup.costs(40.0);
  }

  Diagnostics prepare() override {
    auto law = motion::time_law_from_json(law_json_, "/law");
    if (!law) return std::move(law.error());
    law_ = std::move(*law);
    return {};
  }

  void update(const Cycle&) override {
    if (time_.null() || rate_.null() || rate_derivative_.null()) {
      s_.set_null();
      ds_.set_null();
      dds_.set_null();
      return;
    }
    const auto point = motion::follow(law_, {.tau = *time_, .rate = *rate_, .rate_change = *rate_derivative_});
    s_.set(point.s);
    ds_.set(point.ds);
    dds_.set(point.dds);
  }

 private:
  In<Real> time_, rate_, rate_derivative_;
  Out<Real> s_, ds_, dds_;
  nlohmann::ordered_json law_json_;
  motion::TimeLaw law_;
};

TAKT_PRIMITIVE(
    PathClock, "path",
    "Path time with a rate that follows its target in the shortest time within bounds on its first and "
    "second derivative, without overshoot. A target of null counts as 0, and so does any target once the net is to "
    "stop: the motion stops on its path. In "
    "the first cycle the clock has already run for one period from where it begins: time 0, or the state of another "
    "clock, whose motion it goes on with.");
TAKT_PRIMITIVE(TimeLaw, "path",
               "Path parameter and its derivatives with respect to real time, for a planned time law followed by a "
               "path clock. The first cycle is like any other.");

}  // namespace
}  // namespace takt::primitives
