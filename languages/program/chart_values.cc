#include "languages/program/chart_values.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/program/language/value_template.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;
using program::Value;

Json json_of(const Value& value) {
  if (value.null()) return nullptr;
  switch (value.type.kind) {
    case program::Type::Kind::kBoolean:
      return value.boolean();
    case program::Type::Kind::kNumber:
      return value.number();
    case program::Type::Kind::kText:
      return value.text();
    case program::Type::Kind::kPose:
      return program::pose_to_json(value.pose());
    default:
      break;
  }
  Json list = Json::array();
  for (const Value& one : value.list()) list.push_back(json_of(one));
  return list;
}

/// A text from a script is no expression.
void quote_texts(Json& json) {
  if (json.is_string() && json.get_ref<const std::string&>().starts_with('$')) json = "$" + json.get<std::string>();
  if (json.is_structured())
    for (Json& one : json) quote_texts(one);
}

}  // namespace

Data to_data(const Value& value) {
  return Data::of_json(json_of(value).dump(-1, ' ', false, Json::error_handler_t::replace));
}

Value to_value(const Data& data, const program::Type& wanted, const program::EvalContext& eval_context,
               Diagnostics& diagnostics) {
  auto json = data.kind == Data::Kind::kJson ? parse_json(data.text) : Result<Json>(Json());
  if (!json || json->is_null()) return Value::unknown(wanted);
  quote_texts(*json);
  Diagnostics own;
  const auto piece = program::ValueTemplate::parse(*json, {}, own);
  Value value = own.has_errors() ? Value::unknown(wanted) : piece.value(eval_context, own);
  if (!own.has_errors() && !program::accepts(wanted, value.type))
    own.error(Code::kTypeMismatch, {}, fmt::format("unexpected {}", program::to_string(value.type)),
              "Give a " + program::to_string(wanted));
  diagnostics.append(own);
  return own.has_errors() ? Value::unknown(wanted) : value;
}

}  // namespace takt::languages
