#include "languages/behavior_tree/session.h"

#include <utility>

#include "languages/behavior_tree/tree_node.h"

namespace takt::languages {

std::string_view name_of(TreeStatus status) {
  switch (status) {
    case TreeStatus::kIdle:
      return "IDLE";
    case TreeStatus::kRunning:
      return "RUNNING";
    case TreeStatus::kSuccess:
      return "SUCCESS";
    case TreeStatus::kFailure:
      return "FAILURE";
    case TreeStatus::kSkipped:
      return "SKIPPED";
  }
  return "";
}

// -- Blackboards ------------------------------------------------------------------------------------------------------

namespace {

bool is_outermost(const std::string& name) { return name.starts_with('@'); }

}  // namespace

const TreeValue* TreeBoard::find(const std::string& name) const {
  if (is_outermost(name)) return around_ != nullptr ? around_->find(name) : find(name.substr(1));
  if (const auto found = own_.find(name); found != own_.end()) return &found->second;
  if (around_ == nullptr) return nullptr;
  if (const auto outside = remapped_.find(name); outside != remapped_.end()) return around_->find(outside->second);
  return autoremap_ && !name.starts_with('_') ? around_->find(name) : nullptr;
}

void TreeBoard::set(const std::string& name, TreeValue value) {
  if (is_outermost(name))
    return around_ != nullptr ? around_->set(name, std::move(value)) : set(name.substr(1), std::move(value));
  if (around_ != nullptr && !own_.contains(name)) {
    if (const auto outside = remapped_.find(name); outside != remapped_.end())
      return around_->set(outside->second, std::move(value));
    if (autoremap_ && !name.starts_with('_')) return around_->set(name, std::move(value));
  }
  own_[name] = std::move(value);
}

std::optional<TreeValue> port_value(const TreeNodeSpec& node, std::string_view port, const TreeBoard& board) {
  const TreePort* given = node.port(port);
  if (given != nullptr && given->key.empty()) return TreeValue::of_text(given->text);
  if (given != nullptr) {
    const TreeValue* found = board.find(given->key);
    return found != nullptr && found->is_set() ? std::optional(*found) : std::nullopt;
  }
  if (node.kind == TreeNodeKind::kLeaf) return std::nullopt;
  for (const TreeNodeType::Port& one : type_of(node).ports)
    if (one.name == port && !one.fallback.empty()) return TreeValue::of_text(one.fallback);
  return std::nullopt;
}

TreeSession::TreeSession(const TreeFile& file, TreeLeaves& leaves)
    : shared_(std::make_unique<Shared>(Shared{.host = leaves})) {
  shared_->boards.push_back(std::make_unique<TreeBoard>());
  root_ = make_tree_node(file, file.trees.at(file.main), *shared_->boards.front(), "", *shared_);
}

TreeSession::~TreeSession() = default;

TreeStatus TreeSession::tick(Nanoseconds now) {
  shared_->now = now;
  const TreeStatus status = root_->execute();
  if (shared_->error) halt();
  if (is_over(status)) root_->reset_status();
  return status;
}

void TreeSession::halt() {
  if (root_->status() == TreeStatus::kRunning) root_->halt_running();
  root_->reset_status();
}

TreeStatus TreeSession::status() const { return root_->status(); }
const std::vector<TreeLeaf>& TreeSession::leaves() const { return shared_->leaves; }
TreeBoard& TreeSession::board() { return *shared_->boards.front(); }
const std::optional<Diagnostic>& TreeSession::error() const { return shared_->error; }
std::vector<std::string> TreeSession::running() const {
  std::vector<std::string> names;
  root_->collect_running(names);
  return names;
}

}  // namespace takt::languages
