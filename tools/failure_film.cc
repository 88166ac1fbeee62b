#include "tools/failure_film.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/process.h"
#include "cell/run/session.h"

namespace takt::tools {
namespace {

constexpr double kBefore = 3.0, kAfter = 1.0;  ///< s

/// "scenarios/deep/touch.json" is "scenarios_deep_touch.mp4": two scenarios may have the same name in two folders.
std::string film_name(const std::filesystem::path& scenario, const FailureMoment& moment) {
  std::string name = scenario.lexically_normal().replace_extension().generic_string();
  std::ranges::replace(name, '/', '_');
  const std::size_t first = name.find_first_not_of("._");
  name = first == name.npos ? "film" : name.substr(first);
  if (const auto& tried = moment.interruption)
    name += fmt::format("_{}_{}", cell::Interruptions::name_of(tried->way), tried->cycle);
  return name + ".mp4";
}

/// Where the user's programs put what can be made again: nothing of it is to lie in a project.
std::filesystem::path cache_folder() {
  const auto absolute = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value == '/' ? std::filesystem::path(value) : std::filesystem::path();
  };
  std::error_code ignored;
  std::filesystem::path folder = absolute("XDG_CACHE_HOME");
  if (folder.empty() && !absolute("HOME").empty()) folder = absolute("HOME") / ".cache";
  if (folder.empty()) folder = std::filesystem::temp_directory_path(ignored);
  return folder / "takt" / "failures";
}

Result<void> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return {};
  return failure(Code::kFileNotWritable, "--failures",
                 fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
}

cell::RunOptions film_options(const std::filesystem::path& film, const FailureMoment& moment) {
  cell::RunOptions options;
  options.video = film;
  options.width = 960;
  options.height = 540;
  options.video_from = std::max(0.0, moment.time - kBefore);
  options.measure_times = false;
  options.repeat = false;
  options.interrupt = &app::catch_interrupts();
  if (moment.at_end) return options;
  options.video_to = moment.time + kAfter;
  options.after_cycle = [end = options.video_to](cell::BuiltCell& built) {
    return to_seconds(built.core->time()) <= end;
  };
  return options;
}

/// A program that was interrupted ends by itself; a film of one that does not has to end all the same.
constexpr double kLongestAftermath = 15.0;  // s

/// In place of the moment: the same interruption, in the run that is filmed.
void interrupt_again(const cell::Interruptions::Case& tried, double period, cell::Interruptions& again,
                     cell::RunOptions& options) {
  const double time = period * static_cast<double>(tried.cycle);
  again.attach(options);
  options.video_from = std::max(0.0, time - kBefore);
  options.video_to = time + kLongestAftermath;
  options.video_failure = tried.wrong;
  options.after_cycle = [end = options.video_to, watch = options.after_cycle](cell::BuiltCell& built) {
    return watch(built) && to_seconds(built.core->time()) <= end;
  };
}

}  // namespace

void add_failure_film_options(CLI::App& verb, FailureFilmArguments& arguments) {
  verb.add_option(
          "--failures", arguments.folder,
          "Folder for films of the seconds around failures; default: takt/failures in $XDG_CACHE_HOME or ~/.cache")
      ->type_name("DIR");
  verb.add_flag("--no-film", arguments.off, "Do not film failures");
}

Result<std::filesystem::path> film_failure(const std::filesystem::path& scenario, const FailureMoment& moment,
                                           const FailureFilmArguments& arguments, const Common& common) {
  const auto folder = arguments.folder.empty() ? cache_folder() : std::filesystem::path(arguments.folder);
  if (const auto made = make_folder(folder); !made) return std::unexpected(made.error());
  cell::OpenOptions opening;
  opening.all_may_fail = moment.interruption.has_value();
  auto session = cell::Session::open(scenario, common.library(), opening);
  if (!session) return std::unexpected(session.error());
  const std::filesystem::path film = folder / film_name(scenario, moment);
  cell::RunOptions options = film_options(film, moment);
  auto again = cell::Interruptions::again(moment.interruption.value_or(cell::Interruptions::Case{}));
  if (moment.interruption)
    interrupt_again(*moment.interruption, to_seconds((*session)->built().core->period()), again, options);
  const cell::RunReport report = (*session)->run(options);
  if (report.frames > 0) return film;
  return std::unexpected(report.diagnostics);
}

}  // namespace takt::tools
