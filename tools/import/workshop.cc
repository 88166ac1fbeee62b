#include "tools/import/workshop.h"

#include <stdlib.h>

#include <utility>

#include <fmt/format.h>

#include "core/base/output_file.h"

namespace takt::tools {

namespace fs = std::filesystem;

Workshop::Workshop(fs::path models, std::string name) : models_(std::move(models)), name_(std::move(name)) {
  std::error_code error;
  fs::create_directories(models_, error);
  std::string pattern = (models_ / fmt::format(".{}.XXXXXX", name_)).string();
  if (mkdtemp(pattern.data()) == nullptr) return;
  top_ = pattern;
  folder_ = top_ / name_;
}

Workshop::~Workshop() {
  std::error_code error;
  if (!top_.empty()) fs::remove_all(top_, error);
}

Result<void> Workshop::write(const fs::path& file, const std::string& content) const {
  std::error_code error;
  fs::create_directories((folder_ / file).parent_path(), error);
  Diagnostics diagnostics = write_file(folder_ / file, content, "--out");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return {};
}

Result<void> Workshop::move_in() const {
  std::error_code error;
  fs::rename(folder_, models_ / name_, error);
  if (!error) return {};
  return failure(Code::kFileNotWritable, "--out", fmt::format("cannot write '{}'", (models_ / name_).string()));
}

Diagnostics check_new_model(const fs::path& models, const std::string& name) {
  Diagnostics diagnostics;
  std::error_code error;
  const bool valid = !name.empty() && name.front() >= 'a' && name.front() <= 'z' &&
                     name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
  if (!valid)
    diagnostics.error(Code::kInvalidName, "NAME", fmt::format("invalid model name '{}'", name),
                      "Use a-z, 0-9 and _, a letter first");
  if (fs::exists(models / name, error))
    diagnostics.error(Code::kDuplicate, "--out", fmt::format("'{}' exists already", (models / name).string()),
                      "Choose another name, or remove it");
  return diagnostics;
}

}  // namespace takt::tools
