#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "core/base/object_reader.h"
#include "core/expression/cell.h"
#include "core/program/tree/node.h"

namespace takt::languages {

/// A tool centre point of the cell, as steps name it.
struct CellTool {
  std::string tool, tcp;  ///< empty: what the cell declares
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
};

/// What the numbers of signals and the calls of a robot program are in a cell.
struct SignalMap {
  std::string arm;
  std::map<int, std::string> inputs, analog_inputs, analog_outputs;
  /// A digital output: one of the cell, or steps as JSON for true and for false.
  struct Output {
    std::string name, on, off;
  };
  std::map<int, Output> outputs;
  std::map<std::string, std::string> calls;  ///< name to steps as JSON
  std::set<int> nominal_inputs;              ///< true in a rehearsal

  /// The tool centre point that the cell has there.
  [[nodiscard]] std::optional<CellTool> find_tool(const expression::Cell& cell, const Eigen::Isometry3d& X_FT) const;
  /// The tool centre point that counts where a step names none.
  [[nodiscard]] Eigen::Isometry3d usual_tool(const expression::Cell& cell) const;
};

/// A pose in a frame as the goal of a motion.
[[nodiscard]] nlohmann::ordered_json pose_goal(const Eigen::Isometry3d& X, const std::string& frame);

/// The step that writes a digital or analog output. Null: the map has none.
[[nodiscard]] nlohmann::ordered_json output_step(const SignalMap& map, bool analog, int number, double value);

/// Reads the parts of a map that languages have in common. Diagnostics: names that the cell does not have.
class SignalMapReader {
 public:
  /// @param lowest  number of a signal; the reader and the others outlive it
  SignalMapReader(ObjectReader& reader, const expression::Cell& cell, SignalMap& map, int lowest)
      : reader_(reader), cell_(cell), map_(map), lowest_(lowest) {}

  void read();
  /// A tool of the arm, "NAME" or "NAME/TCP"; nothing with a diagnostic.
  [[nodiscard]] std::optional<CellTool> tool(const nlohmann::ordered_json& value, const std::string& at);
  /// A frame of the cell; empty with a diagnostic.
  [[nodiscard]] std::string frame(const nlohmann::ordered_json& value, const std::string& at);
  /// The members of an object whose keys are numbers of signals.
  void each(
      std::string_view key,
      const std::function<void(int number, const nlohmann::ordered_json& value, const std::string& at)>& function);
  void error(Code code, const std::string& at, std::string message, std::string hint) {
    reader_.diagnostics().error(code, at, std::move(message), std::move(hint));
  }

 private:
  [[nodiscard]] std::optional<int> number(const std::string& name, const std::string& at);
  void signals(std::string_view key, const std::vector<std::string>& known, std::map<int, std::string>& to);
  void outputs();
  void calls();

  ObjectReader& reader_;
  const expression::Cell& cell_;
  SignalMap& map_;
  int lowest_;
};

/// The arm that a node names with "arm", or the only one; empty with a diagnostic.
[[nodiscard]] std::string read_arm(ObjectReader& node, const expression::Cell& cell);

/// The form of the steps that a map has, in the text of a program as if they were in it.
void check_steps(const SignalMap& map, const std::string& pointer, program::NodeParser& parser);

}  // namespace takt::languages
