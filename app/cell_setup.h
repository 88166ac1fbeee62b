#pragma once

#include "cell/run/session.h"

namespace takt::app {

/// A cell's options as the scenario layer takes them; what a command line says beyond CellOptions.
struct CellSetup {
  cell::OpenOptions open;
  cell::RunOptions run;
};

}  // namespace takt::app
