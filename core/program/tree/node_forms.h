#pragma once

#include <vector>

#include "core/base/form.h"

/// Forms of the nodes of a program that are no operations (docs/tables.md). Realtime: setup.
namespace takt::program {

/// What every node has, and keys of its own. @param kind  the word after "do", and the definition's name in the schema
[[nodiscard]] Form node_form(const char* kind, const char* doc, std::vector<Key> keys, std::vector<Rule> rules = {});

[[nodiscard]] const Form& branch_form();
[[nodiscard]] const Form& call_form();
[[nodiscard]] const Form& fail_form();
[[nodiscard]] const Form& for_each_form();
/// "grid" of for_each.
[[nodiscard]] const Form& grid_form();
[[nodiscard]] const Form& let_form();
[[nodiscard]] const Form& log_form();
[[nodiscard]] const Form& parallel_form();
[[nodiscard]] const Form& repeat_form();
[[nodiscard]] const Form& sequence_form();
[[nodiscard]] const Form& stop_form();
[[nodiscard]] const Form& try_form();
/// One of "programs".
[[nodiscard]] const Form& sub_program_form();

}  // namespace takt::program
