#include "record/wire_pattern.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace takt::record {

namespace {
enum WireType : std::uint64_t { kVarint = 0, kFixed64 = 1, kBytes = 2 };

void put_tag(std::string& out, int field, WireType type) {
  put_varint(out, (static_cast<std::uint64_t>(field) << 3) | type);
}
}  // namespace

void put_varint(std::string& out, std::uint64_t value) {
  while (value >= 0x80) {
    out += static_cast<char>((value & 0x7F) | 0x80);
    value >>= 7;
  }
  out += static_cast<char>(value);
}

void put_varint_field(std::string& out, int field, std::uint64_t value) {
  if (value == 0) return;
  put_tag(out, field, kVarint);
  put_varint(out, value);
}

void put_fixed64_field(std::string& out, int field, std::uint64_t value) {
  if (value == 0) return;
  put_tag(out, field, kFixed64);
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void put_text_field(std::string& out, int field, std::string_view text) {
  if (text.empty()) return;
  put_tag(out, field, kBytes);
  put_varint(out, text.size());
  out.append(text);
}

std::string timestamp_bytes(Nanoseconds time) {
  const auto count = static_cast<std::uint64_t>(std::max<Nanoseconds>(time, 0));
  std::string bytes;
  put_varint_field(bytes, 1, count / 1'000'000'000u);
  put_varint_field(bytes, 2, count % 1'000'000'000u);
  return bytes;
}

void WirePattern::add_stamp(int field) {
  put_tag(bytes_, field, kBytes);
  put_varint(bytes_, stamp_size_);
  stamps_.push_back(static_cast<std::uint32_t>(bytes_.size()));
  bytes_.append(stamp_size_, '\0');
}

void WirePattern::add_double(int field) {
  put_tag(bytes_, field, kFixed64);
  doubles_.push_back(static_cast<std::uint32_t>(bytes_.size()));
  bytes_.append(sizeof(double), '\0');
}

void WirePattern::add_packed_doubles(int field, std::size_t count) {
  put_tag(bytes_, field, kBytes);
  put_varint(bytes_, count * sizeof(double));
  for (std::size_t i = 0; i < count; ++i) {
    doubles_.push_back(static_cast<std::uint32_t>(bytes_.size()));
    bytes_.append(sizeof(double), '\0');
  }
}

void WirePattern::add_message(int field, const WirePattern& inner) {
  put_tag(bytes_, field, kBytes);
  put_varint(bytes_, inner.bytes_.size());
  const auto shift = static_cast<std::uint32_t>(bytes_.size());
  for (const std::uint32_t at : inner.doubles_) doubles_.push_back(at + shift);
  for (const std::uint32_t at : inner.stamps_) stamps_.push_back(at + shift);
  bytes_ += inner.bytes_;
}

void WirePattern::encode(std::string& out, std::string_view stamp, std::span<const double> values,
                         std::span<const std::uint32_t> order) const {
  const std::size_t start = out.size();
  out.append(bytes_);
  char* message = out.data() + start;
  for (const std::uint32_t at : stamps_) std::memcpy(message + at, stamp.data(), stamp.size());
  for (std::size_t i = 0; i < doubles_.size(); ++i) {
    std::memcpy(message + doubles_[i], &values[order[i]], sizeof(double));
  }
}

void RowEncoder::encode(std::string& out, std::string_view stamp, std::span<const double> values) {
  auto found = std::find_if(patterns_.begin(), patterns_.end(),
                            [&](const WirePattern& p) { return p.stamp_size() == stamp.size(); });
  if (found == patterns_.end()) {
    patterns_.push_back(build_(stamp.size()));
    found = patterns_.end() - 1;
    if (order_.empty()) {
      order_.resize(found->hole_count());
      std::iota(order_.begin(), order_.end(), 0u);
    }
  }
  found->encode(out, stamp, values, order_);
}

}  // namespace takt::record
