#include "languages/program/tree_leaves.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "languages/program/chart_values.h"
#include "languages/xml/document.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCondition = "Holds";
constexpr const char* kResultPort = "result";

/// A number, an object or an array as JSON; anything else as a text.
Json json_of(const TreeValue& value) {
  if (!value.is_set()) return nullptr;
  if (value.is_number()) return value.number();
  const std::string& text = value.text();
  if (text.starts_with('{') || text.starts_with('['))
    if (auto json = parse_json(text)) return std::move(*json);
  return text;
}

Data data_of(const TreeValue& value) {
  return Data::of_json(json_of(value).dump(-1, ' ', false, Json::error_handler_t::replace));
}

class LeafReader {
 public:
  LeafReader(ProgramTree& tree, const std::string& pointer, program::NodeParser& parser)
      : tree_(tree), pointer_(pointer), parser_(parser), diagnostics_(parser.diagnostics()) {}

  void read(const TreeNodeSpec& node) {
    for (const TreeNodeSpec& child : node.children) read(child);
    if (node.kind != TreeNodeKind::kLeaf) return;
    const std::size_t first = diagnostics_.list().size();
    const program::NodeParser::Inner inner(parser_, false);
    ProgramLeaf leaf;
    leaf.program.name = node.type;
    leaf.program.id = node.name;
    if (node.type == kCondition) {
      condition(node, leaf);
    } else if (is_step(node.type)) {
      operation(node, leaf);
    } else if (const auto found = parser_.program(node.type, {})) {
      call(node, *found, leaf);
    } else if (diagnostics_.list().size() > first) {
      diagnostics_.list().back().message = fmt::format("there is no node, program or operation '{}'", node.type);
      diagnostics_.list().back().hint = nearest_choice(node.type, known_names());
    }
    move_to_leaf(diagnostics_, first, tree_, node);
    tree_.leaves.emplace(&node, std::move(leaf));
  }

 private:
  static bool is_step(const std::string& name) {
    const operations::Operation* found = operations::Operations::global().find(name);
    return found != nullptr && found->read_step != nullptr;
  }
  std::vector<std::string> known_names() {
    std::vector<std::string> names = operations::Operations::global().step_types();
    for (const auto& one : parser_.programs()) names.push_back(one->name);
    for (const TreeNodeType& one : tree_node_types()) names.emplace_back(one.name);
    names.emplace_back(kCondition);
    return names;
  }
  void error(const TextLocation& at, Code code, std::string message, std::string hint) {
    error_at(at, code, std::move(message), std::move(hint), diagnostics_);
    diagnostics_.list().back().file = tree_.name;
  }

  void condition(const TreeNodeSpec& node, ProgramLeaf& leaf) {
    for (const auto& [name, port] : node.ports)
      if (name != "condition" && name != "name")
        error(port.at, Code::kUnknownName, fmt::format("{} has no port '{}'", kCondition, name), "Give 'condition'");
    const TreePort* text = node.port("condition");
    if (text == nullptr || !text->key.empty())
      return error(node.at, Code::kMissing, fmt::format("{} without a condition", kCondition),
                   "Give condition=\"...\", as of a program");
    auto expression = program::Expression::parse(text->text);
    if (!expression) return diagnostics_.append(expression.error());
    const program::Value value = expression->evaluate(parser_.eval_context(), diagnostics_);
    if (!value.type.is(program::Type::Kind::kBoolean) && !diagnostics_.has_errors())
      diagnostics_.error(Code::kWrongType, {}, "unexpected " + program::to_string(value.type), "Give a condition");
    leaf.condition = std::move(*expression);
  }

  void operation(const TreeNodeSpec& node, ProgramLeaf& leaf) {
    Json json{{"do", node.type}};
    for (const auto& [name, port] : node.ports) {
      if (!port.key.empty()) {
        error(port.at, Code::kUnsupported,
              fmt::format("'{}' of the operation '{}' depends on an entry of the blackboard", name, node.type),
              "Write a constant, or a program with parameters that does it");
        continue;
      }
      json[name] = port.text == "true" || port.text == "false" ? Json(port.text == "true")
                                                               : json_of(TreeValue::of_text(port.text));
    }
    leaf.program.node = parser_.node(json, pointer_);
  }

  void call(const TreeNodeSpec& node, const program::SubProgram& program, ProgramLeaf& leaf) {
    Json with = Json::object();
    for (const auto& [name, port] : node.ports) {
      if (name == "name") continue;
      if (name == kResultPort && program.result) {
        leaf.result_key = port.key;
        if (port.key.empty())
          error(port.at, Code::kWrongType, fmt::format("unexpected value '{}'", port.text), "Name an entry: {NAME}");
        continue;
      }
      const auto known = std::ranges::find(program.parameters, name, &program::Declaration::name);
      if (known == program.parameters.end()) {
        with[name] = nullptr;  // the call says what is wrong
        continue;
      }
      parser_.scope().declare(name, {known->type, program::Value::unknown(known->type), {}});
      const auto constant =
          port.key.empty() ? std::optional(data_of(TreeValue::of_text(port.text))) : std::optional<Data>();
      leaf.program.arguments.push_back({name, known->type, constant});
      with[name] = "$" + name;
    }
    Json json{{"do", "call"}, {"name", node.name}, {"program", program.name}, {"with", with}};
    if (!leaf.result_key.empty()) {
      parser_.scope().declare(kChartResult, {program.result_type, program::Value::unknown(program.result_type), {}});
      leaf.program.result = program.result_type;
      json["as"] = kChartResult;
    }
    leaf.program.node = parser_.node(json, pointer_);
  }

  ProgramTree& tree_;
  const std::string& pointer_;
  program::NodeParser& parser_;
  Diagnostics& diagnostics_;
};

}  // namespace

void read_tree_leaves(ProgramTree& tree, const std::string& pointer, program::NodeParser& parser) {
  LeafReader reader(tree, pointer, parser);
  for (const auto& [id, root] : tree.file->trees) reader.read(root);
}

std::vector<std::pair<std::string, Data>> leaf_arguments(const TreeLeaf& leaf) {
  std::vector<std::pair<std::string, Data>> arguments;
  for (const auto& [name, port] : leaf.spec->ports)
    if (const auto value = port_value(*leaf.spec, name, *leaf.board)) arguments.emplace_back(name, data_of(*value));
  return arguments;
}

TreeValue entry_of(const program::Value& value) {
  const Data data = to_data(value);
  if (data.kind != Data::Kind::kJson) return {};
  const Json json = Json::parse(data.text, nullptr, false);
  if (json.is_number()) return {json.get<double>()};
  if (json.is_boolean()) return {json.get<bool>() ? 1.0 : 0.0};
  if (json.is_string()) return {json.get<std::string>()};
  return json.is_null() || json.is_discarded() ? TreeValue{} : TreeValue{data.text};
}

void move_to_leaf(Diagnostics& diagnostics, std::size_t first, const ProgramTree& tree, const TreeNodeSpec& leaf) {
  for (std::size_t i = first; i < diagnostics.list().size(); ++i) {
    Diagnostic& one = diagnostics.list()[i];
    if (!one.file.empty()) continue;
    one.file = tree.name;
    one.line = leaf.at.line;
    one.column = leaf.at.column;
    one.pointer.clear();
  }
}

}  // namespace takt::languages
