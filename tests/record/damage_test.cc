#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <map>

#include "core/base/random.h"
#include "record/mcap_format.h"
#include "record/mcap_writer.h"
#include "record/recording.h"
#include "tests/record/support.h"
#include "tests/support/reports.h"

namespace takt::record {
namespace {

using takt::test::Reports;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// A finished file of several chunks, as bytes.
std::string small_file() {
  TestFolder folder("damage");
  RecorderOptions options;
  options.chunk_time = 5 * kMillisecond;
  options.attachments = {{"a.json", "application/json", "{}"}};
  record_run(folder / "a.mcap", 23, options);
  return bytes_of(folder / "a.mcap");
}

/// Uses everything that a reader offers, so that a wrong length has a chance to do harm.
std::size_t read_all(const Recording& recording) {
  std::size_t seen = recording.digests().size();
  for (const std::string& topic : recording.table_topics()) {
    if (const auto table = recording.table(topic)) seen += table->time.size();
  }
  for (const std::string& topic : recording.event_topics()) {
    if (const auto events = recording.events(topic)) seen += events->size();
  }
  for (const AttachmentInfo& info : recording.attachments()) seen += recording.attachment(info.name) ? 1 : 0;
  return seen;
}

/// Ends of the records at the top of the file, chunks only.
std::vector<std::size_t> chunk_ends(const std::string& bytes) {
  std::vector<std::size_t> ends;
  for (std::size_t offset = mcap::kMagic.size();;) {
    const auto record = mcap::record_at(bytes, offset);
    if (!record) return ends;
    offset = record->end();
    if (static_cast<mcap::Op>(record->op) == mcap::Op::kChunk) ends.push_back(offset);
  }
}

TEST(Damage, CutAtEveryByteItServesEveryWholeChunk) {
  const std::string bytes = small_file();
  const std::vector<std::size_t> ends = chunk_ends(bytes);
  ASSERT_EQ(ends.size(), 5u);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto recording = Recording::from_bytes(bytes.substr(0, size));
    if (size < mcap::kMagic.size()) {
      ASSERT_FALSE(recording);
      continue;
    }
    ASSERT_TRUE(recording) << size;
    ASSERT_TRUE(recording->truncated_at()) << size;
    ASSERT_LE(*recording->truncated_at(), size);
    ASSERT_THAT(recording->damage(), ElementsAre(HasSubstr("truncated at byte "))) << size;
    const auto whole = static_cast<std::size_t>(std::ranges::count_if(ends, [&](std::size_t e) { return e <= size; }));
    ASSERT_EQ(recording->digests().size(), whole == 5 ? 23 : 5 * whole) << size;
    if (size % 31 == 0) read_all(*recording);
  }
  EXPECT_FALSE(Recording::from_bytes(bytes)->truncated_at());
}

TEST(Damage, AFlippedBitIsSeenAndTheRestIsServed) {
  const std::string bytes = small_file();
  const std::size_t all = read_all(Recording::from_bytes(bytes).value());
  const std::size_t definitions = bytes.find(std::string_view("\x04\0\0\0zstd", 8)) - 37;
  Random random(20261121);
  std::size_t unseen = 0;
  for (int round = 0; round < 1500; ++round) {
    std::string rotten = bytes;
    const std::size_t bit = random.bits() % (bytes.size() * 8);
    rotten[bit / 8] = static_cast<char>(rotten[bit / 8] ^ (1 << (bit % 8)));
    const auto recording = Recording::from_bytes(rotten);
    if (!recording) {
      ASSERT_LT(bit / 8, mcap::kMagic.size());
      continue;
    }
    const std::size_t seen = read_all(*recording);
    // A bit in the definitions may cost or mix up channels. Behind them at most the chunk that holds the bit is lost:
    // 10 cycles of 6 channels, and what else stands there.
    if (bit / 8 >= definitions) {
      ASSERT_LE(seen, all);
      ASSERT_GE(seen + 45, all) << bit;
    }
    if (recording->damage().empty()) ++unseen;
  }
  // The summary repeats what stands before it; a bit there harms nobody.
  const std::size_t summary = bytes.size() - chunk_ends(bytes).back();
  EXPECT_LE(static_cast<double>(unseen),
            1500.0 * 1.2 * static_cast<double>(summary) / static_cast<double>(bytes.size()));
}

TEST(Damage, ARottenChunkIsNamedAndTheOthersStay) {
  std::string bytes = small_file();
  const std::vector<std::size_t> ends = chunk_ends(bytes);
  bytes[ends[2] - 40] = static_cast<char>(bytes[ends[2] - 40] ^ 4);
  const auto recording = Recording::from_bytes(bytes);
  ASSERT_TRUE(recording);
  EXPECT_THAT(recording->damage(), Not(IsEmpty()));
  EXPECT_THAT(recording->damage().back(), HasSubstr("chunk at byte "));
  std::vector<std::uint64_t> cycles;
  for (const RecordedDigest& digest : recording->digests()) cycles.push_back(digest.cycle);
  EXPECT_EQ(cycles.size(), 18u);
  EXPECT_EQ(cycles[9], 9u);
  EXPECT_EQ(cycles[10], 15u);
}

TEST(Damage, ALengthThatLeadsAstrayIsBridged) {
  std::string bytes = small_file();
  const std::vector<std::size_t> ends = chunk_ends(bytes);
  // The record after the first chunk, a message index, claims to be enormous.
  bytes[ends[0] + 6] = 0x7F;
  const auto recording = Recording::from_bytes(bytes);
  ASSERT_TRUE(recording);
  EXPECT_THAT(recording->damage().front(), HasSubstr("unreadable up to byte"));
  EXPECT_EQ(recording->digests().size(), 23u);
}

TEST(Damage, WhatIsNoRecordingIsRefusedInWords) {
  EXPECT_THAT(Recording::from_bytes(""), Reports(Code::kSyntax, ""));
  EXPECT_THAT(Recording::from_bytes("{\"scenario\": 1}"), Reports(Code::kSyntax, ""));
  EXPECT_THAT(Recording::open("/nowhere.mcap"), Reports(Code::kNotFound, "", {"/nowhere.mcap"}));
  EXPECT_THAT(Recording::open("/tmp"), Reports(Code::kFileNotReadable, "", {"/tmp"}));
}

TEST(Damage, AWrongTopicNamesTheNearest) {
  const auto recording = Recording::from_bytes(small_file());
  ASSERT_TRUE(recording);
  EXPECT_THAT(recording->table("/left/joint"), Reports(Code::kUnknownName, "", {"/left/joints"}));
  EXPECT_THAT(recording->table("/events"), Reports(Code::kUnknownName, "", {"/events"}));
}

/// The disk as a killed process leaves it: each write and each cut is a step; after `steps` of them nothing arrives any
/// more, and of the step at which the process dies only `share` of the bytes do.
class MortalDisk : public mcap::File {
 public:
  MortalDisk(std::string& content, std::size_t& steps, std::size_t last, double share)
      : content_(content), steps_(steps), last_(last), share_(share) {}

  int write_at(std::uint64_t offset, std::string_view bytes) override {
    const std::size_t step = steps_++;
    if (step > last_) return 0;
    // The head of a record arrives at once or not at all.
    const double share = bytes.size() <= mcap::kRecordHead ? 0.0 : share_;
    if (step == last_) bytes = bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size())));
    if (bytes.empty()) return 0;
    if (content_.size() < offset + bytes.size()) content_.resize(offset + bytes.size());
    content_.replace(offset, bytes.size(), bytes);
    return 0;
  }
  int cut_at(std::uint64_t size) override {
    if (steps_++ < last_) content_.resize(size);
    return 0;
  }
  int close() override { return 0; }

 private:
  std::string& content_;
  std::size_t& steps_;
  std::size_t last_;
  double share_;
};

/// Writes 30 messages, flushing after each and closing a chunk now and then. `promised` gets, per step of the disk, how
/// many messages had been flushed before it.
void write_with_flushes(std::unique_ptr<mcap::File> disk, const std::size_t& steps,
                        std::vector<std::size_t>& promised) {
  mcap::Writer writer(std::move(disk), "disk", 1, 512);
  const std::uint16_t channel = writer.add_channel(writer.add_schema("s", "", ""), "/x", "raw", {});
  for (std::size_t k = 0; k < 30; ++k) {
    writer.begin_message(channel, static_cast<Nanoseconds>(k)) += std::string(20 + k, static_cast<char>('a' + k));
    writer.end_message();
    if (k % 7 == 6) {
      writer.close_chunk();
    } else {
      writer.flush_open_chunk();
    }
    promised.resize(steps, k);
  }
  writer.finish();
  promised.resize(steps, 30);
}

/// What a reader that searches for nothing makes of a file: records one behind the other, of which the last may be
/// torn. Opcode 0 is none: it comes from a hole.
bool is_row_of_records(std::string_view bytes) {
  std::size_t at = mcap::kMagic.size();
  while (at + mcap::kRecordHead <= bytes.size() && bytes.substr(at) != mcap::kMagic) {
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data() + at + 1, sizeof(size));
    if (bytes[at] == 0) return false;
    if (size > bytes.size() - at - mcap::kRecordHead) break;
    at += mcap::kRecordHead + size;
  }
  return true;
}

TEST(Damage, AProcessKilledInAnyWriteKeepsWhatWasFlushedBefore) {
  std::string content;
  std::size_t steps = 0;
  std::vector<std::size_t> promised;
  write_with_flushes(std::make_unique<MortalDisk>(content, steps, 1'000'000, 0.0), steps, promised);
  const std::string whole = content;
  EXPECT_TRUE(Recording::from_bytes(whole)->damage().empty());
  ASSERT_GE(promised.size(), 80u);
  const std::size_t all_steps = promised.size();
  for (std::size_t last = 5; last < all_steps; ++last) {
    for (const double share : {0.0, 0.5}) {
      content.clear();
      steps = 0;
      std::vector<std::size_t> ignored;
      write_with_flushes(std::make_unique<MortalDisk>(content, steps, last, share), steps, ignored);
      const auto recording = Recording::from_bytes(content);
      ASSERT_TRUE(recording);
      ASSERT_TRUE(is_row_of_records(content)) << "step " << last << ", share " << share;
      ASSERT_GE(recording->message_count(), promised[last]) << "step " << last << ", share " << share;
      std::size_t next = 0;
      recording->for_each([&](const MessageView& message) {
        EXPECT_EQ(message.time, static_cast<Nanoseconds>(next++));
        return true;
      });
    }
  }
}

TEST(Damage, FlushesLeaveNoTraceInTheFinishedFile) {
  const auto write = [](bool flush) {
    std::string content;
    std::size_t steps = 0;
    mcap::Writer writer(std::make_unique<MortalDisk>(content, steps, 1'000'000, 0.0), "disk", 1, 512);
    const std::uint16_t channel = writer.add_channel(writer.add_schema("s", "", ""), "/x", "raw", {});
    for (std::size_t k = 0; k < 30; ++k) {
      writer.begin_message(channel, static_cast<Nanoseconds>(k)) += std::string(20 + k, 'x');
      writer.end_message();
      if (k % 7 == 6) writer.close_chunk();
      if (flush) writer.flush_open_chunk();
    }
    writer.finish();
    return content;
  };
  EXPECT_EQ(write(true), write(false));
}

}  // namespace
}  // namespace takt::record
