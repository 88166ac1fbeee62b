#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cell/build/sample_tape.h"
#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/gripper.h"
#include "core/device/signal.h"
#include "record/recording.h"

namespace takt::cell {

/// What a command is; the first value of its row.
enum class CommandKind : std::uint8_t {
  kNothing,     ///< from this cycle on nothing is handed over
  kSetPoint,    ///< of an arm: q, dq, ddq; of a gripper: sequence, width, speed, force
  kCompliance,  ///< of an arm: see encode() in the .cc
  kMode,        ///< of an arm: its control mode begins to change
  kBrake,       ///< of an arm: brakes now
  kOutput,      ///< value of a digital (0, 1) or analog output
};
[[nodiscard]] std::string_view name_of(CommandKind kind);

/// What the core hands over to one device, call by call. A row is one call: its kind, then its values.
/// Thread: the cycle's. Realtime: cyclic but for the constructor.
class CommandTrack {
 public:
  using Row = std::span<const double>;
  /// More calls in a cycle than any device gets.
  static constexpr std::size_t kMostRows = 8;

  /// @param values  most values of a row, the kind included
  CommandTrack(std::string device, std::size_t values);

  [[nodiscard]] const std::string& device() const { return device_; }
  [[nodiscard]] std::size_t values() const { return values_; }

  /// Begins a row; put() adds to it.
  void call(CommandKind kind);
  void put(double value);
  void put(std::span<const double> values);
  void put(const kinematics::JointVector& values) {
    put(std::span<const double>(values.data(), static_cast<std::size_t>(values.size())));
  }

  /// After the core's part of a cycle: what was called in it is what count() and row() tell from now on.
  void end_cycle();
  /// The calls of the last cycle are not those of the cycle before.
  [[nodiscard]] bool changed() const { return changed_; }
  [[nodiscard]] std::size_t count() const { return done_.rows; }
  /// All values(), NaN behind the last one of the call.
  [[nodiscard]] Row row(std::size_t i) const { return Row(done_.cells).subspan(i * values_, values_); }
  /// There were more calls, or longer ones, than there is room for: the track is no record of what happened.
  [[nodiscard]] bool overflowed() const { return overflowed_; }

 private:
  struct Calls {
    std::vector<double> cells;  ///< kMostRows rows
    std::size_t rows = 0;
  };
  [[nodiscard]] bool same() const;

  std::string device_;
  std::size_t values_;
  Calls now_, done_;
  std::size_t next_ = 0;  ///< place in the newest row
  bool changed_ = false, overflowed_ = false;
};

/// The tracks of all devices of a cell. It stands between the devices of the core and what is behind them, and notes
/// every call; played back, the calls of a recording take the place of the core's, which reach nothing.
/// Setup before the first cycle; then the cycle's thread.
class CommandTape {
 public:
  /// A back end that notes what is called, and passes it on. Realtime: setup.
  [[nodiscard]] std::shared_ptr<device::ArmBackend> tap(const std::string& name,
                                                        std::shared_ptr<device::ArmBackend> backend, int joints);
  [[nodiscard]] std::shared_ptr<device::GripperBackend> tap(const std::string& name,
                                                            std::shared_ptr<device::GripperBackend> backend);
  template <class T>
  [[nodiscard]] std::shared_ptr<device::SignalOutputBackend<T>> tap(
      const std::string& name, std::shared_ptr<device::SignalOutputBackend<T>> backend);

  /// From now on calls are noted. Realtime: setup.
  void record() { recording_ = true; }
  /// From now on the commands of the recording are played, and the core's swallowed. Realtime: setup.
  /// @return diagnostics: devices whose commands the recording does not have, or of another size.
  [[nodiscard]] Diagnostics play(const record::Recording& recording);

  /// After the core's part of a cycle, before the machines move. Realtime: cyclic.
  void end_cycle(std::int64_t cycle, Nanoseconds time);
  [[nodiscard]] const std::vector<std::unique_ptr<CommandTrack>>& tracks() const { return tracks_; }
  [[nodiscard]] bool playing() const { return playing_; }
  /// What the same devices read.
  [[nodiscard]] SampleTape& samples() { return samples_; }
  [[nodiscard]] bool noting() const { return recording_ && !playing_; }

  /// Hands a row over to the machine, as made in this cycle.
  using Execute = std::function<void(CommandTrack::Row row, std::int64_t cycle, Nanoseconds time)>;

 private:
  /// A device as it is played.
  struct Player {
    Execute execute;
    record::Table rows = {};                   ///< of the recording
    std::size_t next = 0, begin = 0, end = 0;  ///< rows; [begin, end) are in force
    std::vector<double> row = {};              ///< scratch
    void play(CommandTrack& track, std::int64_t cycle, Nanoseconds time);
  };
  CommandTrack& add(const std::string& name, std::size_t values);

  SampleTape samples_;
  std::vector<std::unique_ptr<CommandTrack>> tracks_;
  std::vector<Player> players_;  ///< one per track
  bool recording_ = false, playing_ = false;
};

}  // namespace takt::cell
