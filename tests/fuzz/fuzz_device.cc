// Any bytes as a device file lead to a description, or to diagnostics with reasons. The URDFs beside it are those of
// models/.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/device/device_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/promise.h"
#include "tests/support/json_mutator.h"
#include "tests/support/scratch_folder.h"

namespace takt {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Copies of the models in a folder of their own, in memory where there is such a thing; gone when the process ends.
class Models {
 public:
  Models() {
    for (const auto& entry : fs::directory_iterator("models")) {
      if (!fs::exists(entry.path() / "device.json")) continue;
      fs::create_directories(root_ / entry.path().filename());
      fs::copy(entry.path(), root_ / entry.path().filename(), fs::copy_options::recursive);
      const auto json = read_json(entry.path() / "device.json");
      if (!json) continue;
      for (std::string& word : test::words_of(*json)) words_.push_back(std::move(word));
    }
  }

  /// The folder in which a file of that name would stand; that of an arm for names that nobody has.
  [[nodiscard]] fs::path folder_of(std::string_view text) const {
    const auto json = parse_json(text);
    if (json && json->is_object() && json->contains("name") && (*json)["name"].is_string()) {
      const auto name = (*json)["name"].get<std::string>();
      std::error_code ignored;
      const bool plain = !name.empty() && name.find('/') == std::string::npos && name[0] != '.';
      if (plain && fs::is_directory(root_ / name, ignored)) return root_ / name;
    }
    return root_ / "lwr4plus";
  }
  [[nodiscard]] const std::vector<std::string>& words() const { return words_; }

 private:
  const takt::test::ScratchFolder scratch_{"fuzz", fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path()};
  const fs::path root_ = scratch_.path();
  std::vector<std::string> words_;
};

const Models& models() {
  static const Models all;
  return all;
}

template <class Description>
void expect_read(const Result<Description>& description) {
  if (!description) return test::expect_reasons(description.error());
  test::demand((*description)->robot != nullptr, "what is read has its URDF");
}

void load(std::string_view text) {
  const fs::path folder = models().folder_of(text);
  std::ofstream(folder / "device.json", std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
  const auto kind = device::read_device_kind(folder);
  if (!kind) return test::expect_reasons(kind.error());
  if (*kind == "arm") return expect_read(device::read_arm(folder));
  if (*kind == "force_torque_sensor") return expect_read(device::read_force_torque_sensor(folder));
  if (*kind == "tool") return expect_read(device::read_tool(folder));
  if (*kind == "gripper") return expect_read(device::read_gripper(folder));
  if (*kind == "io") return expect_read(device::read_io(folder));
  if (*kind == "light_barrier") return expect_read(device::read_light_barrier(folder));
  if (*kind == "range_finder") return expect_read(device::read_range_finder(folder));
}

}  // namespace
}  // namespace takt

namespace takt::test {

const FuzzTarget& fuzz_target() {
  static const FuzzTarget target{.words = models().words(),
                                 .load = load,
                                 .share = 0.8,
                                 .mutate = [](std::string_view input, Random& random) -> std::optional<std::string> {
                                   const auto document = parse_json(input);
                                   if (!document) return std::nullopt;
                                   return mutated_json(*document, models().words(), random);
                                 }};
  return target;
}

}  // namespace takt::test
