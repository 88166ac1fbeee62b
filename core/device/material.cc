#include "core/device/material.h"

#include <filesystem>
#include <ranges>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/table/table.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kMaterialsFile = "materials.json";

using table::NameOf;
using table::Rule;

/// What a file says of a material: figures, and whose count where it says nothing.
struct MaterialEntry : Material {
  std::string like = {};
  std::string source = {};
};

template <class M>
void add_source(table::Table<M>& table) {
  table.text("source", &M::source, "Where the figures come from.");
}

const table::Table<MaterialEntry>& material_entry_table() {
  using M = MaterialEntry;
  static const auto table = [] {
    table::Table<M> material;
    material
        .named("like", NameOf::kMaterial, &M::like,
               "Material whose figures count where this one says nothing; without it stiffness, damping and friction "
               "are required.")
        .not_empty()
        .number("stiffness_N_m", "N/m", &M::stiffness, kPositive, "Stiffness of one side of a contact.")
        .fallback({})
        .number("damping_N_s_m", "N*s/m", &M::damping, kNotNegative, "Damping of one side of a contact.")
        .fallback({})
        .number("friction", "", &M::friction, kNotNegative, "Coefficient of sliding (Coulomb) friction.")
        .fallback({})
        .number("torsion_m", "m", &M::torsion, kNotNegative,
                "Radius of the contact patch that resists twisting: torque about the normal over friction force.")
        .number("rolling_m", "m", &M::rolling, kNotNegative, "Torque against rolling over friction force.");
    add_source(material);
    material.rule({.kind = Rule::Kind::kAnyOf,
                   .groups = {{"like"}, {"stiffness_N_m", "damping_N_s_m", "friction"}},
                   .hint = "Give 'stiffness_N_m', 'damping_N_s_m' and 'friction', or 'like'"});
    return material;
  }();
  return table;
}

struct RuleEntry : MaterialRule {
  std::vector<std::string> names = {};
  std::string source = {};
};

const table::Table<RuleEntry>& material_rule_table() {
  using R = RuleEntry;
  static const auto table = [] {
    table::Table<R> rule;
    rule.value("between", table::texts_type({.min = 2, .max = 2}), &R::names,
               "The two materials; the same twice for a material against itself.")
        .required()
        .number("stiffness_N_m", "N/m", &R::stiffness, kPositive, "Stiffness of the contact.")
        .number("damping_N_s_m", "N*s/m", &R::damping, kNotNegative, "Damping of the contact.")
        .number("friction", "", &R::friction, kNotNegative, "Coefficient of sliding (Coulomb) friction.");
    add_source(rule);
    return rule;
  }();
  return table;
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
      MaterialEntry material;
      if (const auto base = table::word_at("like", reader); base && !base->empty()) {
        const Material placeholder{.stiffness = 1.0};  // so that an unknown name is the only diagnostic
        const Material* like = find(*base, reader.at("like"), diagnostics);
        static_cast<Material&>(material) = like != nullptr ? *like : placeholder;
      }
      material_entry_table().read_into(material, {reader});
      reader.finish();
      materials[name] = material;
    }
  }
  if (!contacts) return;
  for (std::size_t i = 0; i < contacts->size(); ++i) {
    const std::string at = pointer + "/contacts" + pointer_segment(i);
    ObjectReader reader((*contacts)[i], at, diagnostics);
    RuleEntry rule;
    material_rule_table().read_into(rule, {reader});
    for (std::size_t side = 0; side < rule.names.size() && rule.names.size() == 2; ++side) {
      (void)find(rule.names[side], reader.at("between") + pointer_segment(side), diagnostics);
      rule.between[side] = rule.names[side];
    }
    reader.finish();
    rules.push_back(rule);
  }
}

table::Field materials_field() {
  table::Field materials = table::field("materials", table::Field::Type::kMap, "Surfaces by name.");
  materials.items = {material_entry_table().form("material")};
  materials.any_key = true;
  return materials;
}

table::Field contacts_field() {
  table::Field contacts = table::field("contacts", table::Field::Type::kList,
                                       "What two materials do together where it is not what follows from the two.");
  contacts.items = {material_rule_table().form("contact_rule")};
  return contacts;
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
                  fmt::format("the material '{}' is known from another folder", name), "another name");
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
