// From JSON to the tree of a program.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/read_parts.h"
#include "core/program/tree/node.h"
#include "core/program/tree/node_forms.h"

namespace takt::program {
namespace {

using Json = nlohmann::ordered_json;

/// Calls nest so deep at most: each level is a part of the stack of the run.
constexpr int kMostCalls = 16;

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const NodeKind& kind : node_kinds()) names.emplace_back(kind.name);
  for (std::string& name : operations::Operations::global().step_types()) names.push_back(std::move(name));
  std::ranges::sort(names);
  return names;
}

/// A wait for an expression is asked between cycles, one for a condition in every cycle.
bool waits_for_expression(const Json& json) {
  const auto until = json.find("until");
  return json.value("do", Json()) == "wait" && until != json.end() && until->is_string();
}

}  // namespace

namespace {

std::vector<NodeKind>& kinds() {
  static std::vector<NodeKind> all{
      {"branch", branch_form(), parse_branch},
      {"call", call_form(), parse_call},
      {"fail", fail_form(), parse_fail},
      {"for_each", for_each_form(), parse_for_each},
      {"let", let_form(), parse_let},
      {"log", log_form(), parse_log},
      {"parallel", parallel_form(), parse_parallel},
      {"repeat", repeat_form(), parse_repeat},
      {"sequence", sequence_form(), parse_sequence},
      {"stop", stop_form(), parse_stop},
      {"try", try_form(), parse_try},
  };
  return all;
}

}  // namespace

const std::vector<NodeKind>& node_kinds() { return kinds(); }

void add_node_kind(const NodeKind& kind) {
  auto& all = kinds();
  all.insert(std::ranges::lower_bound(all, kind.name, {}, &NodeKind::name), kind);
}

NodeParser::NodeParser(const expression::Cell& cell, const Json* programs, Diagnostics& diagnostics)
    : cell_(cell), programs_json_(programs), diagnostics_(diagnostics) {}
NodeParser::~NodeParser() = default;

EvalContext NodeParser::eval_context() const {
  return {
      .mode = EvalContext::Mode::kCheck, .scope = scope_, .cell = &cell_, .measured = nullptr, .q = nullptr, .time = 0};
}

void NodeParser::head(ObjectReader& reader, Node& node, std::string_view fallback) {
  (void)reader.text("do", "");
  node.name = read_name(reader, std::string(fallback));
}

/// Recursion is bounded by the depth that JSON files may have.
std::unique_ptr<Node> NodeParser::node(const Json& json, const std::string& pointer) {
  Diagnostics unread;
  ObjectReader reader(json, pointer, json.is_object() ? unread : diagnostics_);
  const std::string kind = reader.text("do", "");
  if (!json.is_object()) return make_sequence({}, pointer);
  if (waits_for_expression(json)) return parse_until(json, pointer, *this);
  const auto inner = std::ranges::find(node_kinds(), kind, &NodeKind::name);
  if (inner != node_kinds().end()) return inner->parse(json, pointer, *this);
  const operations::Operation* operation = operations::Operations::global().find(kind);
  if (operation != nullptr && operation->read_step != nullptr) return parse_leaf(*operation, json, pointer, *this);
  diagnostics_.error(kind.empty() ? Code::kMissing : Code::kUnknownName, pointer + "/do",
                     kind.empty() ? "'do' is missing" : fmt::format("there is no step '{}'", kind),
                     nearest_choice(kind, kind_names(), 40));
  return make_sequence({}, pointer);
}

NodeList NodeParser::list(ObjectReader& reader, std::string_view key, bool required) {
  NodeList nodes;
  const Json* steps = reader.array(key, required);
  for (std::size_t i = 0; steps && i < steps->size(); ++i) {
    auto next = node((*steps)[i], reader.at(key) + pointer_segment(i));
    if (nodes.empty() || !absorb_leaf(*nodes.back(), *next)) nodes.push_back(std::move(next));
  }
  return nodes;
}

ValueTemplate NodeParser::value(const Json& json, const std::string& pointer, const Type& wanted, Type* type) {
  Diagnostics own;
  ValueTemplate piece = ValueTemplate::parse(json, pointer, own);
  if (!own.has_errors()) {
    const Value value = piece.value(eval_context(), own);
    if (!own.has_errors() && !accepts(wanted, value.type)) {
      own.error(Code::kWrongType, pointer, fmt::format("unexpected {}", to_string(value.type)),
                "Give a " + to_string(wanted));
    }
    if (type) *type = value.type;
  }
  diagnostics_.append(own);
  return piece;
}

namespace {

/// {"type": ..., "unit": ..., "value": ..., "nominal": ...}, as opposed to a value.
bool is_long_form(const Json& json) {
  return json.is_object() &&
         (json.contains("type") || json.contains("unit") || json.contains("value") || json.contains("nominal"));
}

Declaration read_long_form(const std::string& name, const Json& json, const std::string& pointer, NodeParser& parser) {
  ObjectReader reader(json, pointer, parser.diagnostics());
  Declaration declaration{.name = name, .type = {}, .initial = {}, .nominal = {}};
  const std::string unit = reader.text("unit", "");
  const std::string text = reader.text("type", reader.has("unit") ? "number" : "");
  if (const auto type = type_from_text(text, unit)) {
    declaration.type = *type;
  } else if (!text.empty() || !reader.has("value")) {
    parser.diagnostics().error(Code::kInvalidValue, pointer, fmt::format("'{}' in '{}' is not a type", text, unit),
                               "Use number (with a unit), boolean, text, pose, or \"list of ...\"");
  }
  for (const char* key : {"value", "nominal"}) {
    const Json* value = reader.child(key);
    if (!value) continue;
    Type found;
    auto piece = parser.value(*value, reader.at(key), declaration.type, &found);
    if (declaration.type.kind == Type::Kind::kUnknown) declaration.type = found;
    (std::string_view(key) == "value" ? declaration.initial : declaration.nominal) = std::move(piece);
  }
  reader.finish();
  return declaration;
}

}  // namespace

std::vector<Declaration> NodeParser::declarations(ObjectReader& reader, std::string_view key) {
  std::vector<Declaration> declarations;
  const Json* json = reader.object(key, false);
  if (!json) return declarations;
  for (const auto& [name, value] : json->items()) {
    const std::string place = reader.at(key) + pointer_segment(name);
    if (!is_variable_name(name)) {
      diagnostics_.error(Code::kInvalidName, place, fmt::format("invalid variable name '{}'", name),
                         "Use letters, digits and _, and none of the words of expressions");
      continue;
    }
    Declaration declaration{.name = name, .type = {}, .initial = {}, .nominal = {}};
    if (is_long_form(value)) {
      declaration = read_long_form(name, value, place, *this);
    } else {
      declaration.initial = this->value(value, place, {}, &declaration.type);
    }
    scope_->declare(name, {declaration.type, Value::unknown(declaration.type), {}});
    declarations.push_back(std::move(declaration));
  }
  return declarations;
}

std::vector<std::string> NodeParser::block_frames(ObjectReader& reader, std::string_view key) {
  std::vector<std::string> frames;
  if (reader.has(key)) frames = reader.texts(key);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string& name = frames[i];
    const bool possible = !name.empty() && name.find('/') == std::string::npos && !cell_.frames.contains(name) &&
                          !cell_.objects.contains(name);
    if (!possible)
      diagnostics_.error(Code::kInvalidName, reader.at(key) + pointer_segment(i),
                         fmt::format("'{}' cannot be the name of a frame that ends with a block", name),
                         "Choose a name that the cell does not have, without '/'");
    if (std::ranges::find(frames_around_, name) != frames_around_.end())
      diagnostics_.error(Code::kDuplicate, reader.at(key) + pointer_segment(i),
                         fmt::format("frame '{}' is one of this block, or of one around it", name),
                         "Give it a name of its own");
    frames_around_.push_back(name);
    frames_read_.insert(name);
  }
  return frames;
}

std::shared_ptr<const SubProgram> NodeParser::program(const std::string& name, const std::string& pointer) {
  const auto cycle = std::ranges::find(being_parsed_, name);
  if (cycle != being_parsed_.end()) {
    std::string chain;
    for (auto caller = cycle; caller != being_parsed_.end(); ++caller) chain += "'" + *caller + "' calls ";
    diagnostics_.error(Code::kInvalidValue, pointer, fmt::format("{}'{}': a program may not call itself", chain, name),
                       "Use \"repeat\" for what is done again");
    return nullptr;
  }
  if (!programs_json_ || !programs_json_->is_object() || !programs_json_->contains(name)) {
    std::vector<std::string> names;
    if (programs_json_ && programs_json_->is_object()) {
      for (const auto& [known, json] : programs_json_->items()) names.push_back(known);
    }
    diagnostics_.error(Code::kUnknownName, pointer, fmt::format("there is no program '{}'", name),
                       nearest_choice(name, names));
    return nullptr;
  }
  const auto known = programs_.find(name);
  if (known == programs_.end() && static_cast<int>(being_parsed_.size()) >= kMostCalls) return too_deep(pointer);
  const auto program = known != programs_.end() ? known->second : parse_program(name);
  depth_ = std::max(depth_, program->depth);
  if (static_cast<int>(being_parsed_.size()) + program->depth > kMostCalls) return too_deep(pointer);
  return program;
}

std::nullptr_t NodeParser::too_deep(const std::string& pointer) {
  diagnostics_.error(Code::kTooLarge, pointer, fmt::format("calls are nested more than {} deep", kMostCalls),
                     "Reduce the nesting of calls");
  return nullptr;
}

std::shared_ptr<SubProgram> NodeParser::parse_program(const std::string& name) {
  auto program = std::make_shared<SubProgram>();
  program->name = name;
  program->pointer = "/programs" + pointer_segment(name);
  being_parsed_.push_back(name);
  const int depth = std::exchange(depth_, 0);
  {
    ObjectReader reader(programs_json_->at(name), program->pointer, diagnostics_);
    const Inner inner(*this, false);
    (void)reader.text("description", "");
    program->parameters = declarations(reader, "parameters");
    // The variables of the program are those of its body, so that the result can be one of them.
    const auto variables = declarations(reader, "variables");
    program->variables = variables;
    program->body = steps(reader, "steps");
    if (const Json* result = reader.child("result")) {
      program->result = value(*result, reader.at("result"), {}, &program->result_type);
    }
    reader.finish();
  }
  program->count = program->body->count();
  program->depth = depth_ + 1;
  depth_ = depth;
  being_parsed_.pop_back();
  programs_[name] = program;
  return program;
}

void NodeParser::all_programs() {
  if (!programs_json_) return;
  if (!programs_json_->is_object()) {
    diagnostics_.error(Code::kWrongType, "/programs", "unexpected value " + short_dump(*programs_json_),
                       "Give an object {...}");
    return;
  }
  for (const auto& [name, json] : programs_json_->items()) {
    if (!programs_.contains(name)) (void)parse_program(name);
  }
}

std::vector<std::shared_ptr<const SubProgram>> NodeParser::programs() const {
  std::vector<std::shared_ptr<const SubProgram>> programs;
  if (!programs_json_ || !programs_json_->is_object()) return programs;
  for (const auto& [name, json] : programs_json_->items()) {
    const auto found = programs_.find(name);
    if (found != programs_.end()) programs.push_back(found->second);
  }
  return programs;
}

}  // namespace takt::program
