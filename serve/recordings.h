#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/file/description.h"
#include "cell/judge/run_report.h"
#include "core/rcc/rules.h"

namespace takt::cell {
class RunRecorder;
}

namespace takt::serve {

/// Recordings that clients begin and end while the cell runs. Files lie in one folder and get their names here.
class Recordings {
 public:
  static constexpr double kLongest_s = 600.0;  ///< that are kept in memory

  /// @param folder  empty: no recordings are made. All else outlives it
  Recordings(const cell::Description& description, const cell::BuiltCell& built, const cell::RunOptions& run,
             std::filesystem::path folder);
  ~Recordings();
  Recordings(const Recordings&) = delete;
  Recordings& operator=(const Recordings&) = delete;

  enum class State : std::uint8_t {
    kOff,
    kOn,   ///< everything goes to a file
    kLast  ///< only so many seconds are kept, in memory, until they are saved
  };
  struct Status {
    State state = State::kOff;
    double last_s = 0.0;             ///< of kLast
    std::vector<std::string> files;  ///< names of those that are finished, in the order of their ends
    std::string error;               ///< why the newest one stopped; empty: nothing went wrong
  };

  // -- One thread at a time, not the cycle's; may wait for a few cycles and for the disk. Realtime: setup.
  // --------------
  /// Ends what is recorded and begins anew. @param last_s  0: all; else only so much is kept. @return why it cannot be
  [[nodiscard]] Diagnostics begin(double last_s);
  /// Ends it; what is only kept in memory is lost. @return why there is nothing to end
  [[nodiscard]] Diagnostics end();
  /// Writes what is kept, and goes on as before. @return the name of the file
  [[nodiscard]] Result<std::string> save();
  [[nodiscard]] Status status() const;

  // -- Whoever runs the cell -----------------------------------------------------------------------------------------
  /// After each cycle, on its thread. Realtime: cyclic.
  void after_cycle();
  /// Between two cycles, while none can begin: what is new is taken in, what is over is let go.
  void between_cycles(std::span<const rcc::Event> events);
  /// No cycle comes any more: what is recorded ends.
  void close();

 private:
  [[nodiscard]] Diagnostics refusal() const;
  [[nodiscard]] Diagnostics open(double last_s);
  /// @param keep  writes what is only kept. @return the name of the file; empty: there is none
  std::string finish(bool keep);

  const cell::Description& description_;
  const cell::BuiltCell& built_;
  cell::RunOptions run_;
  std::filesystem::path folder_;
  std::unique_ptr<cell::RunRecorder> active_;  ///< of whoever runs the cell

  mutable std::mutex mutex_;
  std::unique_ptr<cell::RunRecorder> next_, done_;
  bool wanted_ = false;  ///< what is active goes on
  bool closed_ = false;
  Status status_;
  std::string name_;  ///< of the file that is being written
  int count_ = 0;
};

[[nodiscard]] std::string_view name_of(Recordings::State state);

}  // namespace takt::serve
