// Plug-ins: what is loaded, and what is refused with which words before any of its code runs.
#include "core/plugin/load.h"

#include <fstream>
#include <iterator>

#include <gmock/gmock.h>

#include "core/base/random.h"
#include "core/base/version.h"
#include "core/net/compiled_net.h"
#include "core/net/registry.h"
#include "core/plugin/about.h"
#include "core/plugin/elf_section.h"
#include "tests/support/reports.h"

namespace takt::plugin {
namespace {

using takt::test::Reports;

using ::testing::AllOf;
using ::testing::ElementsAre;

std::filesystem::path sample(const std::string& name) { return std::filesystem::path(PLUGINS) / (name + ".so"); }

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A file that goes with the test.
class File {
 public:
  explicit File(const std::string& content) : path_(testing::TempDir() + "takt_plugin_test.so") {
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~File() { std::filesystem::remove(path_); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A plug-in with one text of its description exchanged for another of the same length.
std::string falsified(const std::string& plugin, const std::string& text, const std::string& by) {
  std::string bytes = bytes_of(sample(plugin));
  const std::size_t begin = bytes.find(kMagic);
  const std::size_t at = bytes.find(text, begin);
  EXPECT_LT(at, begin + About::kSize) << text;
  bytes.replace(at, by.size(), by);
  return bytes;
}

Diagnostics refusal(const std::filesystem::path& file) {
  const auto loaded = load(file);
  if (loaded) return {};
  EXPECT_FALSE(loaded.error().list().empty());
  return loaded.error();
}

class NoDevices final : public net::Environment {
 public:
  net::Resource* find(std::string_view) override { return nullptr; }
  [[nodiscard]] std::vector<std::string> names() const override { return {}; }
};

TEST(Plugin, LoadsOnceAndItsPrimitiveRunsInANet) {
  ASSERT_EQ(net::Registry::global().find("SampleGain"), nullptr);
  const auto loaded = load(sample("good"));
  ASSERT_TRUE(loaded) << loaded.error().to_string();
  EXPECT_EQ(loaded->name, "good");
  EXPECT_EQ(loaded->version, "1.2.3");
  EXPECT_THAT(loaded->brings, ElementsAre("primitive SampleGain"));
  const net::PrimitiveInfo* info = net::Registry::global().find("SampleGain");
  ASSERT_NE(info, nullptr);
  EXPECT_EQ(info->family, "sample");

  // Its input is a constant, it has no other primitive to end on: LOAD knows its ports and misses the termination only.
  net::NetDescription description;
  description.add("gain", "SampleGain", {{"factor", 3.0}, {"in", 2.0}});
  NoDevices none;
  const auto net = net::CompiledNet::compile(description, none);
  ASSERT_FALSE(net);
  EXPECT_EQ(net.error().list().size(), 1U) << net.error().to_string();
  EXPECT_THAT(net.error(), Reports(Code::kMissing, "/primitives", {"Termination"}));

  EXPECT_THAT(refusal(sample("good")), Reports(Code::kDuplicate, "", {"good"}));
  // A name that is taken refuses the whole plug-in, what was free in it too.
  EXPECT_THAT(refusal(sample("clash")), Reports(Code::kDuplicate, "", {"SampleGain", "sample"}));
  EXPECT_EQ(net::Registry::global().find("SampleOther"), nullptr);
}

TEST(Plugin, FaultyOnesAreFindingsAndAddNothing) {
  EXPECT_THAT(refusal(sample("broken")), Reports(Code::kInvalidName, "", {"furlong//"}));
  EXPECT_THAT(refusal(sample("twice")), Reports(Code::kDuplicate, "", {"SampleOther"}));
  EXPECT_THAT(refusal(sample("empty")), Reports(Code::kMissing, ""));
  EXPECT_THAT(refusal(sample("plain")), Reports(Code::kIncompatible, "", {"TAKT_PLUGIN"}));
  EXPECT_THAT(refusal(sample("lacking")), Reports(Code::kIncompatible, "", {"a_function_of_another_takt"}));
  EXPECT_EQ(net::Registry::global().find("SampleBroken"), nullptr);
  EXPECT_EQ(net::Registry::global().find("SampleOther"), nullptr);
}

TEST(Plugin, OtherVersionAndOtherFlagsAreNamed) {
  const std::string other_version = std::string("takt 9") + std::string(TAKT_VERSION).substr(1) + "\n";
  const File version(falsified("empty", "takt " TAKT_VERSION "\n", other_version));
  EXPECT_THAT(refusal(version.path()),
              Reports(Code::kIncompatible, "", {other_version.substr(5, other_version.size() - 6), TAKT_VERSION}));
  const File interface(falsified("empty", "interface ", "interface 0123456789abcdef"));
  EXPECT_THAT(refusal(interface.path()), Reports(Code::kIncompatible, ""));
  const File alignment(falsified("empty", "eigen_alignment ", "eigen_alignment 64"));
  EXPECT_THAT(refusal(alignment.path()), Reports(Code::kIncompatible, "", {"64", "eigen_alignment"}));
}

TEST(Plugin, WhatIsNoSharedObjectIsRefusedUnread) {
  EXPECT_THAT(refusal("no/such.so"), Reports(Code::kNotFound, ""));
  EXPECT_THAT(refusal(std::filesystem::path(PLUGINS)), Reports(Code::kFileNotReadable, ""));
  const File empty("");
  EXPECT_THAT(refusal(empty.path()), Reports(Code::kFileNotReadable, ""));
  const File text("#!/bin/sh\necho hello\n");
  EXPECT_THAT(refusal(text.path()), Reports(Code::kFileNotReadable, ""));
  std::string bytes = bytes_of(sample("good"));
  bytes[18] = 0x28;  // EM_ARM
  const File foreign(bytes);
  EXPECT_THAT(refusal(foreign.path()), Reports(Code::kIncompatible, ""));
}

TEST(Plugin, DamagedFilesAreReadWithinTheirBounds) {
  const std::string good = bytes_of(sample("good"));
  for (std::size_t cut = 0; cut < good.size(); cut += 1 + good.size() / 200) {
    const File file(good.substr(0, cut));
    EXPECT_FALSE(read_elf_section(file.path(), kSection).has_value() &&
                 read_elf_section(file.path(), kSection)->size() > 2 * About::kSize);
  }
  Random random(1, "damage");
  for (int i = 0; i < 500; ++i) {
    std::string bytes = good;
    // The header of the file and the table of its sections are what is read.
    for (int k = 0; k < 4; ++k)
      bytes[static_cast<std::size_t>(random.unit() * 64)] = static_cast<char>(random.unit() * 256);
    const std::size_t tail = bytes.size() - 1 - static_cast<std::size_t>(random.unit() * 1900);
    bytes[tail] = static_cast<char>(random.unit() * 256);
    const File file(bytes);
    const auto section = read_elf_section(file.path(), kSection);
    if (section) (void)check_about(*section);
  }
}

TEST(Plugin, DescriptionsOfAnyBytesAreRefused) {
  EXPECT_TRUE(check_about("").has_errors());
  EXPECT_TRUE(check_about(std::string(kMagic)).has_errors());
  EXPECT_TRUE(check_about(std::string(kMagic) + "takt\n\n takt \nname").has_errors());
  EXPECT_TRUE(check_about(std::string(kMagic) + std::string(5000, 'x')).has_errors());
  EXPECT_FALSE(check_about(about_plugin("a", "1").view()).has_errors());
}

}  // namespace
}  // namespace takt::plugin
