#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/form.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/step.h"
#include "core/program/language/value.h"
#include "core/program/language/value_template.h"

/// The tree of a program, and the runs of its nodes (docs/programs.md).
namespace takt::program {

/// How far a node has come. kStopped: a step "stop" ends the program.
enum class Outcome { kRunning, kDone, kFailed, kStopped };

class ControlLine;
struct Declaration;
class Node;
class NodeRun;

/// A step that runs, for people: its name, and its path in the tree ("sort / for_each (2) / grip").
struct RunningStep {
  std::string name, path;
  bool operator==(const RunningStep&) const = default;
};

/// A step that waits for the permission to begin.
struct AskingStep {
  std::string name, pointer;
};

/// What all nodes of a running program share.
struct Execution {
  explicit Execution(activity::Context& of) : context(of) {}

  activity::Context& context;
  ControlLine* strand = nullptr;  ///< the line of control that is being advanced
  bool cancelled = false;         ///< the whole program: nothing follows
  bool held = false;              ///< no step begins
  bool single = false;            ///< a step begins only by permission
  int permits = 0;
  std::vector<AskingStep> asking;  ///< in this advance, in the order of the file
  std::int64_t steps_done = 0;
  std::vector<RunningStep> current;  ///< steps that run, in the order of the file
  int spent = 0;                     ///< steps since the last cycle (row D1)
  std::int64_t begun = 0;            ///< steps so far
  std::int64_t spent_in_cycle = -1;

  /// Counts a step against the budget of the cycle. @return false if it is used up, with a
  /// diagnostic.
  bool charge(const std::string& pointer, Diagnostics& diagnostics);
  /// The same for a round that began no step since `begun` was `mark`.
  bool charge_round(std::int64_t mark, const std::string& pointer, Diagnostics& diagnostics) {
    return begun != mark || charge(pointer, diagnostics);
  }
  /// May the step begin now? Uses up a permission, or asks for one.
  bool may_begin(const Node& step);
  /// A step begins, or has come to an end: for people. @param why  of a failure, in words
  void enter(const std::string& name);
  void leave(const std::string& name, std::string_view how, std::string_view why = {});
  /// Advances what is inside of a node, whose name is a part of its path. @param round  of a loop, from 1; 0: it is
  /// none
  Outcome advance_in(const std::string& name, NodeRun& run, Diagnostics& diagnostics, std::int64_t round = 0);
  /// Where in the tree something happens now: names from the root on, " / " between them; empty outside of the tree.
  [[nodiscard]] std::string path() const;
  [[nodiscard]] EvalContext eval_context(const Scope& scope) const;

  /// A node on the way from the root to what is being advanced.
  struct PathElement {
    const std::string* name;
    std::int64_t round;
  };
  /// Names what is being advanced as long as it lives.
  class Inside {
   public:
    Inside(Execution& execution, const std::string& name, std::int64_t round = 0) : around_(execution.around) {
      around_.push_back({&name, round});
    }
    ~Inside() { around_.pop_back(); }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

   private:
    std::vector<PathElement>& around_;
  };
  std::vector<PathElement> around;
  const std::string* told = nullptr;  ///< path of the step that an event is about; null: it happens where `around` says
};

/// One execution of a node. All its state can be taken as data and put back (row D3).
class NodeRun {
 public:
  virtual ~NodeRun() = default;
  /// Between cycles; never blocks. Diagnostics have whole pointers.
  virtual Outcome advance(Execution& execution, Diagnostics& diagnostics) = 0;
  /// Asks for a graceful end; advance() then comes to it. What has not begun does not begin.
  virtual void cancel(Execution& execution) = 0;
  [[nodiscard]] virtual nlohmann::ordered_json state() const = 0;
  /// Puts a state back into a new run. A step that was begun begins again. Throws nlohmann's exceptions, or
  /// std::out_of_range, on a foreign state; diagnostics: values that cannot be found.
  virtual void restore(const nlohmann::ordered_json& state, Execution& execution, Diagnostics& diagnostics) = 0;
};

/// A node of a program tree. Immutable after parsing.
class Node {
 public:
  virtual ~Node() = default;

  /// A new execution. The node and the scope must outlive it.
  [[nodiscard]] virtual std::unique_ptr<NodeRun> begin(Scope& scope) const = 0;
  /// Plays the node on nominal values: everything that can be found wrong before anything moves.
  virtual void rehearse(operations::Rehearsal& rehearsal, Scope& scope, Diagnostics& diagnostics) const = 0;
  /// Steps that one run executes as far as that is known; kMostSteps means all that is more.
  [[nodiscard]] virtual std::int64_t count() const = 0;
  /// Adds the names of this node and of all in it, in the order of the file.
  virtual void collect_names(std::vector<std::string>& names) const;
  /// True if it does the same each time: no variable is read or written in it.
  [[nodiscard]] virtual bool constant() const = 0;
  /// The state of a run that is about to begin the first node of this name; nothing if there is none that can be
  /// entered.
  [[nodiscard]] virtual std::optional<nlohmann::ordered_json> state_before(std::string_view name) const;

  std::string name;     ///< for people; may be empty
  std::string pointer;  ///< in the file
  static constexpr std::int64_t kMostSteps = 1'000'000'000'000;
};

/// The nodes of "steps", one after the other.
using NodeList = std::vector<std::unique_ptr<Node>>;

/// One after the other, without a name.
[[nodiscard]] std::unique_ptr<Node> make_sequence(NodeList children, const std::string& pointer);

/// A variable as it is declared: by its initial value, or {"type", "unit", "value", "nominal"}.
struct Declaration {
  std::string name;
  Type type;
  std::optional<ValueTemplate> initial, nominal;
};

/// A program that is called by name.
struct SubProgram {
  std::string name, pointer;
  std::vector<Declaration> parameters;  ///< those without an initial value have to be given
  std::vector<Declaration> variables;
  std::unique_ptr<Node> body;
  std::optional<ValueTemplate> result;
  Type result_type;
  std::int64_t count = 0;
  int depth = 1;  ///< of calls inside it
};

/// Makes nodes from JSON: all diagnostics at once. Realtime: setup.
class NodeParser {
 public:
  NodeParser(const expression::Cell& cell, const nlohmann::ordered_json* programs, Diagnostics& diagnostics);
  ~NodeParser();
  NodeParser(const NodeParser&) = delete;
  NodeParser& operator=(const NodeParser&) = delete;

  /// Any node; never null.
  std::unique_ptr<Node> node(const nlohmann::ordered_json& json, const std::string& pointer);
  /// The steps of an array; motions that blend are one.
  NodeList list(ObjectReader& reader, std::string_view key, bool required = true);
  /// The same as one node without a name.
  std::unique_ptr<Node> steps(ObjectReader& reader, std::string_view key, bool required = true) {
    return make_sequence(list(reader, key, required), reader.at(key));
  }
  /// The programs of the file, also those that are never called.
  void all_programs();
  /// A program by its name; null with a diagnostic at `pointer` if there is none, or if it calls itself.
  std::shared_ptr<const SubProgram> program(const std::string& name, const std::string& pointer);
  [[nodiscard]] std::vector<std::shared_ptr<const SubProgram>> programs() const;

  /// {"name": declaration, ...}; each is declared in the scope, unknown.
  std::vector<Declaration> declarations(ObjectReader& reader, std::string_view key);
  /// ["a", ...]: names of frames that steps of a block may make and that end with it. Blocks around it, and branches
  /// beside it, have others. The block is left with leave_frames().
  std::vector<std::string> block_frames(ObjectReader& reader, std::string_view key);
  void leave_frames(std::size_t count) { frames_around_.resize(frames_around_.size() - count); }
  /// All that block_frames() has read since it was asked last.
  std::set<std::string, std::less<>> take_frames() { return std::exchange(frames_read_, {}); }
  /// An expression or a value whose type is checked now; `wanted` may be unknown.
  ValueTemplate value(const nlohmann::ordered_json& json, const std::string& pointer, const Type& wanted,
                      Type* type = nullptr);
  /// The key "name"; "do" is read too.
  void head(ObjectReader& reader, Node& node, std::string_view fallback);

  [[nodiscard]] EvalContext eval_context() const;
  [[nodiscard]] const expression::Cell& cell() const { return cell_; }
  Diagnostics& diagnostics() { return diagnostics_; }
  [[nodiscard]] Scope& scope() { return *scope_; }

  /// Variables that are declared while it lives are seen inside of it only.
  class Inner {
   public:
    Inner(NodeParser& parser, bool sees_around = true)
        : parser_(parser), before_(parser.scope_), scope_(sees_around ? parser.scope_ : nullptr) {
      parser.scope_ = &scope_;
    }
    ~Inner() { parser_.scope_ = before_; }
    Inner(const Inner&) = delete;
    Inner& operator=(const Inner&) = delete;

   private:
    NodeParser& parser_;
    Scope* before_;
    Scope scope_;
  };

 private:
  std::shared_ptr<SubProgram> parse_program(const std::string& name);
  std::nullptr_t too_deep(const std::string& pointer);

  const expression::Cell& cell_;
  const nlohmann::ordered_json* programs_json_;
  Diagnostics& diagnostics_;
  Scope* scope_ = nullptr;
  std::map<std::string, std::shared_ptr<SubProgram>, std::less<>> programs_;
  std::vector<std::string> being_parsed_;
  std::vector<std::string> frames_around_;
  std::set<std::string, std::less<>> frames_read_;
  int depth_ = 0;  ///< of calls below the program that is being parsed
};

/// A kind of node: the word after "do".
struct NodeKind {
  std::string_view name;
  std::reference_wrapper<const Form> form;  ///< lives as long as the process
  std::unique_ptr<Node> (*parse)(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
};

/// All kinds of nodes that are no leaves, by name.
[[nodiscard]] const std::vector<NodeKind>& node_kinds();
/// Adds a kind that a layer above defines; before any program is parsed. Thread: the one that starts. Realtime: setup.
void add_node_kind(const NodeKind& kind);

/// A rehearsal's effort is bounded: @return false once it is used up; a note says so.
bool spend_rehearsal(operations::Rehearsal& rehearsal, const Node& node, Diagnostics& diagnostics);
/// Errors that may not be any, because it is unknown whether or from where their step begins.
[[nodiscard]] Diagnostics as_warnings(const Diagnostics& diagnostics, std::string_view why);
/// What an expression sees in a rehearsal.
[[nodiscard]] EvalContext sight_of(const operations::Rehearsal& rehearsal, const Scope& scope);
/// What is wrong, in one line.
[[nodiscard]] std::string messages_of(const Diagnostics& diagnostics);
/// Evaluates and declares, in a run or a rehearsal. @return false with diagnostics if a value could not be found.
bool declare(const std::vector<Declaration>& declarations, const EvalContext& eval_context, Scope& scope,
             Diagnostics& diagnostics);
/// Adds counts of steps, up to Node::kMostSteps.
[[nodiscard]] std::int64_t saturated(std::int64_t times, std::int64_t count);

// Parsers of the kinds.
std::unique_ptr<Node> parse_leaf(const operations::Operation& operation, const nlohmann::ordered_json& json,
                                 const std::string& pointer, NodeParser& parser);
/// Takes the node that follows a leaf into it if both blend. @return false if they stay two.
bool absorb_leaf(Node& leaf, Node& next);
std::unique_ptr<Node> parse_sequence(const nlohmann::ordered_json& json, const std::string& pointer,
                                     NodeParser& parser);
std::unique_ptr<Node> parse_parallel(const nlohmann::ordered_json& json, const std::string& pointer,
                                     NodeParser& parser);
std::unique_ptr<Node> parse_branch(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_repeat(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_for_each(const nlohmann::ordered_json& json, const std::string& pointer,
                                     NodeParser& parser);
std::unique_ptr<Node> parse_call(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_try(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_let(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_log(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_fail(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_stop(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
std::unique_ptr<Node> parse_until(const nlohmann::ordered_json& json, const std::string& pointer, NodeParser& parser);
}  // namespace takt::program
