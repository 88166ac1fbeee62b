#pragma once

#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/force/pressing.h"
#include "core/operations/force/search_pattern.h"

/// "search": presses and follows a spiral or a zigzag until something is found. Realtime: setup.
namespace takt::operations {

struct SearchParameters {
  std::string arm = {}, sensor = {};  ///< empty: the only one
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  std::string in = "tcp";                                ///< whose axes the direction is along
  double force = 10.0, approach = 0.002, travel = 0.05;  ///< N, m/s, m
  SearchPattern pattern = SearchPattern::kSpiral;
  double radius = 0.01, pitch = 0.001, velocity = 0.01;  ///< m, m, m/s
  std::optional<double> drop = {};                       ///< m; found: so much deeper than at contact
  std::optional<expression::StateSource> until = {};     ///< found: it holds
  bool must_find = true;                                 ///< a pattern that ends without anything found is a failure
  std::optional<ComplianceParameters> compliance = {};
  double tolerance = 0.1;                                ///< share of the force: so far off counts as at force
  std::optional<double> depth = {};                      ///< m beyond the touch at most
  std::optional<double> lateral = {};                    ///< N across the direction at most
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};

[[nodiscard]] const ParameterTable<SearchParameters>& search_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> search_command(const SearchParameters& parameters);
[[nodiscard]] inline OperationForm<SearchParameters> form_of(const SearchParameters&) {
  return {"search", search_parameters, &SearchParameters::arm, search_command};
}
[[nodiscard]] Operation search_operation();

}  // namespace takt::operations
