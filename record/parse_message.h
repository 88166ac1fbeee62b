#pragma once

#include "record/mcap_reader.h"

namespace takt::record {

/// Reads the protobuf message in `view`. @return false if its bytes are no such message. Realtime: any thread.
template <class Message>
[[nodiscard]] bool parse_message(const MessageView& view, Message& message) {
  return message.ParseFromArray(view.data.data(), static_cast<int>(view.data.size()));
}

}  // namespace takt::record
