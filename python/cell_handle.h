#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <nanobind/nanobind.h>

#include "app/cell.h"
#include "app/cell_setup.h"
#include "python/errors.h"
#include "python/interrupts.h"
#include "python/run_options.h"

namespace takt::python {

/// A cell that a Python program works with, as long as any handle to something of it lives. It belongs to the thread
/// and the process that have opened it: any other use is refused. Realtime: setup.
class CellHandle {
 public:
  /// @param options  as run_settings() has them. Raises takt.OpenError.
  CellHandle(const std::string& file, const std::string& options);
  ~CellHandle();
  CellHandle(const CellHandle&) = delete;
  CellHandle& operator=(const CellHandle&) = delete;

  /// The cell. Raises takt.UsageError from another thread or process, and after finish().
  [[nodiscard]] app::Cell& get() const;
  /// Who may use it: as get(), but also after finish().
  void check_owner() const;
  /// The report as JSON. @param why  diagnostics that ended the program, as JSON; "[]": none
  [[nodiscard]] std::string finish(const std::string& why, const std::function<std::string()>& run_again);
  [[nodiscard]] const Interrupts& interrupts() const { return interrupts_; }

  /// Work of the cell without Python's lock. What Ctrl-C has cancelled is a KeyboardInterrupt.
  template <class Work>
  auto unlocked(Work work) const {
    try {
      const nanobind::gil_scoped_release without_lock;
      return work();
    } catch (const activity::ProgramCancelled&) {
      if (interrupts_.any()) raise_interrupt();
      throw;
    }
  }

 private:
  [[nodiscard]] app::CellSetup setup(RunSettings& settings);

  Interrupts interrupts_;
  std::unique_ptr<app::Cell> cell_;
  bool finished_ = false;
  std::thread::id thread_;
  pid_t process_;
};
using CellPtr = std::shared_ptr<CellHandle>;

/// A value of a cell, which lives as long as the value does.
template <class T>
struct Owned {
  CellPtr cell;
  T value;
};

}  // namespace takt::python
