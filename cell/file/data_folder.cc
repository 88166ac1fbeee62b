#include "cell/file/data_folder.h"

#include <dlfcn.h>

#include <cstdlib>
#include <optional>
#include <system_error>

namespace takt::cell {
namespace {

bool holds_data(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::is_directory(folder / "models", error) &&
         std::filesystem::is_directory(folder / "scenarios", error);
}

std::optional<std::filesystem::path> data_above(std::filesystem::path folder) {
  while (!folder.empty() && folder != folder.root_path()) {
    for (const std::filesystem::path& root : {folder, folder / "share" / "takt"}) {
      if (holds_data(root)) return root;
    }
    folder = folder.parent_path();
  }
  return std::nullopt;
}

/// The folder of the shared library that the simulation is linked with; in an install it lies beside ours.
std::filesystem::path folder_of_mujoco() {
  Dl_info library{};
  const void* symbol = dlsym(RTLD_DEFAULT, "mj_version");
  std::error_code error;
  if (symbol == nullptr || dladdr(symbol, &library) == 0 || library.dli_fname == nullptr) return {};
  return std::filesystem::weakly_canonical(library.dli_fname, error).parent_path();
}

}  // namespace

std::filesystem::path data_folder() {
  if (const char* root = std::getenv("TAKT_ROOT")) return root;
  std::error_code error;
  for (const auto& place : {folder_of_mujoco(), std::filesystem::read_symlink("/proc/self/exe", error).parent_path()}) {
    if (auto data = data_above(place)) return *data;
  }
  return std::filesystem::current_path();
}

std::string find_scenario(const std::string& name) {
  std::error_code error;
  const std::filesystem::path installed = data_folder() / "scenarios" / name;
  if (name.empty() || std::filesystem::exists(name, error)) return name;
  for (const std::string& file : {installed.string(), installed.string() + ".json"})
    if (std::filesystem::is_regular_file(file, error)) return file;
  return name;
}

}  // namespace takt::cell
