#pragma once

#include <ctime>

namespace takt::test {

/// Processor time of the process since this was made: for bounds of time that hold on a busy machine, too.
class ProcessorTime {
 public:
  [[nodiscard]] double seconds() const { return static_cast<double>(std::clock() - begin_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t begin_ = std::clock();
};

}  // namespace takt::test
