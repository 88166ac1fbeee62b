#include "core/device/screw_thread.h"

#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/object_reader.h"

namespace takt::device {
namespace {

constexpr const char* kThreadsFile = "threads.json";

void read_head(ObjectReader& parent, ScrewThread& thread) {
  const nlohmann::ordered_json* json = parent.object("head");
  if (!json) return;
  ObjectReader head(*json, parent.at("head"), parent.diagnostics());
  thread.head_diameter = head.number("diameter_m", {}, kPositive);
  thread.head_height = head.number("height_m", {}, kPositive);
  thread.socket_width = head.number("socket_width_m", {}, kPositive);
  thread.socket_depth = head.number("socket_depth_m", {}, kPositive);
  head.finish();
}

/// From the inside out: each diameter is larger than the one before.
void check_order(const ScrewThread& thread, const std::string& pointer, Diagnostics& diagnostics) {
  const bool ordered = thread.minor < thread.pitch_diameter && thread.pitch_diameter < thread.major &&
                       thread.major < thread.clearance && thread.clearance < thread.head_diameter &&
                       thread.pitch < thread.major && thread.socket_width < thread.head_diameter &&
                       thread.socket_depth < thread.head_height;
  if (ordered) return;
  diagnostics.error(Code::kInvalidValue, pointer, "the sizes do not fit each other",
                    "Keep minor < pitch diameter < major < clearance < head, and the socket inside the head");
}

ScrewThread read_thread(const nlohmann::ordered_json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  ScrewThread thread;
  thread.pitch = reader.number("pitch_m", {}, kPositive);
  thread.major = reader.number("major_m", {}, kPositive);
  thread.pitch_diameter = reader.number("pitch_diameter_m", {}, kPositive);
  thread.minor = reader.number("minor_m", {}, kPositive);
  thread.clearance = reader.number("clearance_m", {}, kPositive);
  read_head(reader, thread);
  thread.run_down = reader.number("run_down_Nm", {}, kNotNegative);
  thread.friction = reader.number("friction", {}, kNotNegative);
  (void)reader.text("source", "");
  reader.finish();
  if (!diagnostics.has_errors()) check_order(thread, pointer, diagnostics);
  return thread;
}

void read_file_of(const std::filesystem::path& file, ScrewThreadTable& table, Diagnostics& diagnostics) {
  auto json = read_json(file);
  if (!json) return diagnostics.append(json.error());
  Diagnostics own;
  ObjectReader reader(*json, "", own);
  (void)reader.text("source", "");
  const nlohmann::ordered_json* entries = reader.object("threads");
  for (auto entry = entries ? entries->begin() : nlohmann::ordered_json::const_iterator{};
       entries && entry != entries->end(); ++entry) {
    const std::string pointer = reader.at("threads") + pointer_segment(entry.key());
    const ScrewThread thread = read_thread(*entry, pointer, own);
    if (!table.emplace(entry.key(), thread).second) {
      own.error(Code::kDuplicate, pointer, fmt::format("the thread '{}' is known from another folder", entry.key()),
                "Choose another name");
    }
  }
  reader.finish();
  own.set_file(file.string());
  diagnostics.append(own);
}

}  // namespace

Result<ScrewThreadTable> read_threads(const ModelLibrary& library) {
  std::set<std::filesystem::path> folders;
  for (const std::string& name : library.names()) {
    if (const auto folder = library.find(name)) folders.insert(folder->parent_path());
  }
  ScrewThreadTable table;
  Diagnostics diagnostics;
  for (const auto& folder : folders) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(folder / kThreadsFile, ignored))
      read_file_of(folder / kThreadsFile, table, diagnostics);
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return table;
}

}  // namespace takt::device
