// RTDE on the wire: golden bytes, streams cut anywhere, sizes that lie, and the tables of fields.
#include <set>

#include <gtest/gtest.h>

#include "hw/rtde/message.h"

namespace takt::hw::rtde {
namespace {

std::string bytes(std::initializer_list<int> list) {
  std::string out;
  for (const int byte : list) out.push_back(static_cast<char>(byte));
  return out;
}

TEST(RtdeWire, GoldenBytes) {
  std::string version;
  append(version, std::uint16_t{2});
  EXPECT_EQ(make_package(PackageType::kProtocolVersion, version), bytes({0, 5, 0x56, 0, 2}));
  EXPECT_EQ(make_package(PackageType::kControllerVersion), bytes({0, 3, 0x76}));
  EXPECT_EQ(encode_version({3, 15, 8, 106339}).substr(0, 3), bytes({0, 0x13, 0x76}));
  EXPECT_EQ(encode_output_request(125.0, "timestamp", 2),
            bytes({0, 0x14, 0x4f, 0x40, 0x5f, 0x40, 0, 0, 0, 0, 0}) + "timestamp");
  EXPECT_EQ(encode_setup_reply(PackageType::kSetupOutputs, 1, "DOUBLE", true), bytes({0, 0xa, 0x4f, 1}) + "DOUBLE");
  EXPECT_EQ(make_package(PackageType::kStart), bytes({0, 3, 0x53}));
}

TEST(RtdeWire, MessagesComeBackAsTheyWere) {
  for (const int protocol : {1, 2}) {
    const std::string package = encode(TextMessage{TextMessage::Level::kWarning, "hello", "me"}, protocol);
    const auto message = decode_text(std::string_view(package).substr(kHeaderSize), protocol);
    ASSERT_TRUE(message);
    EXPECT_EQ(message->text, "hello");
    EXPECT_EQ(message->source, protocol == 2 ? "me" : "");
    EXPECT_EQ(message->level, TextMessage::Level::kWarning);
    const std::string request = encode_output_request(62.5, "a,b,", protocol);
    const auto outputs = decode_output_request(std::string_view(request).substr(kHeaderSize), protocol);
    ASSERT_TRUE(outputs);
    EXPECT_EQ(outputs->frequency, protocol == 2 ? 62.5 : 0.0);
    EXPECT_EQ(outputs->names, (std::vector<std::string_view>{"a", "b"}));
  }
  EXPECT_FALSE(decode_text(bytes({9, 'a'}), 2)) << "it announces more than there is";
  EXPECT_FALSE(decode_text("", 1));
  EXPECT_FALSE(decode_version("short"));
  EXPECT_FALSE(decode_output_request("short", 2));
  EXPECT_FALSE(decode_setup_reply("", true));
}

TEST(RtdeWire, ValuesOfEveryTypeComeBack) {
  const FieldValue value = {1.0, 0.0, 1.0, 3.0, 4.0, 5.0};
  for (int i = 0; i <= static_cast<int>(FieldType::kVector6Uint32); ++i) {
    const auto type = static_cast<FieldType>(i);
    std::string out;
    append_value(out, type, value);
    EXPECT_EQ(out.size(), wire_size(type)) << name_of(type);
    ByteReader reader(out);
    const FieldValue back = take_value(reader, type);
    for (std::size_t j = 0; j < element_count(type); ++j) EXPECT_EQ(back[j], value[j]) << name_of(type);
    EXPECT_TRUE(reader.ok() && reader.left() == 0);
    EXPECT_EQ(field_type_of(name_of(type)), type);
    ByteReader cut(std::string_view(out).substr(1));
    (void)take_value(cut, type);
    EXPECT_FALSE(cut.ok()) << name_of(type);
  }
  EXPECT_FALSE(field_type_of("NOT_FOUND"));
}

TEST(RtdeWire, NumbersThatATypeCannotHoldAreTheNearest) {
  std::string out;
  append_value(out, FieldType::kInt32, {1e300});
  append_value(out, FieldType::kInt32, {std::numeric_limits<double>::quiet_NaN()});
  append_value(out, FieldType::kUint8, {-5.0});
  ByteReader reader(out);
  EXPECT_EQ(reader.take<std::int32_t>(), std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(reader.take<std::int32_t>(), 0);
  EXPECT_EQ(reader.take<std::uint8_t>(), 0);
}

/// Three packages, cut at every place.
TEST(RtdeWire, AStreamMayBeCutAnywhere) {
  const std::string stream = make_package(PackageType::kStart) + make_package(PackageType::kData, "payload") +
                             make_package(PackageType::kPause, std::string(300, 'x'));
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    PackageParser parser;
    std::string seen;
    for (const std::string& part : {stream.substr(0, cut), stream.substr(cut)}) {
      ASSERT_TRUE(parser.feed(part));
      while (const auto package = parser.next())
        seen += std::string(1, static_cast<char>(package->type)) + std::to_string(package->payload.size());
    }
    EXPECT_EQ(seen, "S0U7P300") << "cut at " << cut;
    EXPECT_EQ(parser.pending(), 0u);
  }
  PackageParser parser;
  int count = 0;
  for (const char byte : stream) {
    (void)parser.feed({&byte, 1});
    while (parser.next()) ++count;
  }
  EXPECT_EQ(count, 3);
}

TEST(RtdeWire, ASizeThatNoPackageHasBreaksTheStream) {
  for (const int size : {0, 1, 2}) {
    PackageParser parser;
    EXPECT_TRUE(parser.feed(bytes({0, size, 'S', 0, 3, 'S'})));
    EXPECT_FALSE(parser.next());
    EXPECT_TRUE(parser.broken());
    EXPECT_FALSE(parser.feed(make_package(PackageType::kStart)));
    EXPECT_FALSE(parser.next());
  }
  PackageParser parser;
  EXPECT_TRUE(parser.feed(bytes({0xff, 0xff, 'U'}) + std::string(65'531, 'x')));
  EXPECT_FALSE(parser.next()) << "one byte is missing";
  EXPECT_TRUE(parser.feed("x"));
  ASSERT_TRUE(parser.next());
}

TEST(RtdeWire, APayloadThatIsTooLongIsCutOff) {
  EXPECT_EQ(make_package(PackageType::kText, std::string(100'000, 'x')).size(), kLargestPackage);
}

TEST(RtdeFields, NamesAreUniqueAndFound) {
  for (const FieldTable* table : {&output_fields(), &input_fields()}) {
    std::set<std::string> names;
    for (FieldTable::Id i = 0; i < table->size(); ++i) {
      EXPECT_TRUE(names.insert((*table)[i].name).second) << (*table)[i].name;
      EXPECT_EQ(table->find((*table)[i].name), i);
    }
    EXPECT_FALSE(table->find("no_such_field"));
    EXPECT_FALSE(table->find(""));
  }
}

TEST(RtdeFields, SeriesAndVersionsDecideWhatThereIs) {
  const Version cb3 = {3, 15, 8, 0}, old = {3, 3, 0, 0}, e = {5, 12, 0, 0};
  const auto offered = [](const char* name, const Version& version) {
    return output_fields()[output_fields().at(name)].offered_by(version);
  };
  EXPECT_TRUE(offered("timestamp", old) && offered("timestamp", e));
  EXPECT_FALSE(offered("output_int_register_0", old));
  EXPECT_TRUE(offered("output_int_register_0", cb3));
  EXPECT_TRUE(offered("output_int_register_47", cb3));
  EXPECT_FALSE(offered("output_int_register_24", {3, 8, 9, 0}));
  EXPECT_FALSE(offered("ft_raw_wrench", cb3));
  EXPECT_TRUE(offered("ft_raw_wrench", e));
  EXPECT_FALSE(offered("actual_current_as_torque", e));
  EXPECT_FALSE(output_fields().find("output_bit_register_0")) << "the lower bits are words only";
  EXPECT_EQ(cb3.frequency(), 125);
  EXPECT_EQ(e.frequency(), 500);
}

TEST(RtdeFields, RegistersStandInTheOrderOfTheirNumbers) {
  for (const FieldTable* table : {&output_fields(), &input_fields()})
    for (const std::string kind : {"input_int_register_", "input_double_register_"})
      for (int i = 0; i < 48; ++i) EXPECT_EQ(table->at(kind + std::to_string(i)), table->at(kind + "0") + i);
}

TEST(RtdeFields, NamesAreSplitAtCommas) {
  EXPECT_EQ(split_names("a,b,,c,"), (std::vector<std::string_view>{"a", "b", "c"}));
  EXPECT_TRUE(split_names("").empty());
  EXPECT_TRUE(split_names(",,,").empty());
}

TEST(RtdeFields, NoNameIsFoundTwiceOrInPart) {
  for (const FieldTable* table : {&output_fields(), &input_fields()}) {
    const auto names = table->names();
    EXPECT_GT(names.size(), 100u);
    for (const std::string& name : names) {
      EXPECT_TRUE(table->find(name)) << name;
      EXPECT_FALSE(table->find(name + "~")) << name;
    }
    EXPECT_FALSE(table->find("~")) << "behind the last";
  }
}

TEST(RtdeWire, ASetUpIsAnsweredWithOrWithoutANumber) {
  for (const bool with_id : {false, true}) {
    const std::string package = encode_setup_reply(PackageType::kSetupOutputs, 7, "DOUBLE,VECTOR6D", with_id);
    const auto reply = decode_setup_reply(std::string_view(package).substr(kHeaderSize), with_id);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->id, with_id ? 7 : 1);
    EXPECT_EQ(reply->words.size(), 2u);
  }
}

TEST(RtdeWire, TypesOfPackagesHaveTheirNames) {
  std::string all;
  for (const PackageType type :
       {PackageType::kProtocolVersion, PackageType::kControllerVersion, PackageType::kText, PackageType::kData,
        PackageType::kSetupOutputs, PackageType::kSetupInputs, PackageType::kStart, PackageType::kPause})
    all += std::string(name_of(type)) + " ";
  EXPECT_EQ(all,
            "REQUEST_PROTOCOL_VERSION GET_URCONTROL_VERSION TEXT_MESSAGE DATA_PACKAGE SETUP_OUTPUTS SETUP_INPUTS START "
            "PAUSE ");
  EXPECT_EQ(name_of(static_cast<PackageType>(0)), "unknown");
}

}  // namespace
}  // namespace takt::hw::rtde
