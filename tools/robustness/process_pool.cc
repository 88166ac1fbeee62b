#include "tools/robustness/process_pool.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>
#include <utility>

namespace takt::tools {
namespace {

class ProcessPool {
 public:
  using Commands = std::vector<std::vector<std::string>>;

  ProcessPool(const Commands& commands, const PoolOptions& options)
      : commands_(commands), options_(options), ends_(commands.size()) {}

  Result<std::vector<ProcessEnd>> run() {
    constexpr std::chrono::milliseconds kLook(10);
    while (true) {
      pass_interrupts();
      Diagnostics diagnostics = start_next();
      if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
      if (running_.empty()) return std::move(ends_);
      collect();
      std::this_thread::sleep_for(kLook);
    }
  }

 private:
  struct Running {
    std::size_t index;
    ChildProcess process;
  };

  Diagnostics start_next() {
    while (!stopped_ && next_ < commands_.size() && running_.size() < static_cast<std::size_t>(options_.jobs)) {
      auto process = ChildProcess::start(commands_[next_]);
      if (!process) return std::move(process.error());
      running_.push_back({next_++, std::move(*process)});
    }
    return {};
  }

  /// One signal for each that the user has sent.
  void pass_interrupts() {
    const int asked = options_.interrupt != nullptr ? options_.interrupt->load() : 0;
    for (; passed_ < asked; ++passed_) stop();
  }

  void stop() {
    stopped_ = true;
    for (const Running& one : running_) one.process.send(SIGINT);
  }

  void collect() {
    bool go_on = true;
    std::erase_if(running_, [&](Running& one) {
      auto end = one.process.poll();
      if (!end) return false;
      ends_[one.index] = std::move(*end);
      go_on = (!options_.ended || options_.ended(one.index, ends_[one.index])) && go_on;
      return true;
    });
    if (!go_on) stop();
  }

  const Commands& commands_;
  const PoolOptions& options_;
  std::vector<ProcessEnd> ends_;
  std::vector<Running> running_;
  std::size_t next_ = 0;
  int passed_ = 0;
  bool stopped_ = false;
};

}  // namespace

Result<std::vector<ProcessEnd>> run_processes(const std::vector<std::vector<std::string>>& commands,
                                              const PoolOptions& options) {
  return ProcessPool(commands, options).run();
}

}  // namespace takt::tools
