#include "cell/run/recorded_models.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "core/base/json.h"

namespace takt::cell {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLibrary = "library/";
constexpr std::size_t kMostFile = 32u << 20;       ///< bytes of one file
constexpr std::uint64_t kMostModels = 256u << 20;  ///< bytes of all

std::string media_type_of(const fs::path& file) {
  if (file.extension() == ".json") return "application/json";
  if (file.extension() == ".urdf") return "application/xml";
  return "application/octet-stream";
}

/// Files in the order of their names, so that the same run gives the same bytes.
std::set<fs::path> files_below(const fs::path& folder) {
  std::set<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error); !error && at != fs::end(at); at.increment(error))
    if (std::error_code ignored; at->is_regular_file(ignored) && at->path().extension() != ".md")
      files.insert(at->path());
  return files;
}

void attach(const fs::path& file, const std::string& name, std::vector<record::Attachment>& attachments) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return;
  auto data = read_file(file, kMostFile);
  if (data) attachments.push_back({name, media_type_of(file), std::move(*data)});
}

std::set<std::string> models_of(const Description& description) {
  std::set<std::string> names;
  for (const DeviceEntry& device : description.devices) names.insert(device.model);
  for (const ObjectEntry& object : description.objects)
    if (!object.model.empty()) names.insert(object.model);
  return names;
}

}  // namespace

std::vector<record::Attachment> model_attachments(const Description& description, const device::ModelLibrary& models) {
  const std::set<std::string> used = models_of(description);
  std::map<fs::path, std::string> folders;  // of all models, each with one: its tables count only beside a model
  for (const std::string& name : models.names()) {
    const auto folder = models.find(name);
    if (folder && (used.contains(name) || !folders.contains(folder->parent_path())))
      folders[folder->parent_path()] = name;
  }
  std::map<fs::path, std::size_t> numbers;
  std::vector<record::Attachment> attachments;
  for (const auto& [folder, model] : folders) {
    const std::size_t index = numbers.emplace(folder, numbers.size()).first->second;
    const bool only_tables = !used.contains(model);
    for (const std::string& file : {std::string("materials.json"), std::string("threads.json"), model + "/device.json"})
      if (only_tables || !file.starts_with(model + "/"))
        attach(folder / file, fmt::format("{}{:03}/{}", kLibrary, index, file), attachments);
  }
  for (const std::string& name : used) {
    const auto model = models.find(name);
    if (!model) continue;
    const std::size_t index = numbers.at(model->parent_path());
    for (const fs::path& file : files_below(*model))
      attach(file,
             fmt::format("{}{:03}/{}/{}", kLibrary, index, name, file.lexically_relative(*model).generic_string()),
             attachments);
  }
  return attachments;
}

Result<std::optional<RecordedModels>> RecordedModels::unpack(const record::Recording& recording) {
  std::uint64_t bytes = 0;
  std::set<std::string> folders;
  std::vector<std::string> names;
  for (const record::AttachmentInfo& attachment : recording.attachments()) {
    if (!attachment.name.starts_with(kLibrary)) continue;
    names.push_back(attachment.name);
    bytes += attachment.size;
  }
  if (names.empty()) return std::optional<RecordedModels>();
  if (bytes > kMostModels)
    return failure(Code::kTooLarge, "", fmt::format("the recorded models have {} bytes", bytes),
                   fmt::format("Keep it to at most {}", kMostModels));
  auto folder = TemporaryFolder::create();
  if (!folder) return std::unexpected(folder.error());
  for (const std::string& name : names) {
    const auto file = resolve_below(folder->path(), name, "");
    const auto data = recording.attachment(name);
    if (!file || !data) continue;  // it is missed where it is needed
    std::error_code error;
    fs::create_directories(file->parent_path(), error);
    if (Diagnostics diagnostics = write_file(*file, *data); diagnostics.has_errors())
      return std::unexpected(std::move(diagnostics));
    const std::size_t end = name.find('/', kLibrary.size());
    if (end != name.npos) folders.insert(name.substr(0, end));
  }
  std::vector<fs::path> paths;
  for (const std::string& one : folders) paths.push_back(folder->path() / one);
  return RecordedModels(std::move(*folder), device::ModelLibrary(std::move(paths)));
}

}  // namespace takt::cell
