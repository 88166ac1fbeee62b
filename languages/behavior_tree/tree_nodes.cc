#include <algorithm>
#include <set>

#include "languages/behavior_tree/tree_node.h"

namespace takt::languages {

namespace {

using Node = TreeSession::Node;

/// Sequence and Fallback, and the sequence that stays where it failed. Some give the tick back after a child that took
/// no time, so that what is around them may look again.
class InOrder final : public Node {
 public:
  /// @param goes_on  with which the next child is ticked
  InOrder(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, TreeStatus goes_on, bool remembers)
      : Node(spec, board, shared),
        goes_on_(goes_on),
        remembers_(remembers),
        gives_back_(remembers || spec.type.starts_with("Async")) {}

 private:
  TreeStatus tick() override {
    if (!was_active()) skipped_ = 0;
    set_running();
    while (at_ < count()) {
      const bool was_idle = children[at_]->status() == TreeStatus::kIdle;
      const TreeStatus child = children[at_]->execute();
      if (child == TreeStatus::kRunning) return child;
      if (child == TreeStatus::kSkipped) ++skipped_;
      if (child == goes_on_ || child == TreeStatus::kSkipped) {
        ++at_;
        if (gives_back_ && child == goes_on_ && was_idle && at_ < count()) return TreeStatus::kRunning;
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
    return all_skipped ? TreeStatus::kSkipped : goes_on_;
  }
  /// With a memory it goes on where it was even after a halt.
  void halt() override {
    if (!remembers_) at_ = 0;
    skipped_ = 0;
    Node::halt();
  }

  TreeStatus goes_on_;
  bool remembers_, gives_back_;
  std::size_t at_ = 0, skipped_ = 0;
};

class Reactive final : public Node {
 public:
  Reactive(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, TreeStatus goes_on)
      : Node(spec, board, shared), goes_on_(goes_on) {}

 private:
  TreeStatus tick() override {
    bool all_skipped = true;
    set_running();
    for (std::size_t i = 0; i < count(); ++i) {
      const TreeStatus child = children[i]->execute();
      all_skipped = all_skipped && child == TreeStatus::kSkipped;
      if (child == TreeStatus::kRunning) {
        for (std::size_t other = 0; other < count(); ++other)
          if (other != i) halt_child(other);
        return child;
      }
      if (child == TreeStatus::kSkipped) {
        halt_child(i);
      } else if (child != goes_on_) {
        reset_children();
        return child;
      }
    }
    reset_children();
    return all_skipped ? TreeStatus::kSkipped : goes_on_;
  }

  TreeStatus goes_on_;
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
  TreeStatus tick() override { return all_ ? tick_all() : tick_some(); }

  TreeStatus tick_some() {
    const std::int64_t wanted = threshold("success_count"), refused = threshold("failure_count");
    const bool counts_skipped = whole("success_count") < 0;
    if (shared_.error) return TreeStatus::kFailure;
    set_running();
    std::int64_t skipped = 0;
    const auto size = static_cast<std::int64_t>(count());
    for (std::size_t i = 0; i < count(); ++i) {
      if (!done_.contains(i)) {
        const TreeStatus child = children[i]->execute();
        if (child == TreeStatus::kSkipped) ++skipped;
        if (is_over(child)) {
          done_.insert(i);
          ++(child == TreeStatus::kSuccess ? successes_ : failures_);
        }
      }
      if (successes_ >= wanted || (counts_skipped && successes_ + skipped >= wanted)) return end(TreeStatus::kSuccess);
      if (size - failures_ < wanted || failures_ == refused) return end(TreeStatus::kFailure);
    }
    return skipped == size ? TreeStatus::kSkipped : TreeStatus::kRunning;
  }

  TreeStatus tick_all() {
    const std::int64_t refused = threshold("max_failures");
    if (shared_.error) return TreeStatus::kFailure;
    set_running();
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < count(); ++i) {
      if (done_.contains(i)) continue;
      const TreeStatus child = children[i]->execute();
      if (child == TreeStatus::kSkipped) ++skipped;
      if (!is_over(child)) continue;
      done_.insert(i);
      if (child == TreeStatus::kFailure) ++failures_;
    }
    if (skipped == count()) return TreeStatus::kSkipped;
    if (skipped + done_.size() < count()) return TreeStatus::kRunning;
    return end(failures_ >= refused ? TreeStatus::kFailure : TreeStatus::kSuccess);
  }

  TreeStatus end(TreeStatus status) {
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
  TreeStatus tick() override {
    set_running();
    if (chosen_ == 0) {
      const TreeStatus condition = children[0]->execute();
      if (condition == TreeStatus::kRunning) return condition;
      if (condition == TreeStatus::kSkipped) {
        fail(Code::kUnsupported, "its condition was skipped", "Let the condition succeed or fail");
        return TreeStatus::kFailure;
      }
      if (condition == TreeStatus::kFailure && count() < 3) return condition;
      chosen_ = condition == TreeStatus::kSuccess ? 1 : 2;
    }
    const TreeStatus status = children[chosen_]->execute();
    if (status == TreeStatus::kRunning) return status;
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
  TreeStatus tick() override {
    set_running();
    const TreeStatus condition = children[0]->execute();
    if (condition == TreeStatus::kRunning) return condition;
    TreeStatus status = condition;
    if (condition == TreeStatus::kSuccess) {
      if (count() == 3) halt_child(2);
      status = children[1]->execute();
    } else if (condition == TreeStatus::kFailure && count() == 3) {
      halt_child(1);
      status = children[2]->execute();
    }
    if (status != TreeStatus::kRunning) reset_children();
    return status;
  }
};

class Switch final : public Node {
 public:
  using Node::Node;

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  TreeStatus tick() override {
    const std::size_t match = matching();
    if (running_ != kNone && running_ != match) halt_child(running_);
    const TreeStatus status = children[match]->execute();
    if (status == TreeStatus::kRunning) {
      running_ = match;
    } else {
      if (status != TreeStatus::kSkipped) reset_children();
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
  Renaming(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, TreeStatus success,
           TreeStatus failure)
      : Decorator(spec, board, shared), success_(success), failure_(failure) {}

 private:
  TreeStatus tick() override {
    set_running();
    const TreeStatus status = child().execute();
    if (!is_over(status)) return status;
    halt_child(0);
    return status == TreeStatus::kSuccess ? success_ : failure_;
  }
  TreeStatus success_, failure_;
};

/// Repeat and RetryUntilSuccessful: again after one end, as often as it may. A round that took no time gives the tick
/// back.
class Again final : public Decorator {
 public:
  Again(const TreeNodeSpec& spec, TreeBoard& board, TreeSession::Shared& shared, TreeStatus again,
        std::string_view port)
      : Decorator(spec, board, shared), again_(again), port_(port) {}

 private:
  TreeStatus tick() override {
    const std::int64_t most = whole(port_);
    if (shared_.error) return TreeStatus::kFailure;
    const auto goes_on = [&] { return most == -1 || done_ < most; };
    bool again = goes_on();
    set_running();
    while (again) {
      const bool was_idle = child().status() == TreeStatus::kIdle;
      const TreeStatus status = child().execute();
      if (status == TreeStatus::kRunning) return status;
      if (status == TreeStatus::kSkipped) {  // it may be skipped again, which does not count as a round
        halt_child(0);
        return status;
      }
      if (status != again_) {
        done_ = 0;
        halt_child(0);
        return status;
      }
      ++done_;
      again = goes_on();
      halt_child(0);
      if (was_idle && again) return TreeStatus::kRunning;
    }
    done_ = 0;
    return again_;
  }
  void halt() override {
    done_ = 0;
    Node::halt();
  }

  TreeStatus again_;
  std::string_view port_;
  std::int64_t done_ = 0;
};

class KeepRunningUntilFailure final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  TreeStatus tick() override {
    set_running();
    const TreeStatus status = child().execute();
    if (is_over(status)) halt_child(0);
    return status == TreeStatus::kFailure ? status : TreeStatus::kRunning;
  }
};

class Delay final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  TreeStatus tick() override {
    if (!due_) {
      due_ = shared_.now + milliseconds("delay_msec");
      set_running();
    }
    if (shared_.error) return TreeStatus::kFailure;
    if (shared_.now < *due_) return TreeStatus::kRunning;
    const TreeStatus status = child().execute();
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
  TreeStatus tick() override {
    if (!due_) {
      due_ = shared_.now + milliseconds("msec");
      set_running();
    }
    if (shared_.error) return TreeStatus::kFailure;
    if (shared_.now >= *due_ && child().status() == TreeStatus::kRunning) {
      halt_child(0);
      due_.reset();
      return TreeStatus::kFailure;
    }
    const TreeStatus status = child().execute();
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
  TreeStatus tick() override {
    const auto skips = port_value(spec_, "then_skip", board_);
    if (result_) return skips && truth_of(*skips).value_or(true) ? TreeStatus::kSkipped : *result_;
    set_running();
    const TreeStatus status = child().execute();
    if (is_over(status)) {
      result_ = status;
      halt_child(0);
    }
    return status;
  }

  std::optional<TreeStatus> result_;
};

class SubTree final : public Decorator {
 public:
  using Decorator::Decorator;

 private:
  TreeStatus tick() override {
    if (is_idle()) set_running();
    const TreeStatus status = child().execute();
    if (is_over(status)) halt_child(0);
    return status;
  }
};

/// AlwaysSuccess, AlwaysFailure, Script, ScriptCondition, SetBlackboard: over in their tick.
class Instant final : public Node {
 public:
  using Node::Node;

 private:
  TreeStatus tick() override {
    switch (spec_.kind) {
      case TreeNodeKind::kAlwaysSuccess:
        return TreeStatus::kSuccess;
      case TreeNodeKind::kAlwaysFailure:
        return TreeStatus::kFailure;
      case TreeNodeKind::kSetBlackboard:
        return set_entry();
      default:
        break;
    }
    const auto value = run(spec_.script);
    if (!value) return TreeStatus::kFailure;
    if (spec_.kind == TreeNodeKind::kScript) return TreeStatus::kSuccess;
    return truth_of(*value).value_or(false) ? TreeStatus::kSuccess : TreeStatus::kFailure;
  }
  TreeStatus set_entry() {
    const auto value = port_value(spec_, "value", board_);
    const TreePort* key = spec_.port("output_key");
    if (!value || key == nullptr) {
      fail(Code::kUnknownName, "its value is not set", "Set the entry before");
      return TreeStatus::kFailure;
    }
    board_.set(key->key.empty() ? key->text : key->key, *value);
    return TreeStatus::kSuccess;
  }
};

class Sleep final : public Node {
 public:
  using Node::Node;

 private:
  TreeStatus tick() override {
    if (!due_) due_ = shared_.now + milliseconds("msec");
    if (shared_.error) return TreeStatus::kFailure;
    if (shared_.now < *due_) return TreeStatus::kRunning;
    due_.reset();
    return TreeStatus::kSuccess;
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
  TreeStatus tick() override {
    const bool fresh = status() != TreeStatus::kRunning;
    return shared_.host.tick(number_, shared_.leaves[number_], fresh);
  }
  void halt() override {
    if (status() == TreeStatus::kRunning) shared_.host.halt(number_, shared_.leaves[number_]);
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
    if (spec.kind == TreeNodeKind::kSubTree) {
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
      case TreeNodeKind::kSequence:
        return made(std::type_identity<InOrder>(), kSuccess, false);
      case TreeNodeKind::kSequenceWithMemory:
        return made(std::type_identity<InOrder>(), kSuccess, true);
      case TreeNodeKind::kFallback:
        return made(std::type_identity<InOrder>(), kFailure, false);
      case TreeNodeKind::kReactiveSequence:
        return made(std::type_identity<Reactive>(), kSuccess);
      case TreeNodeKind::kReactiveFallback:
        return made(std::type_identity<Reactive>(), kFailure);
      case TreeNodeKind::kParallel:
        return made(std::type_identity<Parallel>(), false);
      case TreeNodeKind::kParallelAll:
        return made(std::type_identity<Parallel>(), true);
      case TreeNodeKind::kIfThenElse:
        return made(std::type_identity<IfThenElse>());
      case TreeNodeKind::kWhileDoElse:
        return made(std::type_identity<WhileDoElse>());
      case TreeNodeKind::kSwitch:
        return made(std::type_identity<Switch>());
      case TreeNodeKind::kInverter:
        return made(std::type_identity<Renaming>(), kFailure, kSuccess);
      case TreeNodeKind::kForceSuccess:
        return made(std::type_identity<Renaming>(), kSuccess, kSuccess);
      case TreeNodeKind::kForceFailure:
        return made(std::type_identity<Renaming>(), kFailure, kFailure);
      case TreeNodeKind::kRepeat:
        return made(std::type_identity<Again>(), kSuccess, std::string_view("num_cycles"));
      case TreeNodeKind::kRetry:
        return made(std::type_identity<Again>(), kFailure, std::string_view("num_attempts"));
      case TreeNodeKind::kKeepRunningUntilFailure:
        return made(std::type_identity<KeepRunningUntilFailure>());
      case TreeNodeKind::kDelay:
        return made(std::type_identity<Delay>());
      case TreeNodeKind::kTimeout:
        return made(std::type_identity<Timeout>());
      case TreeNodeKind::kRunOnce:
        return made(std::type_identity<RunOnce>());
      case TreeNodeKind::kSubTree:
        return made(std::type_identity<SubTree>());
      case TreeNodeKind::kSleep:
        return made(std::type_identity<Sleep>());
      case TreeNodeKind::kLeaf:
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

std::unique_ptr<TreeSession::Node> make_tree_node(const TreeFile& file, const TreeNodeSpec& spec, TreeBoard& board,
                                                  const std::string& around, TreeSession::Shared& shared) {
  return TreeBuilder(file, shared).make(spec, board, around);
}

}  // namespace takt::languages
