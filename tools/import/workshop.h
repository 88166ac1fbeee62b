#pragma once

#include <filesystem>
#include <string>

#include "core/base/diagnostics.h"

namespace takt::tools {

/// A model folder in the making: a hidden folder beside its place, which goes away with all that is still in it.
class Workshop {
 public:
  /// @param models  the folder that is to get the folder `name`; it is made if it is not there
  Workshop(std::filesystem::path models, std::string name);
  ~Workshop();
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;

  /// Where the model is made; empty if that is not possible.
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  /// Writes a file of it.
  [[nodiscard]] Result<void> write(const std::filesystem::path& file, const std::string& content) const;
  /// Puts the whole model in its place.
  [[nodiscard]] Result<void> move_in() const;

 private:
  std::filesystem::path models_, top_, folder_;
  std::string name_;
};

/// What is wrong with the name of a new model, or with its place.
[[nodiscard]] Diagnostics check_new_model(const std::filesystem::path& models, const std::string& name);

}  // namespace takt::tools
