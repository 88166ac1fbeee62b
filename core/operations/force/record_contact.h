#pragma once

#include <string>

#include "core/operations/table/operation.h"

/// "record_contact": keeps the last touch of an arm under a name. Realtime: setup.
namespace takt::operations {

struct RecordContactParameters {
  std::string arm = {};                 ///< empty: the only one
  std::string as = {};                  ///< name under which the contact is kept
  std::string name = {}, pointer = {};  ///< for people; in its file
};
[[nodiscard]] const ParameterTable<RecordContactParameters>& record_contact_parameters();
[[nodiscard]] Operation record_contact_operation();

}  // namespace takt::operations
