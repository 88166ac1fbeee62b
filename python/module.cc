#include <nanobind/nanobind.h>

#include "python/bindings.h"
#include "python/errors.h"

NB_MODULE(_takt, module) {
  nanobind::set_leak_warnings(false);  // a program that ends by an exception keeps its cell in the traceback
  takt::python::bind_errors(module);
  takt::python::bind_operations(module);
  takt::python::bind_scenarios(module);
  takt::python::bind_recordings(module);
  takt::python::bind_expressions(module);
  takt::python::bind_cell(module);
  takt::python::bind_activities(module);
  takt::python::bind_commands(module);
}
