#include "core/command/action.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::command {

std::string ActionModel::add_state(expression::FragmentWriter&, const std::string&,
                                   const nlohmann::ordered_json&) const {
  return {};
}

Result<std::shared_ptr<const ActionModel>> ActionModel::plan(const ActuatorModel&, const expression::Places&) const {
  return failure(Code::kRequires, {}, std::string(name()) + " is not planned", "Give an action that plans itself");
}

Action::Action(std::shared_ptr<const ActionModel> model)
    : model_(std::move(model)),
      subject_(std::make_shared<const expression::Subject>(
          expression::Subject{expression::Subject::Kind::kAction, std::string(model_->name())})) {}

expression::State Action::at_path(double fraction) const {
  if (!(fraction >= 0.0 && fraction <= 1.0))
    return expression::State(expression::broken(Code::kOutOfRange, net::ValueType::kBoolean,
                                                fmt::format("a share of {:g} of a path", fraction),
                                                "Choose a share from 0 to 1"));
  return expression::State(expression::leaf(net::ValueType::kBoolean, subject_, "at_path", {{"fraction", fraction}}));
}
expression::State Action::via_passed(int i) const {
  return expression::State(expression::leaf(net::ValueType::kBoolean, subject_, "via_passed", {{"index", i}}));
}
expression::RealSensor Action::progress() const { return value("progress"); }
expression::RealSensor Action::value(const std::string& name) const {
  return expression::RealSensor(expression::leaf(net::ValueType::kReal, subject_, name));
}
expression::State Action::state(const std::string& name) const {
  return expression::State(expression::leaf(net::ValueType::kBoolean, subject_, name));
}

}  // namespace takt::command
