#include "app/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>

#include "core/base/last_catch.h"
#include "core/base/unfinished.h"

namespace takt::app {
namespace {

constexpr int kFault = 3;
constexpr int kInterrupted = 130;
constexpr std::string_view kLostOutput = "takt: error: the output could not be written\n";
constexpr unsigned kGrace_s = 3;  ///< from the second interrupt to the end

std::atomic<int> interrupts = 0;
/// What the process is doing, for the last message; fixed size, so that it can be read when memory is gone.
std::array<char, 256> task{};

/// Async-signal-safe: write() to a stream that may be closed.
void tell(std::string_view text) { (void)!::write(STDERR_FILENO, text.data(), text.size()); }

[[noreturn]] void end_now(int) {
  remove_unfinished();
  tell("\ntakt: ended by signals before the run was closed\n");
  ::_exit(kInterrupted);
}

[[noreturn]] void end_interrupted(int) {
  remove_unfinished();
  ::_exit(kInterrupted);
}

void count_interrupt(int) {
  const int count = interrupts.fetch_add(1) + 1;
  if (count == 2) ::alarm(kGrace_s);
  if (count > 2) end_now(0);
}

void handle(std::initializer_list<int> signals, void (*handler)(int)) {
  for (const int signal : signals) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = handler;
    sigaction(signal, &action, nullptr);
  }
}

[[noreturn]] void end_at_uncaught_exception() {
  tell("takt: error: internal: ");
  tell(std::current_exception() ? exception_text() : "terminated without an exception");
  tell("; while doing: ");
  tell(task[0] ? task.data() : "start");
  tell("\n");
  remove_unfinished();
  ::_exit(kFault);
}

const char* crash_text(int signal) {
  switch (signal) {
    case SIGSEGV:
    case SIGBUS:
      return "invalid access to memory";
    case SIGFPE:
      return "invalid arithmetic";
    case SIGILL:
      return "invalid instruction";
    default:
      return "aborted";
  }
}

/// The very last catch: of what no code can handle, such as a library under us that does not look whether it was given
/// memory. Async-signal-safe. Who asks for core dumps gets one.
void end_at_crash(int signal) {
  tell("takt: error: internal: ");
  tell(crash_text(signal));
  tell("; while doing: ");
  tell(task[0] ? task.data() : "start");
  tell("\n");
  remove_unfinished();
  rlimit core{};
  if (::getrlimit(RLIMIT_CORE, &core) != 0 || core.rlim_cur == 0) ::_exit(kFault);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

/// Sanitizers and debuggers that have taken these signals keep them.
void handle_crashes() {
  // A stack that is used up leaves no room for the handler.
  static std::array<char, 64 << 10> stack;
  stack_t spare{};
  spare.ss_sp = stack.data();
  spare.ss_size = stack.size();
  ::sigaltstack(&spare, nullptr);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_DFL) continue;
    struct sigaction action {};
    action.sa_handler = end_at_crash;
    action.sa_flags = SA_ONSTACK;
    sigaction(signal, &action, nullptr);
  }
}

void open_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest free number is this one. Standard output opened for reading refuses what is written to it.
    (void)!::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

/// Takes all, whether it could be written or not: nobody could be told.
ssize_t write_or_drop(void*, const char* bytes, std::size_t size) {
  std::size_t sent = 0;
  while (sent < size) {
    const ssize_t written = ::write(STDERR_FILENO, bytes + sent, size - sent);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) break;
    sent += static_cast<std::size_t>(written);
  }
  return static_cast<ssize_t>(size);
}

void drop_what_stderr_refuses() {
  FILE* stream =
      ::fopencookie(nullptr, "w", {.read = nullptr, .write = write_or_drop, .seek = nullptr, .close = nullptr});
  if (stream == nullptr) return;
  ::setvbuf(stream, nullptr, _IONBF, 0);
  stderr = stream;
}

void set_task(std::string_view what) {
  task.fill('\0');
  std::copy_n(what.begin(), std::min(what.size(), task.size() - 1), task.begin());
}

}  // namespace

void prepare_process() {
  open_closed_streams();
  drop_what_stderr_refuses();
  std::set_terminate(end_at_uncaught_exception);
  handle_crashes();
  handle({SIGPIPE, SIGXFSZ}, SIG_IGN);
  handle({SIGINT, SIGTERM, SIGHUP}, end_interrupted);
}

int run_guarded(const std::string& what, const std::function<int()>& work) {
  set_task(what);
  try {
    const int status = work();
    // A script must not take lost output for an answer.
    if (std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout.flush()) return status;
    tell(kLostOutput);
  } catch (...) {
    // A stream that is full is met while it is written to, too.
    if (std::ferror(stdout)) {
      tell(kLostOutput);
      return kFault;
    }
    report_exception(what);
  }
  return kFault;
}

bool is_traced() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("TracerPid:")) return line.find_first_of("123456789") != std::string::npos;
  return false;
}

const std::atomic<int>& catch_interrupts() {
  handle({SIGINT, SIGTERM, SIGHUP}, count_interrupt);
  handle({SIGALRM}, end_now);
  return interrupts;
}

}  // namespace takt::app
