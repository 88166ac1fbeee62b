#pragma once

#include <string_view>
#include <utility>

namespace takt {

/// What the exception that is being handled says; for use inside of a catch block. The text is valid until the next
/// call on the same thread. Allocates nothing, so that it works when memory is gone. Any thread.
[[nodiscard]] const char* exception_text() noexcept;

/// Writes "takt: error: internal: TEXT; while doing: TASK" to the process's standard error, where TEXT is of the
/// exception that is being handled. In one write, so that messages of several threads do not mix. Allocates nothing.
/// Any thread.
void report_exception(std::string_view task) noexcept;

/// The last catch of a thread or a request: an exception out of `work` ends here and is reported with what was being
/// done. An exception that left a thread would end the process, and every machine with it.
/// @param task  "load net 'reach'". @return false if there was an exception. Any thread.
template <class Work>
bool run_caught(std::string_view task, Work&& work) noexcept {
  try {
    std::forward<Work>(work)();
    return true;
  } catch (...) {
    report_exception(task);
    return false;
  }
}

/// Tells which of many equal reports are worth a line: the 1st, 2nd, 4th, 8th ... One thread.
class RareReport {
 public:
  /// @return true if this one is to be reported.
  bool next() {
    const unsigned long long before = count_++;
    return (before & count_) == 0;
  }
  [[nodiscard]] unsigned long long count() const { return count_; }

 private:
  unsigned long long count_ = 0;
};

}  // namespace takt
