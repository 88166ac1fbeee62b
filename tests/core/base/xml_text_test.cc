#include "core/base/xml_text.h"

#include <gtest/gtest.h>

namespace takt {
namespace {

TEST(XmlText, MarksOfTheLanguageBecomeEntities) {
  EXPECT_EQ(xml_text(R"(<a href="x">1 & 2</a>)"), "&lt;a href=&quot;x&quot;&gt;1 &amp; 2&lt;/a&gt;");
}

TEST(XmlText, ControlCharactersBecomeBlanksAndLineBreaksStay) {
  EXPECT_EQ(xml_text(std::string_view("a\0b\tc\nd\x1b", 8)), "a b c\nd ");
}

TEST(XmlText, OtherBytesStay) { EXPECT_EQ(xml_text("Größe 5 µm"), "Größe 5 µm"); }

}  // namespace
}  // namespace takt
