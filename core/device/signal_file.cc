// Device files of what gives and takes signals: I/O blocks, light barriers, range finders.
#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/device_file.h"
#include "core/device/device_file_impl.h"
#include "core/net/unit.h"

namespace takt::device {

namespace {

using Json = nlohmann::ordered_json;
using Kind = IoChannel::Kind;

void read_analog(ObjectReader& reader, IoChannel& channel) {
  channel.unit = reader.text("unit");
  const auto unit = net::parse_unit(channel.unit);
  if (!channel.unit.empty() && (!unit || unit->size() != 1 || !unit->front().variables.empty())) {
    reader.diagnostics().error(Code::kInvalidValue, reader.at("unit"), fmt::format("'{}' is not a unit", channel.unit),
                               "Use a unit such as V, A, m, N, 1");
  }
  const auto ends = reader.numbers("range", 2);
  if (ends.size() == 2) std::tie(channel.lower, channel.upper) = std::pair(ends[0], ends[1]);
  if (!(channel.lower < channel.upper)) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at("range"),
                               fmt::format("from {} to {}", channel.lower, channel.upper), "Write [smallest, largest]");
  }
}

void read_stop(ObjectReader& reader, IoChannel& channel) {
  const Json* stop = reader.child("stop");
  if (stop == nullptr || *stop == "hold") return;
  const auto wrong = [&](const char* allowed) {
    reader.diagnostics().error(Code::kWrongType, reader.at("stop"), "unexpected value " + short_dump(*stop), allowed);
  };
  if (!channel.is_analog()) {
    if (*stop != "on" && *stop != "off") return wrong("hold, off or on");
    channel.stop = *stop == "on" ? 1.0 : 0.0;
  } else if (!stop->is_number() || stop->get<double>() < channel.lower || stop->get<double>() > channel.upper) {
    wrong("hold, or a number in the range");
  } else {
    channel.stop = stop->get<double>();
  }
}

IoChannel read_channel(Kind kind, const std::string& name, const Json& json, const std::string& pointer,
                       Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  IoChannel channel;
  channel.kind = kind;
  channel.name = name;
  if (channel.is_analog()) read_analog(reader, channel);
  if (kind == Kind::kAnalogInput) {
    channel.resolution = reader.number("resolution", 0.0, kNotNegative);
    channel.noise = reader.number("noise_sigma", 0.0, kNotNegative);
  }
  if (kind == Kind::kDigitalOutput) channel.initial = reader.boolean("initial", false) ? 1.0 : 0.0;
  if (kind == Kind::kAnalogOutput) {
    channel.initial = reader.number("initial", 0.0, {.low = channel.lower, .high = channel.upper});
    if (reader.has("rate_max_per_s")) channel.rate_max = reader.number("rate_max_per_s", {}, kPositive);
  }
  if (channel.is_output()) read_stop(reader, channel);
  reader.finish();
  return channel;
}

void read_channels(ObjectReader& reader, const char* key, Kind kind, std::vector<IoChannel>& channels) {
  const Json* members = reader.object(key, false);
  if (members == nullptr) return;
  for (const auto& [name, json] : members->items()) {
    const std::string pointer = reader.at(key) + pointer_segment(name);
    if (name.empty() || name.find('/') != std::string::npos)
      reader.diagnostics().error(Code::kInvalidName, pointer, fmt::format("invalid name '{}'", name),
                                 "Choose a name that is not empty and has no '/'");
    if (std::ranges::find(channels, name, &IoChannel::name) != channels.end())
      reader.diagnostics().error(Code::kDuplicate, pointer, fmt::format("'{}' is the name of two terminals", name),
                                 "Use each name once");
    channels.push_back(read_channel(kind, name, json, pointer, reader.diagnostics()));
  }
}

Result<std::shared_ptr<const BeamDescription>> read_beam(const fs::path& folder, const std::string& kind) {
  auto file = DeviceFile::open(folder, kind);
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  BeamDescription beam;
  beam.mount_link = file->read_common(reader, beam);
  beam.beam_link = file->link(reader, "beam");
  beam.measures_range = kind == "range_finder";
  if (beam.measures_range) {
    const auto ends = reader.numbers("range_m", 2, {}, kNotNegative);
    if (ends.size() == 2) std::tie(beam.range_min, beam.range_max) = std::pair(ends[0], ends[1]);
    if (!(beam.range_min < beam.range_max))
      reader.diagnostics().error(Code::kOutOfRange, reader.at("range_m"), "the range is empty",
                                 "Write [smallest, largest]");
    beam.resolution = reader.number("resolution_m", 0.0, kNotNegative);
    beam.noise = reader.number("noise_sigma_m", 0.0, kNotNegative);
  } else {
    beam.range_max = reader.number("range_m", {}, kPositive);
  }
  beam.cycle = read_cycle(reader);
  beam.sample_age_max = kSampleCyclesMax * beam.cycle;
  return file->finish(reader, std::move(beam));
}

}  // namespace

Result<std::shared_ptr<const IoDescription>> read_io(const fs::path& folder) {
  auto file = DeviceFile::open(folder, "io");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  IoDescription io;
  io.mount_link = file->read_common(reader, io);
  read_channels(reader, "digital_inputs", Kind::kDigitalInput, io.channels);
  read_channels(reader, "digital_outputs", Kind::kDigitalOutput, io.channels);
  read_channels(reader, "analog_inputs", Kind::kAnalogInput, io.channels);
  read_channels(reader, "analog_outputs", Kind::kAnalogOutput, io.channels);
  if (io.channels.empty())
    reader.diagnostics().error(Code::kMissing, "", "the block has no terminal", "Give digital_inputs or the like");
  io.cycle = read_cycle(reader);
  io.sample_age_max = kSampleCyclesMax * io.cycle;
  return file->finish(reader, std::move(io));
}

Result<std::shared_ptr<const BeamDescription>> read_light_barrier(const fs::path& folder) {
  return read_beam(folder, "light_barrier");
}

Result<std::shared_ptr<const BeamDescription>> read_range_finder(const fs::path& folder) {
  return read_beam(folder, "range_finder");
}

}  // namespace takt::device
