#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/form.h"
#include "languages/program/signal_map.h"
#include "languages/urscript/session.h"

namespace takt::languages {

/// What the numbers and names of a program in URScript are in a cell (docs/urscript.md).
struct UrscriptMap : SignalMap {
  std::map<std::string, std::string> frames;  ///< variable to frame: its pose in the base of the arm
  std::map<std::string, CellTool> tools;      ///< variable to the tool centre point that it holds
  std::string pose_channel;                   ///< of type Frame: servoj() and servoc() write it; empty: none
  std::string velocity_channel;               ///< of type Twist: speedl() writes it
  std::string enable_channel;                 ///< of type Boolean: true while speedl() moves the arm
  std::string sensor;                         ///< force/torque sensor of force_mode(); empty: the only one
  double travel = 0.05;                       ///< m: force_mode() looks so far for the contact

  /// The names of the variables that a program has before its first statement; the order of given().
  [[nodiscard]] std::vector<std::string> given_names() const;
  /// The same with their values, as the cell is now.
  [[nodiscard]] std::vector<urscript::GivenVariable> given(const expression::Cell& cell) const;
};

/// The keys of "map", for the schema.
[[nodiscard]] const Form& urscript_map_form();

/// Reads "arm" and "map" of a node. Diagnostics: names that the cell does not have. Realtime: setup.
[[nodiscard]] UrscriptMap read_urscript_map(ObjectReader& node, const expression::Cell& cell);

/// What a program calls and the map has nothing for: signals by their numbers, channels; notes of calls that are data
/// only. Each once, where it is called.
void check_calls(const UrscriptMap& map, const urscript::Program& program, const std::string& file,
                 Diagnostics& diagnostics);

}  // namespace takt::languages
