#include "sim/machines/signals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

double rounded(double value, double step) { return step > 0.0 ? std::round(value / step) * step : value; }

void stream_random(Random& random, StateStream& state) {
  std::uint64_t word = random.state();
  state(word);
  random = Random(word);
}

/// Only collision geometry stops light: pictures may carry more, and the physics does not have it.
double distance_along_z(const mjModel& model, const mjData& data, int body) {
  const double* R = data.xmat + 9 * body;  // row by row; z is its third column
  const std::array<double, 3> z = {R[2], R[5], R[8]};
  int geom = -1;
  // Written by mj_ray: only its scratch memory.
  auto& scratch = const_cast<mjData&>(data);
  return mj_ray(&model, &scratch, data.xpos + 3 * body, z.data(), nullptr, 1, body, &geom, nullptr);
}

}  // namespace

bool SimReading::read(device::SignalSample<bool>& sample) {
  sample = {.sequence = sequence_, .stamp = stamp_, .value = value_ >= 0.5};
  return sequence_ > 0;
}

bool SimReading::read(device::SignalSample<double>& sample) {
  sample = {.sequence = sequence_, .stamp = stamp_, .value = value_};
  return sequence_ > 0;
}

void SimReading::take(double value, Nanoseconds stamp) {
  ++sequence_;
  stamp_ = stamp;
  value_ = value;
}

void SimReading::stream_reading(StateStream& state) {
  state(value_);
  state(sequence_);
  state(stamp_);
}

SimInput::SimInput(const SimInputDescription& description, const double* wire, std::uint64_t seed)
    : figures_(description), wire_(wire), noise_(seed, description.name) {}

double SimInput::scripted(Nanoseconds now) const {
  double value = 0.0;
  for (const auto& step : figures_.script) {
    if (step.from > now) break;
    value = step.value;
  }
  return value;
}

void SimInput::measure(const mjData_&, Nanoseconds now) {
  if (now % figures_.period != 0) return;
  double value = wire_ ? *wire_ : scripted(now);
  if (figures_.analog && std::isfinite(value)) {
    if (figures_.noise > 0.0) value += figures_.noise * noise_.normal();
    value = std::clamp(rounded(value, figures_.resolution), figures_.lower, figures_.upper);
  }
  take(value, now);
}

void SimInput::stream(StateStream& state) {
  stream_random(noise_, state);
  stream_reading(state);
}

SimBeam::SimBeam(const SimBeamDescription& description, const mjModel_& model, int body, std::uint64_t seed)
    : figures_(description), model_(model), body_(body), noise_(seed, description.name) {}

void SimBeam::measure(const mjData_& data, Nanoseconds now) {
  if (now % figures_.period != 0) return;
  const double distance = distance_along_z(model_, data, body_);
  const bool met = distance >= 0.0 && distance <= figures_.range_max;
  if (!figures_.measures_range) return take(met ? 1.0 : 0.0, now);
  if (!met) return take(figures_.range_max, now);  // as far as it can say
  double value = -std::numeric_limits<double>::infinity();
  if (distance >= figures_.range_min) {
    value = distance + (figures_.noise > 0.0 ? figures_.noise * noise_.normal() : 0.0);
    value = std::min(rounded(value, figures_.resolution), figures_.range_max);
  }
  take(value, now);
}

void SimBeam::stream(StateStream& state) {
  stream_random(noise_, state);
  stream_reading(state);
}

}  // namespace takt::sim
