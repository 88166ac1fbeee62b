#pragma once

#include <string_view>
#include <vector>

#include "record/recording.h"

namespace takt::record {

/// True if the channel's messages are rows of numbers that RowDecoder knows.
[[nodiscard]] bool has_columns(const ChannelInfo& channel);

/// Turns the messages of one channel into rows of a table. The first message states the columns where the channel does
/// not. Realtime: setup.
class RowDecoder {
 public:
  /// @param rows  how many messages there will be, so that columns are made once
  explicit RowDecoder(const ChannelInfo& channel, std::size_t rows = 0);
  /// Appends a row to `table`; a message that does not parse is left out and gives false.
  bool append(const MessageView& message, Table& table);

 private:
  bool parse(const MessageView& message, Table& table);

  const ChannelInfo& channel_;
  std::size_t rows_;
  std::vector<double> row_;
  bool has_header_ = false;
};

}  // namespace takt::record
