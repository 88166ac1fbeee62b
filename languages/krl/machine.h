#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "languages/krl/program.h"

namespace takt::languages::krl {

/// What a trigger does at its point of the path.
struct TriggerCommand {
  enum class Where : std::uint8_t { kStart, kEnd, kPath };
  Where where = Where::kStart;
  double path = 0.0;  ///< m, of kPath: from the goal (negative: before it), or from the start
  bool from_start = false;
  double delay = 0.0;  ///< s, >= 0
  Live output = Live::kOut;
  int number = 0;
  double value = 0.0;           ///< of a digital output 0 or 1
  std::optional<double> pulse;  ///< s: then it goes back
  TextLocation at;
};

/// One motion, complete. Poses are of the flange in the base of the arm.
struct MotionCommand {
  enum class Kind : std::uint8_t { kPtp, kLin, kCirc, kSpline };
  struct Point {
    std::vector<double> axes;  ///< deg, in the order of Host::axis_names(); empty: a pose
    Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  };
  Kind kind = Kind::kPtp;
  std::vector<Point> points;  ///< of CIRC the one on the way and the goal
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  double speed = 1.0, acceleration = 1.0;  ///< shares of the limits of the axes
  std::optional<double> velocity;          ///< m/s, of the tool
  std::optional<double> blend_distance;    ///< m
  std::optional<double> blend_fraction;    ///< share of the path
  bool turns = false;                      ///< the orientation changes
  double length = 0.0;                     ///< m, of a straight line
  std::vector<TriggerCommand> triggers;
  std::string label;
  int module = 0;
  TextLocation at;
};

/// What a machine runs on: an arm with its signals, or a test.
class Host {
 public:
  virtual ~Host() = default;
  /// Seconds since something, never falling.
  [[nodiscard]] virtual double now() const = 0;
  /// All that was given is over, and the arm is at rest.
  [[nodiscard]] virtual bool settled() = 0;
  /// Motions that were given and are not over.
  [[nodiscard]] virtual int unfinished() = 0;
  virtual void move(MotionCommand motion) = 0;
  /// @param beside  at once, beside the motions; else after all that was given
  /// @return empty, or what is wrong
  [[nodiscard]] virtual std::string write(Live output, int number, double value, std::optional<double> pulse,
                                          bool beside) = 0;
  /// @return nothing: there is no such signal
  [[nodiscard]] virtual std::optional<double> read(Live signal, int number) = 0;
  /// Carries out a call that the program does not have itself, after all that was given.
  virtual void call(const std::string& name, int module, const TextLocation& at) = 0;
  [[nodiscard]] virtual const std::vector<std::string>& axis_names() const = 0;
  /// Where the arm is, deg; what is sent to it.
  [[nodiscard]] virtual std::vector<double> axes() = 0;
  [[nodiscard]] virtual Eigen::Isometry3d flange(const std::vector<double>& axes) = 0;
  /// A wait that is not over: whether it is taken to be, as a rehearsal does. @param seconds  that are left, if known
  [[nodiscard]] virtual bool skips_wait(std::optional<double> seconds) = 0;
  /// Stops on the path and keeps what was given; goes on with it; forgets it.
  virtual void brake() = 0;
  virtual void go_on() = 0;
  virtual void forget() = 0;
};

/// Runs a program on a host: advance() once in each cycle. The same program on hosts that answer the same does the
/// same. What it may use is bounded: statements without a wait, depth of calls, elements. Thread: one.
class Machine {
 public:
  enum class Progress : std::uint8_t { kRunning, kEnded, kHalted, kFailed };
  static constexpr int kMostStatements = 100'000;  ///< between two cycles
  static constexpr std::size_t kMostDepth = 64;
  static constexpr std::int64_t kMostElements = 200'000;
  static constexpr std::int64_t kMostCopies = 5'000'000;  ///< of elements, between two cycles

  /// Both outlive it.
  Machine(const Program& program, Host& host);

  /// Runs until it has to wait.
  Progress advance();
  /// Why it failed.
  [[nodiscard]] const Diagnostics& diagnostics() const { return diagnostics_; }
  /// The statement that is next, for people.
  [[nodiscard]] TextLocation at() const;
  /// Sets a frame that all see, "TOOL_DATA" or "BASE_DATA" with its number, or "$TOOL" and the like with 0.
  void set_frame(std::string_view name, int number, const Eigen::Isometry3d& X);
  void set_axes(std::string_view name, const std::vector<double>& axes);
  /// Begins at the first statement of this line or behind it in the main program. @return false: there is none
  [[nodiscard]] bool enter(int line);

 private:
  struct Frame {
    int function = 0;
    std::size_t at = 0;
    std::vector<Value> locals;
    const Expression* call = nullptr;  ///< that began it: OUT parameters go back to its arguments
    int result = -1;                   ///< among the locals of the caller
    int interrupt = -1;                ///< that it answers; -1: none
    std::optional<double> deadline;    ///< of a wait
    std::int64_t elements = 0;
  };
  struct Interrupt {
    const Statement* declared = nullptr;
    int module = 0;
    std::size_t level = 0;  ///< frame of the program that declared it
    bool on = false, enabled = true, pending = false, before = false;
  };
  struct Timer {
    double value = 0.0, since = 0.0;
    bool runs = false;
  };
  enum class Step : std::uint8_t { kNext, kStay, kYield };

  Step step(const Instruction& one);
  Step execute(const Statement& one);
  [[nodiscard]] bool blocked(const Instruction& one);
  void poll_interrupts();
  void begin_interrupt(int number);
  /// The frames above a level, which are put back afterwards.
  [[nodiscard]] std::vector<Frame> take_above(std::size_t level);
  void declare_interrupt(const Statement& one);
  Step switch_interrupts(const Statement& one);
  Step resume(const Statement& one);
  bool call(int function, const Expression* call, int result);
  void leave(const Expression* value);
  void assign_place(const Expression& target, const Value& value);
  Step assign_live(const Expression& target, const Expression& value, Live live);
  Step wait(const Statement& one);
  bool for_test(const Instruction& one);
  Step move(const Statement& one);
  std::optional<MotionCommand> motion(const Statement& one);
  bool set_points(const Statement& one, MotionCommand& command);
  bool set_point(const Statement& one, const Expression& goal, MotionCommand& command);
  void set_dynamics(MotionCommand& command);
  void set_blend(const std::vector<std::string>& words, const Eigen::Isometry3d& before, MotionCommand& command);
  void pend_trigger(const Statement& one);
  [[nodiscard]] bool needs_place(const Statement& one);
  Eigen::Isometry3d last_flange();
  [[nodiscard]] bool in_interrupt() const;

  Value evaluate(const Expression& one, const Structure* wanted = nullptr);
  Value evaluate_aggregate(const Expression& one, const Structure* wanted);
  Value evaluate_live(Live live, std::optional<std::int64_t> number, const TextLocation& at);
  double number(const Expression& one);
  bool truth(const Expression& one);
  /// The variable itself; null: it is none, or there is no such element.
  Value* place(const Expression& one, Type* type);
  Value* element(const Expression& one, Value* array);
  [[nodiscard]] Value& shared(std::string_view name);
  void fail(const TextLocation& at, Code code, std::string message, std::string hint = {});
  [[nodiscard]] bool failed() const { return diagnostics_.has_errors(); }

  const Program& program_;
  Host& host_;
  Diagnostics diagnostics_;
  std::vector<std::vector<Value>> modules_;
  std::vector<Frame> frames_;
  std::map<int, Interrupt> interrupts_;
  std::map<std::int64_t, Timer> timers_;
  std::map<std::int64_t, const Expression*> cyclic_;
  std::vector<TriggerCommand> triggers_;
  std::optional<std::vector<double>> last_axes_;
  std::optional<Eigen::Isometry3d> last_flange_;
  std::int64_t elements_ = 0;  ///< that may still be made
  std::int64_t copies_ = 0;    ///< of elements since the last cycle
  int module_ = 0, cyclic_depth_ = 0;
  bool continues_ = false;  ///< CONTINUE: the next statement does not stop the advance run
  bool asked_ = false;      ///< something live was read since the last cycle
  bool braked_ = false, resuming_ = false, halted_ = false;
};

}  // namespace takt::languages::krl
