#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "core/base/form.h"
#include "core/base/object_reader.h"
#include "core/expression/cell.h"
#include "languages/krl/program.h"

namespace takt::languages {

/// A tool centre point of the cell, as steps name it.
struct CellTool {
  std::string tool, tcp;  ///< empty: what the cell declares
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
};

/// What the numbers and names of a robot program are in a cell: signals, tools, bases, calls, axes.
struct KrlMap {
  std::string arm;
  std::vector<std::string> axes;  ///< in the order of the arm's joints
  std::vector<double> offsets;    ///< deg: what the program says less what the joint has
  std::map<int, std::string> inputs, analog_inputs, analog_outputs;
  /// A digital output: one of the cell, or steps as JSON for true and for false.
  struct Output {
    std::string name, on, off;
  };
  std::map<int, Output> outputs;
  std::map<std::string, std::string> calls;  ///< name in capitals to steps as JSON
  std::map<int, CellTool> tools;
  std::map<int, std::string> bases;  ///< number to frame
  std::set<int> nominal_inputs;      ///< true in a rehearsal

  /// The tool centre point that the cell has there.
  [[nodiscard]] std::optional<CellTool> find_tool(const expression::Cell& cell, const Eigen::Isometry3d& X_FT) const;
};

/// The keys of "map", for the schema.
[[nodiscard]] const Form& krl_map_form();

/// Reads "arm" and "map" of a node. Diagnostics: names that the cell does not have. Realtime: setup.
[[nodiscard]] KrlMap read_krl_map(ObjectReader& node, const expression::Cell& cell);

/// Signals that the program names by their numbers and the map does not have: each once, where it is used.
void check_signals(const KrlMap& map, const krl::Program& program, Diagnostics& diagnostics);

}  // namespace takt::languages
