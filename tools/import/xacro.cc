#include "tools/import/xacro.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "core/base/json.h"
#include "core/base/output_file.h"
#include "core/kinematics/xml_scan.h"

extern char** environ;

namespace takt::tools {
namespace {

namespace fs = std::filesystem;

/// xacro asks ROS for the folder of a package; here it is looked for in the folders that are given, by the name of the
/// folder or of its package.xml. Arguments: folder of xacro, file, number of folders, folders, NAME:=VALUE ...
constexpr const char* kDriver = R"(
import os, re, resource, signal, sys, types

resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
resource.setrlimit(resource.RLIMIT_CPU, (30, 30))
signal.alarm(60)
library, file, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
roots, arguments = sys.argv[4:4 + count], sys.argv[4 + count:]

def name_of(folder):
    try:
        with open(os.path.join(folder, "package.xml"), encoding="utf-8") as manifest:
            found = re.search(r"<name>\s*([^<\s]+)\s*</name>", manifest.read(65536))
            return found and found.group(1)
    except (OSError, ValueError):
        return None

def folder_of(package):
    for root in roots:
        if os.path.basename(root) == package or name_of(root) == package:
            return root
        inside = os.path.join(root, package)
        if os.path.isdir(inside):
            return inside
    for root in roots:
        try:
            entries = sorted(os.scandir(root), key=lambda one: one.name)
        except OSError:  # a folder above the file that is not ours to read
            continue
        for entry in entries:
            if entry.is_dir() and name_of(entry.path) == package:
                return entry.path
    raise LookupError(f"there is no package '{package}'")

ament = types.ModuleType("ament_index_python")
ament.packages = types.ModuleType("ament_index_python.packages")
ament.packages.get_package_share_directory = folder_of
ament.packages.PackageNotFoundError = LookupError
sys.modules["ament_index_python"], sys.modules["ament_index_python.packages"] = ament, ament.packages
sys.path.insert(0, library)
try:
    import xacro
except ImportError as error:
    sys.stderr.write(f"{error}\n")
    sys.exit(4)
def reasons(error):
    # xacro wraps what went wrong in what it was doing then.
    inner = getattr(error, "exc", None) or error.__cause__ or error.__context__
    own = " ".join(f"{type(error).__name__}: {error}".split())
    return own if inner is None or inner is error else f"{reasons(inner)}; {own}"

try:
    document = xacro.process_file(file, mappings=dict(one.split(":=", 1) for one in arguments))
    sys.stdout.write(document.toxml())
except Exception as error:
    sys.stderr.write(f"\n{reasons(error)}\n")
    sys.exit(3)
)";

constexpr int kMissing = 4;  ///< exit status of the driver: xacro or what it needs

/// In the tree that built this program; in an install.
fs::path library_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder : {fs::path(TAKT_XACRO), program.parent_path() / TAKT_INSTALL_LIBDIR / "takt" / "xacro"})
    if (fs::is_directory(folder / "xacro", error)) return folder;
  return {};
}

/// The folders above the file, nearest first, after those that are given.
std::vector<fs::path> roots_of(const fs::path& file, const XacroOptions& options) {
  std::error_code error;
  std::vector<fs::path> roots;
  for (const fs::path& folder : options.packages) roots.push_back(fs::absolute(folder, error).lexically_normal());
  for (fs::path above = fs::absolute(file, error).lexically_normal().parent_path(); above != above.root_path();
       above = above.parent_path())
    roots.push_back(above);
  return roots;
}

/// Debian's, for which python3-yaml is installed, before another one that comes first in PATH.
std::string python() {
  constexpr const char* kDebian = "/usr/bin/python3";
  return access(kDebian, X_OK) == 0 ? kDebian : "python3";
}

std::vector<std::string> command_of(const fs::path& file, const XacroOptions& options) {
  const auto roots = roots_of(file, options);
  std::vector<std::string> command = {
      python(), "-I", "-B", "-c", kDriver, library_folder().string(), file.string(), std::to_string(roots.size())};
  for (const fs::path& root : roots) command.push_back(root.string());
  command.insert(command.end(), options.arguments.begin(), options.arguments.end());
  return command;
}

/// Runs a command with its output in two files. @return its status as waitpid() gives it, or an errno as negative
int run(std::vector<std::string>& command, const fs::path& out, const fs::path& errors) {
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, errors.c_str(), O_WRONLY | O_TRUNC, 0600);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, words[0], &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return -failed;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return status;
}

/// The last line that is not blank: xacro's warnings come before what ended it.
std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \n\r\t");
  if (end == text.npos) return "it ended without a word";
  const std::size_t begin = text.find_last_of('\n', end);
  return text.substr(begin == text.npos ? 0 : begin + 1, end - (begin == text.npos ? 0 : begin + 1) + 1);
}

std::unexpected<Diagnostics> not_there(const std::string& why) {
  return failure(Code::kNotFound, "--urdf", "xacro cannot be run: " + why,
                 "Install python3 and python3-yaml, or give a file that was expanded where ROS is installed");
}

Diagnostics check_arguments(const XacroOptions& options) {
  Diagnostics diagnostics;
  for (const std::string& argument : options.arguments) {
    if (argument.find(":=") == std::string::npos || argument.starts_with(":="))
      diagnostics.error(Code::kInvalidValue, "--xacro", fmt::format("'{}' is not NAME:=VALUE", argument),
                        "Write it as in --xacro prefix:=left_");
  }
  return diagnostics;
}

}  // namespace

Result<std::string> expand_xacro(const fs::path& file, const XacroOptions& options) {
  if (Diagnostics diagnostics = check_arguments(options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  if (library_folder().empty()) return not_there("it is not in this build");
  const auto out = TemporaryFile::create(".urdf"), errors = TemporaryFile::create(".txt");
  if (!out || !errors) return std::unexpected((out ? errors : out).error());
  auto command = command_of(file, options);
  const int status = run(command, out->path(), errors->path());
  if (status < 0) return not_there(std::strerror(-status));
  const auto said = read_file(errors->path(), std::size_t{1} << 20);
  const std::string why = last_line(said ? *said : std::string());
  if (WIFSIGNALED(status))
    return failure(Code::kTooLarge, "--urdf", fmt::format("xacro was ended by signal {}", WTERMSIG(status)),
                   "Give a file that is expanded within 30 s and 2 GiB");
  if (WEXITSTATUS(status) == kMissing) return not_there(why);
  if (WEXITSTATUS(status) != 0)
    return failure(Code::kInvalidValue, "--urdf", "xacro: " + why,
                   "Give --packages DIR for $(find), --xacro NAME:=VALUE");
  return read_file(out->path(), kinematics::kMaxXmlBytes);
}

}  // namespace takt::tools
