#include "core/device/arm_reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/control_mode_file.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/joint_range.h"
#include "core/kinematics/link_path.h"
#include "core/kinematics/robot_model.h"

namespace takt::device {

namespace {

using Json = nlohmann::ordered_json;

JointVector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Nanoseconds milliseconds(ObjectReader& reader, const char* key) {
  constexpr Range kUpToASecond{.low = 0.0, .high = 1000.0};
  return static_cast<Nanoseconds>(reader.number(key, 0.0, kUpToASecond) * kMillisecond);
}

double one_number(ObjectReader& parent, const char* object, const char* key) {
  const Json* json = parent.object(object, /*required=*/false);
  if (json == nullptr) return 0.0;
  ObjectReader reader(*json, parent.at(object), parent.diagnostics());
  const double value = reader.number(key, 0.0, kNotNegative);
  reader.finish();
  return value;
}

}  // namespace

void ArmReader::read() {
  read_names();
  read_chain();
  arm_.home = joints(reader_, "home_rad", kAnyNumber);
  check_home();
  read_held_joints();
  arm_.start_tolerance = reader_.number("start_tolerance_rad", 0.01, kPositive);
  arm_.following_error = reader_.number("following_error_rad", arm_.following_error, kPositive);
  arm_.payload_max = reader_.number("payload_max_kg", 0.0, kNotNegative);
  arm_.payload_rated = reader_.number("payload_rated_kg", arm_.payload_max, {.low = 0.0, .high = arm_.payload_max});
  read_times();
  read_limits();
  read_control();
  arm_.armature = joints(reader_, "armature_kg_m2", kNotNegative, /*required=*/false);
  read_sensors();
}

void ArmReader::read_names() {
  arm_.base_link = file_.read_common(reader_, arm_);
  arm_.flange_link = file_.link(reader_, "flange");
}

void ArmReader::read_times() {
  arm_.cycle = read_cycle(reader_);
  arm_.sample_age_max = kSampleCyclesMax * arm_.cycle;
}

/// One number per joint; zeros if absent and not required. Wrong lengths are diagnostics.
JointVector ArmReader::joints(ObjectReader& reader, const char* key, const Range& range, bool required) {
  const auto n = static_cast<std::size_t>(joint_count_);
  std::optional<std::vector<double>> fallback;
  if (!required) fallback = std::vector<double>(n, 0.0);
  auto values = reader.numbers(key, n, fallback, range);
  const auto usable = n > 0 ? n : std::min<std::size_t>(values.size(), kinematics::kMaxJoints);
  values.resize(usable, 0.0);
  return vector_of(values);
}

void ArmReader::read_chain(std::span<const std::string> rolling) {
  if (arm_.robot == nullptr || arm_.base_link.empty() || arm_.flange_link.empty()) return;
  if (arm_.robot->link(arm_.base_link) == nullptr || arm_.robot->link(arm_.flange_link) == nullptr) return;
  auto chain = kinematics::Chain::create(*arm_.robot, arm_.base_link, arm_.flange_link, rolling);
  if (!chain) return reader_.diagnostics().append(chain.error(), {}, arm_.urdf.string());
  joint_count_ = chain->joint_count();
  arm_.joint_names = chain->joint_names();
  arm_.limits.lower = chain->lower();
  arm_.limits.upper = chain->upper();
  arm_.limits.velocity = chain->velocity_limit();
  arm_.effort = chain->effort_limit();
  arm_.damping = arm_.friction = JointVector::Zero(joint_count_);
  for (int i = 0; i < joint_count_; ++i) {
    const auto* joint = arm_.robot->joint(arm_.joint_names[static_cast<std::size_t>(i)]);
    arm_.damping[i] = joint->damping;
    arm_.friction[i] = joint->friction;
    if (!std::isfinite(arm_.limits.velocity[i]))
      reader_.diagnostics().error(Code::kMissing, reader_.at("urdf"),
                                  fmt::format("joint '{}' has no velocity limit", joint->name),
                                  "Add <limit velocity=\"...\"/> to the URDF");
  }
  arm_.chain = std::make_shared<const kinematics::Chain>(std::move(*chain));
  arm_.links = std::make_shared<const kinematics::LinkPaths>(*arm_.robot, arm_.base_link, arm_.joint_names);
}

void ArmReader::check_home() {
  if (arm_.chain == nullptr || arm_.home.size() != joint_count_) return;
  for (int i = 0; i < joint_count_; ++i) {
    if (kinematics::is_in_range(arm_.home[i], arm_.limits.lower[i], arm_.limits.upper[i])) {
      arm_.home[i] = kinematics::into_range(arm_.home[i], arm_.limits.lower[i], arm_.limits.upper[i]);
      continue;
    }
    reader_.diagnostics().error(Code::kOutOfRange,
                                reader_.at("home_rad") + pointer_segment(static_cast<std::size_t>(i)),
                                fmt::format("{} is outside the range of joint '{}'", arm_.home[i],
                                            arm_.joint_names[static_cast<std::size_t>(i)]),
                                fmt::format("Choose a value in [{}, {}]", arm_.limits.lower[i], arm_.limits.upper[i]));
  }
}

void ArmReader::read_held_joints() {
  const bool given = reader_.has("held_joints");
  const auto names = reader_.texts("held_joints", std::vector<std::string>{});
  if (arm_.chain == nullptr) return;
  std::vector<int> held;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::ranges::find(arm_.joint_names, names[i]);
    if (found == arm_.joint_names.end()) {
      reader_.diagnostics().error(Code::kUnknownName, reader_.at("held_joints") + pointer_segment(i),
                                  fmt::format("there is no joint '{}'", names[i]),
                                  nearest_choice(names[i], arm_.joint_names));
      return;
    }
    held.push_back(static_cast<int>(found - arm_.joint_names.begin()));
  }
  if (joint_count_ < 3) return;  // no inverse: only joint motions
  auto inverse = given ? kinematics::InverseKinematics::create(*arm_.chain, held)
                       : kinematics::InverseKinematics::create(*arm_.chain);
  if (!inverse) return reader_.diagnostics().append(inverse.error(), reader_.at("held_joints"));
  arm_.inverse = std::make_shared<const kinematics::InverseKinematics>(std::move(*inverse));
}

void ArmReader::read_limits() {
  const Json* json = reader_.object("limits");
  if (json == nullptr) return;
  ObjectReader limits(*json, reader_.at("limits"), reader_.diagnostics());
  arm_.limits.acceleration = joints(limits, "acceleration_rad_s2", kPositive);
  arm_.limits.jerk = joints(limits, "jerk_rad_s3", kPositive);
  if (const Json* inner = limits.object("cartesian")) {
    ObjectReader cartesian(*inner, limits.at("cartesian"), reader_.diagnostics());
    auto& c = arm_.cartesian;
    c.linear_velocity = cartesian.number("linear_velocity_m_s", {}, kPositive);
    c.linear_acceleration = cartesian.number("linear_acceleration_m_s2", {}, kPositive);
    c.linear_jerk = cartesian.number("linear_jerk_m_s3", {}, kPositive);
    c.angular_velocity = cartesian.number("angular_velocity_rad_s", {}, kPositive);
    c.angular_acceleration = cartesian.number("angular_acceleration_rad_s2", {}, kPositive);
    c.angular_jerk = cartesian.number("angular_jerk_rad_s3", {}, kPositive);
    cartesian.finish();
  }
  limits.finish();
}

void ArmReader::read_control() {
  const Json* json = reader_.object("control");
  if (json == nullptr) return;
  ObjectReader control(*json, reader_.at("control"), reader_.diagnostics());
  read_control_modes(control, joint_count_, arm_.modes, arm_.impedance);
  if (const Json* inner = control.object("gains")) {
    ObjectReader gains(*inner, control.at("gains"), reader_.diagnostics());
    arm_.natural_frequency = joints(gains, "natural_frequency_rad_s", kPositive);
    arm_.damping_ratio = joints(gains, "damping_ratio", kPositive);
    arm_.friction_observer = joints(gains, "friction_observer_per_s", kNotNegative, /*required=*/false);
    gains.finish();
  }
  control.finish();
}

void ArmReader::read_sensors() {
  const Json* json = reader_.object("sensors", /*required=*/false);
  if (json == nullptr) return;
  ObjectReader sensors(*json, reader_.at("sensors"), reader_.diagnostics());
  arm_.position_resolution = one_number(sensors, "position", "resolution_rad");
  arm_.velocity_noise = one_number(sensors, "velocity", "noise_sigma_rad_s");
  arm_.measurement_delay = milliseconds(sensors, "delay_ms");
  arm_.measurement_period = milliseconds(sensors, "period_ms");
  if (const Json* inner = sensors.object("torque", /*required=*/false)) {
    ObjectReader torque(*inner, sensors.at("torque"), reader_.diagnostics());
    arm_.torque_noise = joints(torque, "noise_sigma_Nm", kNotNegative);
    arm_.torque_bias = joints(torque, "bias_sigma_Nm", kNotNegative);
    arm_.torque_at_motor = torque.choice("at", {"joint", "motor"}, "joint") == "motor";
    torque.finish();
  }
  sensors.finish();
}

}  // namespace takt::device
