// Executable content, data and calls of a session (SCXML 1.0, sections 4 to 6).
#include <algorithm>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "languages/scxml/session.h"
#include "languages/scxml/system.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;
using Action = ChartAction::Kind;

/// A loop over more elements runs too long for one cycle.
constexpr std::size_t kMostRounds = 100'000;

/// The text of a value: that of a string, otherwise its JSON.
std::string plain_text(const Data& data) {
  if (data.kind != Data::Kind::kJson) return data.text;
  const Json json = Json::parse(data.text, nullptr, false);
  return json.is_string() ? json.get<std::string>() : data.text;
}

bool is_chart_type(std::string_view type) {
  if (type.ends_with('/')) type.remove_suffix(1);
  return type.empty() || type == "scxml" || type == "http://www.w3.org/TR/scxml";
}

Data object_of(const std::vector<std::pair<std::string, Data>>& members) {
  if (members.empty()) return {};
  std::string text = "{";
  for (const auto& [name, value] : members) {
    if (value.kind == Data::Kind::kUndefined) continue;
    if (text.size() > 1) text += ',';
    text += Json(name).dump(-1, ' ', false, Json::error_handler_t::replace) + ":";
    text += value.kind == Data::Kind::kJson ? value.text
                                            : Json(value.text).dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  return Data::of_json(text + "}");
}

}  // namespace

void ChartSession::tell(std::string_view what, const std::string& text) const {
  if (system_.surroundings().told) system_.surroundings().told(*this, what, text);
}

bool ChartSession::error(std::string_view name, const std::string& why, const std::string& sendid) {
  tell("error", fmt::format("{}: {}", name, why));
  if (model_->exhausted()) {
    fail(why);
    return false;
  }
  Data data = Data::of_json(Json{{"text", why}}.dump(-1, ' ', false, Json::error_handler_t::replace));
  raise({.name = std::string(name), .type = ChartEvent::Type::kPlatform, .sendid = sendid, .data = std::move(data)});
  return false;
}

bool ChartSession::run(const Block& block) {
  return std::ranges::all_of(block, [&](const ChartAction& action) { return failure_.empty() && run_action(action); });
}

bool ChartSession::run_action(const ChartAction& action) {
  switch (action.kind) {
    case Action::kRaise:
      raise({.name = action.text("event"), .type = ChartEvent::Type::kInternal});
      return true;
    case Action::kSend:
      return run_send(action);
    case Action::kCancel: {
      const auto id = text_of(action, "sendid", "sendidexpr");
      if (!id) return false;
      system_.cancel_later(*this, *id);
      return true;
    }
    case Action::kLog: {
      std::string text = action.text("label");
      if (!action.text("expr").empty()) {
        const auto value = model_->evaluate(action.text("expr"));
        if (!value) return error("error.execution", value.error());
        text += (text.empty() ? "" : ": ") + plain_text(*value);
      }
      tell("log", text);
      return true;
    }
    case Action::kAssign:
      return run_assign(action);
    case Action::kScript: {
      const auto done = model_->execute(action.script);
      return done ? true : error("error.execution", done.error());
    }
    case Action::kIf:
      return run_if(action);
    case Action::kForEach:
      return run_for_each(action);
  }
  return true;
}

bool ChartSession::run_assign(const ChartAction& action) {
  const std::string& location = action.text("location");
  const bool is_expression = !action.content.expression.empty();
  const auto done = is_expression ? model_->assign(location, action.content.expression.text)
                                  : model_->assign(location, action.content.value);
  return done ? true : error("error.execution", done.error());
}

bool ChartSession::run_if(const ChartAction& action) {
  for (const ChartAction::Part& part : action.parts) {
    if (!part.condition.empty()) {
      const auto holds = model_->condition(part.condition.text);
      if (!holds) (void)error("error.execution", holds.error());
      if (!holds || !*holds) continue;
    }
    return run(part.block);
  }
  return true;
}

bool ChartSession::run_for_each(const ChartAction& action) {
  const auto count = model_->begin_loop(action.text("array"));
  if (!count) return error("error.execution", count.error());
  bool in_order = true;
  // Without elements the variables are made all the same.
  if (*count > kMostRounds) in_order = error("error.execution", fmt::format("a loop over {} elements", *count));
  for (std::size_t round = 0; round < std::max<std::size_t>(*count, 1) && in_order; ++round) {
    const auto entered = model_->enter_round(round, action.text("item"), action.text("index"));
    if (!entered) {
      in_order = error("error.execution", entered.error());
    } else if (round < *count) {
      in_order = run(action.block);
    }
  }
  model_->end_loop();
  return in_order;
}

std::optional<std::string> ChartSession::text_of(const ChartAction& action, std::string_view plain,
                                                 std::string_view expression) {
  if (action.text(expression).empty()) return action.text(plain);
  const auto value = model_->evaluate(action.text(expression));
  if (value) return plain_text(*value);
  (void)error("error.execution", value.error());
  return std::nullopt;
}

bool ChartSession::run_send(const ChartAction& action) {
  std::string id = action.text("id");
  if (!action.text("idlocation").empty()) {
    id = fmt::format("send.{}.{}", id_, ++numbers_);
    const auto done = model_->assign(action.text("idlocation"),
                                     Data::of_json(Json(id).dump(-1, ' ', false, Json::error_handler_t::replace)));
    if (!done) return error("error.execution", done.error(), id);
  }
  const auto name = text_of(action, "event", "eventexpr");
  const auto target = name ? text_of(action, "target", "targetexpr") : std::nullopt;
  const auto type = target ? text_of(action, "type", "typeexpr") : std::nullopt;
  const auto delay = type ? text_of(action, "delay", "delayexpr") : std::nullopt;
  if (!delay) return false;
  auto data = data_of(action.parameters, action.content, action.text("namelist"), false);
  if (!data) return false;
  if (!type->empty() && *type != kScxmlProcessor && !is_chart_type(*type))
    return error("error.execution", fmt::format("there is no way to send events of type '{}'", *type), id);
  const auto delay_ns = delay->empty() ? std::optional<std::int64_t>(0) : duration_ns(*delay);
  if (!delay_ns) return error("error.execution", fmt::format("'{}' is no duration", *delay), id);
  if (*target == "#_internal" && *delay_ns > 0)
    return error("error.execution", "an internal event cannot be sent later", id);
  ChartEvent event{.name = *name,
                   .sendid = id,
                   .origin = "#_scxml_" + id_,
                   .origintype = std::string(kScxmlProcessor),
                   .data = std::move(*data)};
  if (*delay_ns > 0) {
    if (system_.send_later(*this, *delay_ns, *target, std::move(event))) return true;
    fail("too many events wait for their time");
    return false;
  }
  const auto [wrong, why] = system_.send(*this, *target, std::move(event));
  if (wrong.empty()) return true;
  (void)error(wrong, why, id);
  return wrong != "error.execution";
}

std::optional<Data> ChartSession::data_of(const std::vector<ChartParameter>& parameters, const ChartContent& content,
                                          const std::string& names, bool skips_wrong) {
  if (content.given) {
    if (content.expression.empty()) return content.value;
    auto value = model_->evaluate(content.expression.text);
    if (value) return std::move(*value);
    (void)error("error.execution", value.error());
    return skips_wrong ? std::optional(Data{}) : std::nullopt;
  }
  std::vector<std::pair<std::string, Data>> members;
  const auto add = [&](const std::string& name, const std::string& expression) {
    auto value = model_->evaluate(expression);
    if (value) {
      members.emplace_back(name, std::move(*value));
    } else {
      (void)error("error.execution", value.error());
    }
    return value.has_value() || skips_wrong;
  };
  std::istringstream list(names);
  for (std::string name; list >> name;)
    if (!add(name, name)) return std::nullopt;
  for (const ChartParameter& one : parameters)
    if (!add(one.name, one.value.text)) return std::nullopt;
  return object_of(members);
}

void ChartSession::initialize(const std::vector<ChartVariable>& variables, const std::map<std::string, Data>* given) {
  for (const ChartVariable& one : variables) {
    (void)model_->declare(one.id);
    if (given != nullptr && given->contains(one.id)) {
      (void)model_->assign(one.id, given->at(one.id));
      continue;
    }
    if (!one.initial.given) continue;
    const auto done = one.initial.expression.empty() ? model_->assign(one.id, one.initial.value)
                                                     : model_->assign(one.id, one.initial.expression.text);
    if (!done) (void)error("error.execution", done.error());
  }
}

void ChartSession::invoke(int index, const ChartInvoke& invoke) {
  Call call{.state = index, .invoke = &invoke, .id = invoke.text("id")};
  const auto evaluated = [&](std::string_view plain, std::string_view expression) -> std::optional<std::string> {
    if (invoke.text(expression).empty()) return invoke.text(plain);
    const auto value = model_->evaluate(invoke.text(expression));
    if (value) return plain_text(*value);
    (void)error("error.execution", value.error());
    return std::nullopt;
  };
  if (call.id.empty()) call.id = fmt::format("{}.{}", state(index).id, ++numbers_);
  if (!invoke.text("idlocation").empty()) {
    const auto done = model_->assign(invoke.text("idlocation"),
                                     Data::of_json(Json(call.id).dump(-1, ' ', false, Json::error_handler_t::replace)));
    if (!done) return (void)error("error.execution", done.error());
  }
  const auto type = evaluated("type", "typeexpr");
  if (!type) return;
  const auto parameters = parameters_of(invoke);
  if (!parameters) return;
  if (is_chart_type(*type)) {
    if (begin_child(invoke, call, *parameters)) calls_.push_back(std::move(call));
    return;
  }
  const auto& begin = system_.surroundings().begin;
  const std::string why =
      begin ? begin(*this, {*type, call.id, &invoke, *parameters}) : fmt::format("nothing here runs '{}'", *type);
  if (!why.empty()) return (void)error("error.execution", why, call.id);
  tell("invoked", *type);
  calls_.push_back(std::move(call));
}

std::optional<std::vector<std::pair<std::string, Data>>> ChartSession::parameters_of(const ChartInvoke& invoke) {
  std::vector<std::pair<std::string, Data>> members;
  std::istringstream list(invoke.text("namelist"));
  std::vector<std::pair<std::string, std::string>> wanted;
  for (std::string name; list >> name;) wanted.emplace_back(name, name);
  for (const ChartParameter& one : invoke.parameters) wanted.emplace_back(one.name, one.value.text);
  for (const auto& [name, expression] : wanted) {
    auto value = model_->evaluate(expression);
    if (!value) {
      (void)error("error.execution", value.error());
      return std::nullopt;
    }
    members.emplace_back(name, std::move(*value));
  }
  return members;
}

bool ChartSession::begin_child(const ChartInvoke& invoke, Call& call,
                               const std::vector<std::pair<std::string, Data>>& parameters) {
  std::string text = invoke.content.value.text;
  std::string source = invoke.text("src");
  if (!invoke.text("srcexpr").empty()) {
    const auto value = model_->evaluate(invoke.text("srcexpr"));
    if (!value) return error("error.execution", value.error());
    source = plain_text(*value);
  }
  if (!invoke.content.expression.empty()) {
    const auto value = model_->evaluate(invoke.content.expression.text);
    if (!value) return error("error.execution", value.error());
    text = plain_text(*value);
  } else if (!source.empty()) {
    const auto read = read_named_file(chart_->folder, source);
    if (!read) return error("error.communication", read.error().list().front().message);
    text = *read;
  } else {
    text = plain_text(invoke.content.value);
  }
  const auto chart = read_chart(text, chart_->folder);
  if (!chart) return error("error.execution", chart.error().list().front().message);
  std::map<std::string, Data> given(parameters.begin(), parameters.end());
  call.child = system_.add_child(*this, *chart, call.id, std::move(given));
  if (call.child == nullptr) return error("error.execution", "too many charts run at once");
  return true;
}

void ChartSession::finalize(const ChartInvoke& invoke, const ChartEvent& event) {
  if (!invoke.has_finalize) return;
  if (!invoke.finalize.empty()) {
    (void)run(invoke.finalize);
    return;
  }
  // An empty one takes what comes back into the locations that were given.
  const Json data = event.data.kind == Data::Kind::kJson ? Json::parse(event.data.text, nullptr, false) : Json();
  const auto take = [&](const std::string& name, const std::string& location) {
    if (!data.is_object() || !data.contains(name)) return;
    const auto done =
        model_->assign(location, Data::of_json(data.at(name).dump(-1, ' ', false, Json::error_handler_t::replace)));
    if (!done) (void)error("error.execution", done.error());
  };
  std::istringstream list(invoke.text("namelist"));
  for (std::string name; list >> name;) take(name, name);
  for (const ChartParameter& one : invoke.parameters) take(one.name, one.value.text);
}

void ChartSession::cancel_call(const Call& call) {
  if (call.child != nullptr) {
    call.child->parent_ = {};
    call.child->cancel();
  } else if (system_.surroundings().cancel) {
    system_.surroundings().cancel(*this, call.id);
  }
}

}  // namespace takt::languages
