#include "languages/program/urscript_node.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/device/arm.h"
#include "core/program/tree/node_forms.h"
#include "languages/program/urscript_host.h"
#include "languages/program/urscript_rehearsal.h"
#include "languages/program/urscript_steps.h"
#include "languages/urscript/session.h"

namespace takt::languages {
namespace {

using Json = nlohmann::ordered_json;
using program::Execution;
using program::Outcome;

class UrscriptNode final : public program::Node {
 public:
  std::shared_ptr<const urscript::Program> program;
  std::string file;
  UrscriptMap map;

  [[nodiscard]] std::unique_ptr<program::NodeRun> begin(program::Scope& scope) const override;
  void rehearse(operations::Rehearsal& rehearsal, program::Scope&, Diagnostics& diagnostics) const override {
    if (program == nullptr || !program::spend_rehearsal(rehearsal, *this, diagnostics)) return;
    operations::settle_rehearsal(rehearsal, diagnostics);
    rehearse_urscript(program, file, map, *this, rehearsal, diagnostics);
  }
  /// How often a loop is run is not known.
  [[nodiscard]] std::int64_t count() const override { return kMostSteps; }
  [[nodiscard]] bool constant() const override { return false; }
  /// Its motions as their steps are named.
  void collect_names(std::vector<std::string>& names) const override {
    Node::collect_names(names);
    if (program == nullptr) return;
    for (const urscript::BuiltinCall& call : program->calls)
      if (call.name.starts_with("move")) names.push_back(script_step_name({call.line, call.column}, call.name));
  }
  /// A number is a line of the program; "12: movel" begins with one.
  [[nodiscard]] std::optional<Json> state_before(std::string_view wanted) const override {
    if (auto own = Node::state_before(wanted)) return own;
    int line = 0;
    const auto [end, wrong] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), line);
    const std::string_view rest = wanted.substr(static_cast<std::size_t>(end - wanted.data()));
    if (wrong != std::errc{} || line < 1 || (!rest.empty() && !rest.starts_with(": "))) return std::nullopt;
    return Json{{"line", line}};
  }
};

std::set<std::string> call_names(const UrscriptMap& map) {
  std::set<std::string> names;
  for (const auto& [name, steps] : map.calls) names.insert(name);
  return names;
}

/// The program on the arm: what it gives becomes nodes of the program tree, on the line of control of the node.
class UrscriptRunHost final : public UrscriptHost {
 public:
  UrscriptRunHost(const UrscriptNode& node, Execution& execution)
      : UrscriptHost(node.map, execution.context.cell, node.file),
        node_(node),
        execution_(execution),
        line_(node, execution),
        session_(node.program, *this, call_names(node.map), node.map.given(execution.context.cell)) {}

  [[nodiscard]] bool enter(int line) { return session_.enter(line); }

  Outcome advance(Diagnostics& diagnostics) {
    using Progress = urscript::Session::Progress;
    hold_pose();
    for (bool again = true; again;) {
      const std::int64_t mark = execution_.begun;
      const Progress progress = cancelled_ ? Progress::kEnded : session_.advance();
      if (progress == Progress::kFailed && !cancelled_) {
        fail();
        cancel();
      }
      if (!begin_next()) break;
      again = line_.advance();
      if (again && !execution_.charge_round(mark, node_.pointer, diagnostics)) return Outcome::kFailed;
      if (!again) ended_ = progress != Progress::kRunning;
    }
    if ((line_.failed() || line_.stopped()) && !cancelled_) cancel();
    if (!queue_.empty() || !line_.settled() || line_.beside()) return Outcome::kRunning;
    if (line_.failed()) {
      diagnostics.append(line_.failures());
      return Outcome::kFailed;
    }
    if (line_.stopped()) return Outcome::kStopped;
    if (!ended_ && !cancelled_) return Outcome::kRunning;
    if (!session_.halted()) return Outcome::kDone;
    execution_.context.event("urscript", "halt", fmt::format("line {}", session_.at().line));
    return Outcome::kStopped;
  }

  void cancel() {
    cancelled_ = true;
    queue_.clear();
    release();
    line_.cancel();
  }

 private:
  void fail() {
    Diagnostics own;
    own.add({.code = Code::kNotPossibleNow,
             .file = file_,
             .pointer = {},
             .message = session_.error().text,
             .hint = {},
             .line = session_.error().line,
             .column = session_.error().column});
    line_.fail(own);
  }

  /// @return false if it could not begin
  bool begin_next() {
    if (queue_.empty()) return true;
    // What lasts ends before something else begins.
    if (lasting_ && line_.main() != nullptr) end_lasting();
    if (!line_.idle()) return true;
    auto group = std::make_shared<ScriptGroup>(queue_, file_);
    lasting_ = group->items.front().lasts;
    return line_.begin(std::move(group));
  }

  void end_lasting() {
    lasting_ = false;
    release();
    forget_goal();
    line_.stop();
  }

  /// A pose that nothing follows is written again: the tool comes to rest there.
  void hold_pose() {
    if (kind_ != urscript::LastingCommand::Kind::kServo || now() < servo_.time + 1.5 * servo_.seconds) return;
    write_channel(map_.pose_channel, net::Frame(servo_.X_BT));
    servo_.time = now();
  }

  /// The dead-man switch of speedl().
  void release() {
    if (kind_ == urscript::LastingCommand::Kind::kSpeed) write_channel(map_.enable_channel, false);
    kind_.reset();
  }

  template <class T>
  void write_channel(const std::string& name, const T& value) {
    const auto found = execution_.context.cell.channels.find(name);
    if (found != execution_.context.cell.channels.end() && found->second != nullptr) (void)found->second->write(value);
  }

  [[nodiscard]] double now() const override { return execution_.context.core.time() * 1e-9; }
  [[nodiscard]] double cycle() const override { return execution_.context.core.period() * 1e-9; }
  [[nodiscard]] bool settled() override { return queue_.empty() && (line_.settled() || lasting_); }
  [[nodiscard]] int unfinished() override {
    auto count = std::ranges::count_if(queue_, [](const ScriptItem& one) { return one.moves; });
    if (const StepGroup* const main = line_.main(); main != nullptr && !lasting_) {
      const auto& items = static_cast<const ScriptGroup*>(main)->items;
      if (items.front().moves) count += static_cast<std::ptrdiff_t>(items.size() - first_left(items));
    }
    return static_cast<int>(count) + (line_.open() != nullptr ? 1 : 0);
  }
  /// The first motion of a group that is not over: the one that is being done.
  [[nodiscard]] std::size_t first_left(const std::vector<ScriptItem>& items) const {
    for (std::size_t i = 0; i < items.size(); ++i)
      if (std::ranges::find(execution_.current, items[i].name, &program::RunningStep::name) != execution_.current.end())
        return i;
    return 0;
  }

  [[nodiscard]] std::string last(const urscript::LastingCommand& command) override {
    using Kind = urscript::LastingCommand::Kind;
    if (command.kind == Kind::kServo) {
      servo_ = {command.X_BF * map_.usual_tool(cell_), now(), command.seconds};
      write_channel(map_.pose_channel, net::Frame(servo_.X_BT));
    }
    if (command.kind == Kind::kSpeed) {
      write_channel(map_.velocity_channel, net::Twist{command.twist.head<3>(), command.twist.tail<3>()});
      write_channel(map_.enable_channel, true);
    }
    const bool goes_on =
        lasting_ && kind_ == command.kind && (command.kind == Kind::kServo || command.kind == Kind::kSpeed);
    if (goes_on) return {};
    if (lasting_) end_lasting();
    if (command.kind == Kind::kSpeed) write_channel(map_.enable_channel, true);
    kind_ = command.kind;
    auto step = lasting_step(command, map_);
    ScriptItem item{.step = {}, .name = step.at("name").get<std::string>(), .at = command.at};
    item.lasts = true;
    item.step = std::make_shared<const Json>(std::move(step));
    forget_goal();
    give(std::move(item));
    return {};
  }
  [[nodiscard]] bool lasts() const override { return lasting_ || (!queue_.empty() && queue_.front().lasts); }
  void stop() override {
    queue_.clear();
    lasting_ = false;
    release();
    forget_goal();
    line_.stop();
  }

  [[nodiscard]] std::optional<double> read(urscript::Signal signal, int number) override {
    const auto value_of = [&](const std::map<int, std::string>& names, const auto& devices) -> std::optional<double> {
      const auto name = names.find(number);
      if (name == names.end()) return std::nullopt;
      const auto device = devices.find(name->second);
      if (device == devices.end() || device->second == nullptr) return std::nullopt;
      return device->second->has_sample() ? static_cast<double>(device->second->sample().value) : 0.0;
    };
    if (signal == urscript::Signal::kDigitalIn) return value_of(map_.inputs, cell_.digital_inputs);
    if (signal == urscript::Signal::kAnalogIn) return value_of(map_.analog_inputs, cell_.analog_inputs);
    return written(signal, number);
  }
  void message(const std::string& title, const std::string& text, const TextLocation& at) override {
    execution_.context.event("urscript", title, fmt::format("line {}: {}", at.line, text));
  }
  /// Before anything was sent the arm is where it begins.
  [[nodiscard]] kinematics::JointVector joints(bool measured) override {
    const expression::MountedArm& mounted = arm();
    if (measured && mounted.device != nullptr && mounted.device->has_sample()) return mounted.device->sample().q;
    const kinematics::JointVector& sent = mounted.set_point();
    return sent.size() > 0 ? sent : mounted.start;
  }
  void run_beside(ScriptItem item) override {
    (void)line_.begin_beside(std::make_shared<ScriptGroup>(std::move(item), file_));
  }
  [[nodiscard]] operations::Rehearsal trial() override {
    operations::Rehearsal trial;
    trial.cell = cell_;
    for (const auto& [name, one] : cell_.arms) {
      const kinematics::JointVector& sent = one.set_point();
      trial.q[name] = sent.size() > 0 ? sent : one.start;
      trial.modes[name] = one.mode();
    }
    return trial;
  }

  const UrscriptNode& node_;
  Execution& execution_;
  StepLine line_;
  urscript::Session session_;
  std::optional<urscript::LastingCommand::Kind> kind_;  ///< what lasts, or is about to
  bool lasting_ = false;                                ///< what runs on the line lasts
  struct {
    Eigen::Isometry3d X_BT;
    double time, seconds;
  } servo_{Eigen::Isometry3d::Identity(), 0.0, 0.0};
  bool cancelled_ = false, ended_ = false;
};

class UrscriptRun final : public program::NodeRun {
 public:
  explicit UrscriptRun(const UrscriptNode& node) : node_(node) {}

  Outcome advance(Execution& execution, Diagnostics& diagnostics) override {
    if (!host_) {
      if (cancelled_) return Outcome::kDone;
      if (const Outcome ready = program::settle(execution, diagnostics); ready != Outcome::kDone) return ready;
      host_ = std::make_unique<UrscriptRunHost>(node_, execution);
      if (line_ > 0 && !host_->enter(line_)) {
        diagnostics.error(Code::kUnknownName, node_.pointer,
                          fmt::format("the main program has no statement from line {} on", line_),
                          "Begin at a line of the main program, not of a function or a thread");
        return Outcome::kFailed;
      }
    }
    const Outcome outcome = host_->advance(diagnostics);
    return outcome == Outcome::kFailed && cancelled_ ? Outcome::kDone : outcome;
  }

  void cancel(Execution&) override {
    cancelled_ = true;
    if (host_) host_->cancel();
  }

  [[nodiscard]] Json state() const override { return {{"begun", host_ != nullptr}}; }
  /// The program begins again, as a step does that was running; or at a line that was asked for.
  void restore(const Json& state, Execution&, Diagnostics& diagnostics) override {
    line_ = state.value("line", 0);
    if (state.value("begun", false))
      diagnostics.warning(Code::kNote, node_.pointer, "the URScript program begins again at its first statement",
                          "Begin at a line of it to have a known place");
  }

 private:
  const UrscriptNode& node_;
  std::unique_ptr<UrscriptRunHost> host_;
  bool cancelled_ = false;
  int line_ = 0;
};

std::unique_ptr<program::NodeRun> UrscriptNode::begin(program::Scope&) const {
  return std::make_unique<UrscriptRun>(*this);
}

urscript::ScriptText read_script(ObjectReader& reader) {
  const Json* const program = reader.object("program");
  if (program == nullptr) return {};
  ObjectReader text(*program, reader.at("program"), reader.diagnostics());
  urscript::ScriptText read{text.text("file", ""), text.text("source", "")};
  text.finish();
  return read;
}

const Form& urscript_form() {
  static const Form form = program::node_form(
      "urscript", "Runs a program in URScript on one arm.",
      {any_of_key("program", {"string", "object"},
                  "File of the program (.script), relative to this file and in its folder or below."),
       text_key("arm", "The arm that it moves.").optional("the only one"),
       object_key("map", urscript_map_form(), "What its numbers and names are in the cell (docs/urscript.md).")
           .optional()});
  return form;
}

}  // namespace

std::unique_ptr<program::Node> parse_urscript(const Json& json, const std::string& pointer,
                                              program::NodeParser& parser) {
  auto node = std::make_unique<UrscriptNode>();
  node->pointer = pointer;
  ObjectReader reader(json, pointer, parser.diagnostics());
  parser.head(reader, *node, "urscript");
  node->map = read_urscript_map(reader, parser.cell());
  const urscript::ScriptText text = read_script(reader);
  reader.finish();
  node->file = text.file;
  if (text.source.empty()) return node;
  auto program = urscript::compile_for_arm(text, call_names(node->map), node->map.given_names());
  if (!program) {
    parser.diagnostics().append(program.error());
    return node;
  }
  check_calls(node->map, **program, node->file, parser.diagnostics());
  check_steps(node->map, pointer + "/map", parser);
  if (!node->map.arm.empty()) node->program = std::move(*program);
  return node;
}

program::NodeKind urscript_kind() { return {"urscript", urscript_form(), parse_urscript}; }

}  // namespace takt::languages
