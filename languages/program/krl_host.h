#pragma once

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "languages/krl/machine.h"
#include "languages/program/krl_map.h"
#include "languages/program/krl_steps.h"

namespace takt::languages {

/// What a run and a rehearsal of a program have in common: names, kinematics, and what was given and has not begun.
class KrlHost : public krl::Host {
 public:
  KrlHost(const KrlMap& map, const expression::Cell& cell) : map_(map), cell_(cell) {}

  void move(krl::MotionCommand motion) override;
  [[nodiscard]] std::string write(krl::Live output, int number, double value, std::optional<double> pulse,
                                  bool beside) override;
  void call(const std::string& name, int module, const TextLocation& at) override;
  [[nodiscard]] const std::vector<std::string>& axis_names() const override { return map_.axes; }
  [[nodiscard]] std::vector<double> axes() override { return to_axes(position()); }
  [[nodiscard]] Eigen::Isometry3d flange(const std::vector<double>& axes) override;

  /// Gives a machine the tools and bases of the map, and where the arm rests by its model.
  void prepare(krl::Machine& machine);

 protected:
  /// Where the arm is, rad or m.
  [[nodiscard]] virtual kinematics::JointVector position() const = 0;
  /// Steps that begin at once.
  virtual void run_beside(KrlItem item) = 0;
  [[nodiscard]] const expression::MountedArm& arm() const { return cell_.arms.find(map_.arm)->second; }
  [[nodiscard]] std::vector<double> to_axes(const kinematics::JointVector& q) const;

  const KrlMap& map_;
  const expression::Cell& cell_;
  std::deque<KrlItem> queue_;
  std::map<std::pair<krl::Live, int>, double> written_;
};

}  // namespace takt::languages
