#include "core/net/example.h"

#include <type_traits>

#include "core/net/value_json.h"

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

/// A value of moderate size with no component equal to another; a Boolean is false, so that nothing ends.
template <class T>
T example_value() {
  if constexpr (std::is_same_v<T, Boolean>) {
    return false;
  } else if constexpr (std::is_same_v<T, Integer>) {
    return 1;
  } else if constexpr (std::is_same_v<T, Real>) {
    return 0.5;
  } else if constexpr (std::is_same_v<T, Text>) {
    return Text("text");
  } else if constexpr (std::is_same_v<T, Vector>) {
    return {0.1, 0.2, 0.3};
  } else if constexpr (std::is_same_v<T, Rotation>) {
    return Rotation(0.5, 0.5, 0.5, 0.5);
  } else if constexpr (std::is_same_v<T, Frame>) {
    Frame frame = Frame::Identity();
    frame.translation() = example_value<Vector>();
    return frame;
  } else if constexpr (std::is_same_v<T, JointArray>) {
    return JointArray(Eigen::Matrix<double, 7, 1>(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7));
  } else {
    return {example_value<Vector>(), Vector(0.4, 0.5, 0.6)};
  }
}

}  // namespace

Json example_parameters(const PrimitiveInfo& info) {
  constexpr std::string_view kDevice = "device:";
  Json parameters = Json::object();
  for (const auto& parameter : info.parameters) {
    if (parameter.type.starts_with(kDevice)) {
      parameters[parameter.name] = parameter.type.substr(kDevice.size());
    } else if (parameter.fallback.empty()) {
      parameters[parameter.name] = Json::parse(parameter.spec.example, nullptr, false);
    }
  }
  return parameters;
}

NetDescription example_net(const PrimitiveInfo& info) {
  Json parameters = example_parameters(info);
  for (const auto& input : info.inputs) {
    if (input.spec.optional) continue;
    parameters[input.name] =
        visit_type(input.type, [&]<class T>(std::type_identity<T>) { return value_to_json(example_value<T>()); });
  }
  NetDescription net;
  if (info.merge) parameters[info.inputs.at(1).name] = nullptr;  // of what is merged, all but one rest
  net.add("example", info.type, std::move(parameters));
  if (!info.termination) net.add("end", "Termination", {{"condition", false}});
  return net;
}

}  // namespace takt::net
