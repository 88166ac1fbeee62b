#include "core/device/material.h"

#include <filesystem>
#include <ranges>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/form_of.h"
#include "core/base/json.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kMaterialsFile = "materials.json";

Key source_key() { return text_key("source", "Where the figures come from.").optional(); }

const FormOf<Material>& form_of_material() {
  const auto key = [](const char* name, const char* unit, const Range& range, const char* doc) {
    return number_key(name, unit, range, doc).optional("that of 'like'");
  };
  static const auto form =
      FormOf<Material>("material")
          .add(text_key("like",
                        "Material whose figures count where this one says nothing; without it stiffness, damping and "
                        "friction are required.")
                   .optional())
          .add(key("stiffness_N_m", "N/m", kPositive, "Stiffness of one side of a contact."), &Material::stiffness)
          .add(key("damping_N_s_m", "N s/m", kNotNegative, "Damping of one side of a contact."), &Material::damping)
          .add(key("friction", "", kNotNegative, "Coefficient of sliding (Coulomb) friction."), &Material::friction)
          .add(number_key("torsion_m", "m", kNotNegative,
                          "Radius of the contact patch that resists twisting: torque about the normal over friction "
                          "force.")
                   .optional(),
               &Material::torsion)
          .add(number_key("rolling_m", "m", kNotNegative, "Torque against rolling over normal force.").optional(),
               &Material::rolling)
          .add(number_key("friction_oiled", "", kNotNegative,
                          "Coefficient of sliding friction with oil between the surfaces.")
                   .optional(),
               &Material::oiled)
          .add(source_key());
  return form;
}

const FormOf<MaterialRule>& form_of_contact() {
  static const auto form =
      FormOf<MaterialRule>("contact_rule")
          .add(pair_key("between", "The two materials; the same twice for a material against itself."),
               [](FormReader& from, MaterialRule& rule) {
                 const std::vector<std::string> names = from.texts("between");
                 if (names.size() == 2) rule.between = {names[0], names[1]};
               })
          .add(number_key("stiffness_N_m", "N/m", kPositive, "Stiffness of the contact.").optional(),
               &MaterialRule::stiffness)
          .add(number_key("damping_N_s_m", "N s/m", kNotNegative, "Damping of the contact.").optional(),
               &MaterialRule::damping)
          .add(number_key("friction", "", kNotNegative, "Coefficient of sliding (Coulomb) friction.").optional(),
               &MaterialRule::friction)
          .add(number_key("friction_oiled", "", kNotNegative, "The same with oil between the two.").optional(),
               &MaterialRule::oiled)
          .add(source_key());
  return form;
}

}  // namespace

const Material* MaterialTable::find(const std::string& name, const std::string& pointer,
                                    Diagnostics& diagnostics) const {
  if (const auto found = materials.find(name); found != materials.end()) return &found->second;
  std::vector<std::string> names;
  for (const auto& known : materials | std::views::keys) names.push_back(known);
  diagnostics.error(Code::kUnknownName, pointer, fmt::format("unknown material '{}'", name),
                    nearest_choice(name, names));
  return nullptr;
}

void MaterialTable::read(const Json* entries, const Json* contacts, const std::string& pointer,
                         Diagnostics& diagnostics) {
  if (entries) {
    for (const auto& [name, json] : entries->items()) {
      if (name.starts_with("$") || name == "comment") continue;
      const std::string at = pointer + "/materials" + pointer_segment(name);
      ObjectReader reader(json, at, diagnostics);
      const std::string base = reader.text("like", "");
      const Material* like = base.empty() ? nullptr : find(base, reader.at("like"), diagnostics);
      if (base.empty())
        for (const char* key : {"stiffness_N_m", "damping_N_s_m", "friction"})
          if (!reader.has(key))
            diagnostics.error(Code::kMissing, at, fmt::format("key '{}' is missing", key),
                              "Give a number, or \"like\": MATERIAL");
      Material material = like ? *like : Material{};
      form_of_material().read_into(reader, material);
      reader.finish();
      materials[name] = material;
    }
  }
  if (!contacts) return;
  for (std::size_t i = 0; i < contacts->size(); ++i) {
    const std::string at = pointer + "/contacts" + pointer_segment(i);
    rules.push_back(form_of_contact().read((*contacts)[i], at, diagnostics));
    for (std::size_t side = 0; side < 2; ++side)
      if (const std::string& one = rules.back().between[side]; !one.empty())
        (void)find(one, at + "/between" + pointer_segment(side), diagnostics);
  }
}

const Form& material_form() { return form_of_material().form(); }
const Form& contact_rule_form() { return form_of_contact().form(); }
const Form& materials_form() {
  static const Form form{
      .doc = "Surfaces for the simulation and what pairs of them do together (docs/contacts.md).",
      .keys = {members_key("materials", object_key("", material_form(), ""), "Surfaces by name.").with_comments(),
               objects_key("contacts", 0, contact_rule_form(), "Pairs of materials.").optional()}};
  return form;
}

Result<MaterialTable> read_materials(const ModelLibrary& library) {
  std::set<std::filesystem::path> folders;
  for (const std::string& name : library.names()) {
    if (const auto folder = library.find(name)) folders.insert(folder->parent_path());
  }
  MaterialTable table;
  Diagnostics diagnostics;
  for (const auto& folder : folders) {
    const auto file = folder / kMaterialsFile;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) continue;
    auto json = read_json(file);
    if (!json) {
      diagnostics.append(json.error());
      continue;
    }
    Diagnostics own;
    ObjectReader reader(*json, "", own);
    const Json* entries = reader.object("materials");
    if (entries) {
      for (const auto& [name, ignored_entry] : entries->items()) {
        if (!table.materials.contains(name)) continue;
        own.error(Code::kDuplicate, reader.at("materials") + pointer_segment(name),
                  fmt::format("the material '{}' is known from another folder", name), "Choose another name");
      }
    }
    table.read(entries, reader.array("contacts", false), "", own);
    reader.finish();
    own.set_file(file.string());
    diagnostics.append(own);
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return table;
}

}  // namespace takt::device
