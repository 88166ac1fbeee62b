#include "tools/graphviz.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/output_file.h"

extern char** environ;

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

/// dot takes seconds for hundreds of cards; what takes longer than this is given up.
constexpr auto kLongest = std::chrono::seconds(120);

Diagnostics wait_for_dot(pid_t child, const fs::path& errors, const std::string& pointer) {
  Diagnostics diagnostics;
  int status = 0;
  const auto begin = std::chrono::steady_clock::now();
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() - begin > kLongest) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return diagnostics;
  std::ifstream stream(errors);
  std::string first;
  std::getline(stream, first);
  diagnostics.error(Code::kSystem, pointer,
                    WIFEXITED(status) ? fmt::format("dot failed: {}", first) : "dot takes too long for this picture",
                    "Make what is drawn smaller");
  return diagnostics;
}

}  // namespace

Result<std::string> run_dot(const std::string& graph, const std::string& format, const std::string& pointer) {
  const auto folder = TemporaryFolder::create();
  if (!folder) return std::unexpected(folder.error());
  const fs::path in = folder->path() / "graph.dot", out = folder->path() / "graph.out",
                 errors = folder->path() / "errors";
  if (Diagnostics wrong = write_file(in, graph); wrong.has_errors()) return std::unexpected(std::move(wrong));
  std::vector<std::string> words = {"dot", "-T" + format, in.string(), "-o", out.string()};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "dot", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    return failure(Code::kSystem, pointer, "the program 'dot' cannot be started", "Run apt-get install graphviz");
  if (Diagnostics wrong = wait_for_dot(child, errors, pointer); wrong.has_errors())
    return std::unexpected(std::move(wrong));
  std::ifstream stream(out, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

}  // namespace takt::tools
