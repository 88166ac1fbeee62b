#pragma once

#include "scenario/session.h"

namespace takt::app {

/// A cell's options as the scenario layer takes them; what a command line says beyond CellOptions.
struct CellSetup {
  scenario::OpenOptions open;
  scenario::RunOptions run;
};

}  // namespace takt::app
