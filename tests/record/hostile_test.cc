// Recordings that somebody prepared: whatever they claim, reading them is bounded.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>

#include "core/base/utf8.h"
#include "record/compare.h"
#include "record/mcap_format.h"
#include "record/mcap_reader.h"
#include "record/recording.h"
#include "tests/record/support.h"
#include "tests/support/processor_time.h"
#include "tests/support/reports.h"

namespace takt::record {
namespace {

using mcap::Op;
using mcap::put;
using mcap::ReadLimits;
using mcap::RecordScope;
using takt::test::Reports;
using testing::Contains;
using testing::HasSubstr;

void put_chunk(std::string& file, std::uint64_t raw_size, const std::string& compression, const std::string& data) {
  const RecordScope record(file, Op::kChunk);
  put(file, std::uint64_t{0});
  put(file, std::uint64_t{0});
  put(file, raw_size);
  put(file, std::uint32_t{0});
  mcap::put_text(file, compression);
  put(file, static_cast<std::uint64_t>(data.size()));
  file += data;
}

std::string packed(const std::string& raw) {
  std::string data(ZSTD_compressBound(raw.size()), '\0');
  data.resize(ZSTD_compress(data.data(), data.size(), raw.data(), raw.size(), 1));
  return data;
}

void put_message(std::string& file, std::uint16_t channel, std::uint64_t time, const std::string& data) {
  const RecordScope record(file, Op::kMessage);
  put(file, channel);
  put(file, std::uint32_t{0});
  put(file, time);
  put(file, time);
  file += data;
}

void put_channel(std::string& file, const std::string& schema, const mcap::Map& metadata) {
  {
    const RecordScope record(file, Op::kSchema);
    put(file, std::uint16_t{1});
    mcap::put_text(file, schema);
    mcap::put_text(file, "protobuf");
    mcap::put_text(file, "");
  }
  const RecordScope record(file, Op::kChannel);
  put(file, std::uint16_t{7});
  put(file, std::uint16_t{1});
  mcap::put_text(file, "/numbers");
  mcap::put_text(file, "protobuf");
  mcap::put_map(file, metadata);
}

Recording open(const std::string& body) { return Recording::from_bytes(std::string(mcap::kMagic) + body).value(); }

TEST(Hostile, AChunkThatUnpacksToGigabytesIsDamage) {
  std::string file;
  put_chunk(file, std::uint64_t{4} << 30, "zstd", packed(std::string(1 << 20, '\0')));
  put_chunk(file, ~std::uint64_t{0}, "zstd", packed("x"));
  const Recording recording = open(file);
  EXPECT_THAT(recording.damage(), Contains(HasSubstr("its size is implausible")).Times(2));
  EXPECT_EQ(recording.message_count(), 0u);
}

TEST(Hostile, ChunksAreReadUpToABoundInAll) {
  const std::string raw(ReadLimits::kChunkBytes, '\0'), data = packed(raw);
  std::string file;
  for (int i = 0; i < 200; ++i) put_chunk(file, raw.size(), "zstd", data);
  const test::ProcessorTime time;
  const Recording recording = open(file);
  EXPECT_THAT(recording.damage(), Contains(HasSubstr("the recording is too large")));
  EXPECT_LE(recording.damage().size(), ReadLimits::kDamages + 1);
  EXPECT_LT(time.seconds(), 20.0);
}

TEST(Hostile, ThousandsOfEndRecordsAreSummedOnce) {
  std::string file;
  put_chunk(file, 4 << 20, "", std::string(4 << 20, '\0'));
  for (int i = 0; i < 200'000; ++i) {
    const RecordScope record(file, Op::kDataEnd);
    put(file, std::uint32_t{1});
  }
  const test::ProcessorTime time;
  const Recording recording = open(file);
  EXPECT_LT(time.seconds(), 5.0);
  EXPECT_EQ(recording.damage().size(), ReadLimits::kDamages + 1);
  EXPECT_THAT(recording.damage().back(), HasSubstr("and 199901 more"));
}

TEST(Hostile, TimesFarAwayAndBackwardsStayOutOfCurves) {
  std::string file;
  put_channel(file, "takt.SimState", {{"columns", R"(["q0"])"}});
  for (const std::uint64_t time :
       {std::uint64_t{5}, std::uint64_t{1} << 63, ~std::uint64_t{0}, std::uint64_t{3}, std::uint64_t{9}})
    put_message(file, 7, time, "");
  const Recording recording = open(file);
  EXPECT_EQ(recording.message_count(), 3u);
  EXPECT_THAT(recording.damage(), Contains(HasSubstr("2 messages with impossible times")));
  const auto table = recording.table("/numbers");
  ASSERT_TRUE(table);
  EXPECT_THAT(table->time, testing::ElementsAre(5, 9));
}

TEST(Hostile, MillionsOfMessagesOutsideOfChunksTakeLittleMemory) {
  std::string file;
  for (int i = 0; i < 1'000'000; ++i) put_message(file, 7, static_cast<std::uint64_t>(i), "");
  const test::ProcessorTime time;
  EXPECT_EQ(open(file).message_count(), 1'000'000u);
  EXPECT_LT(time.seconds(), 5.0);
}

TEST(Hostile, ATableOfTooManyValuesIsRefused) {
  std::string columns = "[\"c\"";
  for (int i = 1; i < 40'000; ++i) columns += ",\"c\"";
  columns += "]";
  std::string file;
  put_channel(file, "takt.SimState", {{"columns", columns}});
  for (int i = 0; i < 10'000; ++i) put_message(file, 7, static_cast<std::uint64_t>(i), "");
  const Recording recording = open(file);
  EXPECT_EQ(recording.header("/numbers")->columns.size(), ReadLimits::kColumns) << "more are left out";
  const auto table = recording.table("/numbers");
  ASSERT_FALSE(table);
  EXPECT_THAT(table, Reports(Code::kTooLarge, "", {std::to_string(ReadLimits::kTableValues)}));
}

TEST(Hostile, ComparisonsOfWideTablesAreBounded) {
  std::string columns = "[\"c0\"", file;
  for (int i = 1; i < 4096; ++i) columns += fmt::format(",\"c{}\"", i);
  put_channel(file, "takt.SimState", {{"columns", columns + "]"}});
  for (int i = 0; i < 20'000; ++i) put_message(file, 7, static_cast<std::uint64_t>(i), "");
  const Recording recording = open(file);
  const test::ProcessorTime time;
  const Comparison comparison = compare(recording, recording);
  EXPECT_LT(time.seconds(), 20.0);
  EXPECT_EQ(comparison.columns.size(), 1 + 4096u);
  std::size_t points = 0;
  for (const ColumnComparison& column : comparison.columns) points += column.curve_a.value.size();
  EXPECT_LT(points, 5'000'000u) << "curves to be drawn";
}

TEST(Hostile, EventsAreReadUpToABound) {
  std::string file;
  put_channel(file, "takt.Event", {});
  for (std::size_t i = 0; i <= ReadLimits::kEvents; ++i) put_message(file, 7, i, "");
  const Recording recording = open(file);
  const auto events = recording.events("/numbers");
  ASSERT_FALSE(events);
  EXPECT_THAT(events, Reports(Code::kTooLarge, "", {"/numbers", "1000000"}));
  EXPECT_FALSE(compare(recording, recording).missing.empty());
}

TEST(Hostile, DefinitionsAreReadUpToABound) {
  std::string file;
  const std::string large(1u << 20, 'x');
  for (int i = 0; i < 100; ++i) put_channel(file, "takt.SimState", {{"columns", large}});
  EXPECT_THAT(open(file).damage(), Contains(HasSubstr("left out, the recording is too large")));
}

/// Larger than what was read at all once, and than memory would hold: a private record with a hole of 8 GiB.
TEST(Hostile, AFileIsReadPieceByPiece) {
  TestFolder folder("hole");
  std::string front(mcap::kMagic), raw, back;
  put_channel(front, "takt.SimState", {{"columns", R"(["q0"])"}});
  put_message(raw, 7, 1, "");
  put_chunk(front, raw.size(), "zstd", packed(raw));
  constexpr std::uint64_t kHole = std::uint64_t{8} << 30;
  put(front, std::uint8_t{0x80});
  put(front, kHole);
  raw.clear();
  put_message(raw, 7, 2, "");
  put_chunk(back, raw.size(), "zstd", packed(raw));
  { const RecordScope footer(back, Op::kFooter); }
  back += mcap::kMagic;
  const auto path = folder / "a.mcap";
  std::ofstream(path, std::ios::binary) << front;
  std::filesystem::resize_file(path, front.size() + kHole);
  std::ofstream(path, std::ios::binary | std::ios::app) << back;
  const auto recording = Recording::open(path);
  ASSERT_TRUE(recording) << recording.error().to_string();
  EXPECT_THAT(recording->damage(), testing::IsEmpty());
  EXPECT_THAT(recording->table("/numbers")->time, testing::ElementsAre(1, 2));
}

TEST(Hostile, AFileMayShrinkWhileItIsRead) {
  TestFolder folder("shrinks");
  const auto path = folder / "a.mcap";
  std::string file(mcap::kMagic), raw;
  put_channel(file, "takt.SimState", {{"columns", R"(["q0"])"}});
  // More than is kept unpacked, so that chunks are read again.
  for (std::uint64_t chunk = 0; chunk < 100; ++chunk) {
    raw.clear();
    for (std::uint64_t i = 0; i < 25'000; ++i) put_message(raw, 7, 25'000 * chunk + i, "");
    put_chunk(file, raw.size(), "zstd", packed(raw));
  }
  std::ofstream(path, std::ios::binary) << file;
  const auto recording = Recording::open(path);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->message_count(), 2'500'000u);
  std::filesystem::resize_file(path, 1000);
  std::size_t seen = 0;
  recording->for_each([&seen](const MessageView&) { return ++seen > 0; }, "/numbers");
  EXPECT_LT(seen, 2'500'000u);
}

TEST(Hostile, OfTwoChannelsWithOneTopicTheFirstCounts) {
  std::string file;
  put_channel(file, "foreign.Type", {});
  {
    const RecordScope record(file, Op::kChannel);
    put(file, std::uint16_t{9});
    put(file, std::uint16_t{2});
    mcap::put_text(file, "/numbers");
    mcap::put_text(file, "protobuf");
    mcap::put_map(file, {{"columns", "[]"}});
  }
  {
    const RecordScope record(file, Op::kSchema);
    put(file, std::uint16_t{2});
    mcap::put_text(file, "takt.SimState");
    mcap::put_text(file, "protobuf");
    mcap::put_text(file, "");
  }
  put_message(file, 9, 1, "");
  const Recording recording = open(file);
  ASSERT_EQ(recording.channels().size(), 1u);
  EXPECT_THAT(recording.damage(), Contains(HasSubstr("topic '/numbers': a second channel")));
  for (const std::string& topic : recording.table_topics()) EXPECT_TRUE(recording.table(topic)) << topic;
}

TEST(Hostile, NamesOfColumnsAreReadWithinBounds) {
  std::string file;
  put_channel(file, "takt.SimState", {{"columns", std::string(200'000, '[')}});
  put_message(file, 7, 1, "");
  const auto table = open(file).table("/numbers");
  ASSERT_TRUE(table);
  EXPECT_TRUE(table->columns.empty());
}

TEST(Hostile, RecordedTextsAreUtf8WhateverIsGiven) {
  TestFolder folder("utf8");
  auto recorder = Recorder::open(folder / "a.mcap").value();
  const ChannelId events = recorder->add_events("/events"), log = recorder->add_log("/log");
  recorder->begin_cycle(0, 0);
  recorder->event(events, "a", std::string(3999, 'x') + "\u00e9", std::string(3998, 'x') + "\u20ac");
  recorder->event(events, "b", "half \xC3", "\xFF\xFE");
  recorder->log(log, LogLevel::kInfo, "c", std::string(3997, 'x') + "\U0001F600");
  EXPECT_EQ(recorder->close().error, "");
  const auto recording = Recording::open(folder / "a.mcap");
  ASSERT_TRUE(recording);
  std::vector<RecordedEvent> all = *recording->events("/events");
  all.push_back(recording->events("/log")->at(0));
  ASSERT_EQ(all.size(), 3u);
  for (const RecordedEvent& event : all) EXPECT_TRUE(is_utf8(event.name) && is_utf8(event.text));
  EXPECT_EQ(all[0].name.size(), 3999u);
  EXPECT_EQ(all[0].text.size(), 3998u);
  EXPECT_EQ(all[1].name, "half \uFFFD");
  EXPECT_EQ(all[2].text.size(), 3997u);
}

}  // namespace
}  // namespace takt::record
