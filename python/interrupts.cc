#include "python/interrupts.h"

#include <nanobind/nanobind.h>

namespace takt::python {

void Interrupts::poll() {
  constexpr std::chrono::milliseconds kEvery{20};
  const auto now = Clock::now();
  if (now - looked_ < kEvery) return;
  looked_ = now;
  const nanobind::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() == 0) return;
  PyErr_Clear();
  ++count_;
}

}  // namespace takt::python
