#include "record/mcap_format.h"

#include <zlib.h>

#include <algorithm>

namespace takt::record::mcap {

void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out.append(text);
}

void put_map(std::string& out, const Map& map) {
  std::uint32_t size = 0;
  for (const auto& [key, value] : map) size += static_cast<std::uint32_t>(8 + key.size() + value.size());
  put(out, size);
  for (const auto& [key, value] : map) {
    put_text(out, key);
    put_text(out, value);
  }
}

RecordScope::RecordScope(std::string& out, Op op) : out_(out), start_(out.size()) {
  put(out_, op);
  put(out_, std::uint64_t{0});
}

RecordScope::~RecordScope() {
  const std::uint64_t size = out_.size() - start_ - kRecordHead;
  std::memcpy(out_.data() + start_ + 1, &size, sizeof(size));
}

std::uint32_t crc32(std::uint32_t crc, std::string_view data) {
  // zlib counts in 32 bits.
  constexpr std::size_t kPiece = std::size_t{1} << 30;
  while (!data.empty()) {
    const std::size_t size = std::min(data.size(), kPiece);
    crc = static_cast<std::uint32_t>(
        ::crc32(crc, reinterpret_cast<const unsigned char*>(data.data()), static_cast<unsigned>(size)));
    data.remove_prefix(size);
  }
  return crc;
}

std::string_view Cursor::take(std::uint64_t size) {
  if (!ok_ || size > rest_.size()) {
    ok_ = false;
    rest_ = {};
    return {};
  }
  const std::string_view taken = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return taken;
}

Map Cursor::get_map() {
  Cursor inner(get_text());
  Map map;
  while (inner.ok() && !inner.at_end()) {
    std::string key(inner.get_text());
    std::string value(inner.get_text());
    if (inner.ok()) map.emplace(std::move(key), std::move(value));
  }
  ok_ = ok_ && inner.ok();
  return map;
}

std::optional<Record> record_at(std::string_view bytes, std::size_t offset) {
  if (offset > bytes.size()) return std::nullopt;
  Cursor cursor(bytes.substr(offset));
  const auto op = cursor.get<std::uint8_t>();
  const std::string_view body = cursor.get_blob();
  if (!cursor.ok()) return std::nullopt;
  return Record{.op = op, .offset = offset, .body = body};
}

}  // namespace takt::record::mcap
