#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/interfaces/operation_by_name.h"
#include "python/expressions.h"

/// What Python hands over of an operation. Realtime: setup.
namespace takt::python {

using Activity = Owned<activity::Activity>;
using Run = Owned<activity::RunPtr>;
struct Goal {
  operations::Goal goal;
};

/// Parameters in a form that files do not have, by key (app::ProgramValues).
struct Values {
  std::map<std::string, State> states;
  std::map<std::string, std::vector<Goal>> goals;
  std::optional<double> blend;
  std::optional<Eigen::Matrix4d> X_FM;

  [[nodiscard]] app::ProgramValues in_program() const;
};

/// JSON of Python; what it writes is always JSON.
[[nodiscard]] nlohmann::ordered_json json_from(const std::string& text);

}  // namespace takt::python
