#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/interfaces/actuator_interfaces.h"
#include "app/interfaces/frame_handle.h"
#include "cell/judge/run_report.h"
#include "core/expression/device_sensors.h"

namespace takt::app {

/// Arms that move as one, by their names, in groups: only these are made equally late, and no net may drive arms of
/// different groups. Groups that share an arm are one; an arm in none is alone. Null: every arm may move as one with
/// every other, and all are as late as the slowest (docs/sites.md, "Padding").
using CooperatingArms = std::optional<std::vector<std::vector<std::string>>>;

/// What a run of a cell is to be, as the options of `takt run` say it.
struct CellOptions {
  std::vector<std::pair<std::string, std::string>> set = {};  ///< JSON pointer into the file, value: replaced before
                                                              ///< anything is read
  std::optional<std::uint64_t> seed = {};                     ///< in place of the file's
  std::vector<std::filesystem::path> models = {};             ///< folders that are searched before those of the install
  std::filesystem::path video = {}, record = {};              ///< MP4, MCAP; empty: none
  std::string camera = {};                                    ///< of the film, in place of the file's cuts
  bool realtime = false;                                      ///< at the wall clock's pace, beside the program
  bool quiet = false;                                         ///< print() says nothing
  CooperatingArms cooperating = {};                           ///< null: all
  /// URL of takt serve, "http://127.0.0.1:8700": the cell is there, and this process has the program alone
  /// (docs/remote.md, "A program in another process"). It is built from the same file. Empty: the cell is here.
  std::string core = {};
  std::filesystem::path token = {};  ///< file with the token of an operator, for a server with tokens
};

/// The cell could not be opened: nothing has moved.
class OpenError final : public activity::ActivityError {
 public:
  using ActivityError::ActivityError;
};

struct CellSetup;  // private to app/

/// A simulated cell that a program in C++ works with: what a scenario file says of devices, objects, frames, faults,
/// what the operator does, what must come of it and what is filmed; its "program" is not looked at. Between two calls
/// the time stands still, so a run repeats to the bit. In real time the cycle has a thread of its own and planning
/// another; the program keeps the cycle waiting between two calls only (docs/realtime.md). Not copied; one thread;
/// owned by the program. Realtime: setup.
class Cell {
 public:
  /// Opens a scenario or cell file: as it is named, else beside the program, else among the installed scenarios. When
  /// this returns, all devices are there. Throws OpenError with all that is wrong.
  explicit Cell(const std::filesystem::path& file, const CellOptions& options = {});
  ~Cell();
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;

  // -- Devices by name. No name: the only one of its kind. Throw ActivityError with the nearest name. -----------------
  [[nodiscard]] app::Actuator arm(const std::string& name = {});
  [[nodiscard]] app::Actuator gripper(const std::string& name = {});
  [[nodiscard]] app::Actuator tool_changer(const std::string& name = {});
  [[nodiscard]] app::Actuator output(const std::string& name = {});
  /// What the surroundings exert on the tool side of a force/torque sensor, weight and tared bias taken out, in its
  /// measuring frame. A later tare() counts for sensors that are asked for after it.
  [[nodiscard]] expression::WrenchSensor wrench(const std::string& sensor = {});
  /// The size of its force, N.
  [[nodiscard]] expression::RealSensor force(const std::string& sensor = {});
  /// With how much force the tool presses along a direction of its arm's base, N.
  [[nodiscard]] expression::RealSensor pressing(const Eigen::Vector3d& direction_B, const std::string& sensor = {});
  [[nodiscard]] expression::State input(const std::string& name = {});
  [[nodiscard]] expression::RealSensor analog_input(const std::string& name = {});  ///< in its own unit
  /// The smallest distance of two sides, m: lists of devices, objects and bodies ("arm/link_3"); an arm is meant with
  /// all that it carries. Objects count where the program believes them to be when it is used.
  [[nodiscard]] expression::RealSensor distance(const std::vector<std::string>& side_a,
                                                const std::vector<std::string>& side_b);
  /// "moving", "holding", "lost", "open" or "closed".
  [[nodiscard]] expression::State gripper_is(const std::string& state, const std::string& gripper = {});

  /// A frame of the cell, object or device, where the program believes it to be: cell.frame("tray").offset(0, 0, 0.1).
  [[nodiscard]] app::Frame frame(const std::string& name);

  /// Writes a channel that the outside writes (docs/channels.md): nets and states see it from the next cycle on. No
  /// value: null. Throws ActivityError if there is no such channel, if nets write it, or if it carries another type.
  void write_channel(const std::string& name, const std::optional<device::ChannelValue>& value);

  // -- Doing ---------------------------------------------------------------------------------------------------------
  /// A command of one's own as an activity (docs/command-layer.md). Each time it is carried out it is planned anew.
  [[nodiscard]] activity::Activity as_activity(const command::Command& command);
  /// Averages a sensor while the arms stand, and takes that out from then on. Throws if it does not answer.
  void tare(const std::string& sensor = {}, std::int64_t cycles = 500);
  /// Lets time pass, s, in whole cycles.
  void wait(double seconds);
  /// Until all activities and coroutines that were begun are over. Throws ActivityError for those that have failed and
  /// nobody has asked about.
  void wait_for_all();
  /// Until it holds. @return false: it did not within `timeout`, s
  bool wait_until(const expression::State& state, double timeout = 60.0);
  /// Work of the program's own that takes longer than a cycle: in real time the cycle goes on meanwhile. Nothing of the
  /// cell may be asked inside.
  void beside(const std::function<void()>& work);
  /// A coroutine to its end; beside others with runtime().spawn().
  void run(activity::Task task) { runtime().run(std::move(task)); }

  // -- What people see -----------------------------------------------------------------------------------------------
  /// The part of the program that begins now: for the film, the recording, the operator, the expectation "step".
  void step(const std::string& name);
  /// A line for the user: on stdout, in the report and in the recording.
  void print(const std::string& line);

  /// What the program itself found out: an expectation like those of the file, for the verdict.
  /// @param measured  for people: value, unit, bound
  void expect(const std::string& name, bool passed, const std::string& measured);

  /// Ends the run: waits for what was begun (or, if `why` says what went wrong, cancels it), closes film and recording,
  /// and judges the expectations of the file. Once. @param run_again  digest of a second run, for "repeats"
  [[nodiscard]] cell::RunReport finish(const Diagnostics& why = {}, const std::function<std::string()>& run_again = {});

  // -- Below ---------------------------------------------------------------------------------------------------------
  [[nodiscard]] activity::Runtime& runtime();
  [[nodiscard]] const expression::Cell& model()
      const;  ///< devices and frames, for commands, sensors of frames and channels
  [[nodiscard]] rcc::ControlCore& core();
  [[nodiscard]] double time();  ///< s, simulated
  [[nodiscard]] const std::string& title() const;
  [[nodiscard]] const Diagnostics& warnings() const;  ///< of the file

  Cell(const std::filesystem::path& file, const CellOptions& options, CellSetup setup);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::app
