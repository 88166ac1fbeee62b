#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt::record {

/// What a channel's messages mean: the full name of the message and its self-contained description (a serialised
/// google.protobuf.FileDescriptorSet with all imports), as MCAP wants it.
struct Schema {
  std::string name;
  std::string descriptor_set;
};

/// The messages whose shape this project knows; the names are those of the .proto files.
inline constexpr std::string_view kJointStatesSchema = "foxglove.JointStates";
inline constexpr std::string_view kFrameTransformsSchema = "foxglove.FrameTransforms";
inline constexpr std::string_view kSceneUpdateSchema = "foxglove.SceneUpdate";
inline constexpr std::string_view kLogSchema = "foxglove.Log";
inline constexpr std::string_view kWrenchSchema = "takt.Wrench";
inline constexpr std::string_view kSimStateSchema = "takt.SimState";
inline constexpr std::string_view kDigestSchema = "takt.Digest";
inline constexpr std::string_view kEventSchema = "takt.Event";
/// Samples have a message of their own per channel, takt.samples.<Topic>.
inline constexpr std::string_view kSamplesPackage = "takt.samples";

/// The schema of one of the messages above. Realtime: setup.
[[nodiscard]] Schema known_schema(std::string_view name);

/// A message made for one channel: `timestamp` = 1, then one double per column from 2 on, in order. Columns become
/// field names: letters, digits and '_' stay, anything else turns into '_'; a name that is taken gets a number.
[[nodiscard]] Schema samples_schema(std::string_view topic, const std::vector<std::string>& columns);

}  // namespace takt::record
