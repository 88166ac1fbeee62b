#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace takt::record {

// Protobuf's wire format for messages whose shape never changes: names and tags are laid out once, a row only fills in
// the time stamp and the doubles (what that saves: docs/recording.md, "What else was weighed").

void put_varint(std::string& out, std::uint64_t value);
void put_varint_field(std::string& out, int field, std::uint64_t value);
void put_fixed64_field(std::string& out, int field, std::uint64_t value);
void put_text_field(std::string& out, int field, std::string_view text);

/// google.protobuf.Timestamp of a time >= 0, without its own tag and length; 0 to 12 bytes.
[[nodiscard]] std::string timestamp_bytes(Nanoseconds time);

/// A message with holes for doubles and time stamps.
class WirePattern {
 public:
  /// `stamp_size`: how many bytes timestamp_bytes() has in the rows that this pattern is for.
  explicit WirePattern(std::size_t stamp_size) : stamp_size_(stamp_size) {}

  void add_text(int field, std::string_view text) { put_text_field(bytes_, field, text); }
  void add_stamp(int field);
  /// The next value of the row goes here.
  void add_double(int field);
  void add_packed_doubles(int field, std::size_t count);
  void add_message(int field, const WirePattern& inner);
  [[nodiscard]] std::size_t stamp_size() const { return stamp_size_; }

  /// Appends the message. `stamp` has stamp_size bytes; values[order[i]] goes into hole i, so `order` may sort a row
  /// into the message's own order. Precondition: order.size() == hole_count().
  void encode(std::string& out, std::string_view stamp, std::span<const double> values,
              std::span<const std::uint32_t> order) const;
  [[nodiscard]] std::size_t hole_count() const { return doubles_.size(); }

 private:
  std::size_t stamp_size_;
  std::string bytes_;
  std::vector<std::uint32_t> doubles_, stamps_;  ///< where the holes are
};

/// The pattern of one channel for every size of time stamp, made when first needed.
class RowEncoder {
 public:
  using Build = std::function<WirePattern(std::size_t stamp_size)>;
  RowEncoder() = default;
  /// `order`: the value of the row for each hole; empty: as they come.
  RowEncoder(Build build, std::vector<std::uint32_t> order) : build_(std::move(build)), order_(std::move(order)) {}

  void encode(std::string& out, std::string_view stamp, std::span<const double> values);

 private:
  Build build_;
  std::vector<std::uint32_t> order_;
  std::vector<WirePattern> patterns_;
};

}  // namespace takt::record
