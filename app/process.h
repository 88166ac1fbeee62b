#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace takt::app {

/// Makes a process fit to end only with a status of its own. Call it first in main(). From then on
/// - closed standard streams are /dev/null (standard output: one that refuses what is written, so that the loss shows),
///   so that no file that is opened gets their number;
/// - messages that stderr does not take (closed, disk full) are dropped instead of ending the process;
/// - a file that is too large and a pipe without a reader are errors of the write, not signals;
/// - SIGINT, SIGTERM and SIGHUP end the process with status 130 until catch_interrupts();
/// - an exception that nobody catches, and a crash inside of a library, are reported with what was being done, and end
///   it with status 3 (a crash with its signal where core dumps are asked for).
void prepare_process();

/// Runs `work`, which is described by `what` ("run scenarios/touch.json"), and checks that its output was written.
/// An exception out of it becomes a message that names `what`. @return the status of `work`, or 3
[[nodiscard]] int run_guarded(const std::string& what, const std::function<int()>& work);

/// A debugger or a tracer holds on to this process: its clocks go on while it stands.
[[nodiscard]] bool is_traced();

/// Makes SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) count instead of ending the process; the
/// number of signals so far. The first asks for an orderly end. From the second on the process has 3 s left, whatever
/// it waits for; the third ends it at once. Status 130 then.
[[nodiscard]] const std::atomic<int>& catch_interrupts();

}  // namespace takt::app
