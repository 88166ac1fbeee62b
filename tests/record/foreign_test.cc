// Recordings that other programs write: whatever their container, and what takt does not read of them is never a
// success.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <array>
#include <fstream>

#include "foxglove/Log.pb.h"
#include "record/compare.h"
#include "record/mcap_format.h"
#include "record/recording.h"
#include "record/recover.h"
#include "tests/record/support.h"
#include "tests/support/reports.h"

namespace takt::record {
namespace {

using mcap::Op;
using mcap::put;
using mcap::RecordScope;
using takt::test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

std::string compressed(const std::string& name, const std::string& raw) {
  std::string data;
  if (name == "zstd") {
    data.resize(ZSTD_compressBound(raw.size()));
    data.resize(ZSTD_compress(data.data(), data.size(), raw.data(), raw.size(), 1));
  } else if (name == "lz4") {
    data.resize(LZ4F_compressFrameBound(raw.size(), nullptr));
    data.resize(LZ4F_compressFrame(data.data(), data.size(), raw.data(), raw.size(), nullptr));
  } else {
    data = raw;
  }
  return data;
}

struct Form {
  std::string compression;
  bool chunked = true, summary = true;
  std::string encoding = "protobuf";
};

std::string definitions(const Form& form) {
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kSchema);
    put(bytes, std::uint16_t{1});
    mcap::put_text(bytes, "foxglove.Log");
    mcap::put_text(bytes, form.encoding);
    mcap::put_text(bytes, "");
  }
  {
    const RecordScope record(bytes, Op::kChannel);
    put(bytes, std::uint16_t{1});
    put(bytes, std::uint16_t{1});
    mcap::put_text(bytes, "/log");
    mcap::put_text(bytes, form.encoding);
    mcap::put_map(bytes, {});
  }
  return bytes;
}

std::string message(const Form& form, int k, const std::string& text) {
  std::string data = "{\"message\": \"" + text + "\"}";
  if (form.encoding == "protobuf") {
    foxglove::Log log;
    log.set_message(text);
    log.set_name("node");
    data = log.SerializeAsString();
  }
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kMessage);
    put(bytes, std::uint16_t{1});
    put(bytes, std::uint32_t{0});
    put(bytes, static_cast<std::uint64_t>(k * kSecond));
    put(bytes, static_cast<std::uint64_t>(k * kSecond));
    bytes += data;
  }
  return bytes;
}

std::string chunk(const Form& form, const std::string& raw) {
  const std::string data = compressed(form.compression, raw);
  std::string bytes;
  {
    const RecordScope record(bytes, Op::kChunk);
    put(bytes, std::uint64_t{0});
    put(bytes, std::uint64_t{0});
    put(bytes, static_cast<std::uint64_t>(raw.size()));
    put(bytes, mcap::crc32(0, raw));
    mcap::put_text(bytes, form.compression);
    put(bytes, static_cast<std::uint64_t>(data.size()));
    bytes += data;
  }
  return bytes;
}

/// A chunk for each text.
std::string file_of(const Form& form, const std::vector<std::string>& texts) {
  std::string bytes{mcap::kMagic};
  if (!form.chunked || texts.empty()) bytes += definitions(form);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const std::string one = message(form, static_cast<int>(i), texts[i]);
    bytes += form.chunked ? chunk(form, (i == 0 ? definitions(form) : "") + one) : one;
  }
  {
    const RecordScope record(bytes, Op::kDataEnd);
    put(bytes, std::uint32_t{0});
  }
  if (form.summary) bytes += definitions(form);
  {
    const RecordScope record(bytes, Op::kFooter);
    put(bytes, std::uint64_t{0});
    put(bytes, std::uint64_t{0});
    put(bytes, std::uint32_t{0});
  }
  return bytes + std::string(mcap::kMagic);
}

Recording opened(const std::string& bytes) { return Recording::from_bytes(bytes).value(); }

std::vector<Form> all_forms() {
  std::vector<Form> forms;
  for (const char* encoding : {"protobuf", "json", "cdr", "ros1"})
    for (const bool summary : {true, false}) {
      forms.push_back({.compression = "", .chunked = false, .summary = summary, .encoding = encoding});
      for (const char* compression : {"", "zstd", "lz4"})
        forms.push_back({.compression = compression, .summary = summary, .encoding = encoding});
    }
  return forms;
}

/// The matrix: each container is read whole, equal files are the same, others differ, and so does a file that lacks the
/// last message, a message in the middle, or all of them, whichever of both it is.
TEST(Foreign, EveryContainerIsJudged) {
  for (const Form& form : all_forms()) {
    SCOPED_TRACE(form.encoding + " '" + form.compression + "'" + (form.chunked ? "" : " without chunks") +
                 (form.summary ? "" : " without summary"));
    const std::string abc = file_of(form, {"a", "b", "c"});
    const Comparison same = compare(opened(abc), opened(abc));
    EXPECT_TRUE(same.passed) << to_text(same);
    EXPECT_EQ(same.judged_a.messages, 3u);
    EXPECT_EQ(same.judged_b.messages_in_file, 3u);
    EXPECT_EQ(same.judged_a.channels, 1u);
    for (const auto& other : std::vector<std::vector<std::string>>{{"a", "x", "c"}, {"a", "b"}, {"a"}, {}}) {
      const std::string bytes = file_of(form, other);
      EXPECT_FALSE(compare(opened(abc), opened(bytes)).passed) << other.size();
      EXPECT_FALSE(compare(opened(bytes), opened(abc)).passed) << other.size();
    }
    const TestFolder folder("foreign");
    std::ofstream(folder / "a.mcap", std::ios::binary) << abc;
    const auto recovered = recover(folder / "a.mcap", folder / "b.mcap");
    ASSERT_TRUE(recovered);
    EXPECT_EQ(recovered->messages, 3u);
    EXPECT_THAT(recovered->lost, IsEmpty());
    EXPECT_TRUE(compare(opened(abc), Recording::open(folder / "b.mcap").value()).passed);
  }
}

TEST(Foreign, FilesWithoutMessagesAreNotTheSame) {
  for (const Form& form : all_forms()) {
    const Comparison c = compare(opened(file_of(form, {})), opened(file_of(form, {})));
    EXPECT_FALSE(c.passed);
    EXPECT_EQ(c.judged_a.messages, 0u);
  }
}

/// One flipped bit of a chunk, in either file: a difference.
TEST(Foreign, AFlippedBitIsADifferenceInEitherFile) {
  for (const char* compression : {"", "zstd", "lz4"}) {
    const Form form{.compression = compression};
    const std::string whole = file_of(form, {"a", "b", "c"});
    std::string rotten = whole;
    rotten[whole.find("foxglove.Log") - 1] ^= 8;
    EXPECT_THAT(opened(rotten).lost(), Not(IsEmpty())) << compression;
    EXPECT_FALSE(compare(opened(rotten), opened(whole)).passed) << compression;
    EXPECT_FALSE(compare(opened(whole), opened(rotten)).passed) << compression;
    EXPECT_FALSE(compare(opened(rotten), opened(rotten)).passed) << "what is lost was not judged";
  }
}

TEST(Foreign, AnUnknownCompressionIsNamed) {
  const TestFolder folder("foreign");
  const Form form{.compression = "brotli", .summary = true, .encoding = "protobuf"};
  const std::string bytes = file_of(form, {"a", "b"});
  EXPECT_EQ(opened(bytes).unread().size(), 1u);
  EXPECT_FALSE(compare(opened(bytes), opened(bytes)).passed);
  std::ofstream(folder / "a.mcap", std::ios::binary) << bytes;
  EXPECT_THAT(recover(folder / "a.mcap", folder / "b.mcap"), Reports(Code::kFileNotReadable, "", {"brotli", "2"}));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.mcap"));
}

/// A text that is no UTF-8: the message cannot be read, which the comparison says, and nobody else.
TEST(Foreign, MessagesThatDoNotParseAreToldOnce) {
  std::string bytes = file_of({.compression = "", .chunked = false, .summary = false}, {"a", "b", "c"});
  bytes[bytes.rfind('b')] = '\xff';
  testing::internal::CaptureStderr();
  const Comparison c = compare(opened(bytes), opened(bytes));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(c.passed);
  EXPECT_EQ(c.missing.size(), 2u) << "of A and of B";
}

/// Times that go back are legal in the container, and a copy keeps them.
TEST(Foreign, ACopyKeepsTimesThatGoBack) {
  const TestFolder folder("foreign");
  const Form form{.compression = "lz4"};
  std::string bytes{mcap::kMagic};
  bytes += chunk(form, definitions(form) + message(form, 5, "late") + message(form, 1, "early"));
  std::ofstream(folder / "a.mcap", std::ios::binary) << bytes;
  ASSERT_TRUE(recover(folder / "a.mcap", folder / "b.mcap"));
  std::vector<Nanoseconds> times;
  Recording::open(folder / "b.mcap").value().for_each([&](const MessageView& view) {
    times.push_back(view.time);
    return true;
  });
  EXPECT_THAT(times, ElementsAre(5 * kSecond, 1 * kSecond));
}

/// A hole of one chunk of our own recordings: in A as in B.
TEST(Foreign, AHoleIsADifferenceBothWays) {
  const TestFolder folder("hole");
  const auto record = [&](const std::string& file, std::uint64_t from, std::uint64_t to) {
    auto recorder = Recorder::open(folder / file).value();
    SampleRun run(*recorder);
    for (std::uint64_t k = 0; k < 300; ++k)
      if (k < from || k >= to) run.cycle(k);
    recorder->close();
    return Recording::open(folder / file).value();
  };
  const Recording whole = record("whole.mcap", 0, 0);
  for (const std::uint64_t length : {1u, 20u, 200u}) {
    const Recording hole = record("hole.mcap", 90, 90 + length);
    const Comparison a = compare(hole, whole), b = compare(whole, hole);
    EXPECT_FALSE(a.passed) << length;
    EXPECT_FALSE(b.passed) << length;
    EXPECT_FALSE(a.identical);
    EXPECT_FALSE(a.first_difference) << "cycles that one of them lacks are not cycles that differ";
  }
}

}  // namespace
}  // namespace takt::record
