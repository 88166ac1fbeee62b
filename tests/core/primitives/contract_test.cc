// What every primitive of the library owes the net (rows N1, O3), tried on each registered type; and that each has a
// sample of its parameters here, so that a new one cannot be left out.
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/motion/time_law.h"
#include "core/net/registry.h"
#include "tests/core/primitives/environment.h"
#include "tests/support/primitive_harness.h"

namespace takt::test {
namespace {

using Json = nlohmann::ordered_json;

const Json kLine = {{"kind", "cartesian_line"},     {"start", {0.4, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0}},
                    {"direction", {1.0, 0.0, 0.0}}, {"length_m", 0.1},
                    {"axis", {0.0, 0.0, 1.0}},      {"angle_rad", 0.2},
                    {"held_start", {0.0}},          {"held_goal", {0.1}}};

/// Parameters of the types that demand some; of the families that come for all payloads by the part before the payload.
Json sample_parameters(const std::string& type) {
  static const std::map<std::string, Json> kSamples = {
      {"Gain", {{"factor", 2.0}}},
      {"OnDelay", {{"delay", 0.003}}},
      {"Saturation", {{"lower", -1.0}, {"upper", 1.0}}},
      {"RateLimiter", {{"rate_max", 10.0}}},
      {"LowPass", {{"cutoff", 50.0}}},
      {"Error", {{"text", "it broke"}}},
      {"PathClock", {{"bounds", {{"acceleration_max", 4.0}, {"jerk_max", 80.0}}}, {"duration", 1.0}}},
      {"TimeLaw", {{"law", Json::array({{1.0, 6.0}})}}},
      {"JointLine", {{"path", {{"kind", "joint_line"}, {"start", {0.0, 1.0}}, {"goal", {1.0, 0.0}}}}}},
      {"CartesianLine", {{"path", kLine}}},
      {"Tare", {{"cycles", 3}}},
      {"PayloadCompensation", {{"mass", 0.5}, {"centre", {0.0, 0.0, 0.05}}}},
      {"ArmCommand", {{"device", "arm"}}},
      {"ArmState", {{"device", "arm"}}},
      {"ForwardKinematics", {{"device", "arm"}}},
      {"InverseKinematics", {{"device", "arm"}}},
      {"ForceTorqueSensor", {{"device", "sensor"}}},
      {"GripperCommand", {{"device", "gripper"}}},
      {"GripperState", {{"device", "gripper"}}},
      {"Reservation", {{"device", "outputs"}}},
      {"DigitalInput", {{"device", "digital_input"}}},
      {"DigitalOutput", {{"device", "digital_output"}}},
      {"DigitalOutputState", {{"device", "digital_output"}}},
      {"AnalogInput", {{"device", "analog_input"}}},
      {"AnalogOutput", {{"device", "analog_output"}}},
      {"AnalogOutputState", {{"device", "analog_output"}}},
      {"ConstantBoolean", {{"value", true}}},
      {"ConstantInteger", {{"value", 3}}},
      {"ConstantReal", {{"value", 3.5}}},
      {"ConstantString", {{"value", "text"}}},
      {"ConstantVector", {{"value", {1.0, 2.0, 3.0}}}},
      {"ConstantRotation", {{"value", {1.0, 0.0, 0.0, 0.0}}}},
      {"ConstantFrame", {{"value", {{"position", {1.0, 2.0, 3.0}}, {"quaternion", {1.0, 0.0, 0.0, 0.0}}}}}},
      {"ConstantTwist", {{"value", {{"linear", {1.0, 2.0, 3.0}}, {"angular", {0.0, 0.0, 0.0}}}}}},
      {"ConstantWrench", {{"value", {{"force", {1.0, 2.0, 3.0}}, {"torque", {0.0, 0.0, 0.0}}}}}},
      {"ConstantJoints", {{"value", {1.0, 2.0}}}},
  };
  if (type.starts_with("Input")) return {{"channel", "outside " + type.substr(5)}};
  if (type.starts_with("Output")) return {{"channel", "net " + type.substr(6)}};
  if (type.starts_with("HoldLast")) return {{"cycles", 2}};
  const auto found = kSamples.find(type);
  return found == kSamples.end() ? Json::object() : found->second;
}

/// All types of the library; not the helpers of the harness.
std::vector<std::string> library() {
  std::vector<std::string> types;
  for (const net::PrimitiveInfo* info : net::Registry::global().all())
    if (info->family != "test") types.push_back(info->type);
  return types;
}

class Contract : public testing::TestWithParam<std::string> {};

TEST_P(Contract, N1_O3_IsKept) {
  const std::string& type = GetParam();
  // The law needs segments that end at rest at 1: take the real thing.
  Json parameters = sample_parameters(type);
  if (type == "TimeLaw")
    parameters["law"] =
        motion::to_json(motion::TimeLaw::rest_to_rest({.velocity = 1.0, .acceleration = 4.0, .jerk = 100.0}));
  DeviceEnvironment devices;
  check_primitive_contract(type, parameters, {.environment = &devices});
}

TEST_P(Contract, IsDocumented) {
  const net::PrimitiveInfo& info = *net::Registry::global().find(GetParam());
  EXPECT_FALSE(info.doc.empty());
  EXPECT_TRUE(info.doc.ends_with('.')) << info.doc;
  for (const auto* ports : {&info.inputs, &info.outputs})
    for (const auto& port : *ports) EXPECT_FALSE(port.spec.doc.empty()) << port.name;
  for (const auto& parameter : info.parameters) EXPECT_FALSE(parameter.spec.doc.empty()) << parameter.name;
}

INSTANTIATE_TEST_SUITE_P(Library, Contract, testing::ValuesIn(library()), [](const auto& one) { return one.param; });

TEST(Library, HasTheFamiliesItPromises) {
  std::set<std::string> families;
  for (const net::PrimitiveInfo* info : net::Registry::global().all()) families.insert(info->family);
  for (const char* family : {"arithmetic", "channel", "comparison", "device", "event", "force", "geometry",
                             "kinematics", "logic", "net", "null", "path", "selection", "signal"})
    EXPECT_TRUE(families.contains(family)) << family;
  EXPECT_GE(library().size(), 120u);
}

}  // namespace
}  // namespace takt::test
