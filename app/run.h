#pragma once

#include <filesystem>
#include <functional>

#include "app/cell.h"

namespace takt::app {

/// A program of a cell. It may be run a second time, on a cell of its own, to see whether it repeats.
using Program = std::function<void(Cell& cell)>;

/// The main() of a program: reads the command line (FILE and the options of `takt run`; --help tells), opens the cell,
/// runs the program, waits for what it has begun, prints the verdict. What goes wrong is said on stderr.
/// @param file  what is opened if the command line names no file
/// @param cooperating  as CellOptions::cooperating
/// @return exit status: 0 all expectations hold, 1 one does not, 2 the cell was refused and nothing moved, 3 the
/// program broke off, 130 interrupted
int run(int argc, char** argv, const std::filesystem::path& file, const Program& program,
        const CooperatingArms& cooperating = {});

}  // namespace takt::app
