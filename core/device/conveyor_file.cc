#include <cmath>

#include <fmt/format.h>

#include "core/device/conveyor.h"
#include "core/device/device_file_impl.h"

namespace takt::device {

Result<std::shared_ptr<const ConveyorDescription>> read_conveyor(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "conveyor");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  ConveyorDescription conveyor;
  conveyor.mount_link = file->read_common(reader, conveyor);
  conveyor.belt_link = file->link(reader, "belt");
  conveyor.speed_max = reader.number("speed_max_m_s", {}, kPositive);
  conveyor.speed = reader.number("speed_m_s", conveyor.speed_max);
  conveyor.acceleration = reader.number("acceleration_m_s2", {}, kPositive);
  conveyor.resolution = reader.number("encoder_resolution_m", 0.0, kNotNegative);
  conveyor.noise = reader.number("encoder_noise_sigma_m", 0.0, kNotNegative);
  conveyor.cycle = read_cycle(reader);
  conveyor.sample_age_max = kSampleCyclesMax * conveyor.cycle;
  if (!(std::abs(conveyor.speed) <= conveyor.speed_max)) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at("speed_m_s"),
                               fmt::format("{:g} m/s, of at most {:g} m/s", conveyor.speed, conveyor.speed_max),
                               "Choose at most speed_max_m_s, in either direction");
  }
  if (file->robot() != nullptr && !file->diagnostics().has_errors())
    conveyor.X_MB = pose_between(*file->robot(), conveyor.mount_link, conveyor.belt_link);
  return file->finish(reader, std::move(conveyor));
}

}  // namespace takt::device
