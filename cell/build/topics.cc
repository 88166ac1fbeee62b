#include "cell/build/topics.h"

#include "record/recording.h"

namespace takt::cell {

std::string device_topic(const std::string& device) {
  std::string topic = "/" + device;
  std::ranges::replace(topic, ' ', '_');
  return topic;
}

std::string command_topic(const std::string& device) {
  return device_topic(device) + std::string(record::kCommandSuffix);
}

}  // namespace takt::cell
