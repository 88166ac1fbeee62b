#include "record/recover.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/recording.h"
#include "tests/record/support.h"
#include "tests/support/reports.h"

namespace takt::record {
namespace {

using takt::test::Reports;
using testing::IsEmpty;
using testing::Not;

RecorderOptions with_attachment() {
  RecorderOptions options;
  options.chunk_time = 20 * kMillisecond;
  options.attachments = {{"scenario.json", "application/json", "{\"seed\": 7}"}};
  options.metadata = {{"seed", "7"}};
  return options;
}

void write(const std::filesystem::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// All messages as bytes, with their topics and times.
std::vector<std::string> messages_of(const Recording& recording) {
  std::vector<std::string> messages;
  recording.for_each([&](const MessageView& message) {
    messages.push_back(message.channel->topic + "@" + std::to_string(message.time) + ":" +
                       std::string(reinterpret_cast<const char*>(message.data.data()), message.data.size()));
    return true;
  });
  return messages;
}

TEST(Recover, AWholeRecordingStaysAsItIs) {
  const TestFolder folder("recover");
  record_run(folder / "a.mcap", 240, with_attachment());
  const auto recovered = recover(folder / "a.mcap", folder / "b.mcap");
  ASSERT_TRUE(recovered) << recovered.error().to_string();
  EXPECT_THAT(recovered->lost, IsEmpty());
  const auto a = Recording::open(folder / "a.mcap"), b = Recording::open(folder / "b.mcap");
  EXPECT_EQ(recovered->messages, a->message_count());
  EXPECT_EQ(messages_of(*a), messages_of(*b));
  EXPECT_EQ(a->metadata(), b->metadata());
  EXPECT_EQ(b->attachment("scenario.json"), "{\"seed\": 7}");
  for (const ChannelInfo& channel : a->channels()) {
    const ChannelInfo* copy = b->find_channel(channel.topic);
    ASSERT_NE(copy, nullptr) << channel.topic;
    EXPECT_EQ(copy->schema, channel.schema);
    EXPECT_EQ(b->schema_data(*copy), a->schema_data(channel));
    EXPECT_EQ(copy->metadata, channel.metadata);
  }
}

TEST(Recover, ACutOneBecomesWholeAgain) {
  const TestFolder folder("recover");
  record_run(folder / "a.mcap", 240, with_attachment());
  const std::string bytes = bytes_of(folder / "a.mcap");
  const auto all = messages_of(*Recording::open(folder / "a.mcap"));
  for (const double share : {0.3, 0.6, 0.95}) {
    write(folder / "cut.mcap",
          std::string_view(bytes).substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    const auto recovered = recover(folder / "cut.mcap", folder / "b.mcap");
    ASSERT_TRUE(recovered) << recovered.error().to_string();
    EXPECT_THAT(recovered->lost, Not(IsEmpty())) << "it says what is gone";
    const auto b = Recording::open(folder / "b.mcap");
    EXPECT_FALSE(b->truncated_at());
    EXPECT_THAT(b->damage(), IsEmpty());
    const auto kept = messages_of(*b);
    ASSERT_EQ(kept.size(), recovered->messages);
    ASSERT_LE(kept.size(), all.size());
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), all.begin())) << "what is there is what was";
    EXPECT_EQ(kept, messages_of(*Recording::open(folder / "cut.mcap"))) << "all that could be read";
  }
}

TEST(Recover, ADamagedChunkIsLeftOutAndNamed) {
  const TestFolder folder("recover");
  record_run(folder / "a.mcap", 240, with_attachment());
  std::string bytes = bytes_of(folder / "a.mcap");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write(folder / "bad.mcap", bytes);
  const auto recovered = recover(folder / "bad.mcap", folder / "b.mcap");
  ASSERT_TRUE(recovered) << recovered.error().to_string();
  EXPECT_THAT(recovered->lost, Not(IsEmpty()));
  EXPECT_GT(recovered->messages, 0u);
  EXPECT_THAT(Recording::open(folder / "b.mcap")->damage(), IsEmpty());
}

TEST(Recover, WhatIsNoRecordingIsRefused) {
  const TestFolder folder("recover");
  write(folder / "a.mcap", "no recording at all");
  EXPECT_THAT(recover(folder / "a.mcap", folder / "b.mcap"), Reports(Code::kSyntax, ""));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.mcap"));
  record_run(folder / "c.mcap", 10);
  EXPECT_THAT(recover(folder / "c.mcap", folder / "none" / "b.mcap"), Reports(Code::kFileNotWritable, ""));
}

}  // namespace
}  // namespace takt::record
