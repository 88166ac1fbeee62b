#include "languages/behavior_tree/session.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace takt::languages {

using Kind = TreeNodeKind;
using Status = TreeStatus;

std::string_view name_of(TreeStatus status) {
  switch (status) {
    case Status::kIdle:
      return "IDLE";
    case Status::kRunning:
      return "RUNNING";
    case Status::kSuccess:
      return "SUCCESS";
    case Status::kFailure:
      return "FAILURE";
    case Status::kSkipped:
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
  if (node.kind == Kind::kLeaf) return std::nullopt;
  for (const TreeNodeType::Port& one : type_of(node).ports)
    if (one.name == port && !one.fallback.empty()) return TreeValue::of_text(one.fallback);
  return std::nullopt;
}

// -- Nodes ------------------------------------------------------------------------------------------------------------

struct TreeSession::Shared {
  TreeLeaves& host;
  std::vector<std::unique_ptr<TreeBoard>> boards = {};
  std::vector<TreeLeaf> leaves = {};
  Nanoseconds now = 0;
  std::optional<Diagnostic> error = {};
};

/// A node while its tree runs: what every kind does around its own tick.
class TreeSession::Node {
 public:
  Node(const TreeNodeSpec& spec, TreeBoard& board, Shared& shared) : spec_(spec), board_(board), shared_(shared) {}
  virtual ~Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  std::vector<std::unique_ptr<Node>> children;

  [[nodiscard]] Status status() const { return status_; }
  [[nodiscard]] const TreeNodeSpec& spec() const { return spec_; }

  Status execute() {
    Status next = Status::kIdle;
    if (const auto decided = before()) {
      next = *decided;
    } else if (!shared_.error) {
      next = tick();
    }
    if (shared_.error) next = Status::kFailure;
    if (next == Status::kSuccess || next == Status::kFailure) after(next);
    if (next != Status::kSkipped) status_ = next;
    if (is_decorator()) {
      Node& child = *children.front();
      if (child.status_ == Status::kSuccess || child.status_ == Status::kFailure) child.status_ = Status::kIdle;
    }
    return next;
  }

  /// Of a node that runs.
  void halt_running() {
    halt();
    run(spec_.post[static_cast<std::size_t>(TreePost::kOnHalted)]);
  }
  void reset_status() { status_ = Status::kIdle; }
  void collect_running(std::vector<std::string>& names) const {
    if (status_ != Status::kRunning) return;
    names.push_back(spec_.name);
    for (const auto& child : children) child->collect_running(names);
  }

 protected:
  [[nodiscard]] virtual Status tick() = 0;
  virtual void halt() {
    reset_children();
    status_ = Status::kIdle;
  }
  [[nodiscard]] virtual bool is_decorator() const { return false; }

  [[nodiscard]] std::size_t count() const { return children.size(); }
  void halt_child(std::size_t i) {
    if (children[i]->status_ == Status::kRunning) children[i]->halt_running();
    children[i]->status_ = Status::kIdle;
  }
  void reset_children() {
    for (std::size_t i = 0; i < children.size(); ++i) halt_child(i);
  }
  void set_running() { status_ = Status::kRunning; }
  [[nodiscard]] bool is_idle() const { return status_ == Status::kIdle; }
  [[nodiscard]] bool was_active() const { return status_ != Status::kIdle && status_ != Status::kSkipped; }

  /// A script's value; an error of it is that of the tree.
  std::optional<TreeValue> run(const std::optional<TreeScript>& script) {
    if (!script || shared_.error) return std::nullopt;
    auto value = script->run(board_);
    if (value) return std::move(*value);
    fail(value.error().list().front());
    return std::nullopt;
  }
  void fail(Diagnostic why) {
    if (shared_.error) return;
    why.severity = Severity::kError;
    why.message = fmt::format("{}: {}", spec_.name, why.message);
    why.line = spec_.at.line;
    why.column = spec_.at.column;
    shared_.error = std::move(why);
  }
  void fail(Code code, std::string message, std::string hint) {
    Diagnostics one;
    one.error(code, {}, std::move(message), std::move(hint));
    fail(one.list().front());
  }
  /// A whole number of a port; 0 with an error.
  [[nodiscard]] std::int64_t whole(std::string_view port) {
    const auto value = port_value(spec_, port, board_);
    if (value && value->is_number() && std::trunc(value->number()) == value->number() &&
        std::abs(value->number()) < 1e15)
      return static_cast<std::int64_t>(value->number());
    fail(value ? Code::kWrongType : Code::kUnknownName,
         fmt::format("'{}' is {}", port, value ? value->to_text() : "not set"), "Give a whole number");
    return 0;
  }
  [[nodiscard]] Nanoseconds milliseconds(std::string_view port) { return whole(port) * kMillisecond; }

  const TreeNodeSpec& spec_;
  TreeBoard& board_;
  Shared& shared_;

 private:
  /// What the scripts before it say; nothing: tick it.
  std::optional<Status> before() {
    for (std::size_t i = 0; i < spec_.pre.size(); ++i) {
      if (!spec_.pre[i]) continue;
      const auto what = static_cast<TreePre>(i);
      const bool begins = status_ == Status::kIdle || status_ == Status::kSkipped;
      if (!begins && !(status_ == Status::kRunning && what == TreePre::kWhile)) continue;
      const auto value = run(spec_.pre[i]);
      const auto holds = value ? truth_of(*value) : std::nullopt;
      if (!holds) {
        if (!shared_.error) fail(Code::kWrongType, "a condition that is no number", "Compare it with something");
        return Status::kFailure;
      }
      if (what == TreePre::kWhile) {
        if (*holds) continue;
        if (!begins) halt_running();
        return Status::kSkipped;
      }
      if (!*holds) continue;
      return what == TreePre::kFailureIf   ? Status::kFailure
             : what == TreePre::kSuccessIf ? Status::kSuccess
                                           : Status::kSkipped;
    }
    return std::nullopt;
  }
  void after(Status status) {
    run(spec_.post[static_cast<std::size_t>(status == Status::kSuccess ? TreePost::kOnSuccess : TreePost::kOnFailure)]);
    run(spec_.post[static_cast<std::size_t>(TreePost::kAlways)]);
  }

  Status status_ = Status::kIdle;
};

namespace {

using Node = TreeSession::Node;

bool is_over(Status status) { return status == Status::kSuccess || status == Status::kFailure; }

/// Sequence and Fallback, and the sequence that stays where it failed. Some give the tick back after a child that took
/// no time, so that what is around them may look again.
class InOrder final : public Node {
 public:
  /// @param goes_on  with which the next child is ticked
  InOrder(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, Status goes_on, bool remembers)
      : Node(spec, board, shared),
        goes_on_(goes_on),
        remembers_(remembers),
        gives_back_(remembers || spec.type.starts_with("Async")) {}

 private:
  Status tick() override {
    if (!was_active()) skipped_ = 0;
    set_running();
    while (at_ < count()) {
      const bool was_idle = children[at_]->status() == Status::kIdle;
      const Status child = children[at_]->execute();
      if (child == Status::kRunning) return child;
      if (child == Status::kSkipped) ++skipped_;
      if (child == goes_on_ || child == Status::kSkipped) {
        ++at_;
        if (gives_back_ && child == goes_on_ && was_idle && at_ < count()) return Status::kRunning;
        continue;
      }
      if (remembers_) {
        for (std::size_t i = at_; i < count(); ++i) halt_child(i);
      } else {
        reset_children();
        at_ = 0;
      }
      return child;
    }
    const bool all_skipped = skipped_ == count();
    reset_children();
    at_ = skipped_ = 0;
    return all_skipped ? Status::kSkipped : goes_on_;
  }
  /// With a memory it goes on where it was even after a halt.
  void halt() override {
    if (!remembers_) at_ = 0;
    skipped_ = 0;
    Node::halt();
  }

  Status goes_on_;
  bool remembers_, gives_back_;
  std::size_t at_ = 0, skipped_ = 0;
};

class Reactive final : public Node {
 public:
  Reactive(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, Status goes_on)
      : Node(spec, board, shared), goes_on_(goes_on) {}

 private:
  Status tick() override {
    bool all_skipped = true;
    set_running();
    for (std::size_t i = 0; i < count(); ++i) {
      const Status child = children[i]->execute();
      all_skipped = all_skipped && child == Status::kSkipped;
      if (child == Status::kRunning) {
        for (std::size_t other = 0; other < count(); ++other)
          if (other != i) halt_child(other);
        return child;
      }
      if (child == Status::kSkipped) {
        halt_child(i);
      } else if (child != goes_on_) {
        reset_children();
        return child;
      }
    }
    reset_children();
    return all_skipped ? Status::kSkipped : goes_on_;
  }

  Status goes_on_;
};

class Parallel final : public Node {
 public:
  Parallel(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, bool waits_for_all)
      : Node(spec, board, shared), all_(waits_for_all) {}

 private:
  std::int64_t threshold(std::string_view port) {
    const auto size = static_cast<std::int64_t>(count());
    const std::int64_t given = whole(port);
    if (given > size)
      fail(Code::kOutOfRange, fmt::format("'{}' is {} of {} children", port, given, size), "Decrease it");
    return given < 0 ? std::max<std::int64_t>(size + given + 1, 0) : given;
  }
  Status tick() override { return all_ ? tick_all() : tick_some(); }

  Status tick_some() {
    const std::int64_t wanted = threshold("success_count"), refused = threshold("failure_count");
    const bool counts_skipped = whole("success_count") < 0;
    if (shared_.error) return Status::kFailure;
    set_running();
    std::int64_t skipped = 0;
    const auto size = static_cast<std::int64_t>(count());
    for (std::size_t i = 0; i < count(); ++i) {
      if (!done_.contains(i)) {
        const Status child = children[i]->execute();
        if (child == Status::kSkipped) ++skipped;
        if (is_over(child)) {
          done_.insert(i);
          ++(child == Status::kSuccess ? successes_ : failures_);
        }
      }
      if (successes_ >= wanted || (counts_skipped && successes_ + skipped >= wanted)) return end(Status::kSuccess);
      if (size - failures_ < wanted || failures_ == refused) return end(Status::kFailure);
    }
    return skipped == size ? Status::kSkipped : Status::kRunning;
  }

  Status tick_all() {
    const std::int64_t refused = threshold("max_failures");
    if (shared_.error) return Status::kFailure;
    set_running();
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < count(); ++i) {
      if (done_.contains(i)) continue;
      const Status child = children[i]->execute();
      if (child == Status::kSkipped) ++skipped;
      if (!is_over(child)) continue;
      done_.insert(i);
      if (child == Status::kFailure) ++failures_;
    }
    if (skipped == count()) return Status::kSkipped;
    if (skipped + done_.size() < count()) return Status::kRunning;
    return end(failures_ >= refused ? Status::kFailure : Status::kSuccess);
  }

  Status end(Status status) {
    clear();
    reset_children();
    return status;
  }
  void clear() {
    done_.clear();
    successes_ = failures_ = 0;
  }
  void halt() override {
    clear();
    Node::halt();
  }

  bool all_;
  std::set<std::size_t> done_;
  std::int64_t successes_ = 0, failures_ = 0;
};

class IfThenElse final : public Node {
 public:
  using Node::Node;

 private:
  Status tick() override {
    set_running();
    if (chosen_ == 0) {
      const Status condition = children[0]->execute();
      if (condition == Status::kRunning) return condition;
      if (condition == Status::kSkipped) {
        fail(Code::kUnsupported, "its condition was skipped", "Let the condition succeed or fail");
        return Status::kFailure;
      }
      if (condition == Status::kFailure && count() < 3) return condition;
      chosen_ = condition == Status::kSuccess ? 1 : 2;
    }
    const Status status = children[chosen_]->execute();
    if (status == Status::kRunning) return status;
    reset_children();
    chosen_ = 0;
    return status;
  }
  void halt() override {
    chosen_ = 0;
    Node::halt();
  }

  std::size_t chosen_ = 0;
};

class WhileDoElse final : public Node {
 public:
  using Node::Node;

 private:
  Status tick() override {
    set_running();
    const Status condition = children[0]->execute();
    if (condition == Status::kRunning) return condition;
    Status status = condition;
    if (condition == Status::kSuccess) {
      if (count() == 3) halt_child(2);
      status = children[1]->execute();
    } else if (condition == Status::kFailure && count() == 3) {
      halt_child(1);
      status = children[2]->execute();
    }
    if (status != Status::kRunning) reset_children();
    return status;
  }
};

class Switch final : public Node {
 public:
  using Node::Node;

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  Status tick() override {
    const std::size_t match = matching();
    if (running_ != kNone && running_ != match) halt_child(running_);
    const Status status = children[match]->execute();
    if (status == Status::kRunning) {
      running_ = match;
    } else {
      if (status != Status::kSkipped) reset_children();
      running_ = kNone;
    }
    return status;
  }
  [[nodiscard]] std::size_t matching() const {
    const auto variable = port_value(spec_, "variable", board_);
    const auto cases = static_cast<std::size_t>(spec_.cases);
    for (std::size_t i = 0; variable && i < cases; ++i) {
      const auto one = port_value(spec_, fmt::format("case_{}", i + 1), board_);
      if (one && one->to_text() == variable->to_text()) return i;
    }
    return cases;
  }
  void halt() override {
    running_ = kNone;
    Node::halt();
  }

  std::size_t running_ = kNone;
};

class Decorator : public Node {
 public:
  using Node::Node;

 protected:
  [[nodiscard]] bool is_decorator() const final { return true; }
  [[nodiscard]] Node& child() { return *children.front(); }
};

/// Inverter, ForceSuccess, ForceFailure: another end.
class Renaming final : public Decorator {
 public:
  Renaming(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, Status success, Status failure)
      : Decorator(spec, board, shared), success_(success), failure_(failure) {}

 private:
  Status tick() override {
    set_running();
    const Status status = child().execute();
    if (!is_over(status)) return status;
    halt_child(0);
    return status == Status::kSuccess ? success_ : failure_;
  }
  Status success_, failure_;
};

/// Repeat and RetryUntilSuccessful: again after one end, as often as it may. A round that took no time gives the tick
/// back.
class Again final : public Decorator {
 public:
  Again(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, Status again, std::string_view port)
      : Decorator(spec, board, shared), again_(again), port_(port) {}

 private:
  Status tick() override {
    const std::int64_t most = whole(port_);
    if (shared_.error) return Status::kFailure;
    const auto goes_on = [&] { return most == -1 || done_ < most; };
    bool again = goes_on();
    set_running();
    while (again) {
      const bool was_idle = child().status() == Status::kIdle;
      const Status status = child().execute();
      if (status == Status::kRunning || status == Status::kSkipped) return status;
      if (status != again_) {
        done_ = 0;
        halt_child(0);
        return status;
      }
      ++done_;
      again = goes_on();
      halt_child(0);
      if (was_idle && again) return Status::kRunning;
    }
    done_ = 0;
    return again_;
  }
  void halt() override {
    done_ = 0;
    Node::halt();
  }

  Status again_;
  std::string_view port_;
  std::int64_t done_ = 0;
};

class KeepRunningUntilFailure final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  Status tick() override {
    set_running();
    const Status status = child().execute();
    if (is_over(status)) halt_child(0);
    return status == Status::kFailure ? status : Status::kRunning;
  }
};

class Delay final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  Status tick() override {
    if (!due_) {
      due_ = shared_.now + milliseconds("delay_msec");
      set_running();
    }
    if (shared_.error) return Status::kFailure;
    if (shared_.now < *due_) return Status::kRunning;
    const Status status = child().execute();
    if (is_over(status)) {
      due_.reset();
      halt_child(0);
    }
    return status;
  }
  void halt() override {
    due_.reset();
    Node::halt();
  }

  std::optional<Nanoseconds> due_;
};

class Timeout final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  Status tick() override {
    if (!due_) {
      due_ = shared_.now + milliseconds("msec");
      set_running();
    }
    if (shared_.error) return Status::kFailure;
    if (shared_.now >= *due_ && child().status() == Status::kRunning) {
      halt_child(0);
      due_.reset();
      return Status::kFailure;
    }
    const Status status = child().execute();
    if (is_over(status)) {
      due_.reset();
      halt_child(0);
    }
    return status;
  }
  void halt() override {
    due_.reset();
    Node::halt();
  }

  std::optional<Nanoseconds> due_;
};

class RunOnce final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  Status tick() override {
    const auto skips = port_value(spec_, "then_skip", board_);
    if (result_) return skips && truth_of(*skips).value_or(true) ? Status::kSkipped : *result_;
    set_running();
    const Status status = child().execute();
    if (is_over(status)) {
      result_ = status;
      halt_child(0);
    }
    return status;
  }

  std::optional<Status> result_;
};

class SubTree final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  Status tick() override {
    if (is_idle()) set_running();
    const Status status = child().execute();
    if (is_over(status)) halt_child(0);
    return status;
  }
};

/// AlwaysSuccess, AlwaysFailure, Script, ScriptCondition, SetBlackboard: over in their tick.
class Instant final : public Node {
 public:
  using Node::Node;

 private:
  Status tick() override {
    switch (spec_.kind) {
      case Kind::kAlwaysSuccess:
        return Status::kSuccess;
      case Kind::kAlwaysFailure:
        return Status::kFailure;
      case Kind::kSetBlackboard:
        return set_entry();
      default:
        break;
    }
    const auto value = run(spec_.script);
    if (!value) return Status::kFailure;
    if (spec_.kind == Kind::kScript) return Status::kSuccess;
    return truth_of(*value).value_or(false) ? Status::kSuccess : Status::kFailure;
  }
  Status set_entry() {
    const auto value = port_value(spec_, "value", board_);
    const TreePort* key = spec_.port("output_key");
    if (!value || key == nullptr) {
      fail(Code::kUnknownName, "its value is not set", "Set the entry before");
      return Status::kFailure;
    }
    board_.set(key->key.empty() ? key->text : key->key, *value);
    return Status::kSuccess;
  }
};

class Sleep final : public Node {
 public:
  using Node::Node;

 private:
  Status tick() override {
    if (!due_) due_ = shared_.now + milliseconds("msec");
    if (shared_.error) return Status::kFailure;
    if (shared_.now < *due_) return Status::kRunning;
    due_.reset();
    return Status::kSuccess;
  }
  void halt() override {
    due_.reset();
    Node::halt();
  }

  std::optional<Nanoseconds> due_;
};

class Leaf final : public Node {
 public:
  Leaf(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, std::size_t number)
      : Node(spec, board, shared), number_(number) {}

 private:
  Status tick() override {
    const bool fresh = status() != Status::kRunning;
    return shared_.host.tick(number_, shared_.leaves[number_], fresh);
  }
  void halt() override {
    if (status() == Status::kRunning) shared_.host.halt(number_, shared_.leaves[number_]);
    Node::halt();
  }

  std::size_t number_;
};

/// Makes nodes of what is written, with subtrees.
class TreeBuilder {
 public:
  TreeBuilder(const TreeFile& file, TreeSession::Shared& shared) : file_(file), shared_(shared) {}

  std::unique_ptr<Node> make(const TreeNodeSpec& spec, TreeBoard& board, const std::string& around) {
    const std::string path = around.empty() ? spec.name : around + " / " + spec.name;
    auto node = alone(spec, board, path);
    if (spec.kind == Kind::kSubTree) {
      auto inside = std::make_unique<TreeBoard>(&board, spec.autoremap);
      for (const auto& [name, port] : spec.ports) {
        if (!port.key.empty()) {
          inside->remap(name, port.key);
        } else {
          inside->define(name, TreeValue::of_text(port.text));
        }
      }
      TreeBoard& own = *inside;
      shared_.boards.push_back(std::move(inside));
      node->children.push_back(make(file_.trees.at(spec.type), own, path));
    }
    for (const TreeNodeSpec& child : spec.children) node->children.push_back(make(child, board, path));
    return node;
  }

 private:
  std::unique_ptr<Node> alone(const TreeNodeSpec& spec, TreeBoard& board, const std::string& path) {
    using enum TreeStatus;
    const auto made = [&]<class T, class... Arguments>(std::type_identity<T>, Arguments... arguments) {
      return std::make_unique<T>(spec, board, shared_, arguments...);
    };
    switch (spec.kind) {
      case Kind::kSequence:
        return made(std::type_identity<InOrder>(), kSuccess, false);
      case Kind::kSequenceWithMemory:
        return made(std::type_identity<InOrder>(), kSuccess, true);
      case Kind::kFallback:
        return made(std::type_identity<InOrder>(), kFailure, false);
      case Kind::kReactiveSequence:
        return made(std::type_identity<Reactive>(), kSuccess);
      case Kind::kReactiveFallback:
        return made(std::type_identity<Reactive>(), kFailure);
      case Kind::kParallel:
        return made(std::type_identity<Parallel>(), false);
      case Kind::kParallelAll:
        return made(std::type_identity<Parallel>(), true);
      case Kind::kIfThenElse:
        return made(std::type_identity<IfThenElse>());
      case Kind::kWhileDoElse:
        return made(std::type_identity<WhileDoElse>());
      case Kind::kSwitch:
        return made(std::type_identity<Switch>());
      case Kind::kInverter:
        return made(std::type_identity<Renaming>(), kFailure, kSuccess);
      case Kind::kForceSuccess:
        return made(std::type_identity<Renaming>(), kSuccess, kSuccess);
      case Kind::kForceFailure:
        return made(std::type_identity<Renaming>(), kFailure, kFailure);
      case Kind::kRepeat:
        return made(std::type_identity<Again>(), kSuccess, std::string_view("num_cycles"));
      case Kind::kRetry:
        return made(std::type_identity<Again>(), kFailure, std::string_view("num_attempts"));
      case Kind::kKeepRunningUntilFailure:
        return made(std::type_identity<KeepRunningUntilFailure>());
      case Kind::kDelay:
        return made(std::type_identity<Delay>());
      case Kind::kTimeout:
        return made(std::type_identity<Timeout>());
      case Kind::kRunOnce:
        return made(std::type_identity<RunOnce>());
      case Kind::kSubTree:
        return made(std::type_identity<SubTree>());
      case Kind::kSleep:
        return made(std::type_identity<Sleep>());
      case Kind::kLeaf:
        shared_.leaves.push_back({&spec, &board, path});
        return made(std::type_identity<Leaf>(), shared_.leaves.size() - 1);
      default:
        return made(std::type_identity<Instant>());
    }
  }

  const TreeFile& file_;
  TreeSession::Shared& shared_;
};

}  // namespace

TreeSession::TreeSession(const TreeFile& file, TreeLeaves& leaves)
    : shared_(std::make_unique<Shared>(Shared{.host = leaves})) {
  shared_->boards.push_back(std::make_unique<TreeBoard>());
  root_ = TreeBuilder(file, *shared_).make(file.trees.at(file.main), *shared_->boards.front(), "");
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
