#include "python/cell_handle.h"

#include <unistd.h>

#include "app/cell_setup.h"
#include "core/base/diagnostics.h"
#include "python/errors.h"

#include <nlohmann/json.hpp>

namespace takt::python {

app::CellSetup CellHandle::setup(RunSettings& settings) {
  app::CellSetup made{
      .open = settings.parsed.open, .run = settings.parsed.run, .core = settings.core, .token = settings.token};
  made.run.interrupt = &interrupts_.count();
  made.run.operate = [this](cell::Operator&) { interrupts_.poll(); };
  return made;
}

CellHandle::CellHandle(const std::string& file, const std::string& options)
    : thread_(std::this_thread::get_id()), process_(::getpid()) {
  RunSettings settings = run_settings(file, options);
  settings.models.pop_back();  // the install's: the cell adds it by itself
  app::CellOptions wanted{.models = settings.models, .quiet = true};
  const auto json = nlohmann::json::parse(options);
  if (json.contains("cooperating"))
    wanted.cooperating = json.at("cooperating").get<std::vector<std::vector<std::string>>>();
  const nanobind::gil_scoped_release unlocked;
  cell_ = std::make_unique<app::Cell>(file, wanted, setup(settings));
}

CellHandle::~CellHandle() {
  // A child of a fork has no threads of its parent's cell to join, and must not close its files.
  if (::getpid() != process_) {
    (void)cell_.release();
    return;
  }
  const nanobind::gil_scoped_release unlocked;
  cell_.reset();
}

void CellHandle::check_owner() const {
  if (::getpid() != process_)
    raise_error("UsageError", Code::kNotPossibleNow, "", "the cell belongs to the process that has opened it",
                "Open a cell of its own in each process, after the fork");
  if (std::this_thread::get_id() != thread_)
    raise_error("UsageError", Code::kNotPossibleNow, "", "the cell belongs to the thread that has opened it",
                "Call it from that thread only");
}

app::Cell& CellHandle::get() const {
  check_owner();
  if (finished_)
    raise_error("UsageError", Code::kNotPossibleNow, "", "the run of this cell has ended",
                "Use the cell inside of its 'with' block, or open another one");
  return *cell_;
}

std::string CellHandle::finish(const std::string& why, const std::function<std::string()>& run_again) {
  app::Cell& open = get();
  finished_ = true;
  const Diagnostics diagnostics = diagnostics_from(why);
  nlohmann::ordered_json report;
  {
    const nanobind::gil_scoped_release unlocked;
    report = to_json(open.finish(diagnostics, run_again));
    report["title"] = open.title();
    report["warnings"] = cell::to_json(open.warnings());
  }
  return cell::to_output_text(std::move(report));
}

}  // namespace takt::python
