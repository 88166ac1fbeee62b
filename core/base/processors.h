#pragma once

/// On which processors of the machine the calling thread may run. Threads inherit it from the thread that starts them.
/// Processors are numbered from 0, as Linux does. Realtime: setup, all functions.
namespace takt {

/// The machine has it, and it is online.
[[nodiscard]] bool has_processor(int processor);
/// From now on the calling thread runs on this processor only. @return false: refused, nothing has changed
bool run_on_processor(int processor);
/// From now on the calling thread, and those that it starts, leave this processor to others. @return false: it is the
/// only one that they may use, or refused; nothing has changed
bool keep_off_processor(int processor);

}  // namespace takt
