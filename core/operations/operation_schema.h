#pragma once

#include "core/table/schema.h"

namespace takt::activity {

/// Defines all operations of the process in a schema, from their tables: a definition per operation, which of them are
/// steps and which are commands, and which definition holds for which value of "do". Realtime: setup.
void define_operations(table::SchemaPrinter& schema);

}  // namespace takt::activity
