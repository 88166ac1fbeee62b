#include "serve/panel_files.h"

#include <array>
#include <fstream>
#include <functional>
#include <iterator>

#include <fmt/format.h>

namespace takt::serve {
namespace {

struct ListedFile {
  std::string_view path, name, content_type;
};

constexpr std::array<ListedFile, 5> kList = {{
    {"/", "index.html", "text/html; charset=utf-8"},
    {"/panel.js", "panel.js", "text/javascript; charset=utf-8"},
    {"/panel.css", "panel.css", "text/css; charset=utf-8"},
    {"/icon.svg", "icon.svg", "image/svg+xml"},
    {"/licences.txt", "licences.txt", "text/plain; charset=utf-8"},
}};

/// The page runs its own script, talks with its own server, and shows pictures that it has fetched: nothing else, and
/// in no frame of another page.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

constexpr const char* kNoPage =
    "The server runs, but its page has not been built.\n"
    "\n"
    "The page needs Node.js 18 or newer and npm, once, to be built:\n"
    "  sudo apt-get install --no-install-recommends nodejs npm\n"
    "  ./takt serve FILE        (builds what is missing, then serves)\n"
    "or in a build tree: cmake --build build/release --target takt_panel\n"
    "\n"
    "What clients can ask for: /v1/openapi.json\n";

std::optional<std::string> content(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return {};
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

}  // namespace

PanelFiles PanelFiles::read(const std::filesystem::path& folder) {
  PanelFiles all;
  for (const ListedFile& listed : kList) {
    auto body = content(folder / listed.name);
    if (!body) return {};
    auto packed = content(folder / fmt::format("{}.gz", listed.name));
    all.files_.emplace(listed.path, File{.content_type = std::string(listed.content_type),
                                         .tag = fmt::format("\"{:016x}\"", std::hash<std::string>()(*body)),
                                         .body = std::move(*body),
                                         .packed = packed ? std::move(*packed) : std::string()});
  }
  return all;
}

std::optional<HttpResponse> PanelFiles::answer(const HttpRequest& request) const {
  if (request.method != "GET" && request.method != "HEAD") return {};
  const std::string path = request.target.substr(0, request.target.find('?'));
  if (path == "/" && !complete())
    return HttpResponse{.status = 404, .content_type = "text/plain; charset=utf-8", .body = kNoPage};
  const auto found = files_.find(path);
  if (found == files_.end()) return {};
  const File& file = found->second;
  HttpResponse response{.content_type = file.content_type};
  // A browser asks each time whether its copy still holds: after an update nobody looks at an old page.
  response.headers = {{"Cache-Control", "no-cache"},
                      {"ETag", file.tag},
                      {"Content-Security-Policy", kPolicy},
                      {"Referrer-Policy", "no-referrer"},
                      {"Vary", "Accept-Encoding"}};
  if (request.header("if-none-match") == file.tag) {
    response.status = 304;
    response.content_type.clear();
    return response;
  }
  const bool packed = !file.packed.empty() && request.header("accept-encoding").find("gzip") != std::string::npos;
  if (packed) response.headers["Content-Encoding"] = "gzip";
  response.body = packed ? file.packed : file.body;
  return response;
}

}  // namespace takt::serve
