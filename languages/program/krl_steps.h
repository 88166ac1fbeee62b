#pragma once

#include <deque>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "languages/krl/machine.h"
#include "languages/program/krl_map.h"

namespace takt::languages {

/// What a program has given and what has not begun: a motion, or steps as JSON.
struct KrlItem {
  std::optional<krl::MotionCommand> motion;
  std::string steps, name;
  int module = 0;
  TextLocation at;
};

/// Motions that are planned as one, or one other item.
struct KrlGroup {
  std::vector<KrlItem> items;
  [[nodiscard]] bool moves() const { return items.front().motion.has_value(); }
};

/// "12: PTP XP1 C_PTP".
[[nodiscard]] std::string step_name(const TextLocation& at, const std::string& text);

/// Takes from the front what begins as one: motions that are blended into each other, or one item.
[[nodiscard]] KrlGroup take_group(std::deque<KrlItem>& queue);

/// The group as a step of a program, all in SI units or those of the keys. Diagnostics with locations: what no step can
/// do. Null then. Realtime: setup.
[[nodiscard]] nlohmann::ordered_json to_step(const KrlGroup& group, const KrlMap& map, const expression::Cell& cell,
                                             const krl::Program& program, Diagnostics& diagnostics);

/// The step that writes a digital or analog output. Null: the map has none.
[[nodiscard]] nlohmann::ordered_json output_step(const KrlMap& map, krl::Live output, int number, double value,
                                                 std::optional<double> pulse);

/// Puts diagnostics of a step of the group where it is written.
void locate(Diagnostics& diagnostics, const KrlGroup& group, const krl::Program& program);

}  // namespace takt::languages
