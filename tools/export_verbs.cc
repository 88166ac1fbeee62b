// export, recover: recordings and cells for other programs, and recordings that were not closed.
#include <cstdint>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/run_arguments.h"
#include "core/base/output_file.h"
#include "core/base/text_location.h"
#include "record/export.h"
#include "record/recover.h"
#include "tools/cli.h"
#include "tools/export_mjcf.h"
#include "tools/unread.h"

namespace takt::tools {
namespace {

struct ExportArguments {
  std::string file, csv, tum, frame, frames = "/tf", mjcf;
  std::vector<std::string> topics, sets;
  std::optional<std::uint64_t> seed;
};

/// What belongs to a recording does not to a scenario, and the other way round.
Diagnostics check_kinds(const ExportArguments& arguments) {
  Diagnostics diagnostics;
  const bool of_recording =
      !arguments.csv.empty() || !arguments.tum.empty() || !arguments.frame.empty() || !arguments.topics.empty();
  if (!arguments.mjcf.empty() && of_recording)
    diagnostics.error(Code::kConflict, "--mjcf", "a model is made from a scenario, tables from a recording",
                      "Give --mjcf alone, or leave it out");
  if (arguments.mjcf.empty() && (!arguments.sets.empty() || arguments.seed))
    diagnostics.error(Code::kRequires, arguments.seed ? "--seed" : "--set", "it changes a scenario",
                      "Give --mjcf OUT with it");
  return diagnostics;
}

Diagnostics check(const ExportArguments& arguments) {
  Diagnostics diagnostics;
  if (arguments.csv.empty() && arguments.tum.empty())
    diagnostics.error(Code::kMissing, "", "nothing is to be written",
                      "Give --csv FOLDER, or --tum FILE with --frame NAME; of a scenario --mjcf OUT");
  if (arguments.tum.empty() != arguments.frame.empty())
    diagnostics.error(Code::kRequires, arguments.tum.empty() ? "--frame" : "--tum", "a frame and a file are needed",
                      "Give --tum FILE --frame NAME");
  if (!arguments.tum.empty()) diagnostics.append(check_output(arguments.tum, {arguments.file}, "--tum"));
  return diagnostics;
}

/// All topics that can be tables, or those that were asked for.
Result<std::vector<std::string>> topics_of(const ExportArguments& arguments, const record::Recording& recording) {
  std::vector<std::string> all = recording.table_topics();
  for (std::string& topic : recording.event_topics()) all.push_back(std::move(topic));
  Diagnostics diagnostics;
  for (const std::string& topic : arguments.topics)
    if (std::ranges::find(all, topic) == all.end())
      diagnostics.error(Code::kUnknownName, "--topic", fmt::format("there is no topic '{}'", topic),
                        nearest_choice(topic, all, 60));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return arguments.topics.empty() ? all : arguments.topics;
}

/// A file for each topic, in one folder.
Diagnostics write_tables(const ExportArguments& arguments, const record::Recording& recording,
                         std::vector<std::string>& products) {
  const auto topics = topics_of(arguments, recording);
  if (!topics) return topics.error();
  Diagnostics diagnostics;
  std::error_code error;
  std::filesystem::create_directories(arguments.csv, error);
  if (error) {
    diagnostics.error(Code::kFileNotWritable, "--csv",
                      fmt::format("cannot make the folder '{}': {}", arguments.csv, error.message()));
    return diagnostics;
  }
  std::set<std::string> names;
  for (const std::string& topic : *topics) {
    std::string name = record::file_name_of(topic);
    while (!names.insert(name).second) name += "_";
    const auto file = std::filesystem::path(arguments.csv) / (name + ".csv");
    if (const auto done = record::write_csv(recording, topic, file); done) {
      products.push_back(file.string());
    } else {
      diagnostics.append(done.error());
    }
  }
  return diagnostics;
}

int export_model(const ExportArguments& arguments, const Common& common) {
  Diagnostics diagnostics;
  MjcfExport wanted{.scenario = arguments.file, .out = arguments.mjcf, .seed = arguments.seed};
  wanted.overrides = app::parse_sets(arguments.sets, diagnostics);
  if (diagnostics.has_errors()) return report(diagnostics, common);
  const auto made = export_mjcf(wanted, common.library());
  if (!made) return report(made.error(), common);
  std::vector<std::string> products;
  for (const std::filesystem::path& file : made->files) products.push_back(file.string());
  if (common.json) {
    print({{"result", "exported"}, {"products", products}, {"lacks", made->lacks}});
    return kHeld;
  }
  fmt::print("wrote {} and {} mesh{}\nwhat the model lacks:\n", products.front(), products.size() - 1,
             products.size() == 2 ? "" : "es");
  for (const std::string& one : made->lacks) fmt::print("  {}\n", one);
  fmt::print("next:\n  python3 -m mujoco.viewer --mjcf={}\n", products.front());
  return kHeld;
}

int export_recording(const ExportArguments& arguments, const Common& common) {
  if (const Diagnostics diagnostics = check(arguments); diagnostics.has_errors()) return report(diagnostics, common);
  const auto recording = record::Recording::open(arguments.file);
  if (!recording) return report(recording.error(), common);
  std::vector<std::string> products;
  Diagnostics diagnostics;
  if (!arguments.csv.empty()) diagnostics.append(write_tables(arguments, *recording, products));
  if (!arguments.tum.empty()) {
    const auto done = record::write_tum(*recording, arguments.frames, arguments.frame, arguments.tum);
    if (done) {
      products.push_back(arguments.tum);
    } else {
      diagnostics.append(done.error(), "--frame");
    }
  }
  if (diagnostics.has_errors()) return report(diagnostics, common);
  // Messages of types without numbers, such as pictures, are missed only where nothing else is written.
  const Diagnostics unread = unread_parts(*recording, arguments.file, [&](const record::ChannelInfo& channel) {
    return !arguments.csv.empty() && arguments.topics.empty() && (products.empty() || channel.encoding != "protobuf");
  });
  if (unread.has_errors() && products.empty()) return report(unread, common);
  fmt::print(stderr, "{}", to_located_text(unread));
  const bool all = !unread.has_errors();
  if (common.json) {
    print({{"result", all ? "exported" : "partly exported"}, {"products", products}, {"diagnostics", to_json(unread)}});
  } else {
    for (const std::string& product : products) fmt::print("wrote {}\n", product);
  }
  return all ? kHeld : kBadInput;
}

struct RecoverArguments {
  std::string source, target;
};

int recover(const RecoverArguments& arguments, const Common& common) {
  const Diagnostics diagnostics = check_output(arguments.target, {arguments.source}, "OUT");
  if (diagnostics.has_errors()) return report(diagnostics, common);
  const auto recovered = record::recover(arguments.source, arguments.target);
  if (!recovered) return report(recovered.error(), common);
  if (common.json) {
    print({{"result", "recovered"},
           {"recording", arguments.target},
           {"messages", recovered->messages},
           {"attachments", recovered->attachments},
           {"lost", recovered->lost}});
    return kHeld;
  }
  for (const std::string& lost : recovered->lost) fmt::print("{}: {}\n", arguments.source, lost);
  fmt::print("{}: {} messages, {} attachments\n", arguments.target, recovered->messages, recovered->attachments);
  return kHeld;
}

}  // namespace

std::pair<CLI::App*, Verb> add_export(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* verb =
      app.add_subcommand("export",
                         "Write a recording as tables (CSV) or as a trajectory (TUM), the cell of a scenario "
                         "as a model of MuJoCo (MJCF)");
  verb->add_option("FILE", arguments->file, "Recording (MCAP); with --mjcf a scenario")->required();
  verb->add_option("--csv", arguments->csv, "A file for each topic into this folder")->type_name("FOLDER");
  verb->add_option("--topic", arguments->topics, "With --csv: only this topic; several times")
      ->type_name("TOPIC")
      ->allow_extra_args(false);
  verb->add_option("--tum", arguments->tum, "The poses of a frame: time x y z qx qy qz qw")->type_name("OUT.txt");
  verb->add_option("--frame", arguments->frame, "With --tum: the frame, such as arm/flange")->type_name("NAME");
  verb->add_option("--mjcf", arguments->mjcf,
                   "The cell at its start as a model of MuJoCo, with its meshes, into this folder")
      ->type_name("OUT");
  verb->add_option("--set", arguments->sets, "With --mjcf: change one value of the scenario; several times")
      ->type_name("POINTER=VALUE")
      ->allow_extra_args(false);
  verb->add_option("--seed", arguments->seed, "With --mjcf: seed, instead of the file's")->type_name("N");
  return {verb, [arguments, &common] {
            if (const Diagnostics wrong = check_kinds(*arguments); wrong.has_errors()) return report(wrong, common);
            return arguments->mjcf.empty() ? export_recording(*arguments, common) : export_model(*arguments, common);
          }};
}

std::pair<CLI::App*, Verb> add_recover(CLI::App& app, Common& common) {
  auto arguments = std::make_shared<RecoverArguments>();
  CLI::App* verb = app.add_subcommand("recover", "Write what is whole in a recording into a new one, with its index");
  verb->add_option("RECORDING", arguments->source, "Recording that was killed, cut or damaged")->required();
  verb->add_option("OUT", arguments->target, "The new one")->required();
  return {verb, [arguments, &common] { return recover(*arguments, common); }};
}

}  // namespace takt::tools
