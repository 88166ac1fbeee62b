#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "languages/behavior_tree/model.h"
#include "languages/xml/document.h"

namespace takt::languages {
namespace {

constexpr int kMany = 1000;
constexpr std::size_t kMostNodes = 20'000;  // with all subtrees written out
constexpr std::array<std::string_view, 4> kPreNames = {"_failureIf", "_successIf", "_skipIf", "_while"};
constexpr std::array<std::string_view, 4> kPostNames = {"_onHalted", "_onFailure", "_onSuccess", "_post"};

TreeNodeType switch_of(std::string_view name) {
  TreeNodeType type{name, TreeNodeKind::kSwitch, 0, 0, {{"variable", "", false}}};
  const int cases = name.back() - '0';
  type.min_children = type.max_children = cases + 1;
  static constexpr std::array<std::string_view, 6> kCases = {"case_1", "case_2", "case_3",
                                                             "case_4", "case_5", "case_6"};
  for (int i = 0; i < cases; ++i) type.ports.push_back({kCases[static_cast<std::size_t>(i)], "", false});
  return type;
}

const std::vector<TreeNodeType>& node_types() {
  static const std::vector<TreeNodeType> types{
      {"Sequence", TreeNodeKind::kSequence, 1, kMany, {}},
      {"AsyncSequence", TreeNodeKind::kSequence, 1, kMany, {}},
      {"ReactiveSequence", TreeNodeKind::kReactiveSequence, 1, kMany, {}},
      {"SequenceWithMemory", TreeNodeKind::kSequenceWithMemory, 1, kMany, {}},
      {"Fallback", TreeNodeKind::kFallback, 1, kMany, {}},
      {"AsyncFallback", TreeNodeKind::kFallback, 1, kMany, {}},
      {"ReactiveFallback", TreeNodeKind::kReactiveFallback, 1, kMany, {}},
      {"Parallel", TreeNodeKind::kParallel, 1, kMany, {{"success_count", "-1"}, {"failure_count", "1"}}},
      {"ParallelAll", TreeNodeKind::kParallelAll, 1, kMany, {{"max_failures", "1"}}},
      {"IfThenElse", TreeNodeKind::kIfThenElse, 2, 3, {}},
      {"WhileDoElse", TreeNodeKind::kWhileDoElse, 2, 3, {}},
      switch_of("Switch2"),
      switch_of("Switch3"),
      switch_of("Switch4"),
      switch_of("Switch5"),
      switch_of("Switch6"),
      {"Inverter", TreeNodeKind::kInverter, 1, 1, {}},
      {"ForceSuccess", TreeNodeKind::kForceSuccess, 1, 1, {}},
      {"ForceFailure", TreeNodeKind::kForceFailure, 1, 1, {}},
      {"Repeat", TreeNodeKind::kRepeat, 1, 1, {{"num_cycles", ""}}},
      {"RetryUntilSuccessful", TreeNodeKind::kRetry, 1, 1, {{"num_attempts", ""}}},
      {"KeepRunningUntilFailure", TreeNodeKind::kKeepRunningUntilFailure, 1, 1, {}},
      {"Delay", TreeNodeKind::kDelay, 1, 1, {{"delay_msec", ""}}},
      {"Timeout", TreeNodeKind::kTimeout, 1, 1, {{"msec", ""}}},
      {"RunOnce", TreeNodeKind::kRunOnce, 1, 1, {{"then_skip", "true"}}},
      {"SubTree", TreeNodeKind::kSubTree, 0, 0, {}},
      {"AlwaysSuccess", TreeNodeKind::kAlwaysSuccess, 0, 0, {}},
      {"AlwaysFailure", TreeNodeKind::kAlwaysFailure, 0, 0, {}},
      {"Script", TreeNodeKind::kScript, 0, 0, {{"code", "", false}}},
      {"ScriptCondition", TreeNodeKind::kScriptCondition, 0, 0, {{"code", "", false}}},
      {"SetBlackboard", TreeNodeKind::kSetBlackboard, 0, 0, {{"value", "", false}, {"output_key", "", false}}},
      {"Sleep", TreeNodeKind::kSleep, 0, 0, {{"msec", ""}}}};
  return types;
}

/// "{key}": the key; "{=}": that of the port's own name; else nothing. A text in braces that is no key is a text.
std::string key_in(const std::string& value, const std::string& port) {
  if (value.size() < 3 || value.front() != '{' || value.back() != '}') return {};
  std::string key = value.substr(1, value.size() - 2);
  if (key == "=") return port;
  const bool is_key = std::ranges::all_of(key, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '@' || c == '-' || c == '/';
  });
  return is_key ? key : std::string();
}

class TreeReader {
 public:
  explicit TreeReader(TreeFile& file) : file_(file) {}

  Diagnostics read(const XmlElement& root, const std::string& main) {
    if (root.name != "root")
      error_at(root.at, Code::kUnknownName, fmt::format("unexpected element '{}'", root.name), "Begin with <root>",
               diagnostics_);
    const XmlAttribute* format = root.find("BTCPP_format");
    if (format == nullptr || format->value != "4")
      error_at(format != nullptr ? format->at : root.at, Code::kUnsupported,
               format != nullptr ? fmt::format("format {}", format->value) : "no format is given",
               "Give BTCPP_format=\"4\" and write the trees as BehaviorTree.CPP 4 has them", diagnostics_);
    for (const auto& child : root.children)
      if (child.element) read_top(*child.element);
    choose_main(root, main);
    for (const auto& [id, tree] : file_.trees) check_subtrees(tree);
    if (!diagnostics_.has_errors()) check_size(root);
    return std::move(diagnostics_);
  }

 private:
  void error(const TextLocation& at, Code code, std::string message, std::string hint) {
    error_at(at, code, std::move(message), std::move(hint), diagnostics_);
  }

  void read_top(const XmlElement& element) {
    if (element.name == "TreeNodesModel") return;  // what editors draw nodes by
    if (element.name != "BehaviorTree")
      return error(element.at, Code::kUnsupported, fmt::format("unexpected element '{}'", element.name),
                   element.name == "include" ? "Write all trees into one file" : "Use <BehaviorTree> in <root>");
    const XmlAttribute* id = element.find("ID");
    if (id == nullptr || id->value.empty())
      error(element.at, Code::kMissing, "a tree without an ID", "Give it ID=\"NAME\"");
    const std::string name = id != nullptr ? id->value : "";
    std::vector<TreeNodeSpec> nodes = read_children(element, 1);
    if (nodes.size() != 1)
      error(element.at, Code::kWrongSize, fmt::format("{} nodes in the tree '{}'", nodes.size(), name),
            "Give it one, such as a Sequence");
    if (file_.trees.contains(name))
      return error(element.at, Code::kDuplicate, fmt::format("a second tree '{}'", name),
                   "Give each tree an ID of its own");
    file_.trees[name] = nodes.empty() ? TreeNodeSpec{} : std::move(nodes.front());
  }

  std::vector<TreeNodeSpec> read_children(const XmlElement& element, int depth) {
    std::vector<TreeNodeSpec> children;
    for (const auto& child : element.children) {
      if (child.element) {
        children.push_back(read_node(*child.element, depth));
      } else if (child.text.find_first_not_of(" \t\r\n") != std::string::npos) {
        error(element.at, Code::kSyntax, fmt::format("a text in <{}>", element.name),
              "Remove it, or make it a comment");
      }
    }
    return children;
  }

  TreeNodeSpec read_node(const XmlElement& element, int depth) {
    TreeNodeSpec node;
    node.at = element.at;
    node.type = element.name;
    static constexpr std::array<std::string_view, 4> kExplicit = {"Action", "Condition", "Control", "Decorator"};
    const bool with_id = std::ranges::find(kExplicit, element.name) != kExplicit.end() || element.name == "SubTree";
    if (with_id) {
      const XmlAttribute* id = element.find("ID");
      if (id == nullptr || id->value.empty()) {
        error(element.at, Code::kMissing, fmt::format("<{}> without an ID", element.name), "Give it ID=\"NAME\"");
      } else {
        node.type = id->value;
      }
    }
    const TreeNodeType* type = tree_node_type(element.name == "SubTree" ? "SubTree" : node.type);
    if (element.name != "SubTree" && type != nullptr && type->kind == TreeNodeKind::kSubTree) type = nullptr;
    if (type != nullptr) node.kind = type->kind;
    if (type != nullptr && node.kind == TreeNodeKind::kSwitch) node.cases = type->max_children - 1;
    node.name = node.type;
    read_attributes(element, type, with_id, node);
    node.children = read_children(element, depth + 1);
    check_children(element, type, node);
    if (type != nullptr) check_ports(element, *type, node);
    if (node.kind == TreeNodeKind::kScript || node.kind == TreeNodeKind::kScriptCondition) {
      if (const TreePort* code = node.port("code")) node.script = script(code->text, code->at);
    }
    return node;
  }

  void read_attributes(const XmlElement& element, const TreeNodeType* type, bool with_id, TreeNodeSpec& node) {
    for (const XmlAttribute& one : element.attributes) {
      if (one.name == "ID" && with_id) continue;
      if (one.name == "name") {
        node.name = one.value;
        if (type != nullptr || node.kind != TreeNodeKind::kLeaf) continue;
      }
      if (one.name == "_description" || one.name == "_uid" || one.name == "_fullpath") continue;
      if (one.name == "_autoremap" && node.kind == TreeNodeKind::kSubTree) {
        node.autoremap = one.value == "true" || one.value == "1";
        continue;
      }
      if (read_condition(one, node)) continue;
      if (one.name.starts_with("_")) {
        std::vector<std::string> known(kPreNames.begin(), kPreNames.end());
        known.insert(known.end(), kPostNames.begin(), kPostNames.end());
        error(one.at, Code::kUnknownName, fmt::format("unknown attribute '{}'", one.name),
              nearest_choice(one.name, known));
        continue;
      }
      if (type != nullptr && node.kind != TreeNodeKind::kSubTree &&
          std::ranges::find(type->ports, one.name, &TreeNodeType::Port::name) == type->ports.end()) {
        std::vector<std::string> known;
        for (const auto& port : type->ports) known.emplace_back(port.name);
        error(one.at, Code::kUnknownName, fmt::format("{} has no port '{}'", type->name, one.name),
              known.empty() ? "Remove it" : nearest_choice(one.name, known));
        continue;
      }
      node.ports[one.name] = {.text = one.value, .key = key_in(one.value, one.name), .at = one.at};
    }
  }

  /// @return whether it is a script before or after the node
  bool read_condition(const XmlAttribute& one, TreeNodeSpec& node) {
    for (std::size_t i = 0; i < kPreNames.size(); ++i) {
      if (one.name == kPreNames[i]) node.pre[i] = script(one.value, one.at);
      if (one.name == kPostNames[i]) node.post[i] = script(one.value, one.at);
      if (one.name == kPreNames[i] || one.name == kPostNames[i]) return true;
    }
    return false;
  }

  std::optional<TreeScript> script(const std::string& text, const TextLocation& at) {
    auto script = TreeScript::parse(text);
    if (script) return std::move(*script);
    for (const Diagnostic& one : script.error().list()) error(at, one.code, one.message, one.hint);
    return std::nullopt;
  }

  void check_children(const XmlElement& element, const TreeNodeType* type, const TreeNodeSpec& node) {
    const int count = static_cast<int>(node.children.size());
    const int low = type != nullptr ? type->min_children : 0, high = type != nullptr ? type->max_children : 0;
    if (count >= low && count <= high) return;
    const std::string what = type != nullptr ? std::string(type->name) : fmt::format("the leaf '{}'", node.type);
    error(element.at, Code::kWrongSize, fmt::format("{} children of {}", count, what),
          low == high ? fmt::format("Give it {}", low == 0 ? "none" : std::to_string(low))
                      : fmt::format("Give it {}", high == kMany ? "at least 1" : fmt::format("{} to {}", low, high)));
  }

  void check_ports(const XmlElement& element, const TreeNodeType& type, const TreeNodeSpec& node) {
    for (const TreeNodeType::Port& port : type.ports) {
      const TreePort* given = node.port(port.name);
      if (given == nullptr) {
        if (port.fallback.empty())
          error(element.at, Code::kMissing, fmt::format("{} without '{}'", type.name, port.name),
                fmt::format("Give it {}=\"...\"", port.name));
        continue;
      }
      if (!port.number || !given->key.empty()) continue;
      if (!TreeValue::of_text(given->text).is_number())
        error(given->at, Code::kWrongType, fmt::format("unexpected value '{}'", given->text),
              "Give a number, or an entry as {NAME}");
    }
  }

  void choose_main(const XmlElement& root, const std::string& main) {
    const XmlAttribute* said = root.find("main_tree_to_execute");
    file_.main = !main.empty() ? main : said != nullptr ? said->value : "";
    if (file_.main.empty() && file_.trees.size() == 1) file_.main = file_.trees.begin()->first;
    if (file_.trees.contains(file_.main)) return;
    std::vector<std::string> names;
    for (const auto& [id, tree] : file_.trees) names.push_back(id);
    const TextLocation& at = said != nullptr && main.empty() ? said->at : root.at;
    if (file_.main.empty()) {
      error(at, Code::kMissing, fmt::format("one of {} trees", names.size()), "Give main_tree_to_execute=\"NAME\"");
    } else {
      error(at, Code::kUnknownName, fmt::format("there is no tree '{}'", file_.main),
            nearest_choice(file_.main, names));
    }
  }

  void check_subtrees(const TreeNodeSpec& node) {
    if (node.kind == TreeNodeKind::kSubTree && !file_.trees.contains(node.type)) {
      std::vector<std::string> names;
      for (const auto& [id, tree] : file_.trees) names.push_back(id);
      error(node.at, Code::kUnknownName, fmt::format("there is no tree '{}'", node.type),
            nearest_choice(node.type, names));
    }
    for (const TreeNodeSpec& child : node.children) check_subtrees(child);
  }

  /// No tree is inside of itself, and all written out is not too much.
  void check_size(const XmlElement& root) {
    std::map<std::string, std::size_t, std::less<>> sizes;
    std::vector<std::string> open;
    const auto size_of = [&](const auto& self, const std::string& id) -> std::size_t {
      if (const auto known = sizes.find(id); known != sizes.end()) return known->second;
      open.push_back(id);
      const auto count = [&](const auto& again, const TreeNodeSpec& node) -> std::size_t {
        std::size_t size = 1;
        if (node.kind == TreeNodeKind::kSubTree) {
          if (std::ranges::find(open, node.type) != open.end()) {
            error(node.at, Code::kConflict, fmt::format("the tree '{}' contains itself", node.type),
                  "Use Repeat or RetryUntilSuccessful for what is done again");
          } else {
            size += self(self, node.type);
          }
        }
        for (const TreeNodeSpec& child : node.children) size += again(again, child);
        return std::min(size, 10 * kMostNodes);
      };
      const std::size_t size = count(count, file_.trees.at(id));
      open.pop_back();
      return sizes[id] = size;
    };
    if (size_of(size_of, file_.main) > kMostNodes)
      error(root.at, Code::kTooLarge, "too many nodes with all subtrees", fmt::format("Use {} at most", kMostNodes));
  }

  TreeFile& file_;
  Diagnostics diagnostics_;
};

}  // namespace

std::span<const TreeNodeType> tree_node_types() { return node_types(); }

const TreeNodeType* tree_node_type(std::string_view name) {
  const auto found = std::ranges::find(node_types(), name, &TreeNodeType::name);
  return found == node_types().end() ? nullptr : &*found;
}

const TreeNodeType& type_of(const TreeNodeSpec& node) {
  return *tree_node_type(node.kind == TreeNodeKind::kSubTree ? "SubTree" : node.type);
}

Result<std::shared_ptr<const TreeFile>> read_trees(std::string_view xml, const std::string& main) {
  const auto document = parse_xml(xml);
  if (!document) return std::unexpected(document.error());
  auto file = std::make_shared<TreeFile>();
  Diagnostics wrong = TreeReader(*file).read(**document, main);
  if (wrong.has_errors()) return std::unexpected(std::move(wrong));
  return file;
}

}  // namespace takt::languages
