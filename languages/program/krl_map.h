#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/form.h"
#include "core/base/object_reader.h"
#include "core/expression/cell.h"
#include "languages/krl/program.h"
#include "languages/program/signal_map.h"

namespace takt::languages {

/// What the numbers and names of a robot program are in a cell: signals, tools, bases, calls, axes.
struct KrlMap : SignalMap {
  std::vector<std::string> axes;  ///< in the order of the arm's joints
  std::vector<double> offsets;    ///< deg: what the program says less what the joint has
  std::map<int, CellTool> tools;
  std::map<int, std::string> bases;  ///< number to frame
};

/// The keys of "map", for the schema.
[[nodiscard]] const Form& krl_map_form();

/// Reads "arm" and "map" of a node. Diagnostics: names that the cell does not have. Realtime: setup.
[[nodiscard]] KrlMap read_krl_map(ObjectReader& node, const expression::Cell& cell);

/// Signals that the program names by their numbers and the map does not have: each once, where it is used.
void check_signals(const KrlMap& map, const krl::Program& program, Diagnostics& diagnostics);

}  // namespace takt::languages
