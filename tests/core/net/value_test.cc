#include "core/net/value.h"

#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/net/primitive.h"
#include "core/net/value_json.h"
#include "tests/support/primitive_harness.h"

namespace takt::net {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

template <class T>
Slot<T> sent(const T& value) {
  Slot<T> slot;
  Out<T>(&slot).set(value);
  return slot;
}

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

TEST(Value, RowsN1N5RealIsCanonicalOrNull) {
  EXPECT_FALSE(std::signbit(sent(-0.0).value));
  for (const double bad : {kNan, -kNan, kInf, -kInf}) {
    EXPECT_EQ(sent(bad).null, 1u);
    EXPECT_TRUE(same_bits(sent(bad).value, 0.0));
  }
  for (const double good : {1.0, -1.0, 5e-324, -5e-324, 1.7976931348623157e308}) {
    EXPECT_TRUE(same_bits(sent(good).value, good));
    EXPECT_EQ(sent(good).null, 0u);
  }
}

TEST(Value, RowsN1N5EveryComponentIsLookedAt) {
  for (int i = 0; i < 3; ++i) {
    Vector v(1, 2, 3);
    v[i] = kNan;
    EXPECT_EQ(sent(v).null, 1u);
    EXPECT_EQ(sent(Twist{v, Vector::Zero()}).null, 1u);
    EXPECT_EQ(sent(Twist{Vector::Zero(), v}).null, 1u);
    EXPECT_EQ(sent(Wrench{v, Vector::Zero()}).null, 1u);
    EXPECT_EQ(sent(Wrench{Vector::Zero(), v}).null, 1u);
    Frame f = Frame::Identity();
    f.translation() = v;
    EXPECT_EQ(sent(f).null, 1u);
    v[i] = -0.0;
    EXPECT_FALSE(std::signbit(sent(v).value[i]));
  }
  for (int i = 0; i < 4; ++i) {
    Rotation q(0.5, 0.5, 0.5, 0.5);
    q.coeffs()[i] = kInf;
    EXPECT_EQ(sent(q).null, 1u);
  }
}

TEST(Value, FramesHaveOneLastRow) {
  Frame f;
  f.matrix().setConstant(kNan);
  f.linear().setIdentity();
  f.translation() << -0.0, 1, 2;
  const auto slot = sent(f);
  EXPECT_EQ(slot.null, 0u);
  EXPECT_EQ(slot.value.matrix().row(3), Eigen::RowVector4d(0, 0, 0, 1));
  EXPECT_FALSE(std::signbit(slot.value.translation().x()));
}

TEST(Value, JointArraysKeepUnusedEntriesZero) {
  JointArray joints;
  joints.value.fill(-0.0);
  joints.value[9] = kNan;
  joints.size = 3;
  const auto slot = sent(joints);
  EXPECT_EQ(slot.null, 0u) << "what lies past the size does not count";
  for (const double entry : slot.value.value) EXPECT_TRUE(same_bits(entry, 0.0));
  joints.size = 10;
  EXPECT_EQ(sent(joints).null, 1u);
  for (const std::int64_t size : {std::int64_t{-1}, std::int64_t{13}, std::numeric_limits<std::int64_t>::max()}) {
    joints = JointArray();
    joints.size = size;
    EXPECT_EQ(sent(joints).null, 1u) << size;
  }
  EXPECT_EQ(sent(JointArray(Eigen::VectorXd::Ones(20))).null, 1u) << "too many joints are null, not cut";
}

TEST(Value, TextIsCutAtACharacter) {
  EXPECT_EQ(Text("abc").view(), "abc");
  EXPECT_EQ(Text(std::string(100, 'x')).view().size(), 63u);
  EXPECT_EQ(Text(std::string(62, 'x') + "\u00fc").view(), std::string(62, 'x'));
  Text text("abc");
  text.size = 2;
  EXPECT_TRUE(same_bits(sent(text).value, Text("ab")));
}

TEST(Value, JsonRoundTripOfRandomValues) {
  Random random(5);
  for (int round = 0; round < 200; ++round) {
    for (int t = 0; t <= static_cast<int>(ValueType::kJoints); ++t) {
      visit_type(static_cast<ValueType>(t), [&]<class T>(std::type_identity<T>) {
        T value = test::harness::random_value<T>(random);
        canonicalise(value);
        T again = null_payload<T>();
        const Diagnostics diagnostics =
            value_from_json(nlohmann::ordered_json::parse(value_to_json(value).dump()), again);
        ASSERT_TRUE(diagnostics.empty()) << diagnostics.to_string();
        if constexpr (std::is_same_v<T, Frame>) {
          ASSERT_TRUE(again.isApprox(value, 1e-12));
        } else if constexpr (std::is_same_v<T, Rotation>) {
          ASSERT_TRUE(again.isApprox(value, 1e-12));
        } else {
          ASSERT_TRUE(same_bits(again, value)) << value_to_json(value).dump();
        }
      });
    }
  }
}

TEST(Value, Ranges) {
  EXPECT_TRUE(check_range(0.5, "[0,1]").empty());
  EXPECT_TRUE(check_range(0.0, "[0,1]").empty());
  EXPECT_FALSE(check_range(0.0, "(0,1]").empty());
  EXPECT_FALSE(check_range(1.0, "(0,1)").empty());
  EXPECT_TRUE(check_range(1e300, "(0,inf)").empty());
  EXPECT_TRUE(check_range(-1e300, "(-inf,0)").empty());
  EXPECT_FALSE(check_range(Integer{0}, "[1,5]").empty());
  EXPECT_EQ(check_range(Vector(1, -1, -1), "[0,inf)").list().size(), 2u);
  EXPECT_EQ(check_range(Vector(1, -1, 1), "[0,inf)").list()[0].pointer, "/1");
  EXPECT_TRUE(check_range(std::string("b"), "a|b").empty());
  EXPECT_FALSE(check_range(std::string("c"), "a|b").empty());
  EXPECT_DEATH((void)check_range(1.0, "0..1"), "malformed range");
}

}  // namespace
}  // namespace takt::net
