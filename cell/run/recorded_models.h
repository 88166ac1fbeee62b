#pragma once

#include <optional>
#include <vector>

#include "cell/file/description.h"
#include "core/base/output_file.h"
#include "core/device/device_file.h"
#include "record/recorder.h"
#include "record/recording.h"

namespace takt::cell {

/// The models that a scenario uses, and the tables of materials and threads beside models, as attachments of its
/// recording: "library/FOLDER/MODEL/FILE", FOLDER a number. What cannot be read is left out. Realtime: setup.
[[nodiscard]] std::vector<record::Attachment> model_attachments(const Description& description,
                                                                const device::ModelLibrary& models);

/// The models that a recording carries, unpacked for as long as this lives.
class RecordedModels {
 public:
  /// @return nothing: it carries none. Diagnostics: they are too large, or there is no room for them.
  [[nodiscard]] static Result<std::optional<RecordedModels>> unpack(const record::Recording& recording);

  [[nodiscard]] const device::ModelLibrary& library() const { return library_; }

 private:
  RecordedModels(TemporaryFolder folder, device::ModelLibrary library)
      : folder_(std::move(folder)), library_(std::move(library)) {}

  TemporaryFolder folder_;
  device::ModelLibrary library_;
};

}  // namespace takt::cell
