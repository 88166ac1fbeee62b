#include <algorithm>

#include <fmt/format.h>

#include "core/device/device_file_impl.h"
#include "core/device/vacuum_cup.h"

namespace takt::device {

namespace {

std::vector<std::string> links_of(const DeviceFile& file, ObjectReader& reader, const char* key) {
  std::vector<std::string> names = reader.texts(key);
  if (names.empty()) reader.diagnostics().error(Code::kMissing, reader.at(key), "no lip", "Name one link or more");
  if (file.robot() == nullptr) return names;
  std::vector<std::string> known;
  for (const kinematics::Link& link : file.robot()->links) known.push_back(link.name);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(known, names[i]) != known.end()) continue;
    reader.diagnostics().error(Code::kUnknownName, reader.at(key) + pointer_segment(i),
                               fmt::format("the URDF has no link '{}'", names[i]), nearest_choice(names[i], known));
  }
  return names;
}

}  // namespace

Result<std::shared_ptr<const VacuumCupDescription>> read_vacuum_cup(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "vacuum_cup");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  VacuumCupDescription cup;
  cup.mount_link = file->read_common(reader, cup);
  cup.tcp_link = file->link(reader, "tcp");
  if (reader.has("lips"))
    cup.lips = links_of(*file, reader, "lips");
  else
    cup.lips = {file->link(reader, "lip")};
  cup.area = reader.number("area_m2", {}, kPositive);
  cup.vacuum_max = reader.number("vacuum_max_Pa", {}, {.low = 1.0, .high = 101'325.0});
  cup.evacuation = reader.number("evacuation_s", {}, kPositive);
  cup.venting = reader.number("venting_s", {}, kPositive);
  cup.lip_leak = reader.number("lip_leak", {}, kNotNegative);
  cup.switch_on = reader.number("switch_on_Pa", {}, kPositive);
  cup.switch_off = reader.number("switch_off_Pa", {}, kPositive);
  cup.resolution = reader.number("resolution_Pa", 0.0, kNotNegative);
  cup.cycle = read_cycle(reader);
  cup.sample_age_max = kSampleCyclesMax * cup.cycle;
  if (cup.switch_off > cup.switch_on || cup.switch_on > cup.vacuum_max) {
    reader.diagnostics().error(
        Code::kOutOfRange, reader.at("switch_on_Pa"),
        fmt::format("on at {:g} Pa, off at {:g} Pa, of at most {:g} Pa", cup.switch_on, cup.switch_off, cup.vacuum_max),
        "Keep switch_off_Pa <= switch_on_Pa <= vacuum_max_Pa");
  }
  if (file->robot() != nullptr && !file->diagnostics().has_errors()) {
    cup.X_MT = pose_between(*file->robot(), cup.mount_link, cup.tcp_link);
    cup.payload = transform(pose_between(*file->robot(), cup.mount_link, file->robot()->root().name),
                            rigid_payload(*file->robot()));
  }
  return file->finish(reader, std::move(cup));
}

}  // namespace takt::device
