#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "cell/run/session.h"
#include "serve/panel_files.h"
#include "serve/server.h"
#include "serve/watched_run.h"
#include "tools/cli.h"

namespace takt::tools {

/// Where the page lies: in a build tree and in an install.
[[nodiscard]] std::filesystem::path panel_folder(const Common& common);
/// On stderr: where to open the page, or that it has not been built.
void tell_page(const std::string& url, const serve::PanelFiles& page);

/// The page beside a run (`takt run --panel`): a server of this machine alone, whose address with a token of its own is
/// printed. Use: open() before the run, ended() after it.
class RunPanel {
 public:
  /// @param options  of the run to come; outlives it, and so does the session
  /// @param port  0: any that is free
  [[nodiscard]] static Result<std::unique_ptr<RunPanel>> open(cell::Session& session, cell::RunOptions& options,
                                                              unsigned short port, const Common& common);
  /// Shows what became of the run until the last page is closed, or somebody interrupts.
  void ended(const cell::RunReport& report, const cell::RunOptions& options);

 private:
  RunPanel(cell::Session& session, cell::RunOptions& options) : run_(session, options) {}
  serve::WatchedRun run_;
  std::unique_ptr<serve::Server> server_;
};

}  // namespace takt::tools
