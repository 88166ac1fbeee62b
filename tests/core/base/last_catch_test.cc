#include "core/base/last_catch.h"

#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt {
namespace {

using testing::HasSubstr;
using testing::internal::CaptureStderr;
using testing::internal::GetCapturedStderr;

template <class Exception>
std::string said_of(const Exception& exception) {
  CaptureStderr();
  bool done = true;
  std::thread([&] { done = run_caught("load net 'reach'", [&] { throw exception; }); }).join();
  EXPECT_FALSE(done);
  return GetCapturedStderr();
}

TEST(LastCatch, AnExceptionOfAThreadIsReportedWithWhatWasBeingDone) {
  EXPECT_EQ(said_of(std::runtime_error("no such port")),
            "takt: error: internal: no such port; while doing: load net 'reach'\n");
  EXPECT_THAT(said_of(std::bad_alloc()), HasSubstr("internal: out of memory; while doing: load net 'reach'"));
  EXPECT_THAT(said_of(42), HasSubstr("internal: an exception of unknown type; while doing:"));
}

TEST(LastCatch, WhatGoesWellSaysNothing) {
  CaptureStderr();
  int done = 0;
  EXPECT_TRUE(run_caught("count", [&] { ++done; }));
  EXPECT_EQ(GetCapturedStderr(), "");
  EXPECT_EQ(done, 1);
}

TEST(LastCatch, LongTextsAreCutAndTheLineStaysWhole) {
  const std::string said = said_of(std::runtime_error(std::string(100'000, 'x')));
  EXPECT_LT(said.size(), 1000u);
  EXPECT_THAT(said, HasSubstr("x; while doing: load net 'reach'\n"));
}

TEST(LastCatch, RepeatedReportsGetRare) {
  RareReport report;
  int told = 0;
  for (int i = 0; i < 1000; ++i) told += report.next() ? 1 : 0;
  EXPECT_EQ(told, 10);  // 1, 2, 4 ... 512
  EXPECT_EQ(report.count(), 1000u);
}

}  // namespace
}  // namespace takt
