#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/kinematics/xml_scan.h"

namespace takt::tools {

/// A model in MuJoCo's format as text: the file with all that it includes and attaches. It is read by MuJoCo; this says
/// where in it things stand, which MuJoCo tells of the first file only, and what of it nobody takes. Realtime: setup.
class MjcfSource {
 public:
  /// @return the files, or diagnostics with file and line: what is not XML, a file that is not there, one that is
  /// included twice (a loop is that, too).
  [[nodiscard]] static Result<MjcfSource> scan(const std::filesystem::path& file);

  /// "line 7", in an included file "parts.xml line 7"; empty if no element of that kind has that name.
  [[nodiscard]] std::string place(const std::string& element, const std::string& name) const;

  /// Elements and attributes that are no part of what is taken, as "solref of geom", with how often, and where first.
  struct Unread {
    int count = 0;
    std::string first;
  };
  [[nodiscard]] std::map<std::string, Unread> unread() const;

  /// File and line in which a text of MuJoCo's compiler says that the fault is ("Element 'geom', line 7").
  void locate(const std::string& text, Diagnostic& diagnostic) const;

 private:
  struct File {
    std::filesystem::path path;
    kinematics::XmlTree tree;
  };
  void add(const std::filesystem::path& path, const std::string& including, const std::string& pointer,
           Diagnostics& diagnostics);
  /// A model that the file attaches: MuJoCo may take it several times.
  void add_attached(const std::filesystem::path& path, Diagnostics& diagnostics);
  void index(std::size_t file);
  [[nodiscard]] std::string place(std::size_t file, int line) const;

  std::vector<File> files_;  ///< the one that was asked for first
  std::map<std::pair<std::string, std::string>, std::pair<std::size_t, int>> named_;  ///< element, name: file, line
};

}  // namespace takt::tools
