#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/operations/table/step.h"
#include "languages/program/step_line.h"
#include "languages/program/urscript_map.h"

namespace takt::languages {

/// What a program has given and what has not begun: a step, and where it is written.
struct ScriptItem {
  std::shared_ptr<const nlohmann::ordered_json> step;
  std::string name;
  TextLocation at;
  bool moves = false, blends = false;
  bool lasts = false;  ///< until something else is commanded
};

/// Motions that are planned as one, or one other item.
class ScriptGroup final : public StepGroup {
 public:
  /// Takes from the front what begins as one. `file` outlives it.
  ScriptGroup(std::deque<ScriptItem>& queue, const std::string& file);
  ScriptGroup(ScriptItem item, const std::string& file) : items{std::move(item)}, file_(file) {}

  [[nodiscard]] nlohmann::ordered_json to_step(Diagnostics& diagnostics) const override;
  void locate(Diagnostics& diagnostics) const override;

  std::vector<ScriptItem> items;

 private:
  const std::string& file_;
};

/// What a run and a rehearsal of a program have in common: kinematics, and what was given and has not begun.
class UrscriptHost : public urscript::Host {
 public:
  UrscriptHost(const UrscriptMap& map, const expression::Cell& cell, const std::string& file)
      : map_(map), cell_(cell), file_(file) {}

  [[nodiscard]] std::string move(urscript::MotionCommand motion) override;
  [[nodiscard]] std::string write(urscript::Signal output, int number, double value, bool beside,
                                  const TextLocation& at) override;
  void call(const std::string& name, const TextLocation& at) override;
  [[nodiscard]] std::string tare(const TextLocation& at) override;
  [[nodiscard]] Eigen::Isometry3d flange(const kinematics::JointVector& q) override;
  [[nodiscard]] std::optional<kinematics::JointVector> solve(const Eigen::Isometry3d& X_BF,
                                                             const kinematics::JointVector& near) override;
  [[nodiscard]] Eigen::Isometry3d tool() const override { return map_.usual_tool(cell_); }

 protected:
  /// Steps that begin at once.
  virtual void run_beside(ScriptItem item) = 0;
  /// A rehearsal that begins where the arm is now.
  [[nodiscard]] virtual operations::Rehearsal trial() = 0;
  [[nodiscard]] const expression::MountedArm& arm() const { return cell_.arms.find(map_.arm)->second; }
  /// What was written to an output, or what another signal has; nothing: there is none.
  [[nodiscard]] std::optional<double> written(urscript::Signal output, int number) const;
  void give(ScriptItem item) { queue_.push_back(std::move(item)); }
  /// Where the arm will be is not known from what was given.
  void forget_goal() { last_flange_.reset(); }

  const UrscriptMap& map_;
  const expression::Cell& cell_;
  const std::string& file_;
  std::deque<ScriptItem> queue_;
  std::map<std::pair<urscript::Signal, int>, double> written_;

 private:
  [[nodiscard]] std::string fit_time(nlohmann::ordered_json& step, double seconds);
  [[nodiscard]] double duration_of(const nlohmann::ordered_json& step, std::string& problem);

  std::optional<Eigen::Isometry3d> last_flange_;
};

}  // namespace takt::languages
