#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "core/base/output_file.h"

namespace takt::tools {

/// What became of a process.
struct ProcessEnd {
  int status = -1;          ///< exit status; -1: it ended by a signal, or was never started
  int signal = 0;           ///< that ended it; 0: none
  std::string output = {};  ///< of its stdout
  std::string errors = {};  ///< of its stderr
  double wall_s = 0.0;      ///< from its start to its end
};

/// A process of this machine with its output in temporary files. It has a process group of its own, so Ctrl-C on the
/// terminal does not reach it: whoever started it decides. Killed and waited for when this goes. Move-only. Thread:
/// one.
class ChildProcess {
 public:
  /// @param words  program (a path) and its arguments. @return diagnostics: no temporary file, cannot be started.
  [[nodiscard]] static Result<ChildProcess> start(const std::vector<std::string>& words);
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;

  /// Its end, once; nothing while it runs. Does not wait.
  [[nodiscard]] std::optional<ProcessEnd> poll();
  /// Nothing happens to a process that has ended.
  void send(int signal) const;

 private:
  ChildProcess(TemporaryFile output, TemporaryFile errors);

  pid_t process_ = -1;  ///< -1: ended, or moved from
  TemporaryFile output_, errors_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace takt::tools
