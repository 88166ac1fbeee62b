#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/device/backend.h"
#include "core/device/gripper.h"
#include "core/device/signal.h"

namespace takt::cell {

/// Values one after the other in a buffer of the caller's, little-endian. Realtime: cyclic.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> buffer) : buffer_(buffer) {}
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { put_bytes(std::as_bytes(std::span(&value, 1))); }
  void put(const kinematics::JointVector& values);
  void put_bytes(std::span<const std::byte> bytes);
  [[nodiscard]] std::size_t size() const { return size_; }
  /// There was no room for all.
  [[nodiscard]] bool overflowed() const { return overflowed_; }

 private:
  std::span<std::byte> buffer_;
  std::size_t size_ = 0;
  bool overflowed_ = false;
};

/// The same, read. Behind the end everything is 0.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  requires std::is_arithmetic_v<T>
  [[nodiscard]] T get() {
    T value{};
    get_bytes(std::as_writable_bytes(std::span(&value, 1)));
    return value;
  }
  void get(kinematics::JointVector& values);
  void get_bytes(std::span<std::byte> bytes);
  [[nodiscard]] bool ended_early() const { return ended_early_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  bool ended_early_ = false;
};

/// What one device of the core has read in this cycle.
class SampleTrack {
 public:
  explicit SampleTrack(std::string device) : device_(std::move(device)) {}
  virtual ~SampleTrack() = default;
  [[nodiscard]] const std::string& device() const { return device_; }
  virtual void write(ByteWriter& out) const = 0;
  virtual void read(ByteReader& in) = 0;

 private:
  std::string device_;
};

/// What all devices of a cell read, beside what is handed over to them (CommandTape): with both a cell can be followed
/// by another one that has no machines. It stands between the devices of the core and their back ends. Of a cell that
/// follows, devices read what write() of the other cell has said. Setup before the first cycle; then the cycle's
/// thread.
class SampleTape {
 public:
  // A back end whose readings are noted, or taken from the other cell. Realtime: setup.
  [[nodiscard]] std::shared_ptr<device::ArmBackend> tap(const std::string& name,
                                                        std::shared_ptr<device::ArmBackend> backend);
  [[nodiscard]] std::shared_ptr<device::GripperBackend> tap(const std::string& name,
                                                            std::shared_ptr<device::GripperBackend> backend);
  [[nodiscard]] std::shared_ptr<device::ForceTorqueBackend> tap(const std::string& name,
                                                                std::shared_ptr<device::ForceTorqueBackend> backend);
  template <class T>
  [[nodiscard]] std::shared_ptr<device::SignalInputBackend<T>> tap(
      const std::string& name, std::shared_ptr<device::SignalInputBackend<T>> backend);
  template <class T>
  [[nodiscard]] std::shared_ptr<device::SignalOutputBackend<T>> tap(
      const std::string& name, std::shared_ptr<device::SignalOutputBackend<T>> backend);

  /// From now on devices read what read() has brought. @param told  hears tools and loads that arms are told
  using ToolTold = std::function<void(const std::string& arm, const device::ToolSetting& tool)>;
  void follow(ToolTold told);
  [[nodiscard]] bool follows() const { return follows_; }
  [[nodiscard]] const ToolTold& told() const { return told_; }

  /// Names of all devices whose readings it has, in the order of write().
  [[nodiscard]] std::vector<std::string> devices() const;
  void write(ByteWriter& out) const;
  void read(ByteReader& in);
  /// Of a cell that follows: the next sample of an arm says that the device is told to be here.
  void set_commanded(std::string_view arm, const kinematics::JointVector& q);

 private:
  template <class Track, class Backend>
  std::shared_ptr<Track> add(const std::string& name, std::shared_ptr<Backend> backend);

  std::vector<std::shared_ptr<SampleTrack>> tracks_;
  bool follows_ = false;
  ToolTold told_;
};

/// Tool and load in 25 numbers: the pose of the tool centre point row by row (3x4), mass, centre, inertia.
inline constexpr std::size_t kToolValues = 25;
using ToolValues = std::array<double, kToolValues>;
[[nodiscard]] ToolValues values_of(const device::ToolSetting& tool);
[[nodiscard]] device::ToolSetting tool_of(std::span<const double> values);

}  // namespace takt::cell
