#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json_fwd.hpp>

#include "core/base/object_reader.h"
#include "core/base/time.h"
#include "core/device/plant_file.h"
#include "core/kinematics/robot_model.h"

/// What the readers of all kinds of device files share. Realtime: setup.
namespace takt::device {

namespace fs = std::filesystem;

inline constexpr const char* kFileName = "device.json";
/// A sample may be missing for this many device cycles: a lost packet or two.
inline constexpr int kSampleCyclesMax = 20;

/// One device file while it is read, and where diagnostics go.
class DeviceFile {
 public:
  static Result<DeviceFile> open(const fs::path& folder, const std::string& kind);
  DeviceFile(DeviceFile&&) noexcept;
  DeviceFile& operator=(DeviceFile&&) noexcept;
  ~DeviceFile();

  [[nodiscard]] const nlohmann::ordered_json& json() const { return *json_; }
  [[nodiscard]] Diagnostics& diagnostics() { return *diagnostics_; }
  [[nodiscard]] const fs::path& folder() const { return folder_; }
  /// Null until read_common() and where the URDF is wrong.
  [[nodiscard]] const std::shared_ptr<const kinematics::RobotModel>& robot() const { return robot_; }

  /// Of read_common().
  [[nodiscard]] const PlantDescription& plant() const { return plant_; }

  /// kind, name, title, maker, urdf, base: as members of every description.
  template <class Description>
  std::string read_common(ObjectReader& reader, Description& description) {
    reader.choice("kind", {kind_});
    reader.text("name");
    reader.text("maker", "");
    description.title = reader.text("title", "");
    description.folder = folder_;
    description.model = folder_.filename().string();
    const std::string urdf = reader.text("urdf");
    description.urdf = load_urdf(urdf, reader.at("urdf"));
    description.robot = robot_;
    plant_ = read_plant_keys(reader, robot_.get(), kind_);
    std::string base = reader.text("base");
    check_link(base, reader.at("base"));
    return base;
  }

  /// The name of a link that must exist; empty without a URDF or if it does not.
  std::string link(ObjectReader& reader, const char* key, std::optional<std::string> fallback = {});

  /// Ends reading: the diagnostics with the file's name, or the description.
  template <class Description>
  Result<std::shared_ptr<const Description>> finish(ObjectReader& reader, Description description) {
    reader.finish();
    if (diagnostics_->has_errors()) {
      diagnostics_->set_file((folder_ / kFileName).string());
      return std::unexpected(std::move(*diagnostics_));
    }
    return std::make_shared<const Description>(std::move(description));
  }

 private:
  DeviceFile(fs::path folder, nlohmann::ordered_json json, const std::string& kind);
  fs::path load_urdf(const std::string& name, const std::string& pointer);
  void check_link(const std::string& name, const std::string& pointer);

  fs::path folder_;
  std::unique_ptr<nlohmann::ordered_json> json_;
  std::string kind_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::shared_ptr<const kinematics::RobotModel> robot_;
  PlantDescription plant_;
};

/// Key "cycle_ms"; default 1 ms.
[[nodiscard]] Nanoseconds read_cycle(ObjectReader& reader);

}  // namespace takt::device
