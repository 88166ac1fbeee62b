#pragma once

#include <filesystem>
#include <string>

#include "cell/run/session.h"

namespace takt::app {

/// A cell's options as the scenario layer takes them; what a command line says beyond CellOptions.
struct CellSetup {
  cell::OpenOptions open;
  cell::RunOptions run;
  std::string core = {};             ///< URL of a server that has the cell; empty: it is in this process
  std::filesystem::path token = {};  ///< CellOptions::token
};

}  // namespace takt::app
