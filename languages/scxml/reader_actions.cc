// Executable content of a chart, from its elements.
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "languages/scxml/reader.h"

namespace takt::languages {
namespace {

using Action = ChartAction::Kind;

/// An element of executable content: its attributes, those that it needs, those that are expressions.
struct ActionForm {
  std::string_view name;
  Action kind;
  std::vector<std::string_view> attributes, required, expressions;
};

const std::array kForms{
    ActionForm{"raise", Action::kRaise, {"event"}, {"event"}, {}},
    ActionForm{"send",
               Action::kSend,
               {"event", "eventexpr", "target", "targetexpr", "type", "typeexpr", "id", "idlocation", "delay",
                "delayexpr", "namelist"},
               {},
               {"eventexpr", "targetexpr", "typeexpr", "delayexpr"}},
    ActionForm{"cancel", Action::kCancel, {"sendid", "sendidexpr"}, {}, {"sendidexpr"}},
    ActionForm{"log", Action::kLog, {"label", "expr"}, {}, {"expr"}},
    ActionForm{"assign", Action::kAssign, {"location", "expr"}, {"location"}, {}},
    ActionForm{"script", Action::kScript, {"src"}, {}, {}},
    ActionForm{"if", Action::kIf, {"cond"}, {"cond"}, {"cond"}},
    ActionForm{"foreach", Action::kForEach, {"array", "item", "index"}, {"array", "item"}, {"array"}},
};

}  // namespace

ChartBlock ChartReader::block(const XmlElement& element) {
  ChartBlock made;
  for (const XmlElement::Child& child : element.children) {
    if (child.element && is_ours(*child.element)) action(*child.element, made);
  }
  return made;
}

void ChartReader::action(const XmlElement& element, ChartBlock& block_of) {
  const auto form = std::ranges::find(kForms, element.name, &ActionForm::name);
  if (form == kForms.end()) {
    std::vector<std::string> names;
    for (const ActionForm& one : kForms) names.emplace_back(one.name);
    error(element.at, Code::kUnknownKey, fmt::format("<{}> is no executable content", element.name),
          nearest_choice(element.name, names));
    return;
  }
  ChartAction made;
  made.kind = form->kind;
  made.at = element.at;
  check_attributes(element, form->attributes);
  for (const std::string_view name : form->required) (void)attribute(element, name, true);
  for (const XmlAttribute& one : element.attributes)
    if (one.space.empty()) made.attributes[one.name] = {one.value, one.at};
  for (const std::string_view name : form->expressions) check_expression(attribute(element, name));
  switch (form->kind) {
    case Action::kSend:
      for (const auto& [one, other] : {std::pair{"event", "eventexpr"},
                                       {"target", "targetexpr"},
                                       {"type", "typeexpr"},
                                       {"id", "idlocation"},
                                       {"delay", "delayexpr"}})
        if (element.find(one) && element.find(other)) conflict(element, one, other);
      parameters(element, made.parameters, made.content);
      if (const ChartText delay = attribute(element, "delay"); element.find("delay") && !duration_ns(delay.text))
        error(delay.at, Code::kInvalidValue, fmt::format("'{}' is no duration", delay.text), "Write 1.5s or 20ms");
      break;
    case Action::kAssign:
      made.content = content_of(element);
      break;
    case Action::kCancel:
      if ((element.find("sendid") != nullptr) == (element.find("sendidexpr") != nullptr))
        error(element.at, Code::kMissing, "<cancel> needs 'sendid' or 'sendidexpr'", "Give one of them");
      break;
    case Action::kScript:
      made.script = script_of(element);
      break;
    case Action::kIf:
      if_parts(element, made);
      break;
    case Action::kForEach:
      made.block = block(element);
      break;
    default:
      break;
  }
  block_of.push_back(std::move(made));
}

void ChartReader::if_parts(const XmlElement& element, ChartAction& made) {
  made.parts.push_back({attribute(element, "cond"), {}});
  bool last = false;
  for (const XmlElement::Child& child : element.children) {
    if (!child.element || !is_ours(*child.element)) continue;
    const XmlElement& own = *child.element;
    if (own.name != "elseif" && own.name != "else") {
      action(own, made.parts.back().block);
      continue;
    }
    if (last) unexpected(own, element);
    last = own.name == "else";
    check_attributes(own, last ? std::vector<std::string_view>{} : std::vector<std::string_view>{"cond"});
    const ChartText condition = attribute(own, "cond", !last);
    check_expression(condition);
    made.parts.push_back({condition, {}});
  }
}

}  // namespace takt::languages
