#include "cell/build/sample_tape.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace takt::cell {
namespace {

using device::ArmSample;
using device::GripperSample;
using device::WrenchSample;

void put_sample(const ArmSample& sample, ByteWriter& out) {
  out.put(sample.sequence);
  out.put(sample.stamp);
  for (const auto* part : {&sample.q, &sample.dq, &sample.tau, &sample.tau_external, &sample.commanded}) out.put(*part);
  out.put(static_cast<std::uint8_t>(sample.mode));
  for (const bool flag : {sample.changing_mode, sample.braked, sample.ready}) out.put(std::uint8_t{flag});
  out.put(sample.fault);
}

void get_sample(ByteReader& in, ArmSample& sample) {
  sample.sequence = in.get<std::uint64_t>();
  sample.stamp = in.get<Nanoseconds>();
  for (auto* part : {&sample.q, &sample.dq, &sample.tau, &sample.tau_external, &sample.commanded}) in.get(*part);
  sample.mode = static_cast<device::ControlMode>(in.get<std::uint8_t>());
  for (bool* flag : {&sample.changing_mode, &sample.braked, &sample.ready}) *flag = in.get<std::uint8_t>() != 0;
  sample.fault = in.get<std::uint32_t>();
}

void put_sample(const GripperSample& sample, ByteWriter& out) {
  out.put(sample.sequence);
  out.put(sample.stamp);
  for (const double value : {sample.width, sample.speed, sample.force}) out.put(value);
  out.put(static_cast<std::uint8_t>(sample.state));
  out.put(sample.command);
  out.put(std::uint8_t{sample.ready});
  out.put(sample.fault);
}

void get_sample(ByteReader& in, GripperSample& sample) {
  sample.sequence = in.get<std::uint64_t>();
  sample.stamp = in.get<Nanoseconds>();
  for (double* value : {&sample.width, &sample.speed, &sample.force}) *value = in.get<double>();
  sample.state = static_cast<device::GripperState>(in.get<std::uint8_t>());
  sample.command = in.get<std::uint64_t>();
  sample.ready = in.get<std::uint8_t>() != 0;
  sample.fault = in.get<std::uint32_t>();
}

void put_sample(const WrenchSample& sample, ByteWriter& out) {
  out.put(sample.sequence);
  out.put(sample.stamp);
  for (const auto* part : {&sample.wrench.force, &sample.wrench.torque})
    for (const double value : *part) out.put(value);
  out.put(std::uint8_t{sample.overload});
}

void get_sample(ByteReader& in, WrenchSample& sample) {
  sample.sequence = in.get<std::uint64_t>();
  sample.stamp = in.get<Nanoseconds>();
  for (auto* part : {&sample.wrench.force, &sample.wrench.torque})
    for (double& value : *part) value = in.get<double>();
  sample.overload = in.get<std::uint8_t>() != 0;
}

template <class T>
void put_sample(const device::SignalSample<T>& sample, ByteWriter& out) {
  out.put(sample.sequence);
  out.put(sample.stamp);
  out.put(static_cast<double>(sample.value));
}

template <class T>
void get_sample(ByteReader& in, device::SignalSample<T>& sample) {
  sample.sequence = in.get<std::uint64_t>();
  sample.stamp = in.get<Nanoseconds>();
  sample.value = static_cast<T>(in.get<double>());
}

/// The newest reading of a back end that gives samples.
template <class Sample, class Backend>
class Readings : public SampleTrack, public Backend {
 public:
  Readings(std::string name, std::shared_ptr<Backend> machine, const SampleTape& tape)
      : SampleTrack(std::move(name)), machine_(std::move(machine)), tape_(tape) {}

  bool read(Sample& sample) override {
    if (!tape_.follows()) any_ = machine_->read(newest_);
    if (any_) sample = newest_;
    return any_;
  }
  void write(ByteWriter& out) const override {
    out.put(std::uint8_t{any_});
    if (any_) put_sample(newest_, out);
  }
  void read(ByteReader& in) override {
    any_ = in.get<std::uint8_t>() != 0;
    if (any_) get_sample(in, newest_);
  }

 protected:
  [[nodiscard]] Backend& machine() const { return *machine_; }
  [[nodiscard]] const SampleTape& tape() const { return tape_; }
  Sample newest_;

 private:
  std::shared_ptr<Backend> machine_;
  const SampleTape& tape_;
  bool any_ = false;
};

class ArmReadings final : public Readings<ArmSample, device::ArmBackend> {
 public:
  using Base = Readings<ArmSample, device::ArmBackend>;
  using Base::Base;
  using Base::read;
  using SampleTrack::write;

  void set_held(bool held) override { machine().set_held(held); }
  void write(const device::ArmSetPoint& set_point) override { machine().write(set_point); }
  void write(ByteWriter& out) const override { Base::write(out); }
  void write_compliance(const device::Compliance& compliance) override { machine().write_compliance(compliance); }
  void change_mode(device::ControlMode mode) override { machine().change_mode(mode); }
  void set_payload(const device::PayloadSetting& payload) override { machine().set_payload(payload); }
  void set_tool(const device::ToolSetting& tool) override {
    machine().set_tool(tool);
    if (tape().follows()) tape().told()(device(), tool);
  }
  void brake() override { machine().brake(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return machine().fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override { return machine().timing(); }

  void set_commanded(const kinematics::JointVector& q) { newest_.commanded = q; }
};

class GripperReadings final : public Readings<GripperSample, device::GripperBackend> {
 public:
  using Base = Readings<GripperSample, device::GripperBackend>;
  using Base::Base;
  using Base::read;
  void write(const device::GripperSetPoint& set_point) override { machine().write(set_point); }
  void write(ByteWriter& out) const override { Base::write(out); }
};

class WrenchReadings final : public Readings<WrenchSample, device::ForceTorqueBackend> {
 public:
  using Readings::Readings;
  [[nodiscard]] device::BackendTiming timing() const override { return machine().timing(); }
};

template <class T>
class InputReadings final : public Readings<device::SignalSample<T>, device::SignalInputBackend<T>> {
 public:
  using Readings<device::SignalSample<T>, device::SignalInputBackend<T>>::Readings;
};

/// An output says only whether it takes values.
template <class T>
class OutputReadings final : public SampleTrack, public device::SignalOutputBackend<T> {
 public:
  OutputReadings(std::string name, std::shared_ptr<device::SignalOutputBackend<T>> machine, const SampleTape& tape)
      : SampleTrack(std::move(name)), machine_(std::move(machine)), tape_(tape) {}

  [[nodiscard]] bool ready() const override {
    if (!tape_.follows()) ready_ = machine_->ready();
    return ready_;
  }
  void write(T value) override { machine_->write(value); }
  void write(ByteWriter& out) const override { out.put(std::uint8_t{ready_}); }
  void read(ByteReader& in) override { ready_ = in.get<std::uint8_t>() != 0; }

 private:
  std::shared_ptr<device::SignalOutputBackend<T>> machine_;
  const SampleTape& tape_;
  mutable bool ready_ = false;  ///< as it was when the core asked last
};

}  // namespace

void ByteWriter::put_bytes(std::span<const std::byte> bytes) {
  if (overflowed_ || bytes.size() > buffer_.size() - size_) {
    overflowed_ = true;
    return;
  }
  std::memcpy(buffer_.data() + size_, bytes.data(), bytes.size());
  size_ += bytes.size();
}

void ByteWriter::put(const kinematics::JointVector& values) {
  put(static_cast<std::uint8_t>(values.size()));
  put_bytes(std::as_bytes(std::span(values.data(), static_cast<std::size_t>(values.size()))));
}

void ByteReader::get_bytes(std::span<std::byte> bytes) {
  if (bytes.size() > bytes_.size()) {
    ended_early_ = true;
    bytes_ = {};
    std::ranges::fill(bytes, std::byte{0});
    return;
  }
  std::memcpy(bytes.data(), bytes_.data(), bytes.size());
  bytes_ = bytes_.subspan(bytes.size());
}

void ByteReader::get(kinematics::JointVector& values) {
  const auto size = std::min<Eigen::Index>(get<std::uint8_t>(), kinematics::kMaxJoints);
  values.resize(size);
  get_bytes(std::as_writable_bytes(std::span(values.data(), static_cast<std::size_t>(size))));
}

template <class Track, class Backend>
std::shared_ptr<Track> SampleTape::add(const std::string& name, std::shared_ptr<Backend> backend) {
  auto track = std::make_shared<Track>(name, std::move(backend), *this);
  tracks_.push_back(track);
  return track;
}

std::shared_ptr<device::ArmBackend> SampleTape::tap(const std::string& name,
                                                    std::shared_ptr<device::ArmBackend> backend) {
  return add<ArmReadings>(name, std::move(backend));
}
std::shared_ptr<device::GripperBackend> SampleTape::tap(const std::string& name,
                                                        std::shared_ptr<device::GripperBackend> backend) {
  return add<GripperReadings>(name, std::move(backend));
}
std::shared_ptr<device::ForceTorqueBackend> SampleTape::tap(const std::string& name,
                                                            std::shared_ptr<device::ForceTorqueBackend> backend) {
  return add<WrenchReadings>(name, std::move(backend));
}
template <class T>
std::shared_ptr<device::SignalInputBackend<T>> SampleTape::tap(const std::string& name,
                                                               std::shared_ptr<device::SignalInputBackend<T>> backend) {
  return add<InputReadings<T>>(name, std::move(backend));
}
template <class T>
std::shared_ptr<device::SignalOutputBackend<T>> SampleTape::tap(
    const std::string& name, std::shared_ptr<device::SignalOutputBackend<T>> backend) {
  return add<OutputReadings<T>>(name, std::move(backend));
}
template std::shared_ptr<device::SignalInputBackend<bool>> SampleTape::tap(
    const std::string&, std::shared_ptr<device::SignalInputBackend<bool>>);
template std::shared_ptr<device::SignalInputBackend<double>> SampleTape::tap(
    const std::string&, std::shared_ptr<device::SignalInputBackend<double>>);
template std::shared_ptr<device::SignalOutputBackend<bool>> SampleTape::tap(
    const std::string&, std::shared_ptr<device::SignalOutputBackend<bool>>);
template std::shared_ptr<device::SignalOutputBackend<double>> SampleTape::tap(
    const std::string&, std::shared_ptr<device::SignalOutputBackend<double>>);

void SampleTape::follow(ToolTold told) {
  told_ = std::move(told);
  follows_ = true;
}

std::vector<std::string> SampleTape::devices() const {
  std::vector<std::string> names;
  for (const auto& track : tracks_) names.push_back(track->device());
  return names;
}

void SampleTape::write(ByteWriter& out) const {
  for (const auto& track : tracks_) track->write(out);
}

void SampleTape::read(ByteReader& in) {
  for (const auto& track : tracks_) track->read(in);
}

void SampleTape::set_commanded(std::string_view arm, const kinematics::JointVector& q) {
  for (const auto& track : tracks_)
    if (auto* readings = dynamic_cast<ArmReadings*>(track.get()); readings != nullptr && track->device() == arm)
      readings->set_commanded(q);
}

ToolValues values_of(const device::ToolSetting& tool) {
  ToolValues values{};
  std::size_t next = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) values[next++] = tool.X_FT.matrix()(row, column);
  values[next++] = tool.payload.mass;
  for (int i = 0; i < 3; ++i) values[next++] = tool.payload.p_FC[i];
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) values[next++] = tool.payload.I_C(row, column);
  return values;
}

device::ToolSetting tool_of(std::span<const double> values) {
  device::ToolSetting tool;
  std::size_t next = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) tool.X_FT.matrix()(row, column) = values[next++];
  tool.payload.mass = values[next++];
  for (int i = 0; i < 3; ++i) tool.payload.p_FC[i] = values[next++];
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) tool.payload.I_C(row, column) = values[next++];
  return tool;
}

}  // namespace takt::cell
