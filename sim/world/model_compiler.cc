#include "sim/world/model_compiler.h"

#include <clocale>
#include <cstring>
#include <vector>

#include <fmt/format.h>
#include <locale.h>
#include <mujoco/mujoco.h>

#include "sim/contact/islands.h"
#include "sim/model/mujoco_errors.h"
#include "sim/world/reach.h"
#include "sim/world/spec_builder.h"

namespace takt::sim {

void MujocoDeleter::operator()(mjSpec_* spec) const { mj_deleteSpec(spec); }
void MujocoDeleter::operator()(mjModel_* model) const { mj_deleteModel(model); }
void MujocoDeleter::operator()(mjData_* data) const { mj_deleteData(data); }

namespace {

/// MuJoCo reads mesh files with the decimal point of the process: while this lives, this thread has that of C. Its
/// other threads cannot be given one, so the caller does without them where it matters.
class PointInNumbers {
 public:
  PointInNumbers() : classic_(newlocale(LC_ALL_MASK, "C", nullptr)), before_(uselocale(classic_)) {}
  ~PointInNumbers() {
    uselocale(before_);
    freelocale(classic_);
  }
  PointInNumbers(const PointInNumbers&) = delete;
  PointInNumbers& operator=(const PointInNumbers&) = delete;

 private:
  locale_t classic_, before_;
};

/// Leaves out of the search for contacts what can never meet. @return null if MuJoCo refuses
Owned<mjModel> search_less(mjSpec& spec, Owned<mjModel> model) {
  const auto pairs = never_meet(*model);
  if (pairs.empty()) return model;
  const std::vector<int> alone = meet_nothing(*model, pairs);
  for (const auto& [a, b] : pairs) {
    const char* first = mj_id2name(model.get(), mjOBJ_BODY, a);
    const char* second = mj_id2name(model.get(), mjOBJ_BODY, b);
    if (!first || !second) continue;  // a hook's own body
    mjsExclude* exclude = mjs_addExclude(&spec);
    mjs_setString(exclude->bodyname1, first);
    mjs_setString(exclude->bodyname2, second);
  }
  Owned<mjModel> less(mj_compile(&spec, nullptr));
  if (!less) return less;
  for (const int body : alone) {
    less->body_contype[body] = less->body_conaffinity[body] = 0;
    for (int i = less->body_geomadr[body]; i < less->body_geomadr[body] + less->body_geomnum[body]; ++i)
      less->geom_contype[i] = less->geom_conaffinity[i] = 0;
  }
  return less;
}

}  // namespace

Result<Owned<mjModel_>> compile_model(const WorldDescription& description, bool visuals, const SpecHook& hook) {
  Owned<mjSpec> spec(mj_makeSpec());
  build_spec(description, visuals, *spec);
  for (const SimDeviceDescription& device : description.devices) {
    if (device.extend) device.extend(*spec);
  }
  if (hook) hook(*spec);
  if (std::strcmp(std::localeconv()->decimal_point, ".") != 0) spec->compiler.usethread = 0;
  const PointInNumbers point;
  Owned<mjModel> model(mj_compile(spec.get(), nullptr));
  if (model && !visuals && !description.physics.search_all_pairs) model = search_less(*spec, std::move(model));
  if (model) choose_matrices(*model);
  if (model) return model;
  return failure(Code::kSystem, "", fmt::format("MuJoCo cannot build the world: {}", mjs_getError(spec.get())));
}

Diagnostics make_data(const mjModel_& model, Owned<mjData_>& data) {
  constexpr double kMiB = 1024.0 * 1024.0;
  Diagnostics diagnostics;
  const auto made = mujoco_call("", [&] { data.reset(mj_makeData(&model)); });
  if (made && data) return diagnostics;
  diagnostics.error(Code::kSystem, "",
                    fmt::format("a simulation of {} bodies needs more than {:.0f} MiB of memory, which the system does "
                                "not give",
                                model.nbody, static_cast<double>(model.narena) / kMiB),
                    "Simulate fewer free objects, or allow the process more memory");
  return diagnostics;
}

}  // namespace takt::sim
