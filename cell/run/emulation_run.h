#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/build/device_kind.h"
#include "cell/faults/faults.h"
#include "cell/file/description.h"

namespace takt::cell {

/// The controllers of a cell without its core: the simulated world, at the pace of the wall clock, and the emulated
/// controllers of the devices that a site gives a driver. Programs that move them are other processes. Thread: one.
/// Realtime: setup.
class EmulationRun {
 public:
  struct Options {
    bool realtime = false;                              ///< real-time scheduling and locked memory, where permitted
    const std::atomic<int>* interrupt = nullptr;        ///< ends the run
    std::function<void(const std::string& line)> tell;  ///< what the controllers have to say
    /// What somebody at the machines does next, without waiting for it: "reset ARM", "stop ARM".
    std::function<std::optional<std::string>()> next_command;
  };
  struct Report {
    double sim_time = 0.0;      ///< s
    std::int64_t overruns = 0;  ///< cycles that the wall clock was ahead of: they are lost, the machines' time stood
    Diagnostics diagnostics;    ///< with a warning where it lost time that clients have noticed
  };
  /// What is emulated: "arm as fri at 127.0.0.1:49938".
  struct Served {
    std::string device, kind, address;
  };

  /// @return diagnostics if no device has a driver on a real wire, and all that is wrong with the cell
  [[nodiscard]] static Result<std::unique_ptr<EmulationRun>> create(Description description,
                                                                    const device::ModelLibrary& models);
  [[nodiscard]] const std::vector<Served>& served() const { return served_; }
  /// Until it is interrupted, or the physics diverge.
  [[nodiscard]] Report run(const Options& options);

 private:
  EmulationRun(BuiltCell built, std::vector<ScheduledFault> faults, std::uint64_t seed)
      : built_(std::move(built)), faults_(std::move(faults)), seed_(seed) {}
  [[nodiscard]] Diagnostics add_emulators(const Site& site, LoadedDevices devices, std::uint64_t seed);
  [[nodiscard]] Result<std::unique_ptr<device::ControllerEmulator>> emulator_of(const std::string& name,
                                                                                const Site& site, LoadedDevices devices,
                                                                                std::uint64_t seed);
  [[nodiscard]] Result<std::unique_ptr<device::ControllerEmulator>> arm_emulator(const std::string& name,
                                                                                 const Site& site,
                                                                                 LoadedDevices devices,
                                                                                 std::uint64_t seed);
  void tell(const Options& options, const std::string& who, const std::string& what) const;
  void tell_news(const Options& options);
  void carry_out_commands(const Options& options);
  void tell_lost_time(const Options& options, Nanoseconds lost);

  struct Emulated {
    std::string device;
    std::unique_ptr<device::ControllerEmulator> emulator;
  };
  BuiltCell built_;
  std::vector<ScheduledFault> faults_;
  std::uint64_t seed_;  ///< of the scenario
  Nanoseconds lost_told_ = 0;
  double next_tell_ = 0.0;  ///< s, of lost time
  std::vector<Emulated> emulators_;
  std::vector<Served> served_;
};

}  // namespace takt::cell
