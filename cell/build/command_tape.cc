#include "cell/build/command_tape.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "cell/build/topics.h"
#include "core/device/mailbox.h"

namespace takt::cell {
namespace {

using device::Compliance;
using kinematics::JointVector;

constexpr double kUnused = std::numeric_limits<double>::quiet_NaN();

/// mode, axes, nullspace stiffness and damping, number of axes; then stiffness, damping ratio, feed forward of each.
constexpr std::size_t kComplianceHead = 5;
constexpr int kCartesianAxes = 6;

std::size_t arm_values(int joints) {
  const auto set_point = static_cast<std::size_t>(3 * joints);
  const auto compliance = kComplianceHead + static_cast<std::size_t>(3 * std::max(joints, kCartesianAxes));
  return 1 + std::max(set_point, compliance);
}

void encode(const Compliance& compliance, CommandTrack& track) {
  track.call(CommandKind::kCompliance);
  track.put(static_cast<double>(compliance.mode));
  track.put(compliance.in_tool_axes ? 1.0 : 0.0);
  track.put(compliance.nullspace_stiffness);
  track.put(compliance.nullspace_damping_ratio);
  track.put(static_cast<double>(compliance.stiffness.size()));
  track.put(compliance.stiffness);
  track.put(compliance.damping_ratio);
  track.put(compliance.feed_forward);
}

/// Values number `part` of as many parts of `size` values, from `from` on.
JointVector part_of(CommandTrack::Row row, std::size_t from, std::size_t size, std::size_t part) {
  const std::size_t begin = std::min(row.size(), from + part * size), end = std::min(row.size(), begin + size);
  return Eigen::Map<const Eigen::VectorXd>(row.data() + begin, static_cast<Eigen::Index>(end - begin));
}

/// A whole number of a recording; 0 where there is none.
std::size_t whole(double value, std::size_t most) {
  return value >= 0.0 && value <= static_cast<double>(most) ? static_cast<std::size_t>(value) : 0;
}

Compliance decode_compliance(CommandTrack::Row row) {
  Compliance compliance;
  compliance.mode = static_cast<device::ControlMode>(
      whole(row[1], static_cast<std::size_t>(device::ControlMode::kCartesianImpedance)));
  compliance.in_tool_axes = row[2] == 1.0;
  compliance.nullspace_stiffness = row[3];
  compliance.nullspace_damping_ratio = row[4];
  const std::size_t axes = whole(row[5], static_cast<std::size_t>(kinematics::kMaxJoints));
  compliance.stiffness = part_of(row, 1 + kComplianceHead, axes, 0);
  compliance.damping_ratio = part_of(row, 1 + kComplianceHead, axes, 1);
  compliance.feed_forward = part_of(row, 1 + kComplianceHead, axes, 2);
  return compliance;
}

CommandKind kind_of(CommandTrack::Row row) {
  return static_cast<CommandKind>(whole(row[0], static_cast<std::size_t>(CommandKind::kOutput)));
}

class TappedArm final : public device::ArmBackend {
 public:
  /// @param tool  track of its tool and load
  TappedArm(std::shared_ptr<device::ArmBackend> machine, CommandTrack& track, CommandTrack& tool,
            const CommandTape& tape, int joints)
      : machine_(std::move(machine)),
        track_(track),
        tool_track_(tool),
        tape_(tape),
        joints_(static_cast<std::size_t>(joints)) {}

  void set_held(bool held) override { machine_->set_held(held); }
  bool read(device::ArmSample& sample) override {
    (void)told_.take([this](const std::byte* bytes) { note_tool(bytes); });
    return machine_->read(sample);
  }
  void write(const device::ArmSetPoint& set_point) override {
    if (tape_.noting()) {
      track_.call(CommandKind::kSetPoint);
      track_.put(set_point.q);
      track_.put(set_point.dq);
      track_.put(set_point.ddq);
    }
    if (!tape_.playing()) machine_->write(set_point);
  }
  void write_compliance(const Compliance& compliance) override {
    if (tape_.noting()) encode(compliance, track_);
    if (!tape_.playing()) machine_->write_compliance(compliance);
  }
  void change_mode(device::ControlMode mode) override {
    if (tape_.noting()) {
      track_.call(CommandKind::kMode);
      track_.put(static_cast<double>(mode));
    }
    if (!tape_.playing()) machine_->change_mode(mode);
  }
  void brake() override {
    if (tape_.noting()) track_.call(CommandKind::kBrake);
    if (!tape_.playing()) machine_->brake();
  }
  void set_payload(const device::PayloadSetting& payload) override { machine_->set_payload(payload); }
  /// By whoever runs the program, between cycles or beside one; the next cycle notes it.
  void set_tool(const device::ToolSetting& tool) override {
    if (tape_.noting()) {
      const ToolValues values = values_of(tool);
      (void)told_.put([&](std::byte* bytes) { std::memcpy(bytes, values.data(), sizeof(values)); });
    }
    if (!tape_.playing()) machine_->set_tool(tool);
  }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override { return machine_->fault_text(fault); }
  [[nodiscard]] device::BackendTiming timing() const override { return machine_->timing(); }

  void execute_tool(CommandTrack::Row row) {
    if (kind_of(row) == CommandKind::kSetPoint) machine_->set_tool(tool_of(row.subspan(1)));
  }
  void execute(CommandTrack::Row row, std::int64_t cycle, Nanoseconds time) {
    switch (kind_of(row)) {
      case CommandKind::kSetPoint:
        return machine_->write({.cycle = cycle,
                                .stamp = time,
                                .q = part_of(row, 1, joints_, 0),
                                .dq = part_of(row, 1, joints_, 1),
                                .ddq = part_of(row, 1, joints_, 2)});
      case CommandKind::kCompliance:
        return machine_->write_compliance(decode_compliance(row));
      case CommandKind::kMode:
        return machine_->change_mode(static_cast<device::ControlMode>(
            whole(row[1], static_cast<std::size_t>(device::ControlMode::kCartesianImpedance))));
      case CommandKind::kBrake:
        return machine_->brake();
      case CommandKind::kNothing:
      case CommandKind::kOutput:
        return;
    }
  }

 private:
  void note_tool(const std::byte* bytes) {
    ToolValues values{};
    std::memcpy(values.data(), bytes, sizeof(values));
    tool_track_.call(CommandKind::kSetPoint);
    tool_track_.put(values);
  }

  std::shared_ptr<device::ArmBackend> machine_;
  CommandTrack &track_, &tool_track_;
  const CommandTape& tape_;
  std::size_t joints_;
  device::Mailbox<sizeof(ToolValues)> told_;
};

class TappedGripper final : public device::GripperBackend {
 public:
  TappedGripper(std::shared_ptr<device::GripperBackend> machine, CommandTrack& track, const CommandTape& tape)
      : machine_(std::move(machine)), track_(track), tape_(tape) {}

  bool read(device::GripperSample& sample) override { return machine_->read(sample); }
  void write(const device::GripperSetPoint& set_point) override {
    if (tape_.noting()) {
      track_.call(CommandKind::kSetPoint);
      track_.put(static_cast<double>(set_point.sequence));
      track_.put(set_point.width);
      track_.put(set_point.speed);
      track_.put(set_point.force);
    }
    if (!tape_.playing()) machine_->write(set_point);
  }

  void execute(CommandTrack::Row row) {
    if (kind_of(row) != CommandKind::kSetPoint) return;
    machine_->write(
        {.sequence = whole(row[1], std::size_t{1} << 53), .width = row[2], .speed = row[3], .force = row[4]});
  }

 private:
  std::shared_ptr<device::GripperBackend> machine_;
  CommandTrack& track_;
  const CommandTape& tape_;
};

template <class T>
class TappedOutput final : public device::SignalOutputBackend<T> {
 public:
  TappedOutput(std::shared_ptr<device::SignalOutputBackend<T>> machine, CommandTrack& track, const CommandTape& tape)
      : machine_(std::move(machine)), track_(track), tape_(tape) {}

  [[nodiscard]] bool ready() const override { return machine_->ready(); }
  void write(T value) override {
    if (tape_.noting()) {
      track_.call(CommandKind::kOutput);
      track_.put(static_cast<double>(value));
    }
    if (!tape_.playing()) machine_->write(value);
  }

  void execute(CommandTrack::Row row) {
    if (kind_of(row) == CommandKind::kOutput) machine_->write(static_cast<T>(row[1]));
  }

 private:
  std::shared_ptr<device::SignalOutputBackend<T>> machine_;
  CommandTrack& track_;
  const CommandTape& tape_;
};

}  // namespace

std::string_view name_of(CommandKind kind) {
  static constexpr std::array<std::string_view, 6> kNames = {"nothing", "set_point", "compliance",
                                                             "mode",    "brake",     "output"};
  return kNames[static_cast<std::size_t>(kind)];
}

CommandTrack::CommandTrack(std::string device, std::size_t values) : device_(std::move(device)), values_(values) {
  now_.cells.assign(kMostRows * values_, kUnused);
  done_ = now_;
}

void CommandTrack::call(CommandKind kind) {
  if (now_.rows == kMostRows) {
    overflowed_ = true;
    next_ = now_.cells.size();
    return;
  }
  const auto begin = now_.cells.begin() + static_cast<std::ptrdiff_t>(now_.rows * values_);
  std::fill_n(begin, values_, kUnused);
  next_ = now_.rows++ * values_;
  put(static_cast<double>(kind));
}

void CommandTrack::put(double value) {
  if (next_ >= now_.rows * values_) {
    overflowed_ = true;
    return;
  }
  now_.cells[next_++] = value;
}

void CommandTrack::put(std::span<const double> values) {
  for (const double value : values) put(value);
}

/// To the bit: a set point of -0 is another one.
bool CommandTrack::same() const {
  const auto equal = [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  };
  return now_.rows == done_.rows &&
         std::equal(now_.cells.begin(), now_.cells.begin() + static_cast<std::ptrdiff_t>(now_.rows * values_),
                    done_.cells.begin(), equal);
}

void CommandTrack::end_cycle() {
  changed_ = !same();
  std::swap(now_, done_);
  now_.rows = 0;
}

CommandTrack& CommandTape::add(const std::string& name, std::size_t values) {
  return *tracks_.emplace_back(std::make_unique<CommandTrack>(name, values));
}

std::shared_ptr<device::ArmBackend> CommandTape::tap(const std::string& name,
                                                     std::shared_ptr<device::ArmBackend> backend, int joints) {
  CommandTrack& track = add(name, arm_values(joints));
  CommandTrack& tool = add(name + "/tool", 1 + kToolValues);
  auto tapped = std::make_shared<TappedArm>(samples_.tap(name, std::move(backend)), track, tool, *this, joints);
  TappedArm* const arm = tapped.get();
  players_.push_back({.execute = [arm](auto row, auto cycle, auto time) { arm->execute(row, cycle, time); }});
  players_.push_back({.execute = [arm](auto row, auto, auto) { arm->execute_tool(row); }});
  return tapped;
}

std::shared_ptr<device::GripperBackend> CommandTape::tap(const std::string& name,
                                                         std::shared_ptr<device::GripperBackend> backend) {
  constexpr std::size_t kValues = 5;
  auto tapped = std::make_shared<TappedGripper>(samples_.tap(name, std::move(backend)), add(name, kValues), *this);
  players_.push_back({.execute = [gripper = tapped.get()](auto row, auto, auto) { gripper->execute(row); }});
  return tapped;
}

template <class T>
std::shared_ptr<device::SignalOutputBackend<T>> CommandTape::tap(
    const std::string& name, std::shared_ptr<device::SignalOutputBackend<T>> backend) {
  constexpr std::size_t kValues = 2;
  auto tapped = std::make_shared<TappedOutput<T>>(samples_.tap(name, std::move(backend)), add(name, kValues), *this);
  players_.push_back({.execute = [output = tapped.get()](auto row, auto, auto) { output->execute(row); }});
  return tapped;
}
template std::shared_ptr<device::SignalOutputBackend<bool>> CommandTape::tap(
    const std::string&, std::shared_ptr<device::SignalOutputBackend<bool>>);
template std::shared_ptr<device::SignalOutputBackend<double>> CommandTape::tap(
    const std::string&, std::shared_ptr<device::SignalOutputBackend<double>>);

Diagnostics CommandTape::play(const record::Recording& recording) {
  Diagnostics diagnostics;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const CommandTrack& track = *tracks_[i];
    auto rows = recording.table(command_topic(track.device()));
    if (!rows) {
      diagnostics.error(Code::kIncompatible, {},
                        fmt::format("the recording does not have what '{}' was commanded", track.device()),
                        "Use one made by takt run --record of this version or a later one");
      continue;
    }
    // A topic without a message has no columns: nothing was handed over.
    if (!rows->time.empty() && rows->columns.size() != track.values()) {
      diagnostics.error(Code::kIncompatible, {},
                        fmt::format("commands of '{}' have {} values in the recording and {} here", track.device(),
                                    rows->columns.size(), track.values()));
      continue;
    }
    players_[i].rows = std::move(*rows);
    players_[i].row.resize(track.values());
  }
  playing_ = !diagnostics.has_errors();
  return diagnostics;
}

/// Rows of a cycle take the place of those in force.
void CommandTape::Player::play(CommandTrack& track, std::int64_t cycle, Nanoseconds time) {
  if (next < rows.time.size() && rows.time[next] <= time) {
    begin = next;
    while (next < rows.time.size() && rows.time[next] == rows.time[begin]) ++next;
    end = next;
  }
  for (std::size_t i = begin; i < end; ++i) {
    for (std::size_t value = 0; value < row.size(); ++value) row[value] = rows.values[value][i];
    execute(row, cycle, time);
    if (kind_of(row) == CommandKind::kNothing) continue;
    track.call(kind_of(row));
    track.put(std::span(row).subspan(1));
  }
}

void CommandTape::end_cycle(std::int64_t cycle, Nanoseconds time) {
  for (std::size_t i = 0; playing_ && i < tracks_.size(); ++i) players_[i].play(*tracks_[i], cycle, time);
  if (!recording_ && !playing_) return;
  for (const auto& track : tracks_) track->end_cycle();
}

}  // namespace takt::cell
