#include "core/base/utf8.h"

#include <gtest/gtest.h>

namespace takt {
namespace {

TEST(Utf8, TextIsCutBetweenCharacters) {
  const std::string text = "a\u00e9\u20ac\U0001F600z";  // 1 + 2 + 3 + 4 + 1 bytes
  const std::size_t ends[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 11};
  for (std::size_t most = 0; most < std::size(ends); ++most) {
    EXPECT_EQ(cut_utf8(text, most).size(), ends[most]) << most;
    EXPECT_TRUE(is_utf8(cut_utf8(text, most))) << most;
  }
  EXPECT_EQ(cut_utf8(text, 100), text);
  EXPECT_EQ(cut_utf8("", 0), "");
}

TEST(Utf8, BytesThatAreNoTextAreCutAnywhere) { EXPECT_EQ(cut_utf8(std::string(100, '\x80'), 50).size(), 50u); }

TEST(Utf8, EverySequenceThatTheStandardForbidsIsFound) {
  EXPECT_TRUE(is_utf8("plain, \u00e9, \u20ac, \U0001F600, \U0010FFFF"));
  for (const std::string_view wrong :
       {"\x80", "\xC3", "\xC0\x80", "\xC1\xBF", "\xE0\x80\x80", "\xED\xA0\x80", "\xE2\x82", "\xF0\x80\x80\x80",
        "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF", "\xC3z"}) {
    EXPECT_FALSE(is_utf8(wrong));
    EXPECT_TRUE(is_utf8(to_valid_utf8(wrong)));
  }
}

TEST(Utf8, WhatIsValidStaysWhenTheRestIsReplaced) {
  EXPECT_EQ(to_valid_utf8("a\xC3\u20ac\xFFz"), "a\uFFFD\u20ac\uFFFDz");
  EXPECT_EQ(to_valid_utf8("\u20ac"), "\u20ac");
}

TEST(Utf8, WhatADeviceSaysCannotSteerATerminal) {
  EXPECT_EQ(escape_controls("UR5\n\x1b[2J\x7f"), "UR5\\x0a\\x1b[2J\\x7f");
  EXPECT_EQ(escape_controls(std::string_view("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(escape_controls("\u20ac\xFF"), "\u20ac\uFFFD");
}

}  // namespace
}  // namespace takt
