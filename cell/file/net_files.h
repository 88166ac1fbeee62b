#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"

namespace takt::net {
struct NetDescription;
}

namespace takt::cell {

/// A net that the scenario's program may run, under a name.
struct NetEntry {
  std::string name;
  std::string file;  ///< it was read from; empty if it stands in the scenario itself
  std::shared_ptr<const net::NetDescription> net;
};

/// Reads "nets": name to a net, or to the file of one, relative to `folder` and below it. The files' content is put in
/// the place of their names, so that the document says all. Realtime: setup.
[[nodiscard]] std::vector<NetEntry> read_nets(nlohmann::ordered_json& document, const std::filesystem::path& folder,
                                              Diagnostics& diagnostics);

}  // namespace takt::cell
