#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "tools/import/mesh_files.h"
#include "tools/import/node.h"

namespace takt::tools {

/// Something that was guessed, replaced or left out.
struct ImportNote {
  std::string key;    ///< what: "joint 'a1' limit velocity", "/limits/jerk_rad_s3"
  std::string value;  ///< what it is now, with unit
  std::string why;
};

/// What a file says of a joint and a URDF has no word for.
struct JointExtras {
  std::optional<double> armature;  ///< kg m^2 or kg
  std::optional<double> home;      ///< rad or m
};

/// A foreign URDF on its way into a model folder, or what another format says in its words. Each step changes the tree
/// and writes down what it did.
struct Draft {
  Node robot;
  std::vector<ImportNote> notes;
  Diagnostics diagnostics;  ///< errors that no guess can mend
  std::string base, flange;
  std::vector<std::string> without;               ///< links that are left out, with what hangs on them
  std::vector<std::string> without_effort;        ///< movable joints whose torque limit is not known
  std::set<std::string> mimicked;                 ///< joints that others followed before they were frozen
  std::map<std::string, std::string> mesh_files;  ///< path below the folder of the model, content
  std::map<std::string, MeshFile> meshes;         ///< that came with the tree, by their name in it
  std::map<std::string, JointExtras> extras;      ///< by joint
  std::string home;                               ///< what the home in `extras` is called; empty: there is none

  void note(std::string key, std::string value, std::string why) {
    notes.push_back({std::move(key), std::move(value), std::move(why)});
  }
  [[nodiscard]] Node* link(std::string_view name);
  /// The joint that carries the link, or null.
  [[nodiscard]] Node* joint_above(std::string_view link);
  /// The joints that hang on the link.
  [[nodiscard]] std::vector<Node*> joints_below(std::string_view link);
};

[[nodiscard]] std::string parent_of(const Node& joint);
[[nodiscard]] std::string child_of(const Node& joint);
[[nodiscard]] bool is_movable(const Node& joint);

// The steps, in this order. None needs the tree to be one but those from guess_chain on.

/// Words of other programs go; materials get names and colours; names become plain.
void clean(Draft& draft, const std::string& name);
/// Couplings are frozen; limits that are missing get conservative ones.
void complete_joints(Draft& draft);
/// Meshes become files of the model; what cannot be read falls back to the collision shape, or goes.
void gather_meshes(Draft& draft, const MeshPaths& paths);
/// Finds base and flange where they are empty, drops what lies above the base, freezes joints beside the chain.
void guess_chain(Draft& draft);
/// Links that move and have no body, no mass or no shape get one.
void complete_bodies(Draft& draft);

}  // namespace takt::tools
