#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cell/run/session.h"

namespace CLI {
class App;
}

namespace takt::app {

/// What a command line may say of what a film shows, of a run or of a recording.
struct FilmViewArguments {
  std::vector<double> eye, look_at;  ///< m in world, three each; empty: not asked for
  std::optional<std::vector<std::string>> show;
};
/// --eye, --look-at and --show; `arguments` outlives the parser. Realtime: setup.
void add_film_view_options(CLI::App& parser, FilmViewArguments& arguments);
/// The camera that they ask for; nothing: none, or what they say is wrong, which goes to `diagnostics`.
[[nodiscard]] std::optional<sim::FreeCamera> parse_view(const FilmViewArguments& arguments, Diagnostics& diagnostics);

/// What a command line may say of a run, of a scenario's program or of one in C++.
struct RunArguments {
  std::string video, camera, size = "1280x720", record, log = "info";
  int fps = 25;
  double video_from = 0.0;
  std::optional<double> video_to, record_last;
  FilmViewArguments film;
  bool realtime = false, record_blocks = false;
  std::optional<std::string> seed;
  std::vector<std::string> sets;
  std::string site;
  std::vector<std::string> backends;
  std::optional<double> speed_override;
};

/// Adds the options to a parser; `arguments` outlives it. Realtime: setup.
void add_run_options(CLI::App& parser, RunArguments& arguments);

/// The arguments as a run takes them; all that is wrong with them goes to `diagnostics`, with the names of the options.
/// Realtime: setup.
struct ParsedRun {
  cell::OpenOptions open;
  cell::RunOptions run;
};
/// @param inputs  files that the run reads: none of its products may replace one
[[nodiscard]] ParsedRun parse(const RunArguments& arguments, const std::vector<std::filesystem::path>& inputs,
                              Diagnostics& diagnostics);

/// The values of several --set, JSON_POINTER=VALUE each. Realtime: setup.
[[nodiscard]] std::vector<cell::Override> parse_sets(const std::vector<std::string>& sets, Diagnostics& diagnostics);

/// What happens goes to stderr, a line each, from this level on. @param level  a name of log_level_names()
void log_on_stderr(std::string_view level, cell::RunOptions& options);
/// On stderr: a bar on a terminal that is drawn over itself, elsewhere a line every ten seconds with what is left.
void show_progress_of(cell::RunOptions& options);
/// For RunOptions::before_step: shows on stderr what would begin, and waits for a line of stdin. Whoever goes away (end
/// of input) wants nothing to move on.
[[nodiscard]] cell::StepAnswer ask_on_terminal(const cell::NextStep& next);
/// Takes the bar away.
void clear_progress();

/// "WIDTHxHEIGHT" in pixels, and nothing behind it. @return false: it is something else
[[nodiscard]] bool parse_size(std::string_view text, int& width, int& height);

/// A folder of models that is not there. Realtime: setup.
[[nodiscard]] Diagnostics check_model_folders(const std::vector<std::string>& folders);

}  // namespace takt::app
