#include <fmt/format.h>

#include "core/device/device_file_impl.h"
#include "core/device/torch.h"

namespace takt::device {

Result<std::shared_ptr<const TorchDescription>> read_torch(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "torch");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  TorchDescription torch;
  torch.mount_link = file->read_common(reader, torch);
  torch.tcp_link = file->link(reader, "tcp");
  torch.ignition = reader.number("ignition_s", {}, kNotNegative);
  torch.stick_out_min = reader.number("stick_out_min_m", {}, kNotNegative);
  torch.stick_out_max = reader.number("stick_out_max_m", {}, kPositive);
  torch.extinction = reader.number("extinction_s", {}, kNotNegative);
  torch.wire_diameter = reader.number("wire_diameter_m", {}, kPositive);
  torch.wire_speed = reader.number("wire_speed_m_s", {}, kPositive);
  torch.cycle = read_cycle(reader);
  torch.sample_age_max = kSampleCyclesMax * torch.cycle;
  if (torch.stick_out_min >= torch.stick_out_max) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at("stick_out_min_m"),
                               fmt::format("from {:g} m to {:g} m", torch.stick_out_min, torch.stick_out_max),
                               "Keep stick_out_min_m < stick_out_max_m");
  }
  if (file->robot() != nullptr && !file->diagnostics().has_errors()) {
    torch.X_MT = pose_between(*file->robot(), torch.mount_link, torch.tcp_link);
    torch.payload = transform(pose_between(*file->robot(), torch.mount_link, file->robot()->root().name),
                              rigid_payload(*file->robot()));
  }
  return file->finish(reader, std::move(torch));
}

}  // namespace takt::device
