#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "record/recording.h"

namespace takt::record {

/// True if the channel's messages are rows of numbers that RowDecoder knows.
[[nodiscard]] bool has_columns(const ChannelInfo& channel);

/// Turns the messages of one channel into rows of a table, or of some columns of it. The first message states the
/// columns where the channel does not. Realtime: setup.
class RowDecoder {
 public:
  /// @param rows  how many messages there will be, so that columns are made once
  explicit RowDecoder(const ChannelInfo& channel, std::optional<std::vector<std::size_t>> columns = {},
                      std::size_t rows = 0);
  /// Appends a row to `table`; a message that does not parse is left out and gives false.
  bool append(const MessageView& message, Table& table);

 private:
  bool parse(const MessageView& message);
  void begin(Table& table);

  const ChannelInfo& channel_;
  std::optional<std::vector<std::size_t>> wanted_;  ///< set by the first message
  std::size_t rows_;
  Table all_;  ///< names and units of all columns
  std::vector<double> row_;
  bool has_header_ = false;
};

}  // namespace takt::record
