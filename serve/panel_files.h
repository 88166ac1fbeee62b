#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "serve/http_server.h"

namespace takt::serve {

/// The files of the page (panel/), by the paths at which a server hands them out. They are read once, before there is
/// any client; a request is compared with this list and never reaches the file system. Any thread.
class PanelFiles {
 public:
  /// There is no page: "/" says how to get one.
  PanelFiles() = default;
  /// @param folder  with what `npm run build` makes; if a file of the list is missing there is no page. Realtime: setup
  [[nodiscard]] static PanelFiles read(const std::filesystem::path& folder);

  [[nodiscard]] bool complete() const { return !files_.empty(); }
  /// The answer to a GET or HEAD of "/" or a file of the list; nothing: the path is none of them. `/?...` is "/".
  [[nodiscard]] std::optional<HttpResponse> answer(const HttpRequest& request) const;

 private:
  struct File {
    std::string content_type, tag, body, packed;  ///< `packed`: the same in gzip
  };
  std::map<std::string, File, std::less<>> files_;  ///< by path
};

}  // namespace takt::serve
