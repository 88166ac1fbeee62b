#pragma once

#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/device/signal.h"
#include "sim/model/device.h"
#include "sim/model/world_description.h"

struct mjModel_;

/// Simulated terminals and what is wired to them. A wire is one number that never moves in memory: a digital one is 0
/// or 1, an analog one may be infinite, which means that there is nothing to measure.
namespace takt::sim {

/// An output terminal: what is written is on its wire from the same cycle on.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic.
class SimOutput final : public device::SignalOutputBackend<bool>,
                        public device::SignalOutputBackend<double>,
                        public SimDevice {
 public:
  explicit SimOutput(const SimOutputDescription& description) : value_(description.initial) {}

  [[nodiscard]] bool ready() const override { return true; }
  void write(bool value) override { value_ = value ? 1.0 : 0.0; }
  void write(double value) override { value_ = value; }
  [[nodiscard]] const double* wire() const { return &value_; }

  void start(const mjData_&) override {}
  void actuate(mjData_&, const Substep&) override {}
  void measure(const mjData_&, Nanoseconds) override {}
  void stream(StateStream& state) override { state(value_); }

 private:
  double value_;
};

/// The newest number, given out as a digital or an analog sample.
class SimReading : public device::SignalInputBackend<bool>, public device::SignalInputBackend<double> {
 public:
  bool read(device::SignalSample<bool>& sample) override;
  bool read(device::SignalSample<double>& sample) override;
  [[nodiscard]] const double* wire() const { return &value_; }

 protected:
  void take(double value, Nanoseconds stamp);
  void stream_reading(StateStream& state);

 private:
  double value_ = 0.0;
  std::uint64_t sequence_ = 0;
  Nanoseconds stamp_ = 0;
};

/// A reading that a device gives by itself.
class SimGauge final : public SimReading {
 public:
  using SimReading::stream_reading;
  using SimReading::take;
};

/// An input terminal: reads a wire, or what a time script says; an analog one with resolution, noise and range.
class SimInput final : public SimReading, public SimDevice {
 public:
  /// @param wire  null: only the script
  SimInput(const SimInputDescription& description, const double* wire, std::uint64_t seed);

  void start(const mjData_&) override {}
  void actuate(mjData_&, const Substep&) override {}
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  [[nodiscard]] double scripted(Nanoseconds now) const;

  SimInputDescription figures_;
  const double* wire_;
  Random noise_;
};

/// A light barrier (1: something stands in the beam) or a laser range finder (m to the first surface; the end of its
/// range where there is none; nothing to measure where it is too near). The beam leaves the origin of its body along z
/// and meets every solid surface but those of that body.
/// Owned by its World. Thread: the one that steps the world. Realtime: cyclic.
class SimBeam final : public SimReading, public SimDevice {
 public:
  SimBeam(const SimBeamDescription& description, const mjModel_& model, int body, std::uint64_t seed);

  void start(const mjData_&) override {}
  void actuate(mjData_&, const Substep&) override {}
  void measure(const mjData_& data, Nanoseconds now) override;
  void stream(StateStream& state) override;

 private:
  SimBeamDescription figures_;
  const mjModel_& model_;
  int body_;
  Random noise_;
};

}  // namespace takt::sim
