#include "record/schemas.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/timestamp.pb.h>

#include <cctype>
#include <set>

#include "foxglove/FrameTransforms.pb.h"
#include "foxglove/JointStates.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "takt/Digest.pb.h"
#include "takt/Event.pb.h"
#include "takt/SimState.pb.h"
#include "takt/Wrench.pb.h"

namespace takt::record {

namespace pb = google::protobuf;

namespace {

/// Imports first, each file once.
void add_with_imports(const pb::FileDescriptor& file, std::set<std::string>& seen, pb::FileDescriptorSet& set) {
  if (!seen.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_with_imports(*file.dependency(i), seen, set);
  file.CopyTo(set.add_file());
}

template <class Message>
Schema schema_of() {
  const pb::Descriptor& descriptor = *Message::descriptor();
  pb::FileDescriptorSet set;
  std::set<std::string> seen;
  add_with_imports(*descriptor.file(), seen, set);
  return {descriptor.full_name(), set.SerializeAsString()};
}

std::string identifier(std::string_view text, std::string_view fallback) {
  std::string name;
  for (const char c : text) {
    const bool keeps = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (keeps) {
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  if (name.empty()) name = fallback;
  if (std::isdigit(static_cast<unsigned char>(name.front())) != 0) name.insert(0, 1, '_');
  return name;
}

}  // namespace

Schema known_schema(std::string_view name) {
  if (name == kJointStatesSchema) return schema_of<foxglove::JointStates>();
  if (name == kFrameTransformsSchema) return schema_of<foxglove::FrameTransforms>();
  if (name == kSceneUpdateSchema) return schema_of<foxglove::SceneUpdate>();
  if (name == kLogSchema) return schema_of<foxglove::Log>();
  if (name == kWrenchSchema) return schema_of<takt::Wrench>();
  if (name == kSimStateSchema) return schema_of<takt::SimState>();
  if (name == kDigestSchema) return schema_of<takt::Digest>();
  if (name == kEventSchema) return schema_of<takt::Event>();
  return {};
}

Schema samples_schema(std::string_view topic, const std::vector<std::string>& columns) {
  pb::FileDescriptorSet set;
  pb::Timestamp::descriptor()->file()->CopyTo(set.add_file());

  const std::string message_name = identifier(topic, "Samples");
  pb::FileDescriptorProto& file = *set.add_file();
  file.set_name(fmt::format("takt/samples/{}.proto", message_name));
  file.set_package(std::string(kSamplesPackage));
  file.set_syntax("proto3");
  file.add_dependency("google/protobuf/timestamp.proto");
  pb::DescriptorProto& message = *file.add_message_type();
  message.set_name(message_name);

  pb::FieldDescriptorProto& stamp = *message.add_field();
  stamp.set_name("timestamp");
  stamp.set_number(1);
  stamp.set_label(pb::FieldDescriptorProto::LABEL_OPTIONAL);
  stamp.set_type(pb::FieldDescriptorProto::TYPE_MESSAGE);
  stamp.set_type_name(".google.protobuf.Timestamp");

  // Protobuf compares field names without case and underscores (their JSON forms must differ).
  const auto key_of = [](const std::string& name) {
    std::string key;
    for (const char c : name) {
      if (c != '_') key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return key;
  };
  std::set<std::string> taken{"timestamp"};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::string plain = identifier(columns[i], "column");
    std::string name = plain;
    for (int n = 2; !taken.insert(key_of(name)).second; ++n) name = fmt::format("{}_n{}", plain, n);
    pb::FieldDescriptorProto& field = *message.add_field();
    field.set_name(name);
    field.set_number(static_cast<int>(i) + 2);
    field.set_label(pb::FieldDescriptorProto::LABEL_OPTIONAL);
    field.set_type(pb::FieldDescriptorProto::TYPE_DOUBLE);
  }
  return {fmt::format("{}.{}", kSamplesPackage, message_name), set.SerializeAsString()};
}

}  // namespace takt::record
