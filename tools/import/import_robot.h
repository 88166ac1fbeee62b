#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "tools/import/draft.h"

namespace takt::tools {

struct ImportOptions {
  std::string name;                             ///< of the model: lower case letters, digits, _
  std::filesystem::path file;                   ///< the foreign one: a URDF, a xacro file, or MuJoCo's MJCF
  std::filesystem::path out;                    ///< the folder of models that gets the folder `name`
  std::vector<std::filesystem::path> packages;  ///< where package:// meshes may lie, beside the folders above the file
  std::vector<std::string> xacro;               ///< "NAME:=VALUE", arguments of a xacro file
  std::string base, flange;                     ///< links; empty: guessed
  std::vector<std::string> without;             ///< links that are left out, with all that hangs on them
  std::string title;                            ///< for people; empty: the name
  /// Tries the model out before it comes to its place: an error refuses it, notes say what a guess does not do. Empty:
  /// it is read only.
  std::function<Result<void>(const std::filesystem::path& folder, std::vector<ImportNote>& notes)> trial = {};
};

struct ImportReport {
  std::filesystem::path folder;
  std::string base, flange;
  std::vector<std::string> joints;
  std::vector<ImportNote> notes;  ///< all that was guessed, replaced, left out, in the order of the work
};

/// Makes the folder out/name from a model of somebody else: URDF, meshes, device file, README. Nothing is written
/// unless all of it can be used as a model; all that is wrong is said at once. Realtime: setup.
[[nodiscard]] Result<ImportReport> import_robot(const ImportOptions& options);

}  // namespace takt::tools
