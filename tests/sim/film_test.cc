#include "sim/film/film.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "sim/film/film_encoder.h"
#include "tests/sim/render_fixture.h"
#include "tests/support/reports.h"
#include "tests/support/scratch_folder.h"

namespace takt::sim {
namespace {

using takt::test::Reports;
using testing::AllOf;

std::string output_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) text.append(buffer.data(), n);
  pclose(pipe);
  return text;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class FilmTest : public testing::Test {
 protected:
  void SetUp() override {
    const StageOptions stage;
    model_ = compile_scene(std::string(kFrontCamera) + R"(<camera name="top" pos="0 0 4"/>
        <body><joint type="slide" axis="1 0 0"/>
        <geom type="box" size=".3 .3 1" pos="-1.4 0 1" rgba="0.05 0.05 0.05 1"/></body>)",
                           &stage);
    data_ = posed_data(model_.get());
  }

  FilmOptions options(const char* name = "film.mp4") const {
    FilmOptions options;
    options.path = folder_ / name;
    options.render = small_picture();
    options.title = "A test";
    options.workers = 1;
    return options;
  }

  // A block that moves right, a step a frame.
  Result<FilmReport> make_film(const FilmOptions& film_options, int frames) {
    Result<Film> film = Film::open(model_.get(), film_options);
    if (!film) return std::unexpected(film.error());
    for (int i = 0; i < frames; ++i) {
      data_->qpos[0] = 2.8 * i / frames;
      Overlay overlay;
      overlay.time = film->next_time();
      overlay.step = fmt::format("step {}", i);
      if (Result<void> pushed = film->push(data_.get(), overlay); !pushed) return std::unexpected(pushed.error());
    }
    return film->close();
  }

  // Grey frames as ffmpeg decodes them.
  std::vector<std::string> decoded(const std::filesystem::path& path) const {
    const std::string all =
        output_of(fmt::format("ffmpeg -loglevel error -i '{}' -f rawvideo -pix_fmt gray -", path.string()));
    std::vector<std::string> frames;
    for (std::size_t i = 0; i + 160 * 120 <= all.size(); i += 160 * 120) frames.push_back(all.substr(i, 160 * 120));
    return frames;
  }

  takt::test::ScratchFolder folder_{"film"};
  ModelPtr model_{nullptr, &mj_deleteModel};
  DataPtr data_{nullptr, &mj_deleteData};
};

TEST_F(FilmTest, HasTheFramesRateSizeAndCodecAskedFor) {
  FilmOptions film = options();
  film.fps = 30;
  const Result<FilmReport> report = make_film(film, 10);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_EQ(report->frames, 10);
  EXPECT_EQ(report->drawn, 10);
  const std::string probe = output_of(fmt::format(
      "ffprobe -v error -count_frames -select_streams v -show_entries "
      "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames,color_space -of default=nw=1 '{}'",
      film.path.string()));
  for (const char* line : {"codec_name=h264\n", "width=160\n", "height=120\n", "pix_fmt=yuv420p\n",
                           "r_frame_rate=30/1\n", "nb_read_frames=10\n", "color_space=bt709\n"})
    EXPECT_NE(probe.find(line), std::string::npos) << line << probe;
}

TEST_F(FilmTest, KeepsTheOrderOfFramesWithManyWorkers) {
  FilmOptions film = options();
  film.workers = 3;
  film.queue_frames = 4;
  film.overlay = false;
  film.render.shadow_size = 0;
  ASSERT_TRUE(make_film(film, 16));
  double last = -1;
  const auto frames = decoded(film.path);
  ASSERT_EQ(frames.size(), 16u);
  for (const std::string& frame : frames) {
    double sum = 0, count = 0;
    for (int x = 0; x < 160; ++x) {
      if (static_cast<unsigned char>(frame[static_cast<std::size_t>(60 * 160 + x)]) > 80) continue;
      sum += x;
      ++count;
    }
    ASSERT_GT(count, 5);
    EXPECT_GT(sum / count, last + 1);
    last = sum / count;
  }
}

TEST_F(FilmTest, IsTheSameToTheByteWhateverTheWorkerCount) {
  std::string first;
  for (const int workers : {1, 3}) {
    FilmOptions film = options("same.mp4");
    film.workers = workers;
    film.inset_camera = "top";
    ASSERT_TRUE(make_film(film, 12));
    const std::string bytes = bytes_of(film.path);
    ASSERT_GT(bytes.size(), 1000u);
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first) << workers;
  }
}

TEST_F(FilmTest, DrawsAnUnchangedStateOnce) {
  Result<Film> film = Film::open(model_.get(), options());
  ASSERT_TRUE(film);
  for (int i = 0; i < 6; ++i) {
    data_->qpos[0] = i < 4 ? 0 : 1;
    ASSERT_TRUE(film->push(data_.get(), {}));
  }
  const Result<FilmReport> report = film->close();
  ASSERT_TRUE(report);
  EXPECT_EQ(report->frames, 6);
  EXPECT_EQ(report->drawn, 2);
  EXPECT_EQ(film->close()->frames, 6) << "a second close gives the same report";
  EXPECT_FALSE(film->push(data_.get(), {}));
}

TEST_F(FilmTest, CutsToAnotherCameraAtItsTimeAndOnDemand) {
  FilmOptions film = options();
  film.overlay = false;
  film.cuts = {{0, "front"}, {120 * kMillisecond, "top"}};
  Result<Film> running = Film::open(model_.get(), film);
  ASSERT_TRUE(running);
  for (int i = 0; i < 8; ++i) {
    if (i == 6) {
      ASSERT_TRUE(running->set_camera("front"));
    }
    Overlay overlay;
    overlay.time = running->next_time();
    ASSERT_TRUE(running->push(data_.get(), overlay));
  }
  EXPECT_FALSE(running->set_camera("nowhere"));
  EXPECT_EQ(running->close()->drawn, 3);
  const auto frames = decoded(film.path);
  ASSERT_EQ(frames.size(), 8u);
  const auto distance = [&](std::size_t a, std::size_t b) {
    double sum = 0;
    for (std::size_t i = 0; i < frames[a].size(); ++i)
      sum += std::abs(static_cast<unsigned char>(frames[a][i]) - static_cast<unsigned char>(frames[b][i]));
    return sum / static_cast<double>(frames[a].size());
  };
  EXPECT_LT(distance(0, 2), 3);
  EXPECT_GT(distance(2, 3), 8);
  EXPECT_LT(distance(3, 5), 3);
  EXPECT_LT(distance(0, 7), 3);
}

TEST_F(FilmTest, ARecordingShowsTheNewestStateOfEachFrame) {
  std::vector<FilmState> states;
  for (int i = 0; i <= 50; ++i) states.push_back({i * 10 * kMillisecond, {0.02 * i}, {}});
  const Result<FilmReport> report = film_from_states(model_.get(), states, options());
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_EQ(report->frames, 13);  // 0, 40 ... 480 ms
  EXPECT_EQ(report->drawn, 13);
  EXPECT_FALSE(film_from_states(model_.get(), {}, options()));
  states.resize(1);
  states[0].qpos = {1, 2, 3};
  EXPECT_FALSE(film_from_states(model_.get(), states, options()));
}

TEST_F(FilmTest, ReportsEverythingThatIsWrongWithTheOptions) {
  FilmOptions film = options();
  film.path = folder_ / "no" / "such" / "film.mp4";
  film.render.width = 161;
  film.render.height = 1'000'000;
  film.fps = 0;
  film.workers = 99;
  film.cuts = {{kSecond, "front"}, {0, "tpo"}};
  film.inset_camera = "insid";
  const Result<Film> opened = Film::open(model_.get(), film);
  ASSERT_FALSE(opened);
  const std::string text = opened.error().to_string();
  for (const char* pointer : {"/path", "/render/width", "/render/height", "/fps", "/workers", "/cuts/1/camera",
                              "/cuts/1/from", "/inset_camera"})
    EXPECT_NE(text.find(std::string(pointer) + ": error"), std::string::npos) << pointer << "\n" << text;
  EXPECT_THAT(opened.error(), AllOf(Reports(Code::kFileNotWritable, "/path", {std::strerror(ENOENT)}),
                                    Reports(Code::kOutOfRange, "/render/width", {"161", "160", "162"}),
                                    Reports(Code::kUnknownName, "/cuts/1/camera", {"tpo", "top"})));
  EXPECT_FALSE(Film::open(model_.get(), options("film.avi")));
}

TEST_F(FilmTest, TellsWhatBecameOfFfmpeg) {
  FilmOptions film = options();
  film.ffmpeg = "no-such-ffmpeg";
  const Result<Film> missing = Film::open(model_.get(), film);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().list().front().code, Code::kSystem);
  EXPECT_EQ(missing.error().list().front().pointer, "/ffmpeg");

  film.ffmpeg = "false";
  const Result<FilmReport> failed = make_film(film, 40);
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error(), Reports(Code::kSystem, "/path", {"false", "1"}));

  film.ffmpeg = "true";
  EXPECT_FALSE(make_film(film, 40));
}

TEST_F(FilmTest, AFilmWithoutAFrameIsAnErrorAndLeavesNoFile) {
  const FilmOptions film = options();
  EXPECT_FALSE(make_film(film, 0));
  EXPECT_FALSE(std::filesystem::exists(film.path));
}

TEST(ToYuv420, MatchesTheFormulaOfHdVideo) {
  for (const auto& [r, g, b] :
       {std::array{255, 255, 255}, {0, 0, 0}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {90, 160, 30}}) {
    Image image;
    image.resize(64, 64);
    for (int i = 0; i < 64 * 64; ++i) {
      std::uint8_t* p = image.pixel(i % 64, i / 64);
      p[0] = static_cast<std::uint8_t>(r);
      p[1] = static_cast<std::uint8_t>(g);
      p[2] = static_cast<std::uint8_t>(b);
    }
    std::vector<std::uint8_t> yuv;
    to_yuv420(image, yuv);
    ASSERT_EQ(yuv.size(), 64u * 64 * 3 / 2);
    const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    EXPECT_NEAR(yuv[0], 16 + 219 * y / 255, 1.5);
    EXPECT_NEAR(yuv[64 * 64], 128 + 224 * (b - y) / 1.8556 / 255, 1.5);
    EXPECT_NEAR(yuv.back(), 128 + 224 * (r - y) / 1.5748 / 255, 1.5);
  }
}

}  // namespace
}  // namespace takt::sim
