// What films show beside the picture: marks, captions, failures and what comes after them.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/replay/replay.h"
#include "cell/run/film_caption.h"
#include "cell/run/film_marks.h"
#include "cell/run/session.h"
#include "record/recording.h"
#include "tests/cell/described.h"
#include "tests/support/reports.h"
#include "tests/support/scratch_folder.h"

namespace takt::cell::film_test {
namespace {

using takt::test::Names;
using takt::test::Reports;
using test::models;
using test::parsed;

/// An arm with a probe over a block, and a range finder whose beam meets the block from above.
std::string cell(const std::string& steps, const std::string& more = "") {
  return R"({"devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "wrist": {"model": "ft_gamma", "on": "arm"}, "probe": {"model": "probe_ball", "on": "wrist"},
      "finder": {"model": "range_finder", "at": {"position_m": [0.7, 0, 0.7], "rpy_deg": [0, 90, 0]}}},
    "frames": {"fixture": {"in": "world", "position_m": [0.3, 0.3, 0.1]}},
    "objects": {"block": {"shape": "box", "size_m": [0.4, 0.4, 0.2], "at": {"position_m": [0.55, 0, 0.1]}}},
    "program": {"do": "sequence", "name": "main", "steps": [)" +
         steps + "]}" + more + "}";
}

constexpr const char* kAbove = R"({"do": "ptp", "name": "above", "to": {"in": "block", "position_m": [0, 0, 0.12],
                                                                       "rpy_deg": [180, 0, 0]}})";
// Blind, and much too far: the block stops the probe.
constexpr const char* kRam = R"({"do": "lin", "name": "ram", "to": {"by_m": [0, 0, -0.08]},
      "velocity_m_s": 0.2, "until": {"sensor": "wrist", "above_N": 5000}, "on_end": "continue"})";

std::unique_ptr<Session> session_of(const std::string& text) {
  auto session = Session::create(parsed(text), models());
  if (session) return std::move(*session);
  ADD_FAILURE() << session.error().to_string();
  return nullptr;
}

FilmShow only(bool FilmShow::*mark) {
  FilmShow show{.traces = false, .beams = false, .forces = false};
  show.*mark = true;
  return show;
}

TEST(FilmMarks, ABeamEndsAtTheSurfaceThatItMeets) {
  const auto session = session_of(cell(kAbove));
  FilmMarks marks(session->built(), only(&FilmShow::beams));
  const auto qpos = session->built().world->positions();
  const sim::Marks shown = marks.at({0, qpos});
  ASSERT_EQ(shown.shapes.size(), 1u);
  EXPECT_NEAR(shown.shapes[0].to[2], 0.2, 1e-3) << "the top of the block";
  EXPECT_NEAR(shown.shapes[0].from[0], shown.shapes[0].to[0], 1e-6);
  EXPECT_GT(shown.shapes[0].from[2], 0.5);
}

TEST(FilmMarks, ATraceFollowsTheToolAndForgetsWhatIsOld) {
  const auto session = session_of(cell(kAbove));
  FilmShow show = only(&FilmShow::traces);
  show.trace_s = 1.0;
  FilmMarks marks(session->built(), show);
  std::vector<double> qpos(session->built().world->positions().begin(), session->built().world->positions().end());
  std::size_t most = 0;
  for (int i = 0; i <= 100; ++i) {
    qpos[0] = 0.01 * i;
    most = std::max(most, marks.at({i * 40 * kMillisecond, qpos}).shapes.size());
  }
  EXPECT_GE(most, 24u);
  EXPECT_LE(most, 27u) << "25 points a second";
  // Standing still, it is forgotten.
  EXPECT_EQ(marks.at({100 * kSecond, qpos}).shapes.size(), 1u);
}

TEST(FilmMarks, AForceIsAnArrowWhoseTipIsAtTheContact) {
  const auto session = session_of(cell(kAbove));
  FilmMarks marks(session->built(), only(&FilmShow::forces));
  const std::array<ContactForce, 2> contacts = {{{{0.5, 0, 0.2}, {0, 0, 50}}, {{0.5, 0, 0.2}, {0, 0, 5000}}}};
  const auto qpos = session->built().world->positions();
  const sim::Marks shown = marks.at({0, qpos, {}, contacts});
  ASSERT_EQ(shown.shapes.size(), 2u);
  EXPECT_NEAR(shown.shapes[0].to[2] - shown.shapes[0].from[2], 0.15, 1e-6);
  EXPECT_NEAR(shown.shapes[0].to[2], 0.2, 1e-6);
  EXPECT_LT(shown.shapes[1].to[2] - shown.shapes[1].from[2], 0.3) << "it stays in the picture";
  EXPECT_TRUE(shown.shapes[0].on_top);
}

TEST(FilmMarks, ACommandedMachineIsShownWhereItIsNotThere) {
  const auto session = session_of(cell(kAbove));
  FilmMarks marks(session->built(), only(&FilmShow::commanded));
  const auto positions = session->built().world->positions();
  std::vector<double> qpos(positions.begin(), positions.end()), commanded = qpos;
  EXPECT_TRUE(marks.at({0, qpos, commanded}).ghost.qpos.empty());
  commanded[0] += 0.1;
  const sim::Ghost ghost = marks.at({1, qpos, commanded}).ghost;
  EXPECT_EQ(ghost.qpos, commanded);
  EXPECT_GE(std::ranges::count(ghost.bodies, true), 7);
  EXPECT_FALSE(ghost.bodies.at(0));
}

TEST(FilmMarks, FramesHaveThreeAxesWhereTheyAre) {
  const auto session = session_of(cell(kAbove));
  FilmMarks marks(session->built(), only(&FilmShow::frames));
  const auto qpos = session->built().world->positions();
  const sim::Marks shown = marks.at({0, qpos});
  ASSERT_EQ(shown.shapes.size(), 6u) << "of 'fixture' and of the tool centre point";
  EXPECT_NEAR(shown.shapes[0].from[0], 0.3, 1e-6);
  EXPECT_NEAR(shown.shapes[0].from[1], 0.3, 1e-6);
  EXPECT_NEAR(shown.shapes[2].to[2] - shown.shapes[2].from[2], 0.08, 1e-6);
}

TEST(FilmMarks, NamesThatAreNoneAreReported) {
  const auto wrong = parse_description(cell(kAbove, R"(, "film": {"show": ["traces", "frams"], "camera": "fit"})"));
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error(), Reports(Code::kUnknownName, "/film/show/1", {"frams", "frames"}));
  const Description right = parsed(cell(kAbove, R"(, "film": {"show": ["frames"], "trace_s": 2})"));
  EXPECT_TRUE(right.film.show.frames);
  EXPECT_FALSE(right.film.show.traces);
  EXPECT_EQ(right.film.show.trace_s, 2.0);
}

LogEntry event(double at, LogLevel level, const std::string& source, const std::string& name, const std::string& step,
               const std::string& text = "") {
  return {.time = static_cast<Nanoseconds>(1e9 * at),
          .cycle = 0,
          .level = level,
          .source = source,
          .name = name,
          .step = step,
          .text = text};
}

sim::Overlay written(const FilmCaption& caption, double at) {
  sim::Overlay overlay;
  caption.write(static_cast<Nanoseconds>(1e9 * at), "fallback", overlay);
  return overlay;
}

TEST(FilmCaption, HasTheStepAtWorkAndThePathToIt) {
  FilmCaption caption;
  EXPECT_EQ(written(caption, 0).step, "fallback");
  caption.happened(event(0, LogLevel::kDebug, "program", "begin", "main"));
  EXPECT_EQ(written(caption, 0).step, "main");
  EXPECT_EQ(written(caption, 0).path, "");
  caption.happened(event(1, LogLevel::kDebug, "program", "begin", "main / sort (2) / grip"));
  EXPECT_EQ(written(caption, 1).step, "grip");
  EXPECT_EQ(written(caption, 1).path, "main / sort (2)");
  caption.happened(event(2, LogLevel::kDebug, "program", "end", "main / sort (2) / grip"));
  EXPECT_EQ(written(caption, 2).step, "main");
}

TEST(FilmCaption, ACompositionThatIsCalledByItsTypeIsNoStepToAReader) {
  FilmCaption caption;
  caption.happened(event(0, LogLevel::kDebug, "program", "begin", "sequence"));
  EXPECT_EQ(written(caption, 0).step, "sequence") << "nothing else is known";
  caption.happened(event(1, LogLevel::kDebug, "program", "begin", "sequence / sort (2) / branch"));
  caption.happened(event(1, LogLevel::kDebug, "program", "begin", "sequence / sort (2) / branch / try (3)"));
  EXPECT_EQ(written(caption, 1).step, "sort (2)");
  EXPECT_EQ(written(caption, 1).path, "");
  caption.happened(event(2, LogLevel::kDebug, "program", "begin", "sequence / sort (2) / branch / try (3) / grip"));
  EXPECT_EQ(written(caption, 2).step, "grip");
  EXPECT_EQ(written(caption, 2).path, "sort (2)");
}

TEST(FilmCaption, TheVerdictTakesThePlaceOfTheStep) {
  FilmCaption caption;
  caption.happened(event(0, LogLevel::kDebug, "program", "begin", "main / grip"));
  EXPECT_EQ(written(caption, 0).step_tone, sim::Overlay::Tone::kPlain);
  caption.judge(Verdict::kFailed, 3, 4);
  const sim::Overlay failed = written(caption, 1);
  EXPECT_THAT(failed.step, Names("failed", "3", "4"));
  EXPECT_EQ(failed.path, "");
  EXPECT_EQ(failed.step_tone, sim::Overlay::Tone::kBad);
  caption.judge(Verdict::kPassed, 0, 0);
  EXPECT_EQ(written(caption, 1).step, "passed");
  EXPECT_EQ(written(caption, 1).step_tone, sim::Overlay::Tone::kGood);
}

TEST(FilmCaption, ShowsForAWhileWhatWentWrong) {
  FilmCaption caption;
  caption.happened(event(0, LogLevel::kInfo, "contact", "contact", "main", "nothing wrong"));
  EXPECT_EQ(written(caption, 0).note, "");
  caption.happened(event(1, LogLevel::kWarning, "program", "retry", "main", "1 of 3"));
  EXPECT_THAT(written(caption, 1).note, Names("1", "3"));
  caption.happened(event(2, LogLevel::kError, "arm", "fault", "main", "the block was hit"));
  caption.happened(event(2.1, LogLevel::kError, "run", "error", "main", "the net ended"));
  caption.happened(event(2.2, LogLevel::kWarning, "program", "failed", "main", "ram"));
  EXPECT_THAT(written(caption, 3).note, Names("the", "block")) << "what it began with";
  EXPECT_EQ(written(caption, 10).note, "");
}

int frames_in(const std::filesystem::path& film) {
  const std::string command =
      "ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames "
      "-of default=nw=1:nk=1 '" +
      film.string() + "'";
  FILE* pipe = popen(command.c_str(), "r");
  int frames = -1;
  if (pipe == nullptr || std::fscanf(pipe, "%d", &frames) != 1) frames = -1;
  if (pipe != nullptr) pclose(pipe);
  return frames;
}

/// One picture of a film of 320x240: brightness, 0 to 255, row by row. Its last one for a negative number.
std::vector<int> picture(const std::filesystem::path& film, int number) {
  const int wanted = number >= 0 ? number : frames_in(film) - 1;
  const std::string command = "ffmpeg -v error -i '" + film.string() + "' -vf 'select=eq(n\\," +
                              std::to_string(wanted) + ")' -frames:v 1 -f rawvideo -pix_fmt gray -";
  std::vector<int> pixels;
  FILE* pipe = popen(command.c_str(), "r");
  for (int c = pipe == nullptr ? EOF : std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) pixels.push_back(c);
  if (pipe != nullptr) pclose(pipe);
  EXPECT_EQ(pixels.size(), 320u * 240u) << command;
  pixels.resize(320 * 240);
  return pixels;
}

/// Mean difference of the pixels of some rows.
double apart(const std::vector<int>& a, const std::vector<int>& b, int from_row = 0, int to_row = 240) {
  double sum = 0;
  for (int i = 320 * from_row; i < 320 * to_row; ++i) sum += std::abs(a[std::size_t(i)] - b[std::size_t(i)]);
  return sum / (320 * (to_row - from_row));
}

RunOptions small_film(const std::filesystem::path& video) {
  RunOptions options;
  options.video = video;
  options.width = 320;
  options.height = 240;
  options.fps = 10;
  return options;
}

// Down to the block until the probe touches it, which it goes on doing for a second.
constexpr const char* kTouch = R"({"do": "lin", "name": "touch", "to": {"by_m": [0, 0, -0.06]}, "velocity_m_s": 0.04,
      "until": {"sensor": "wrist", "above_N": 15}}, {"do": "wait", "seconds": 1})";
constexpr const char* kAway = R"({"do": "lin", "name": "away", "to": {"by_m": [0, 0, 0.08]}})";
constexpr const char* kWatched = R"(, "film": {"force_sensor": "wrist", "force_limit_N": 20})";
constexpr int kStrip = 240 - 18;  // first row of the lower strip

TEST(RunFilm, ARecordingGivesTheFilmOfTheRunWithItsForceAndItsVerdict) {
  const takt::test::ScratchFolder folder("run_film");
  RunOptions options = small_film(folder / "run.mp4");
  options.record = folder / "run.mcap";
  const RunReport report = session_of(cell(std::string(kAbove) + "," + kTouch, kWatched))->run(options);
  ASSERT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_NEAR(static_cast<double>(report.frames), 10 * (report.sim_time + 1), 1.5) << "a second for the verdict";

  ReplayOptions replay;
  replay.video = folder / "replay.mp4";
  replay.width = options.width;
  replay.height = options.height;
  replay.fps = options.fps;
  const auto frames = render_recording(options.record, models(), replay);
  ASSERT_TRUE(frames) << frames.error().to_string();
  EXPECT_NEAR(static_cast<double>(*frames), static_cast<double>(report.frames), 1.5);
  const int pressing = static_cast<int>(report.frames) - 15;
  const std::vector<int> pressed = picture(options.video, pressing), ended = picture(options.video, -1);
  EXPECT_LT(apart(pressed, picture(replay.video, pressing), kStrip), 1.5) << "number and bar";
  EXPECT_LT(apart(ended, picture(replay.video, -1), kStrip), 1.5) << "the verdict";
  EXPECT_GT(apart(ended, pressed, kStrip), 3) << "which stands in the place of the step";

  RunOptions blind = small_film(folder / "blind.mp4");
  (void)session_of(cell(std::string(kAbove) + "," + kTouch))->run(blind);
  EXPECT_GT(apart(pressed, picture(blind.video, pressing), kStrip), 3) << "the bar is what makes the difference";
}

TEST(RunFilm, BeginsWithTheForcesOfItsFirstPictureAlone) {
  const takt::test::ScratchFolder folder("run_film");
  const std::string program = std::string(kAbove) + "," + kTouch + "," + kAway;
  const double end = session_of(cell(program))->run({}).sim_time;
  RunOptions late = small_film(folder / "forces.mp4");
  late.video_from = end - 0.3;
  late.view = sim::camera_from({1.6, -1.1, 1.0}, {0.5, 0, 0.3});
  late.show = {"forces"};
  ASSERT_EQ(session_of(cell(program))->run(late).verdict, Verdict::kPassed);
  const std::vector<int> with = picture(late.video, 0);
  late.video = folder / "bare.mp4";
  late.show = std::vector<std::string>{};
  ASSERT_EQ(session_of(cell(program))->run(late).verdict, Verdict::kPassed);
  const double now = apart(with, picture(late.video, 0));  // the block on the floor
  // A film of the whole run has the force of the touch in it, too.
  const int same_time = static_cast<int>(std::lround(10 * late.video_from));
  late.video_from = 0.0;
  ASSERT_EQ(session_of(cell(program))->run(late).verdict, Verdict::kPassed);
  const std::vector<int> bare = picture(late.video, same_time);
  late.video = folder / "whole.mp4";
  late.show = {"forces"};
  ASSERT_EQ(session_of(cell(program))->run(late).verdict, Verdict::kPassed);
  EXPECT_LT(now, 0.5 * apart(picture(late.video, same_time), bare)) << "the probe was long gone";
}

TEST(RunFilm, AFailureIsFilmedForASecondMoreAndChangesNothing) {
  const takt::test::ScratchFolder folder("run_film");
  RunOptions options;
  options.width = 160;
  options.height = 120;
  options.fps = 10;
  const RunReport plain = session_of(cell(std::string(kAbove) + "," + kRam))->run(options);
  options.video = folder / "a.mp4";
  options.record = folder / "a.mcap";
  const RunReport filmed = session_of(cell(std::string(kAbove) + "," + kRam))->run(options);
  EXPECT_EQ(filmed.verdict, Verdict::kError);
  EXPECT_EQ(filmed.digest, plain.digest);
  EXPECT_EQ(filmed.cycles, plain.cycles);
  const auto expected = static_cast<std::int64_t>(10 * (filmed.sim_time + 1.0));
  EXPECT_NEAR(static_cast<double>(filmed.frames), static_cast<double>(expected), 1.5);
  EXPECT_EQ(frames_in(options.video), filmed.frames);

  // Its recording has the forces, and gives a film of any part with any camera.
  const auto recording = record::Recording::open(options.record);
  ASSERT_TRUE(recording);
  const auto forces = recording->table(record::kContactForceTopic);
  ASSERT_TRUE(forces);
  double greatest = 0;
  for (const double force : forces->values[5]) greatest = std::max(greatest, std::isfinite(force) ? force : 0);
  EXPECT_GT(greatest, 50) << "the block pushes the probe up";

  ReplayOptions replay;
  replay.video = folder / "b.mp4";
  replay.width = 160;
  replay.height = 120;
  replay.fps = 10;
  replay.view = sim::camera_from({1.6, -1.1, 1.5}, {0.3, 0, 0.9});
  replay.show = {"traces", "commanded", "frames", "forces", "beams"};
  replay.from = 0.5;
  replay.to = 1.0;
  const auto part = render_recording(options.record, models(), replay);
  ASSERT_TRUE(part) << part.error().to_string();
  EXPECT_NEAR(static_cast<double>(*part), 5, 1);
  replay.from = 0;
  replay.to = 1e9;
  const auto whole = render_recording(options.record, models(), replay);
  ASSERT_TRUE(whole);
  EXPECT_NEAR(static_cast<double>(*whole), static_cast<double>(filmed.frames), 1.5) << "the failure is held";
  replay.from = 500;
  EXPECT_THAT(render_recording(options.record, models(), replay).error(), Reports(Code::kOutOfRange, "--from"));
  replay.from = 1;
  replay.to = 0.5;
  replay.show = {"nothing"};
  const auto wrong = render_recording(options.record, models(), replay);
  EXPECT_THAT(wrong.error(), Reports(Code::kOutOfRange, "--to"));
  EXPECT_THAT(wrong.error(), Reports(Code::kUnknownName, "--show", {"nothing"}));
}

TEST(RunFilm, AnExpectationThatDoesNotHoldIsFilmedToo) {
  const takt::test::ScratchFolder folder("run_film");
  RunOptions options;
  options.video = folder / "a.mp4";
  options.width = 160;
  options.height = 120;
  options.fps = 10;
  const RunReport report =
      session_of(cell(kAbove, R"(, "expectations": [{"kind": "duration", "below_s": 0.01}])"))->run(options);
  EXPECT_EQ(report.verdict, Verdict::kFailed) << report.diagnostics.to_string();
  EXPECT_GT(static_cast<double>(report.frames), 10 * report.sim_time + 8);
  options.video_to = 0.5;
  const RunReport part =
      session_of(cell(kAbove, R"(, "expectations": [{"kind": "duration", "below_s": 0.01}])"))->run(options);
  EXPECT_NEAR(static_cast<double>(part.frames), 5, 1);
}

}  // namespace
}  // namespace takt::cell::film_test
