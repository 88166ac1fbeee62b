#include "tools/robustness/child_process.h"

#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace takt::tools {
namespace {

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

ChildProcess::ChildProcess(TemporaryFile output, TemporaryFile errors)
    : output_(std::move(output)), errors_(std::move(errors)) {}

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& words) {
  auto output = TemporaryFile::create(".out");
  if (!output) return std::unexpected(std::move(output.error()));
  auto errors = TemporaryFile::create(".err");
  if (!errors) return std::unexpected(std::move(errors.error()));
  ChildProcess child(std::move(*output), std::move(*errors));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, child.output_.path().c_str(), O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, child.errors_.path().c_str(), O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::vector<std::string> copies = words;
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int error = posix_spawn(&child.process_, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error == 0) return child;
  child.process_ = -1;
  return failure(Code::kSystem, "", fmt::format("cannot start '{}': {}", words[0], std::strerror(error)));
}

ChildProcess::~ChildProcess() {
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      output_(std::move(other.output_)),
      errors_(std::move(other.errors_)),
      begin_(other.begin_) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  std::swap(process_, other.process_);
  std::swap(output_, other.output_);
  std::swap(errors_, other.errors_);
  std::swap(begin_, other.begin_);
  return *this;
}

std::optional<ProcessEnd> ChildProcess::poll() {
  int status = 0;
  const pid_t ended = process_ < 0 ? 0 : waitpid(process_, &status, WNOHANG);
  if (ended == 0) return std::nullopt;
  process_ = -1;
  const bool known = ended > 0;  // else somebody else has waited for it
  return ProcessEnd{.status = known && WIFEXITED(status) ? WEXITSTATUS(status) : -1,
                    .signal = known && WIFSIGNALED(status) ? WTERMSIG(status) : 0,
                    .output = content_of(output_.path()),
                    .errors = content_of(errors_.path()),
                    .wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count()};
}

void ChildProcess::send(int signal) const {
  if (process_ > 0) kill(process_, signal);
}

}  // namespace takt::tools
