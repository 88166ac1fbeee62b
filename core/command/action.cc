#include "core/command/action.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::command {

std::string ActionModel::add_state(FragmentWriter&, const std::string&, const nlohmann::ordered_json&) const {
  return {};
}

Result<std::shared_ptr<const ActionModel>> ActionModel::plan(const ActuatorModel&, const Places&) const {
  return failure(Code::kRequires, {}, std::string(name()) + " is not planned", "Give an action that plans itself");
}

Action::Action(std::shared_ptr<const ActionModel> model)
    : model_(std::move(model)),
      subject_(std::make_shared<const Subject>(Subject{Subject::Kind::kAction, std::string(model_->name())})) {}

State Action::at_path(double fraction) const {
  if (!(fraction >= 0.0 && fraction <= 1.0))
    return State(broken(Code::kOutOfRange, net::ValueType::kBoolean, fmt::format("a share of {:g} of a path", fraction),
                        "Choose a share from 0 to 1"));
  return State(leaf(net::ValueType::kBoolean, subject_, "at_path", {{"fraction", fraction}}));
}
State Action::via_passed(int i) const {
  return State(leaf(net::ValueType::kBoolean, subject_, "via_passed", {{"index", i}}));
}
RealSensor Action::progress() const { return value("progress"); }
RealSensor Action::value(const std::string& name) const {
  return RealSensor(leaf(net::ValueType::kReal, subject_, name));
}
State Action::state(const std::string& name) const { return State(leaf(net::ValueType::kBoolean, subject_, name)); }

}  // namespace takt::command
