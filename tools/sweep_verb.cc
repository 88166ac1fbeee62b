// sweep: many runs of a scenario, by the Python package, which has the executors and the statistics.
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "tools/cli.h"

namespace takt::tools {
namespace {

/// The folder of the package that belongs to this executable; empty: Python has to find one by itself.
std::filesystem::path package_folder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto beside = program.parent_path().parent_path() / "python";  // of a build
  return std::filesystem::exists(beside / "takt" / "__init__.py", error) ? beside : std::filesystem::path();
}

/// @return whether the interpreter imports the package
bool imports_package(const std::string& python) {
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);  // our own diagnostic says it
    if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    execlp(python.c_str(), python.c_str(), "-c", "import takt", nullptr);
    _exit(127);
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Becomes the Python process: signals, output and exit status are its own. Returns only where that is not possible.
int sweep(const std::vector<std::string>& words, const Common& common) {
  const char* chosen = std::getenv("TAKT_PYTHON");
  const std::string python = chosen != nullptr ? chosen : "python3";
  if (const auto folder = package_folder(); !folder.empty()) {
    const char* before = std::getenv("PYTHONPATH");
    const std::string path = before != nullptr ? fmt::format("{}:{}", folder.string(), before) : folder.string();
    setenv("PYTHONPATH", path.c_str(), 1);
  }
  Diagnostics diagnostics;
  if (!common.models.empty() || !common.plugins.empty()) {
    diagnostics.error(Code::kConflict, common.models.empty() ? "--plugin" : "--models",
                      "a sweep runs with the models and plug-ins of its installation", "Remove it");
  } else if (!imports_package(python)) {
    diagnostics.error(Code::kRequires, "sweep", fmt::format("'{}' does not find the Python package takt", python),
                      "Install it (./takt wheel makes a file for pip), or name the interpreter in TAKT_PYTHON; 'takt "
                      "verify FILE --seeds N' needs no Python");
  }
  if (diagnostics.has_errors()) return report(diagnostics, common);
  std::vector<std::string> all{python, "-m", "takt", "sweep"};
  all.insert(all.end(), words.begin(), words.end());
  if (common.json) all.emplace_back("--json");
  std::vector<char*> arguments;
  for (std::string& word : all) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execvp(arguments.front(), arguments.data());
  diagnostics.error(Code::kSystem, "sweep", fmt::format("'{}' cannot be started: {}", python, std::strerror(errno)),
                    "Check TAKT_PYTHON");
  return report(diagnostics, common);
}

}  // namespace

std::pair<CLI::App*, Verb> add_sweep(CLI::App& app, Common& common) {
  CLI::App* verb = app.add_subcommand(
      "sweep", "Run scenarios with many seeds and values, as a folder that any engine works on; with statistics");
  verb->set_help_flag();  // Python says which options there are
  verb->allow_extras();
  return {verb, [verb, &common] { return sweep(verb->remaining(), common); }};
}

}  // namespace takt::tools
