#pragma once

#include <nanobind/nanobind.h>

/// The parts of the module takt._takt: what Python's classes in python/takt are made of (docs/python.md).
namespace takt::python {

class CellHandle;

void bind_operations(nanobind::module_& module);         ///< the operations' tables
void bind_scenarios(nanobind::module_& module);          ///< runs of scenario files, checks
void bind_recordings(nanobind::module_& module);         ///< channels as numpy, comparisons
void bind_expressions(nanobind::module_& module);        ///< sensors and states with their operators
void bind_cell(nanobind::module_& module);               ///< a cell, its devices
void bind_channels(nanobind::class_<CellHandle>& cell);  ///< of a cell
void bind_activities(nanobind::module_& module);         ///< what devices do
void bind_commands(nanobind::module_& module);           ///< commands of one's own, with event handlers

}  // namespace takt::python
