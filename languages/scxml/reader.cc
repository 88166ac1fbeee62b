#include "languages/scxml/reader.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

#include "core/base/json.h"

namespace takt::languages {

using Kind = ChartState::Kind;
using Action = ChartAction::Kind;

std::unique_ptr<Chart> ChartReader::read(const XmlElement& root) {
  if (root.name != "scxml" || root.space != kScxmlSpace) {
    error(root.at, Code::kUnknownKey, fmt::format("the document is a '{}' of '{}'", root.name, root.space),
          fmt::format("Begin with <scxml xmlns=\"{}\" version=\"1.0\">", kScxmlSpace));
    return std::move(chart_);
  }
  check_attributes(root, {"initial", "name", "version", "datamodel", "binding", "exmode"});
  if (const ChartText version = attribute(root, "version", true); !version.empty() && version.text != "1.0")
    error(version.at, Code::kInvalidValue, fmt::format("version '{}'", version.text), "Write 1.0");
  chart_->name = attribute(root, "name").text;
  // Without a data model of its own a document has the platform's, as the standard says.
  const std::string model = choice(root, "datamodel", {"ecmascript", "null"});
  chart_->model = model == "null" ? Chart::Model::kNull : Chart::Model::kEcmascript;
  chart_->early_binding = choice(root, "binding", {"early", "late"}) != "late";
  chart_->folder = folder_;
  if (chart_->model == Chart::Model::kEcmascript) syntax_ = std::make_unique<ScriptEngine>();
  (void)state(root, Kind::kRoot, -1);
  resolve_targets();
  return std::move(chart_);
}

int ChartReader::state(const XmlElement& element, Kind kind, int parent) {
  const int index = static_cast<int>(chart_->states.size());
  chart_->states.emplace_back();
  {
    ChartState& own = chart_->states.back();
    own.kind = kind;
    own.parent = parent;
    own.at = element.at;
    if (kind != Kind::kRoot) own.id = attribute(element, "id").text;
    if (own.id.empty()) own.id = kind == Kind::kRoot ? "" : fmt::format("{}.{}", element.name, ++unnamed_);
    if (kind != Kind::kRoot && !ids_.insert(own.id).second)
      error(element.at, Code::kDuplicate, fmt::format("duplicate id '{}'", own.id), "Give each state an id of its own");
  }
  if (kind == Kind::kState) check_attributes(element, {"id", "initial"});
  if (kind == Kind::kParallel || kind == Kind::kFinal) check_attributes(element, {"id"});
  if (kind == Kind::kHistory || kind == Kind::kDeepHistory) check_attributes(element, {"id", "type"});
  for (const XmlElement::Child& child : element.children) {
    if (child.element && is_ours(*child.element)) state_child(*child.element, index);
  }
  if (kind == Kind::kState || kind == Kind::kRoot) initial_attribute(element, index);
  chart_->states[static_cast<std::size_t>(index)].last = static_cast<int>(chart_->states.size()) - 1;
  return index;
}

void ChartReader::state_child(const XmlElement& child, int index) {
  const auto own = [&]() -> ChartState& { return chart_->states[static_cast<std::size_t>(index)]; };
  const Kind kind = own().kind;
  const std::string& name = child.name;
  const bool holds_states = kind == Kind::kRoot || kind == Kind::kState || kind == Kind::kParallel;
  if (holds_states && (name == "state" || name == "parallel" || (name == "final" && kind != Kind::kParallel))) {
    const int made = state(child,
                           name == "state"   ? Kind::kState
                           : name == "final" ? Kind::kFinal
                                             : Kind::kParallel,
                           index);
    own().children.push_back(made);
  } else if (name == "history" && (kind == Kind::kState || kind == Kind::kParallel)) {
    const bool deep = choice(child, "type", {"shallow", "deep"}) == "deep";
    const int made = state(child, deep ? Kind::kDeepHistory : Kind::kHistory, index);
    own().histories.push_back(made);
  } else if (name == "transition" && kind != Kind::kRoot && kind != Kind::kFinal) {
    const int made = transition(child, index);
    own().transitions.push_back(made);
  } else if (name == "initial" && kind == Kind::kState) {
    initial(child, index);
  } else if ((name == "onentry" || name == "onexit") && kind != Kind::kRoot && !own().is_history()) {
    check_attributes(child, {});
    ChartBlock made = block(child);
    (name == "onentry" ? own().on_entry : own().on_exit).push_back(std::move(made));
  } else if (name == "invoke" && (kind == Kind::kState || kind == Kind::kParallel)) {
    ChartInvoke made = invoke(child);
    own().invokes.push_back(std::move(made));
  } else if (name == "datamodel" && holds_states) {
    variables(child, index);
  } else if (name == "donedata" && kind == Kind::kFinal) {
    done_data(child, own().done);
  } else if (name == "script" && kind == Kind::kRoot) {
    chart_->script += script_of(child) + "\n";
  } else {
    error(child.at, Code::kUnknownKey, fmt::format("unexpected <{}> here", name),
          "Remove it, or move it into an element that may have one");
  }
}

int ChartReader::transition(const XmlElement& element, int source) {
  check_attributes(element, {"event", "cond", "target", "type"});
  const int index = static_cast<int>(chart_->transitions.size());
  chart_->transitions.emplace_back();
  ChartTransition made;
  made.source = source;
  made.at = element.at;
  std::istringstream events(attribute(element, "event").text);
  for (std::string event; events >> event;) made.events.push_back(event);
  made.condition = attribute(element, "cond");
  if (chart_->model == Chart::Model::kEcmascript) check_expression(made.condition);
  if (const XmlAttribute* sensors = element.find("cond", kTaktSpace)) made.sensors = {sensors->value, sensors->at};
  made.internal = choice(element, "type", {"external", "internal"}) == "internal";
  made.block = block(element);
  const ChartText targets = attribute(element, "target");
  if (element.find("target") != nullptr) named_.push_back({index, targets});
  if (element.find("target") == nullptr && made.events.empty() && made.condition.empty() && made.sensors.empty())
    error(element.at, Code::kMissing, "a transition without event, condition and target", "Give it one of them");
  chart_->transitions[static_cast<std::size_t>(index)] = std::move(made);
  return index;
}

void ChartReader::initial(const XmlElement& element, int index) {
  check_attributes(element, {});
  int found = 0;
  for (const XmlElement::Child& child : element.children) {
    if (!child.element || !is_ours(*child.element)) continue;
    if (child.element->name != "transition" || ++found > 1) {
      unexpected(*child.element, element);
      continue;
    }
    const int made = transition(*child.element, index);
    chart_->states[static_cast<std::size_t>(index)].initial = made;
    const ChartTransition& own = chart_->transitions[static_cast<std::size_t>(made)];
    if (!own.events.empty() || !own.condition.empty() || child.element->find("target") == nullptr)
      error(own.at, Code::kInvalidValue, "the transition of <initial> has an event or a condition, or no target",
            "Give it a target alone");
  }
  if (found == 0)
    error(element.at, Code::kMissing, "<initial> without a transition", "Add <transition target=\"...\"/>");
}

void ChartReader::initial_attribute(const XmlElement& element, int index) {
  const ChartText ids = attribute(element, "initial");
  if (element.find("initial") == nullptr) return;
  ChartState& own = chart_->states[static_cast<std::size_t>(index)];
  if (own.initial >= 0) return conflict(element, "initial", "<initial>");
  if (own.children.empty()) {
    error(ids.at, Code::kInvalidValue, "a state without states in it has no initial one", "Remove 'initial'");
    return;
  }
  own.initial = static_cast<int>(chart_->transitions.size());
  ChartTransition made;
  made.source = index;
  made.at = ids.at;
  chart_->transitions.push_back(std::move(made));
  named_.push_back({own.initial, ids});
}

void ChartReader::variables(const XmlElement& element, int index) {
  check_attributes(element, {});
  for (const XmlElement::Child& child : element.children) {
    if (!child.element || !is_ours(*child.element)) continue;
    const XmlElement& data = *child.element;
    if (data.name != "data") {
      unexpected(data, element);
      continue;
    }
    check_attributes(data, {"id", "src", "expr"});
    ChartVariable variable;
    const ChartText id = attribute(data, "id", true);
    variable.id = id.text;
    variable.at = data.at;
    if (!id.empty() && !is_script_name(id.text))
      error(id.at, Code::kInvalidName, fmt::format("invalid variable name '{}'", id.text),
            "Use letters, digits and _, and no word of ECMAScript");
    variable.initial = content_of(data);
    chart_->states[static_cast<std::size_t>(index)].variables.push_back(std::move(variable));
  }
}

void ChartReader::done_data(const XmlElement& element, ChartDoneData& done) {
  check_attributes(element, {});
  done.given = true;
  parameters(element, done.parameters, done.content);
  for (const XmlElement::Child& child : element.children) {
    if (child.element && is_ours(*child.element) && child.element->name != "param" && child.element->name != "content")
      unexpected(*child.element, element);
  }
}

ChartInvoke ChartReader::invoke(const XmlElement& element) {
  check_attributes(element, {"type", "typeexpr", "src", "srcexpr", "id", "idlocation", "namelist", "autoforward"});
  ChartInvoke made;
  made.at = element.at;
  for (const XmlAttribute& one : element.attributes)
    if (one.space.empty()) made.attributes[one.name] = {one.value, one.at};
  for (const auto& [one, other] : {std::pair{"type", "typeexpr"}, {"src", "srcexpr"}, {"id", "idlocation"}})
    if (element.find(one) && element.find(other)) conflict(element, one, other);
  for (const char* key : {"typeexpr", "srcexpr", "idlocation"}) check_expression(attribute(element, key));
  made.autoforward = choice(element, "autoforward", {"false", "true"}) == "true";
  parameters(element, made.parameters, made.content);
  if (made.content.given && (element.find("src") || element.find("srcexpr"))) conflict(element, "src", "<content>");
  if (element.find("namelist") && !made.parameters.empty()) conflict(element, "namelist", "<param>");
  for (const XmlElement::Child& child : element.children) {
    if (!child.element || !is_ours(*child.element)) continue;
    if (child.element->name == "finalize") {
      made.has_finalize = true;
      made.finalize = block(*child.element);
    } else if (child.element->name != "param" && child.element->name != "content") {
      unexpected(*child.element, element);
    }
  }
  return made;
}

void ChartReader::parameters(const XmlElement& element, std::vector<ChartParameter>& list, ChartContent& content) {
  for (const XmlElement::Child& child : element.children) {
    if (!child.element || !is_ours(*child.element)) continue;
    const XmlElement& own = *child.element;
    if (own.name == "param") {
      check_attributes(own, {"name", "expr", "location"});
      if (own.find("expr") && own.find("location")) conflict(own, "expr", "location");
      ChartText value = attribute(own, own.find("expr") ? "expr" : "location");
      if (!own.find("expr") && !own.find("location"))
        error(own.at, Code::kMissing, "<param> without a value", "Give it 'expr' or 'location'");
      check_expression(value);
      if (value.empty()) value.at = own.at;
      list.push_back({attribute(own, "name", true).text, std::move(value)});
    } else if (own.name == "content") {
      if (content.given) error(own.at, Code::kDuplicate, "a second <content>", "Keep one of them");
      check_attributes(own, {"expr"});
      content = content_of(own);
      content.given = true;
    }
  }
  if (content.given && !list.empty() && element.name != "invoke")
    error(element.at, Code::kConflict, "<param> and <content> exclude each other", "Keep one of them");
}

ChartContent ChartReader::content_of(const XmlElement& element) {
  ChartContent content;
  content.expression = attribute(element, "expr");
  check_expression(content.expression);
  const ChartText source = element.name == "data" ? attribute(element, "src") : ChartText{};
  const std::string text = element.text();
  const bool has_text = text.find_first_not_of(" \t\r\n") != std::string::npos;
  content.given = element.find("expr") != nullptr || has_text || element.has_elements() || !source.empty();
  if (element.find("expr") && (has_text || element.has_elements())) conflict(element, "expr", "content");
  if (element.find("expr") && !source.empty()) conflict(element, "expr", "src");
  if (!source.empty() && (has_text || element.has_elements())) conflict(element, "src", "content");
  if (element.has_elements()) {
    for (const XmlElement::Child& child : element.children)
      if (child.element && content.value.text.empty()) content.value = Data::of_xml(child.element->to_xml());
  } else if (!source.empty()) {
    if (const auto read = read_named_file(folder_, source.text)) {
      const auto first = read->find_first_not_of(" \t\r\n");
      const bool is_xml = first != std::string::npos && (*read)[first] == '<' && parse_xml(*read).has_value();
      content.value = is_xml ? Data::of_xml(*read) : data_of_text(*read);
    } else {
      error(source.at, read.error().list().front().code, read.error().list().front().message,
            "Name a file below the chart's folder");
    }
  } else if (has_text) {
    content.value = data_of_text(text);
  }
  return content;
}

std::string ChartReader::script_of(const XmlElement& element) {
  check_attributes(element, {"src"});
  const ChartText source = attribute(element, "src");
  std::string text = element.text();
  if (!source.empty()) {
    auto read = read_named_file(folder_, source.text);
    if (!read)
      error(source.at, read.error().list().front().code, read.error().list().front().message,
            "Name a file below the chart's folder");
    text = read ? *read : "";
  }
  check_expression({text, element.at}, true);
  return text;
}

void ChartReader::resolve_targets() {
  for (const Named& one : named_) {
    ChartTransition& transition = chart_->transitions[static_cast<std::size_t>(one.transition)];
    std::istringstream ids(one.ids.text);
    for (std::string id; ids >> id;) {
      const int target = chart_->find(id);
      if (target > 0) {
        transition.targets.push_back(target);
        continue;
      }
      std::vector<std::string> known(ids_.begin(), ids_.end());
      error(one.ids.at, Code::kUnknownName, fmt::format("there is no state '{}'", id), nearest_choice(id, known));
    }
    if (one.ids.text.find_first_not_of(" \t\r\n") == std::string::npos)
      error(one.ids.at, Code::kMissing, "a target without a state", "Name a state");
  }
}

void ChartReader::check_attributes(const XmlElement& element, const std::vector<std::string_view>& known) {
  for (const XmlAttribute& one : element.attributes) {
    const bool takt_condition = one.space == kTaktSpace && one.name == "cond" && element.name == "transition";
    const bool foreign = !one.space.empty() && one.space != kTaktSpace;
    if (takt_condition || foreign || (one.space.empty() && std::ranges::find(known, one.name) != known.end())) continue;
    error(one.at, Code::kUnknownKey, fmt::format("<{}> has no attribute '{}'", element.name, one.name),
          nearest_choice(one.name, {known.begin(), known.end()}));
  }
}

ChartText ChartReader::attribute(const XmlElement& element, std::string_view name, bool required) {
  const XmlAttribute* found = element.find(name);
  if (found != nullptr) return {found->value, found->at};
  if (required)
    error(element.at, Code::kMissing, fmt::format("<{}> without '{}'", element.name, name),
          fmt::format("Add {}=\"...\"", name));
  return {"", element.at};
}

std::string ChartReader::choice(const XmlElement& element, std::string_view name,
                                std::initializer_list<std::string_view> allowed) {
  const ChartText text = attribute(element, name);
  if (element.find(name) == nullptr) return std::string(*allowed.begin());
  if (std::ranges::find(allowed, text.text) != allowed.end()) return text.text;
  error(text.at, Code::kInvalidValue, fmt::format("invalid {} '{}'", name, text.text),
        nearest_choice(text.text, {allowed.begin(), allowed.end()}));
  return std::string(*allowed.begin());
}

void ChartReader::check_expression(const ChartText& text, bool statements) {
  if (text.empty() || !syntax_) return;
  if (const auto wrong = syntax_->syntax_error(text.text, statements))
    warning_at(text.at, Code::kSyntax, fmt::format("'{}' raises error.execution: {}", text.text.substr(0, 60), *wrong),
               "Correct the script", diagnostics_);
}

bool ChartReader::is_ours(const XmlElement& element) {
  if (element.space == kTaktSpace)
    error(element.at, Code::kUnknownKey, fmt::format("there is no element '{}' of takt", element.name), "Remove it");
  return element.space == kScxmlSpace;
}

void ChartReader::unexpected(const XmlElement& element, const XmlElement& around) {
  error(element.at, Code::kUnknownKey, fmt::format("unexpected <{}> in <{}>", element.name, around.name),
        "Remove it, or move it into an element that may have one");
}

void ChartReader::conflict(const XmlElement& element, std::string_view one, std::string_view other) {
  error(element.at, Code::kConflict, fmt::format("<{}>: '{}' and '{}' exclude each other", element.name, one, other),
        "Keep one of them");
}

}  // namespace takt::languages
