// The functions of the language of expressions.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/activity/context.h"
#include "core/base/json.h"
#include "core/expression/condition_state.h"
#include "core/program/language/expression.h"
#include "core/program/language/text_limit.h"

namespace takt::program {
namespace {

using Call = Function::Call;
using Kind = Type::Kind;
using Changes = Function::Changes;
using expression::Quantity;

/// A number computed from numbers; its unit is given.
template <class F>
Value numeric(const Call& call, const net::Dimension& unit, F&& compute) {
  if (!call.all_known) return Value::unknown(Type::number(unit));
  const double value = compute();
  if (std::isfinite(value)) return Value::of(value, unit);
  call.errors.emplace_back("the result is not a number");
  return Value::unknown(Type::number(unit));
}

double number(const Call& call, std::size_t i) { return call.arguments[i].number(); }

/// Keeps the unit of its argument.
template <double (*f)(double)>
Value keeping(Call& call) {
  return numeric(call, call.arguments[0].type.unit, [&] { return f(number(call, 0)); });
}

/// Of a number without a unit, or an angle.
template <double (*f)(double)>
Value ratio(Call& call) {
  return numeric(call, {}, [&] { return f(number(call, 0)); });
}

template <double (*f)(double)>
Value inverse_angle(Call& call) {
  return numeric(call, unit_dimension("rad"), [&] { return f(number(call, 0)); });
}

double lesser(double a, double b) { return std::min(a, b); }
double greater(double a, double b) { return std::max(a, b); }
double absolute(double x) { return std::abs(x); }
double root(double x) { return std::sqrt(x); }
double rounded(double x) { return std::round(x); }
double rounded_down(double x) { return std::floor(x); }
double rounded_up(double x) { return std::ceil(x); }
double sine(double x) { return std::sin(x); }
double cosine(double x) { return std::cos(x); }
double tangent(double x) { return std::tan(x); }
double arc_cosine(double x) { return std::acos(x); }
double arc_sine(double x) { return std::asin(x); }

template <double (*f)(double, double)>
Value of_two(Call& call) {
  const Type &a = call.arguments[0].type, &b = call.arguments[1].type;
  if (a.kind == Kind::kNumber && b.kind == Kind::kNumber && a.unit != b.unit) {
    call.errors.push_back(fmt::format("a {} and a {} cannot be compared", to_string(a), to_string(b)));
  }
  return numeric(call, a.unit, [&] { return f(number(call, 0), number(call, 1)); });
}

Value arc_tangent(Call& call) {
  return numeric(call, unit_dimension("rad"), [&] { return std::atan2(number(call, 0), number(call, 1)); });
}

Value square_root(Call& call) {
  return numeric(call, net::Dimension{}.times(call.arguments[0].type.unit, {1, 2}),
                 [&] { return root(number(call, 0)); });
}

// -- Texts and lists -----------------------------------------------------------------------------------------------

Value as_text(Call& call) {
  std::string text = to_string(call.arguments[0]);
  if (text.size() <= kMostTextBytes) return Value::of(std::move(text));
  call.errors.push_back(fmt::format("a text of {} bytes, at most {}", text.size(), kMostTextBytes));
  return Value::unknown(Type::text());
}

Value known(Call& call) {
  return call.eval_context.mode == EvalContext::Mode::kCheck ? Value::unknown(Type::boolean())
                                                             : Value::of(!call.arguments[0].null());
}

Value choose(Call& call) {
  const Value& condition = call.arguments[0];
  const Type type = common(call.arguments[1].type, call.arguments[2].type);
  if (type.kind == Kind::kUnknown && call.arguments[1].type.kind != Kind::kUnknown &&
      call.arguments[2].type.kind != Kind::kUnknown) {
    call.errors.emplace_back("the two values are of different types");
  }
  if (condition.null()) return Value::unknown(type);
  return call.arguments[condition.boolean() ? 1 : 2];
}

Value length(Call& call) {
  return numeric(call, {}, [&] { return static_cast<double>(call.arguments[0].list().size()); });
}

Type element_type(const Value& list) { return list.type.kind == Kind::kList ? list.type.element.front() : Type{}; }

/// Bytes of all texts in a value. Recursion is bounded by its type.
std::size_t text_bytes(const Value& value) {
  if (value.null()) return 0;
  if (value.type.kind == Kind::kText) return value.text().size();
  if (value.type.kind != Kind::kList) return 0;
  std::size_t sum = 0;
  for (const Value& element : value.list()) sum += text_bytes(element);
  return sum;
}

Value append(Call& call) {
  const Value &list = call.arguments[0], &element = call.arguments[1];
  const Type wanted = element_type(list);
  if (!accepts(wanted, element.type)) {
    call.errors.push_back(fmt::format("a {} does not go into a {}", to_string(element.type), to_string(list.type)));
  }
  const Type type = Type::list_of(common(wanted, element.type));
  if (list.null()) return Value::unknown(type);
  constexpr std::size_t kMostElements = 100'000;
  if (list.list().size() >= kMostElements) {
    call.errors.emplace_back("a list of more than 100 000 elements");
    return list;
  }
  constexpr std::size_t kMostListBytes = 4u << 20;
  if (text_bytes(list) + text_bytes(element) > kMostListBytes) {
    call.errors.push_back(fmt::format("a list with more than {} bytes of text", kMostListBytes));
    return list;
  }
  std::vector<Value> values = list.list();
  values.push_back(element);
  return {type, std::move(values)};
}

bool numbers_of(Call& call, std::vector<double>& numbers) {
  if (!element_type(call.arguments[0]).is(Kind::kNumber)) {
    call.errors.emplace_back("a list of numbers is needed");
    return false;
  }
  if (call.arguments[0].null()) return false;
  for (const Value& value : call.arguments[0].list()) {
    if (value.null()) return false;
    numbers.push_back(value.number());
  }
  return true;
}

/// A number from a list of numbers; null if one of them is.
template <double (*f)(const std::vector<double>&)>
Value of_list(Call& call) {
  const Type type = Type::number(element_type(call.arguments[0]).unit);
  std::vector<double> numbers;
  if (!numbers_of(call, numbers)) return Value::unknown(type);
  const double value = f(numbers);
  if (std::isfinite(value)) return {type, value};
  // A rehearsal may not have filled the list.
  if (call.eval_context.running()) call.errors.emplace_back("an empty list has no such number");
  return Value::unknown(type);
}

double sum_of(const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); }
double mean_of(const std::vector<double>& x) { return sum_of(x) / static_cast<double>(x.size()); }
double least_of(const std::vector<double>& x) { return x.empty() ? NAN : *std::ranges::min_element(x); }
double greatest_of(const std::vector<double>& x) { return x.empty() ? NAN : *std::ranges::max_element(x); }

// -- Poses ---------------------------------------------------------------------------------------------------------

Value translation(Call& call) {
  if (!call.all_known) return Value::unknown(Type::pose());
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << number(call, 0), number(call, 1), number(call, 2);
  return Value::of(X);
}

Value turn(Call& call) {
  if (!call.all_known) return Value::unknown(Type::pose());
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = (Eigen::AngleAxisd(number(call, 2), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(number(call, 1), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(number(call, 0), Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return Value::of(X);
}

template <int axis>
Value component(Call& call) {
  return numeric(call, unit_dimension("m"), [&] { return call.arguments[0].pose().translation()[axis]; });
}

/// About the fixed z, the last of roll, pitch, yaw.
Value yaw(Call& call) {
  return numeric(call, unit_dimension("rad"), [&] {
    const Eigen::Matrix3d R = call.arguments[0].pose().linear();
    return std::atan2(R(1, 0), R(0, 0));
  });
}

Value distance(Call& call) {
  return numeric(call, unit_dimension("m"), [&] {
    return (call.arguments[0].pose().translation() - call.arguments[1].pose().translation()).norm();
  });
}

Value inverted(Call& call) {
  if (!call.all_known) return Value::unknown(Type::pose());
  return Value::of(Eigen::Isometry3d(call.arguments[0].pose().inverse()));
}

/// Frames that a program makes are not there when types are checked.
Value frame(Call& call) {
  if (!call.all_known || call.eval_context.mode == EvalContext::Mode::kCheck || !call.eval_context.cell) {
    return Value::unknown(Type::pose());
  }
  const bool relative = call.arguments.size() > 1;
  const auto X = call.eval_context.cell->frames.pose(call.arguments[0].text(),
                                                     relative ? call.arguments[1].text() : std::string("world"));
  if (X) return Value::of(*X);
  for (const Diagnostic& diagnostic : X.error().list()) call.errors.push_back(diagnostic.message);
  return Value::unknown(Type::pose());
}

// -- The cell ------------------------------------------------------------------------------------------------------

/// @param i  of the argument that names it
template <class Map>
auto device_of(Call& call, const Map& devices, const char* what, std::size_t i = 0) {
  const auto found = call.arguments[i].null() ? devices.end() : devices.find(call.arguments[i].text());
  if (found != devices.end() || call.arguments[i].null()) return found;
  std::vector<std::string> names;
  for (const auto& [name, device] : devices) names.push_back(name);
  call.errors.push_back(fmt::format("there is no {} '{}' ({})", what, call.arguments[i].text(),
                                    nearest_choice(call.arguments[i].text(), names)));
  return found;
}

Value analog_value(Call& call, const device::AnalogInput* input) {
  const net::Dimension unit = input ? unit_dimension(input->description().unit) : net::Dimension{};
  const Value unknown = Value::unknown(input ? Type::number(unit) : Type{});
  if (!input || !call.eval_context.running()) return unknown;
  const bool measured = input->has_sample() && std::isfinite(input->sample().value);
  return measured ? Value::of(input->sample().value, unit) : unknown;
}

Value input(Call& call) {
  if (!call.eval_context.cell || call.arguments[0].null()) return {};
  const auto analog = call.eval_context.cell->analog_inputs.find(call.arguments[0].text());
  if (analog != call.eval_context.cell->analog_inputs.end()) return analog_value(call, analog->second);
  const auto digital = device_of(call, call.eval_context.cell->digital_inputs, "input");
  if (digital == call.eval_context.cell->digital_inputs.end() || !call.eval_context.running() ||
      !digital->second->has_sample()) {
    return Value::unknown(Type::boolean());
  }
  return Value::of(digital->second->sample().value);
}

const device::Gripper* gripper_of(Call& call) {
  if (!call.eval_context.cell) return nullptr;
  const auto found = device_of(call, call.eval_context.cell->grippers, "gripper");
  if (found == call.eval_context.cell->grippers.end() || !call.eval_context.running()) return nullptr;
  return found->second.device->has_sample() ? found->second.device : nullptr;
}

Value width(Call& call) {
  const device::Gripper* gripper = gripper_of(call);
  const net::Dimension metre = unit_dimension("m");
  return gripper ? Value::of(gripper->sample().width, metre) : Value::unknown(Type::number(metre));
}

Value holding(Call& call) {
  const device::Gripper* gripper = gripper_of(call);
  if (!gripper) return Value::unknown(Type::boolean());
  return Value::of(gripper->sample().state == device::GripperState::kHolding);
}

/// Where the tool was sent last, in the world.
Value position(Call& call) {
  const Value unknown = Value::unknown(Type::pose());
  if (!call.eval_context.cell) return unknown;
  const auto found = device_of(call, call.eval_context.cell->arms, "arm");
  if (found == call.eval_context.cell->arms.end() || call.eval_context.mode == EvalContext::Mode::kCheck)
    return unknown;
  kinematics::JointVector q;
  if (call.eval_context.running()) {
    q = found->second.device->set_point().q;
  } else if (call.eval_context.q && call.eval_context.q->contains(found->first)) {
    q = call.eval_context.q->find(found->first)->second;
  }
  const auto X_WB = call.eval_context.cell->frames.pose(found->first);
  if (q.size() == 0 || !X_WB) return unknown;
  return Value::of(Eigen::Isometry3d(*X_WB * tool_pose(found->second, q)));
}

/// Where the last guarded motion of an arm touched.
Value touch(Call& call) {
  const Value unknown = Value::unknown(Type::pose());
  if (!call.eval_context.cell) return unknown;
  const auto found = device_of(call, call.eval_context.cell->arms, "arm");
  if (found == call.eval_context.cell->arms.end() || !call.eval_context.measured) return unknown;
  const auto touched = call.eval_context.measured->touches.find(found->first);
  if (touched == call.eval_context.measured->touches.end()) return unknown;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = touched->second.p_W;
  return Value::of(X);
}

Value residual(Call& call) {
  const net::Dimension metre = unit_dimension("m");
  const Value unknown = Value::unknown(Type::number(metre));
  if (!call.eval_context.measured || !call.all_known) return unknown;
  const auto found = call.eval_context.measured->residuals.find(call.arguments[0].text());
  return found == call.eval_context.measured->residuals.end() ? unknown : Value::of(found->second, metre);
}

/// The last value of a monitor of a net: a number or a Boolean.
Value monitor(Call& call) {
  if (!call.eval_context.measured || !call.all_known) return {};
  const auto net = call.eval_context.measured->monitors.find(call.arguments[0].text());
  if (net == call.eval_context.measured->monitors.end()) return {};
  const auto text = net->second.find(call.arguments[1].text());
  const auto json = text == net->second.end() ? Result<nlohmann::ordered_json>{} : parse_json(text->second);
  if (!json) return {};
  if (json->is_number()) return Value::of(json->get<double>());
  return json->is_boolean() ? Value::of(json->get<bool>()) : Value{};
}

/// A formula over contact wrenches, now.
Value contact_value(const Call& call, const net::Dimension& unit, const std::string& name,
                    const std::vector<std::string>& sensors, const std::function<expression::RealSensor()>& formula) {
  std::optional<double> felt;
  if (call.eval_context.readers == nullptr) {
    felt = formula().now();
  } else {
    std::vector<expression::ContactConstants> constants;
    std::string key = name;
    for (const std::string& sensor : sensors) {
      constants.push_back(
          expression::contact_constants(*call.eval_context.cell, sensor, call.eval_context.measured->biases));
      key += '/' + sensor;
    }
    felt = (*call.eval_context.readers)[key].now(std::move(constants), formula);
  }
  return felt ? Value::of(*felt, unit) : Value::unknown(Type::number(unit));
}

/// What conditions compare, now: the same formula, so weight and tared offset are removed.
template <Quantity quantity>
Value contact(Call& call) {
  const net::Dimension unit = unit_dimension(expression::is_torque(quantity) ? "Nm" : "N");
  const Value unknown = Value::unknown(Type::number(unit));
  if (!call.eval_context.cell) return unknown;
  const expression::Cell& cell = *call.eval_context.cell;
  const auto found = device_of(call, cell.sensors, "force/torque sensor");
  if (found == cell.sensors.end() || !call.eval_context.running() || !call.eval_context.measured) return unknown;
  const std::string& sensor = found->first;
  return contact_value(call, unit, std::to_string(static_cast<int>(quantity)), {sensor}, [&] {
    return expression::contact_quantity(cell, sensor, quantity, call.eval_context.measured->biases);
  });
}

/// What two arms do to the part that both hold, now: the formula of the condition of this name.
Value internal_force(Call& call) {
  const net::Dimension newton = unit_dimension("N");
  const Value unknown = Value::unknown(Type::number(newton));
  if (!call.eval_context.cell) return unknown;
  const expression::Cell& cell = *call.eval_context.cell;
  const auto one = device_of(call, cell.sensors, "force/torque sensor", 0);
  const auto other = device_of(call, cell.sensors, "force/torque sensor", 1);
  const bool there = one != cell.sensors.end() && other != cell.sensors.end();
  if (!there || !call.eval_context.running() || !call.eval_context.measured) return unknown;
  return contact_value(call, newton, "internal_force", {one->first, other->first}, [&] {
    return expression::internal_force(cell, one->first, other->first, call.eval_context.measured->biases);
  });
}

Value time(Call& call) {
  const net::Dimension second = unit_dimension("s");
  return call.eval_context.running() ? Value::of(to_seconds(call.eval_context.time), second)
                                     : Value::unknown(Type::number(second));
}

/// The bare number, in SI units.
Value magnitude(Call& call) {
  return numeric(call, {}, [&] { return number(call, 0); });
}

}  // namespace

const std::vector<Function>& functions() {
  static const std::vector<Function> table{
      {"abs", "n", "abs(x): size of a number", keeping<absolute>},
      {"acos", "d", "acos(x): angle", inverse_angle<arc_cosine>},
      {"append", "L*", "append(list, value): the list with one more element", append},
      {"asin", "d", "asin(x): angle", inverse_angle<arc_sine>},
      {"at", "lll", "at(x, y, z): a pose without a turn", translation},
      {"atan2", "nn", "atan2(y, x): angle", arc_tangent},
      {"ceil", "d", "ceil(x): next whole number", ratio<rounded_up>},
      {"cos", "a", "cos(angle)", ratio<cosine>},
      {"distance", "pp", "distance(pose, pose): between their origins", distance},
      {"floor", "d", "floor(x): whole number below", ratio<rounded_down>},
      {"force", "t", "force('sensor'): contact force now, its length; weight and tared offset are removed",
       contact<Quantity::kForce>, Changes::kAlways},
      {"force_x", "t", "force_x('sensor'): along x of its measuring frame", contact<Quantity::kForceX>,
       Changes::kAlways},
      {"force_y", "t", "force_y('sensor'): along y of its measuring frame", contact<Quantity::kForceY>,
       Changes::kAlways},
      {"force_z", "t", "force_z('sensor'): along z of its measuring frame", contact<Quantity::kForceZ>,
       Changes::kAlways},
      {"greatest", "L", "greatest(list): of numbers", of_list<greatest_of>},
      {"holding", "t", "holding('gripper'): it holds a part", holding, Changes::kAlways},
      {"input", "t", "input('name'): level or value of an input now", input, Changes::kAlways},
      {"internal_force", "tt", "internal_force('sensor', 'sensor'): what two arms do to the part between them, now",
       internal_force, Changes::kAlways},
      {"inverse", "p", "inverse(pose)", inverted},
      {"known", "*", "known(x): x is not null", known},
      {"least", "L", "least(list): of numbers", of_list<least_of>},
      {"length", "L", "length(list): number of elements", length},
      {"magnitude", "n", "magnitude(x): the number in SI units, without its unit", magnitude},
      {"max", "nn", "max(x, y)", of_two<greater>},
      {"mean", "L", "mean(list): of numbers", of_list<mean_of>},
      {"min", "nn", "min(x, y)", of_two<lesser>},
      {"monitor", "tt", "monitor('net', 'id'): last value that a monitor showed", monitor},
      {"pose", "t?t", "pose('frame') in the world, or pose('frame', 'frame') of the first in the second", frame,
       Changes::kFrames},
      {"position", "t", "position('arm'): pose of the tool centre point in the world, as sent", position,
       Changes::kAlways},
      {"residual", "t", "residual('estimate'): rms of a fit", residual},
      {"round", "d", "round(x): nearest whole number", ratio<rounded>},
      {"rpy", "aaa", "rpy(roll, pitch, yaw): a pose that only turns", turn},
      {"select", "b**", "select(condition, a, b): a if it holds, else b", choose},
      {"sin", "a", "sin(angle)", ratio<sine>},
      {"sqrt", "n", "sqrt(x)", square_root},
      {"sum", "L", "sum(list): of numbers", of_list<sum_of>},
      {"tan", "a", "tan(angle)", ratio<tangent>},
      {"text", "*", "text(x): for people", as_text},
      {"time", "", "time(): simulated time since the start", time, Changes::kAlways},
      {"torque", "t", "torque('sensor'): contact torque now, its length; weight and tared offset are removed",
       contact<Quantity::kTorque>, Changes::kAlways},
      {"torque_x", "t", "torque_x('sensor'): about x of its measuring frame", contact<Quantity::kTorqueX>,
       Changes::kAlways},
      {"torque_y", "t", "torque_y('sensor'): about y of its measuring frame", contact<Quantity::kTorqueY>,
       Changes::kAlways},
      {"torque_z", "t", "torque_z('sensor'): about z of its measuring frame", contact<Quantity::kTorqueZ>,
       Changes::kAlways},
      {"touch", "t", "touch('arm'): where its last guarded motion touched, in the world", touch, Changes::kAlways},
      {"width", "t", "width('gripper'): between its fingers now", width, Changes::kAlways},
      {"x", "p", "x(pose)", component<0>},
      {"y", "p", "y(pose)", component<1>},
      {"yaw", "p", "yaw(pose): turn about z", yaw},
      {"z", "p", "z(pose)", component<2>},
  };
  return table;
}

}  // namespace takt::program
