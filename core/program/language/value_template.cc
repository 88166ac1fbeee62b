#include "core/program/language/value_template.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/expression/moving_frames.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

/// Calls `visit(text, pointer)` for every text that is an expression. Keys for comments hold none. Recursion is bounded
/// by the depth that JSON files may have.
template <class Visit>
void for_each_expression(const Json& json, const std::string& pointer, const Visit& visit) {
  if (json.is_string()) {
    const auto& text = json.get_ref<const std::string&>();
    if (is_expression(text)) visit(text, pointer);
  } else if (json.is_object()) {
    for (const auto& [key, value] : json.items()) {
      if (key.starts_with("$") || key == "comment") continue;
      for_each_expression(value, pointer + pointer_segment(key), visit);
    }
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) for_each_expression(json[i], pointer + pointer_segment(i), visit);
  }
}

/// Keys of a pose: position_m, rpy_deg, quaternion.
std::optional<net::FileUnit> unit_in_pose(std::string_view pointer) {
  if (pointer.find("/position_m") != std::string_view::npos) return net::file_unit("m");
  if (pointer.find("/rpy_deg") != std::string_view::npos) return net::file_unit("deg");
  return net::FileUnit{};
}

Json number_json(double value) {
  constexpr double kExact = 9e15;
  if (value == std::floor(value) && std::abs(value) < kExact) return static_cast<std::int64_t>(value);
  return value;
}

}  // namespace

/// Replaces expressions, walking down a piece of a file.
class ValueTemplate::Resolver {
 public:
  Resolver(const ValueTemplate& whole, const EvalContext& eval_context, expression::Cell& cell, const UnitOf& unit_of,
           Diagnostics& diagnostics)
      : whole_(whole), sight_(eval_context), cell_(cell), unit_of_(unit_of), diagnostics_(diagnostics) {}

  Json resolve(const Json& json, const std::string& pointer, std::string_view key) {
    if (json.is_object()) {
      Json result = Json::object();
      for (const auto& [name, value] : json.items())
        result[name] = resolve(value, pointer + pointer_segment(name), name);
      return result;
    }
    if (json.is_array()) {
      Json result = Json::array();
      for (std::size_t i = 0; i < json.size(); ++i) {
        result.push_back(resolve(json[i], pointer + pointer_segment(i), key));
      }
      return result;
    }
    const auto expression = whole_.expressions_.find(pointer);
    if (expression == whole_.expressions_.end()) return plain(json);
    Diagnostics own;
    const Value value = expression->second.evaluate(sight_, own);
    diagnostics_.append(own, pointer);
    if (value.null() || own.has_errors()) unknown.push_back(expression->second.text());
    return in_file(value, pointer, key);
  }

  std::vector<std::string> unknown;

 private:
  /// "$$" stands for a "$".
  static Json plain(const Json& json) {
    if (!json.is_string() || !json.get_ref<const std::string&>().starts_with("$$")) return json;
    return json.get_ref<const std::string&>().substr(1);
  }

  Json in_file(const Value& value, const std::string& pointer, std::string_view key) {
    switch (value.type.kind) {
      case Type::Kind::kNumber:
        return number(value, pointer, key);
      case Type::Kind::kBoolean:
        return value.null() || value.boolean();
      case Type::Kind::kText:
        return value.null() ? std::string("text") : value.text();
      case Type::Kind::kPose:
        return pose(value, pointer, key);
      case Type::Kind::kList: {
        Json list = Json::array();
        if (value.null()) return list;
        for (const Value& element : value.list()) list.push_back(in_file(element, pointer, key));
        return list;
      }
      case Type::Kind::kUnknown:
        break;
    }
    return 1;
  }

  Json number(const Value& value, const std::string& pointer, std::string_view key) {
    const std::optional<net::FileUnit> wanted = unit_of_(std::string_view(pointer).substr(whole_.pointer_.size()));
    const bool bare = value.type.unit.zero();
    if (wanted && !bare && value.type.unit != wanted->dimension) {
      diagnostics_.error(Code::kUnitMismatch, pointer, fmt::format("'{}' is given a {}", key, to_string(value.type)),
                         wanted->dimension.zero() ? "Give a number without a unit"
                                                  : "Give a number in " + net::to_string(wanted->dimension));
    }
    if (value.null()) return 1;
    return number_json(bare || !wanted ? value.number() : value.number() * wanted->units_per_si);
  }

  /// At "in" a pose is a frame; elsewhere it is as it would be written.
  Json pose(const Value& value, const std::string& pointer, std::string_view key) {
    if (key != "in") {
      Json place = pose_to_json(value.null() ? Eigen::Isometry3d::Identity() : value.pose());
      place["in"] = "world";
      return place;
    }
    if (value.null()) return "world";
    const std::string frame = "$" + pointer;
    diagnostics_.append(cell_.frames.set(frame, std::string(world::FrameGraph::kWorld), value.pose()), pointer);
    return frame;
  }

  const ValueTemplate& whole_;
  const EvalContext& sight_;
  expression::Cell& cell_;
  const UnitOf& unit_of_;
  Diagnostics& diagnostics_;
};

ValueTemplate ValueTemplate::parse(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ValueTemplate result;
  result.json_ = std::make_shared<const Json>(json);
  result.pointer_ = pointer;
  for_each_expression(json, pointer, [&](const std::string& text, const std::string& place) {
    auto expression = Expression::parse(std::string_view(text).substr(1));
    if (expression) {
      result.expressions_.emplace(place, std::move(*expression));
    } else {
      diagnostics.append(expression.error(), place);
    }
  });
  return result;
}

namespace {

bool is_place_that_moves(const Json& json, const expression::Cell& cell) {
  if (json.is_array())
    return std::ranges::any_of(json, [&](const Json& one) { return is_place_that_moves(one, cell); });
  if (!json.is_object()) return false;
  const auto in = json.find("in");
  return in != json.end() && in->is_string() &&
         expression::moves(cell.frames, in->get_ref<const std::string&>(), world::FrameGraph::kWorld);
}

}  // namespace

bool ValueTemplate::changes(const expression::Cell& cell) const {
  if (json_ && is_place_that_moves(*json_, cell)) return true;
  return std::ranges::any_of(expressions_, [&](const auto& entry) { return entry.second.changes(cell); });
}

bool ValueTemplate::depends(std::string_view pointer) const {
  for (const auto& [place, expression] : expressions_) {
    const bool below = pointer.starts_with(place) && (pointer.size() == place.size() || pointer[place.size()] == '/');
    const bool above = place.starts_with(pointer) && place.size() > pointer.size() && place[pointer.size()] == '/';
    if (below || (above && pointer.size() > pointer_.size())) return true;
  }
  return false;
}

bool ValueTemplate::depends_on_key(std::string_view key) const {
  const std::string place = pointer_ + pointer_segment(key);
  for (const auto& [pointer, expression] : expressions_) {
    if (pointer == place || pointer.starts_with(place + "/")) return true;
  }
  return false;
}

ValueTemplate::Resolved ValueTemplate::resolve(const EvalContext& eval_context, expression::Cell& cell,
                                               const UnitOf& unit_of, Diagnostics& diagnostics) const {
  Resolver resolver(*this, eval_context, cell, unit_of, diagnostics);
  auto json = std::make_shared<const Json>(resolver.resolve(*json_, pointer_, ""));
  return {std::move(json), std::move(resolver.unknown)};
}

namespace {

/// A goal of a file as a pose in the world.
Value place_value(const Json& json, const std::string& pointer, const EvalContext& eval_context,
                  Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  const std::string in = reader.text("in", "world");
  const Eigen::Isometry3d X = reader.pose();
  reader.finish();
  if (eval_context.mode == EvalContext::Mode::kCheck || !eval_context.cell) return Value::unknown(Type::pose());
  const auto X_WI = eval_context.cell->frames.pose(in);
  if (X_WI) return Value::of(Eigen::Isometry3d(*X_WI * X));
  diagnostics.append(X_WI.error(), pointer + "/in");
  return Value::unknown(Type::pose());
}

}  // namespace

Value ValueTemplate::value(const EvalContext& eval_context, Diagnostics& diagnostics) const {
  struct Walk {
    const ValueTemplate& whole;
    const EvalContext& eval_context;
    Diagnostics& diagnostics;

    Value at(const Json& json, const std::string& pointer) {
      if (json.is_boolean()) return Value::of(json.get<bool>());
      if (json.is_number()) return Value::of(json.get<double>());
      if (json.is_array()) return list(json, pointer);
      if (json.is_string()) return text(json.get_ref<const std::string&>(), pointer);
      if (json.is_object()) return place(json, pointer);
      return {};
    }
    Value list(const Json& json, const std::string& pointer) {
      std::vector<Value> values;
      for (std::size_t i = 0; i < json.size(); ++i) values.push_back(at(json[i], pointer + pointer_segment(i)));
      Value result = Value::of(std::move(values));
      const Type& element = result.type.element.front();
      for (std::size_t i = 0; i < result.list().size(); ++i) {
        const Type& given = result.list()[i].type;
        if (given.kind == Type::Kind::kUnknown || (element.kind != Type::Kind::kUnknown && accepts(element, given))) {
          continue;
        }
        diagnostics.error(Code::kTypeMismatch, pointer + pointer_segment(i),
                          fmt::format("a {} in this list", to_string(given)), "Use elements of one type and one unit");
      }
      return result;
    }
    Value text(const std::string& text, const std::string& pointer) {
      const auto expression = whole.expressions_.find(pointer);
      if (expression == whole.expressions_.end()) return Value::of(text.starts_with("$$") ? text.substr(1) : text);
      Diagnostics own;
      Value value = expression->second.evaluate(eval_context, own);
      diagnostics.append(own, pointer);
      return value;
    }
    /// A goal with expressions in it is resolved first.
    Value place(const Json& json, const std::string& pointer) {
      expression::Cell frames;
      if (eval_context.cell) frames.frames = eval_context.cell->frames;
      const UnitOf unit_of = unit_in_pose;
      Resolver resolver(whole, eval_context, frames, unit_of, diagnostics);
      const Json resolved = resolver.resolve(json, pointer, "");
      EvalContext inside = eval_context;
      inside.cell = &frames;
      Diagnostics own;
      const Value value = place_value(resolved, pointer, inside, own);
      for (const Diagnostic& diagnostic : own.list()) {
        if (resolver.unknown.empty() || !whole.depends(diagnostic.pointer)) diagnostics.add(diagnostic);
      }
      return resolver.unknown.empty() ? value : Value::unknown(Type::pose());
    }
  };
  return json_ ? Walk{*this, eval_context, diagnostics}.at(*json_, pointer_) : Value{};
}

}  // namespace takt::program
