#include "record/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/random.h"
#include "record/golden.h"
#include "tests/record/support.h"
#include "tests/support/reports.h"

namespace takt::record {
namespace {

using takt::test::Reports;

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// A run of `cycles` cycles in memory; `disturb` adds to the first joint in each cycle.
Recording run(
    std::uint64_t cycles, const std::function<double(std::uint64_t)>& disturb = [](std::uint64_t) { return 0.0; }) {
  TestFolder folder("compare");
  RecorderOptions options;
  options.fingerprint = {{"takt", "0.1.0"}, {"cpu", "x86_64: avx2"}};
  auto recorder = Recorder::open(folder / "a.mcap", options).value();
  SampleRun sample(*recorder);
  for (std::uint64_t k = 0; k < cycles; ++k) sample.cycle(k, disturb(k));
  recorder->close();
  return Recording::open(folder / "a.mcap").value();
}

const ColumnComparison& column(const Comparison& comparison, std::string_view topic, std::string_view name) {
  const auto found = std::ranges::find_if(
      comparison.columns, [&](const ColumnComparison& c) { return c.topic == topic && c.column == name; });
  EXPECT_NE(found, comparison.columns.end()) << topic << " " << name;
  return *found;
}

TEST(Compare, EqualRunsAreIdentical) {
  const Comparison c = compare(run(200), run(200));
  EXPECT_TRUE(c.identical);
  EXPECT_TRUE(c.passed);
  EXPECT_FALSE(c.first_difference);
  EXPECT_THAT(c.missing, IsEmpty());
  EXPECT_THAT(c.notes, IsEmpty());
  EXPECT_EQ(c.cycles_a, 200u);
  for (const ColumnComparison& each : c.columns) EXPECT_EQ(each.max_difference, 0.0) << each.topic << each.column;
  EXPECT_THAT(to_text(c), HasSubstr("identical"));
}

/// However little fits into memory at a time, down to one column, the answer is the same.
TEST(Compare, InPassesAsInOne) {
  const Recording a = run(200, [](std::uint64_t k) { return k >= 137 ? 1e-2 : 0.0; }), b = run(200);
  const Comparison whole = compare(a, b);
  for (const std::size_t values : {std::size_t{800}, std::size_t{1000}, std::size_t{3000}}) {
    CompareOptions options;
    options.values_at_a_time = values;
    EXPECT_EQ(to_json(compare(a, b, options)), to_json(whole)) << values;
  }
  CompareOptions too_little;
  too_little.values_at_a_time = 799;
  EXPECT_THAT(compare(a, b, too_little).missing, testing::Contains(HasSubstr("too many messages to be compared")));
}

TEST(Compare, AFilmNeedsARowAPictureOnly) {
  const Recording recording = run(200);
  const Table all = recording.table("/sim/state").value();
  const Table few = recording.table_every("/sim/state", 40 * kMillisecond).value();
  ASSERT_EQ(few.columns, all.columns);
  EXPECT_EQ(recording.rows("/sim/state"), 200u);
  EXPECT_THAT(few.time, ElementsAre(0, 40 * kMillisecond, 80 * kMillisecond, 120 * kMillisecond, 160 * kMillisecond));
  for (std::size_t i = 0; i < few.time.size(); ++i) EXPECT_EQ(few.values[0][i], all.values[0][40 * i]);
}

TEST(Compare, TheFirstDifferingCycleIsNamed) {
  const Comparison c = compare(run(200, [](std::uint64_t k) { return k >= 137 ? 1e-9 : 0.0; }), run(200));
  EXPECT_FALSE(c.identical);
  ASSERT_TRUE(c.first_difference);
  EXPECT_EQ(c.first_difference->cycle, 137u);
  EXPECT_EQ(c.first_difference->time, 137 * kMillisecond);
  EXPECT_EQ(c.first_difference->a, c.first_difference->b + 1);
  EXPECT_TRUE(c.passed) << "a nanoradian is inside of every tolerance";
  CompareOptions strict;
  strict.require_equal_digests = true;
  EXPECT_FALSE(compare(run(200, [](std::uint64_t) { return 1e-9; }), run(200), strict).passed);
}

TEST(Compare, BothEndsOfAToleranceArePinned) {
  CompareOptions options;
  options.rules = {{"/left/joints", "a1.position", {.kind = ToleranceKind::kTube, .dt = 0, .dv = 0.01}}};
  const auto with = [&](double size) {
    return compare(run(200, [size](std::uint64_t k) { return k == 77 ? size : 0.0; }), run(200), options);
  };
  EXPECT_TRUE(with(0.0099).passed);
  const Comparison failed = with(0.0101);
  EXPECT_FALSE(failed.passed);
  const ColumnComparison& c = column(failed, "/left/joints", "a1.position");
  EXPECT_FALSE(c.passed);
  EXPECT_EQ(c.samples_outside, 1u);
  EXPECT_NEAR(c.max_deviation, 0.0101, 1e-12);
  EXPECT_EQ(c.time, 77 * kMillisecond);
  EXPECT_NEAR(c.a - c.b, 0.0101, 1e-12);
  EXPECT_TRUE(column(failed, "/left/joints", "a2.position").passed);
  EXPECT_THAT(to_text(failed),
              AllOf(HasSubstr("different"), HasSubstr("outside: /left/joints a1.position: 0.0101 rad")));
}

TEST(Compare, EveryClassOfToleranceJudgesItsOwnWay) {
  const auto judged_by = [](ToleranceKind kind, double size) {
    CompareOptions options;
    options.rules = {{"/left/joints", "a1.*", {.kind = kind, .dt = 0, .dv = 0.05}}};
    return column(compare(run(200, [size](std::uint64_t k) { return k == 50 ? size : 0.0; }), run(200), options),
                  "/left/joints", "a1.position");
  };
  EXPECT_FALSE(judged_by(ToleranceKind::kExact, 1e-12).passed);
  EXPECT_TRUE(judged_by(ToleranceKind::kExact, 0.0).passed);
  EXPECT_FALSE(judged_by(ToleranceKind::kTube, 0.1).passed);
  EXPECT_TRUE(judged_by(ToleranceKind::kReportOnly, 100.0).passed);
  EXPECT_EQ(judged_by(ToleranceKind::kReportOnly, 100.0).max_deviation, 100.0);
  // sin(0.003 k) is 0.15 at the spike and 0.56 at the end: a spike of 0.1 changes neither peak nor end.
  EXPECT_TRUE(judged_by(ToleranceKind::kFeatures, 0.1).passed);
  const ColumnComparison peak = judged_by(ToleranceKind::kFeatures, 1.0);
  EXPECT_FALSE(peak.passed);
  ASSERT_EQ(peak.features.size(), kFeatureCount);
  EXPECT_EQ(peak.features[0].name, "max");
  EXPECT_FALSE(peak.features[0].passed);
  EXPECT_TRUE(peak.features[3].passed);
  EXPECT_TRUE(peak.features[4].passed) << "reported, not judged";
  EXPECT_FALSE(peak.features[4].judged);
}

TEST(Compare, NullAgainstAValueIsNeverClose) {
  TestFolder folder("null");
  const auto record = [&](const std::string& name, std::uint64_t null_at) {
    auto recorder = Recorder::open(folder / name).value();
    const ChannelId id = recorder->add_samples("/x", {"v"});
    for (std::uint64_t k = 0; k < 100; ++k) {
      recorder->begin_cycle(static_cast<Nanoseconds>(k) * kMillisecond, k);
      recorder->write(id, std::vector<double>{k / 10 == null_at ? NAN : 1.0});
    }
    recorder->close();
    return Recording::open(folder / name).value();
  };
  const Comparison c = compare(record("a", 3), record("b", 7));
  EXPECT_FALSE(c.passed);
  EXPECT_TRUE(std::isinf(column(c, "/x", "v").max_deviation));
  EXPECT_TRUE(compare(record("a", 3), record("b", 3)).passed);
  EXPECT_TRUE(to_json(c).at("columns").back().at("max_deviation").is_null());
}

TEST(Compare, AShorterRunAndMissingTopicsFail) {
  const Comparison shorter = compare(run(150), run(200));
  EXPECT_FALSE(shorter.passed);
  EXPECT_FALSE(column(shorter, "run", "end").passed);
  EXPECT_FALSE(column(shorter, "/events", "events").passed);
  EXPECT_THAT(column(shorter, "/events", "events").note, HasSubstr("4 events, not 5"));

  TestFolder folder("missing");
  {
    auto recorder = Recorder::open(folder / "a.mcap").value();
    recorder->add_samples("/other", {"x"});
    recorder->begin_cycle(199 * kMillisecond, 0);
  }
  const Comparison c = compare(Recording::open(folder / "a.mcap").value(), run(200));
  EXPECT_FALSE(c.passed);
  EXPECT_THAT(c.missing, ::testing::Contains("topic '/other' is only in A"));
  EXPECT_THAT(c.missing, ::testing::Contains("topic '/left/joints' is only in B"));
}

TEST(Compare, EventsAreASequenceWithWindows) {
  TestFolder folder("events");
  const auto record = [&](const std::string& file, const std::vector<std::pair<int, std::string>>& events) {
    auto recorder = Recorder::open(folder / file).value();
    const ChannelId id = recorder->add_events("/events");
    for (int k = 0; k < 100; ++k) {
      recorder->begin_cycle(k * kMillisecond, static_cast<std::uint64_t>(k));
      for (const auto& [at, name] : events) {
        if (at == k) recorder->event(id, "net", name, "text");
      }
    }
    recorder->close();
    return Recording::open(folder / file).value();
  };
  const auto events = [&](const std::vector<std::pair<int, std::string>>& a) {
    return column(compare(record("a", a), record("b", {{10, "start"}, {50, "contact"}})), "/events", "events");
  };
  EXPECT_TRUE(events({{10, "start"}, {55, "contact"}}).passed) << "5 ms is the window";
  EXPECT_THAT(events({{10, "start"}, {56, "contact"}}).note, HasSubstr("'net contact' at 0.056000 s, not 0.050000 s"));
  EXPECT_THAT(events({{10, "contact"}, {50, "start"}}).note, HasSubstr("event 1 is 'net contact', not 'net start'"));
  EXPECT_FALSE(events({{10, "start"}}).passed);
}

TEST(Compare, OtherMachinesAndTornFilesAreTold) {
  TestFolder folder("notes");
  RecorderOptions options;
  options.fingerprint = {{"takt", "0.1.0"}, {"cpu", "x86_64: avx512f"}};
  record_run(folder / "a.mcap", 200, options);
  const std::string bytes = bytes_of(folder / "a.mcap");
  const Comparison c = compare(Recording::from_bytes(bytes.substr(0, bytes.size() - 5)).value(), run(200));
  EXPECT_THAT(c.notes, ElementsAre(HasSubstr("truncated at byte"), "cpu: 'x86_64: avx512f' in A, 'x86_64: avx2' in B"));
  EXPECT_TRUE(c.identical);
}

TEST(Compare, FilesAreOpenedWithAllFindings) {
  const auto c = compare_recordings("/no/a.mcap", "/no/b.mcap");
  ASSERT_FALSE(c);
  EXPECT_EQ(c.error().list().size(), 2u);
}

TEST(Compare, TheReportHasTheCurvesAndNoForeignText) {
  Comparison c = compare(run(200, [](std::uint64_t k) { return k > 90 ? 0.2 : 0.0; }), run(200));
  c.name_a = "<script>alert(1)</script>";
  const std::string page = to_html(c);
  EXPECT_THAT(page, AllOf(HasSubstr("<svg"), HasSubstr("Different"), HasSubstr("a1.position"),
                          HasSubstr("equal before cycle 91")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;"));
  EXPECT_EQ(page.find("<script>"), page.rfind("<script>"))
      << "names from files are text; the one script is the report's";
  EXPECT_THAT(page, Not(HasSubstr("http"))) << "nothing is loaded from elsewhere";
  EXPECT_LT(page.size(), 3u << 20);
  TestFolder folder("report");
  EXPECT_TRUE(write_report(c, folder / "r.html"));
  EXPECT_EQ(bytes_of(folder / "r.html"), page);
  EXPECT_FALSE(write_report(c, "/nowhere/r.html"));
}

TEST(Compare, JsonHoldsTheVerdict) {
  const auto json = to_json(compare(run(200, [](std::uint64_t k) { return k > 90 ? 0.2 : 0.0; }), run(200)));
  EXPECT_FALSE(json.at("passed"));
  EXPECT_EQ(json.at("first_difference").at("cycle"), 91);
  EXPECT_EQ(json.at("columns").size(), 3 + 9 + 8 + 6 + 3 + 3u) << "an orientation is one column";
}

/// A run of 100 cycles whose frame is turned by `angle` about z, and told as q or -q.
Recording turned(const std::function<double(int)>& angle, double sign = 1.0) {
  TestFolder folder("turned");
  auto recorder = Recorder::open(folder / "a.mcap").value();
  const ChannelId frames = recorder->add_transforms("/tf", {{"world", "part"}});
  for (int k = 0; k < 100; ++k) {
    recorder->begin_cycle(k * 20 * kMillisecond, static_cast<std::uint64_t>(20 * k));
    const double half = angle(k) / 2;
    recorder->write(frames, std::vector<double>{0, 0, 0, sign * std::cos(half), 0, 0, sign * std::sin(half)});
  }
  recorder->close();
  return Recording::open(folder / "a.mcap").value();
}

TEST(Compare, OrientationsAreComparedAsAngles) {
  const auto slow = [](int k) { return 0.01 * k; };
  const auto judged = [&](const Recording& a, double dv, Nanoseconds dt = 0) {
    CompareOptions options;
    options.rules = {{"/tf", "part.rotation", {.kind = ToleranceKind::kTube, .dt = dt, .dv = dv}}};
    return column(compare(a, turned(slow), options), "/tf", "part.rotation");
  };
  EXPECT_EQ(judged(turned(slow), 0.0).max_deviation, 0.0);
  EXPECT_LT(judged(turned(slow, -1.0), 1e-9).max_deviation, 1e-9) << "q and -q are the same orientation";
  const Recording off = turned([&](int k) { return slow(k) + (k == 40 ? 0.05 : 0.0); });
  EXPECT_TRUE(judged(off, 0.0501).passed);
  const ColumnComparison outside = judged(off, 0.0499);
  EXPECT_FALSE(outside.passed);
  EXPECT_EQ(outside.unit, "rad");
  EXPECT_NEAR(outside.max_deviation, 0.05, 1e-9);
  EXPECT_EQ(outside.time, 800 * kMillisecond);
  // Two samples late is 0.02 rad off at equal times, and nothing within the freedom in time.
  const Recording late = turned([&](int k) { return slow(std::max(0, k - 2)); });
  EXPECT_NEAR(judged(late, 0.1).max_deviation, 0.02, 1e-9);
  EXPECT_LT(judged(late, 0.1, 40 * kMillisecond).max_deviation, 1e-9);
  EXPECT_NEAR(judged(late, 0.1, 40 * kMillisecond).max_difference, 0.02, 1e-9);
  CompareOptions one_at_a_time;
  one_at_a_time.values_at_a_time = 5 * 200;
  EXPECT_EQ(to_json(compare(off, turned(slow), one_at_a_time)), to_json(compare(off, turned(slow))));
}

/// A curve of 100 samples a second.
Recording curve(const std::vector<double>& values) {
  TestFolder folder("curve");
  auto recorder = Recorder::open(folder / "a.mcap").value();
  const ChannelId force = recorder->add_samples("/wrist", {"force"}, {"N"});
  for (std::size_t k = 0; k < values.size(); ++k) {
    recorder->begin_cycle(static_cast<Nanoseconds>(k) * 10 * kMillisecond, k);
    recorder->write(force, std::vector<double>{values[k]});
  }
  recorder->close();
  return Recording::open(folder / "a.mcap").value();
}

TEST(Compare, FeaturesAreWhatIsLeftOfACurve) {
  // Up to 20, back to -30, at rest at 10 from 0.06 s on, with noise that is smaller than dv.
  const std::vector<double> reference{0, 10, 20, 0, -30, -10, 10, 10.2, 10, 9.9, 10.1};
  const auto compared = [&](const std::vector<double>& values, std::vector<std::string> judged, double dv = 0.5,
                            Nanoseconds dt = 5 * kMillisecond) {
    Tolerance tolerance{.kind = ToleranceKind::kFeatures, .dt = dt, .dv = dv};
    Diagnostics none;
    tolerance.features.reset();
    for (const std::string& name : judged) judge_feature(name, "", tolerance.features, none);
    EXPECT_FALSE(none.has_errors());
    CompareOptions options;
    options.rules = {{"/wrist", "force", tolerance}};
    return column(compare(curve(values), curve(reference), options), "/wrist", "force");
  };
  std::vector<double> other = reference;
  other[3] = 1;  // on the way: no feature knows it
  const ColumnComparison same = compared(other, {"max", "min", "end", "peak", "settling", "path", "duration"}, 0.5);
  EXPECT_TRUE(same.passed) << same.note;
  std::map<std::string, double> b;
  for (const FeatureDifference& feature : same.features) b[feature.name] = feature.b;
  EXPECT_EQ(b["peak"], 30);
  EXPECT_NEAR(b["settling"], 0.06, 1e-9);
  EXPECT_NEAR(b["path"], 20 + 50 + 40.2, 1e-9);
  EXPECT_NEAR(b["duration"], 0.10, 1e-9);

  other = reference;
  other[6] = 9;  // settles a sample later
  EXPECT_FALSE(compared(other, {"settling"}).passed);
  EXPECT_TRUE(compared(other, {"settling"}, 0.5, 20 * kMillisecond).passed);
  EXPECT_TRUE(compared(other, {"peak", "max", "duration"}).passed);
  other = reference;
  other[4] = -34;
  EXPECT_FALSE(compared(other, {"peak"}).passed);
  EXPECT_FALSE(compared(other, {"path"}).passed) << "8 N more, where 0.5 N for each of three turns are free";
  EXPECT_TRUE(compared(other, {"max", "end", "settling"}).passed);
  other = reference;
  other.push_back(10);
  EXPECT_FALSE(compared(other, {"duration"}).passed);
  Diagnostics wrong;
  FeatureSet none;
  judge_feature("peek", "/at", none, wrong);
  EXPECT_THAT(wrong, Reports(Code::kUnknownName, "/at", {"peek", "peak"}));
}

TEST(Compare, TheReportHasStepsAndFilms) {
  TestFolder folder("steps");
  auto recorder = Recorder::open(folder / "a.mcap").value();
  const ChannelId force = recorder->add_samples("/wrist", {"force"}, {"N"});
  const ChannelId program = recorder->add_events(std::string(kProgramTopic));
  for (int k = 0; k < 100; ++k) {
    recorder->begin_cycle(k * 10 * kMillisecond, static_cast<std::uint64_t>(k));
    recorder->write(force, std::vector<double>{0.1 * k});
    if (k == 50) recorder->event(program, "program", "begin", "press <firmly>");
  }
  recorder->close();
  const Recording recording = Recording::open(folder / "a.mcap").value();
  Comparison c = compare(recording, recording);
  ASSERT_EQ(c.steps.size(), 1u);
  EXPECT_EQ(c.steps[0].time_s, 0.5);
  EXPECT_THAT(to_html(c), AllOf(HasSubstr("press &lt;firmly&gt;"), Not(HasSubstr("<video"))));
  c.film_a = "abcd";
  c.film_b = "abc";
  EXPECT_THAT(to_html(c), AllOf(HasSubstr("base64,YWJjZA==\""), HasSubstr("base64,YWJj\"")));
}

// Goldens.

BlessOptions bless_options() {
  BlessOptions options;
  options.scenario = "scenarios/touch.json";
  options.reason = "first run that a person has watched";
  return options;
}

TEST(Golden, TheRunItCameFromPassesAndAnotherDoesNot) {
  const Recording first = run(400);
  const Golden golden = make_golden(first, bless_options()).value();
  const Comparison same = compare_with_golden(first, golden);
  EXPECT_TRUE(same.passed) << to_text(same);
  EXPECT_TRUE(same.identical);
  // Thinning and rounding stay within a quarter of each tolerance.
  for (const ColumnComparison& c : same.columns) {
    EXPECT_LE(c.max_difference, 0.25 * c.tolerance.dv * (1 + 1e-9)) << c.topic << " " << c.column;
  }
  const Comparison close = compare_with_golden(run(400, [](std::uint64_t) { return 1e-4; }), golden);
  EXPECT_TRUE(close.passed) << to_text(close);
  EXPECT_FALSE(close.identical);
  EXPECT_THAT(close.notes, ElementsAre(HasSubstr("the digest at the end is")));
  const Comparison far = compare_with_golden(run(400, [](std::uint64_t k) { return k > 200 ? 0.01 : 0.0; }), golden);
  EXPECT_FALSE(far.passed);
  EXPECT_FALSE(column(far, "/left/joints", "a1.position").passed);
  EXPECT_FALSE(compare_with_golden(run(380), golden).passed);
}

TEST(Golden, ComesBackFromItsText) {
  TestFolder folder("golden");
  record_run(folder / "run.mcap", 300);
  const Golden made = bless(folder / "run.mcap", folder / "sub/golden.json", bless_options()).value();
  const Golden read = read_golden(folder / "sub/golden.json").value();
  EXPECT_EQ(golden_to_text(read), golden_to_text(made));
  EXPECT_EQ(read.reason, made.reason);
  EXPECT_EQ(read.columns.size(), 9u + 14 + 6 + 3);
  const auto verdict = verify(folder / "run.mcap", folder / "sub/golden.json");
  ASSERT_TRUE(verdict);
  EXPECT_TRUE(verdict->passed) << to_text(*verdict);
  // Smooth curves are cheap: a second of 32 columns is some kilobytes.
  EXPECT_LT(bytes_of(folder / "sub/golden.json").size(), 40'000u);
}

TEST(Golden, IsRefusedWithoutReasonFromTornRunsAndWhenLarge) {
  const Recording whole = run(300);
  BlessOptions options = bless_options();
  options.reason = "  ";
  EXPECT_THAT(make_golden(whole, options), Reports(Code::kMissing, ""));
  options = bless_options();
  options.max_bytes = 2000;
  EXPECT_THAT(make_golden(whole, options), Reports(Code::kTooLarge, "", {"/net/probe force.z"}));
  options = bless_options();
  options.topics = {"/left/*"};
  EXPECT_EQ(make_golden(whole, options)->columns.size(), 15u);
  TestFolder folder("torn");
  record_run(folder / "a.mcap", 300);
  const std::string bytes = bytes_of(folder / "a.mcap");
  EXPECT_THAT(make_golden(Recording::from_bytes(bytes.substr(0, bytes.size() - 9)).value(), bless_options()),
              Reports(Code::kFileNotReadable, ""));
}

TEST(Golden, NoiseMayTakeHalfOfTheTolerance) {
  TestFolder folder("noise");
  {
    auto recorder = Recorder::open(folder / "a.mcap").value();
    const ChannelId id = recorder->add_samples("/noise", {"force"}, {"N"});
    Random random(3);
    for (std::uint64_t k = 0; k < 2000; ++k) {
      recorder->begin_cycle(static_cast<Nanoseconds>(k) * kMillisecond, k);
      recorder->write(id, std::vector<double>{random.uniform(-0.2, 0.2)});
    }
  }
  const Recording noise = Recording::open(folder / "a.mcap").value();
  BlessOptions options = bless_options();
  const Golden fine = make_golden(noise, options).value();
  EXPECT_EQ(fine.columns[0].thinning, 0.125);
  options.max_bytes = golden_to_text(fine).size() / 2;
  const Golden coarse = make_golden(noise, options).value();
  EXPECT_EQ(coarse.columns[0].thinning, 0.25);
  EXPECT_TRUE(compare_with_golden(noise, coarse).passed);
}

TEST(Golden, MistakesInTheFileAreAllTold) {
  const std::string text = R"({"takt_golden": 2, "scenario": 3, "reason": "", "cycles": 1, "end_s": 1, "digest": "",
    "event_tolerance": {"kind": "tub", "dt_s": 1, "dv": 1}, "steps": ["a"],
    "events": [["program", "begin"], ["program", "begin", 0, 7]],
    "grids": [{"topic": "/a", "start_s": 0, "period_s": 0, "samples": 3}],
    "columns": [{"topic": "/a", "column": "c", "unit": "", "tolerance": {"kind": "tube", "dt_s": 0, "dv": 1},
                 "thinning": 0, "time_s": [1, 0.5, 2], "value": [1, null]},
                {"topic": "/a", "column": "d", "unit": "", "tolerance": {"kind": "tube", "dt_s": 0, "dv": 1},
                 "thinning": 0, "curve": {"pieces": "00", "exponent": 99, "follows": ["/a"], "hold": [1, "x"]}}]})";
  const auto golden = golden_from_json(nlohmann::ordered_json::parse(text));
  ASSERT_FALSE(golden);
  EXPECT_THAT(golden, AllOf(Reports(Code::kWrongType, "/scenario"),
                            Reports(Code::kUnknownName, "/event_tolerance/kind", {"tub", "tube"}),
                            Reports(Code::kWrongType, "/events/0"), Reports(Code::kOutOfRange, "/events/1/3", {"7"}),
                            Reports(Code::kWrongSize, "/columns/0", {"3", "2"}),
                            Reports(Code::kOutOfRange, "/columns/0/time_s")));
  EXPECT_THAT(golden, AllOf(Reports(Code::kOutOfRange, "/grids/0/period_s"),
                            Reports(Code::kOutOfRange, "/columns/1/curve/exponent", {"-30", "30"}),
                            Reports(Code::kWrongSize, "/columns/1/curve/follows"),
                            Reports(Code::kWrongType, "/columns/1/curve/hold")));
  EXPECT_THAT(golden_from_json(nlohmann::ordered_json::parse("[]")), Reports(Code::kMissing, "", {"takt_golden"}));
  EXPECT_THAT(golden_from_json(nlohmann::ordered_json::parse(R"({"takt_golden": 1})")),
              Reports(Code::kIncompatible, "/takt_golden", {"1", "2"}));
}

/// Pieces that are too few for the grid, and a column that follows what is not there.
TEST(Golden, CurvesThatCannotBeHadAreRefused) {
  const Golden golden = make_golden(run(300), bless_options()).value();
  for (const auto& [key, value] : std::map<std::string, nlohmann::ordered_json>{
           {"pieces", "0"}, {"pieces", "&&"}, {"follows", {"/left/joints", "a9.position"}}}) {
    auto json = nlohmann::ordered_json::parse(golden_to_text(golden));
    json["columns"][2]["curve"][key] = value;
    EXPECT_THAT(golden_from_json(json), Reports(Code::kInvalidValue, "/columns/2/curve")) << value;
  }
  auto json = nlohmann::ordered_json::parse(golden_to_text(golden));
  json["grids"][0]["samples"] = 1'000'000'000;
  EXPECT_THAT(golden_from_json(json), Reports(Code::kTooLarge, "/columns"));
}

}  // namespace
}  // namespace takt::record
