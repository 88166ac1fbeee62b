#include "core/device/material.h"

#include <filesystem>
#include <ranges>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/base/object_reader.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kMaterialsFile = "materials.json";

std::optional<double> optional_number(ObjectReader& reader, const char* key, const Range& range) {
  if (!reader.has(key)) return std::nullopt;
  return reader.number(key, 0.0, range);
}

Material read_material(ObjectReader& reader, const Material* like) {
  const auto value = [&](const char* key, double Material::*member, const Range& range) {
    return reader.number(key, like ? std::optional(like->*member) : std::nullopt, range);
  };
  Material material;
  material.stiffness = value("stiffness_N_m", &Material::stiffness, kPositive);
  material.damping = value("damping_N_s_m", &Material::damping, kNotNegative);
  material.friction = value("friction", &Material::friction, kNotNegative);
  material.torsion = reader.number("torsion_m", like ? like->torsion : 0.0, kNotNegative);
  material.rolling = reader.number("rolling_m", like ? like->rolling : 0.0, kNotNegative);
  material.oiled = reader.number("friction_oiled", like ? like->oiled : Material{}.oiled, kNotNegative);
  (void)reader.text("source", "");
  return material;
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
      const Material placeholder{.stiffness = 1.0};  // so that an unknown name is the only diagnostic
      const Material material = read_material(reader, base.empty() ? nullptr : like ? like : &placeholder);
      reader.finish();
      materials[name] = material;
    }
  }
  if (!contacts) return;
  for (std::size_t i = 0; i < contacts->size(); ++i) {
    const std::string at = pointer + "/contacts" + pointer_segment(i);
    ObjectReader reader((*contacts)[i], at, diagnostics);
    const auto between = reader.texts("between");
    MaterialRule rule;
    if (between.size() != 2) {
      diagnostics.error(Code::kWrongSize, reader.at("between"), fmt::format("{} materials", between.size()),
                        "Name the two materials that touch");
    } else {
      for (std::size_t side = 0; side < 2; ++side) {
        (void)find(between[side], reader.at("between") + pointer_segment(side), diagnostics);
        rule.between[side] = between[side];
      }
    }
    rule.stiffness = optional_number(reader, "stiffness_N_m", kPositive);
    rule.damping = optional_number(reader, "damping_N_s_m", kNotNegative);
    rule.friction = optional_number(reader, "friction", kNotNegative);
    rule.oiled = optional_number(reader, "friction_oiled", kNotNegative);
    (void)reader.text("source", "");
    reader.finish();
    rules.push_back(rule);
  }
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
