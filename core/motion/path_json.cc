#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/motion/path.h"

namespace takt::motion {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const auto& vector) {
  Json json = Json::array();
  for (int i = 0; i < static_cast<int>(vector.size()); ++i) json.push_back(vector[i]);
  return json;
}

JointVector joints(ObjectReader& reader, const std::string& key) {
  const auto values = reader.numbers(key, 0);
  if (values.size() > kinematics::kMaxJoints) {
    reader.diagnostics().error(Code::kWrongSize, reader.at(key), fmt::format("{} joints", values.size()),
                               fmt::format("Keep it to at most {}", kinematics::kMaxJoints));
    return {};
  }
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void check_same_size(ObjectReader& reader, const std::string& key, const JointVector& start, const JointVector& goal) {
  if (start.size() == goal.size()) return;
  reader.diagnostics().error(Code::kWrongSize, reader.at(key), fmt::format("{} joints", goal.size()),
                             fmt::format("Give as many as at the start: {}", start.size()));
}

void check_unit(ObjectReader& reader, const std::string& key, double norm) {
  constexpr double kUnitTolerance = 1e-9;
  if (std::abs(norm - 1.0) <= kUnitTolerance) return;
  reader.diagnostics().error(Code::kOutOfRange, reader.at(key), fmt::format("'{}' has length {}", key, norm),
                             "Give a vector of length 1");
}

Geometry read_joint_line(ObjectReader& reader) {
  JointLine line{.q_start = joints(reader, "start"), .q_goal = joints(reader, "goal")};
  check_same_size(reader, "goal", line.q_start, line.q_goal);
  return line;
}

void read_held(ObjectReader& reader, JointVector& start, JointVector& goal) {
  if (reader.has("held_start")) start = joints(reader, "held_start");
  if (reader.has("held_goal")) goal = joints(reader, "held_goal");
  check_same_size(reader, "held_goal", start, goal);
}

void read_start(ObjectReader& reader, Eigen::Vector3d& p, Eigen::Quaterniond& R) {
  const std::vector<double> start = reader.numbers("start", 7, std::vector<double>{0, 0, 0, 1, 0, 0, 0});
  p = {start[0], start[1], start[2]};
  R = Eigen::Quaterniond(start[3], start[4], start[5], start[6]);
  check_unit(reader, "start", R.norm());
}

CartesianLine read_line(ObjectReader& reader) {
  CartesianLine line;
  read_start(reader, line.p_start, line.R_start);
  line.direction = reader.vector("direction", line.direction);
  check_unit(reader, "direction", line.direction.norm());
  line.length = reader.number("length_m", 0.0, kNotNegative);
  line.axis = reader.vector("axis", line.axis);
  check_unit(reader, "axis", line.axis.norm());
  line.angle = reader.number("angle_rad", 0.0, kNotNegative);
  read_held(reader, line.held_start, line.held_goal);
  return line;
}

Geometry read_cartesian_line(ObjectReader& reader) { return read_line(reader); }

Geometry read_carried_line(ObjectReader& reader) {
  CarriedLine carried;
  if (const Json* json = reader.object("line")) {
    ObjectReader line(*json, reader.at("line"), reader.diagnostics());
    line.choice("kind", {"cartesian_line"});
    carried.line = read_line(line);
    line.finish();
  }
  carried.carrier_start = reader.vector("carrier_start");
  carried.carrier_goal = reader.vector("carrier_goal");
  const std::vector<double> mount = reader.numbers("mount", 7, std::vector<double>{0, 0, 0, 1, 0, 0, 0});
  const Eigen::Quaterniond R(mount[3], mount[4], mount[5], mount[6]);
  check_unit(reader, "mount", R.norm());
  carried.X_FA.translation() << mount[0], mount[1], mount[2];
  carried.X_FA.linear() = R.normalized().toRotationMatrix();
  return carried;
}

Geometry read_cartesian_arc(ObjectReader& reader) {
  CartesianArc arc;
  read_start(reader, arc.p_start, arc.R_start);
  arc.centre = reader.vector("centre");
  arc.normal = reader.vector("normal");
  check_unit(reader, "normal", arc.normal.norm());
  arc.arc = reader.number("arc_rad", {}, kNotNegative);
  arc.axis = reader.vector("axis", arc.axis);
  check_unit(reader, "axis", arc.axis.norm());
  arc.angle = reader.number("angle_rad", 0.0, kNotNegative);
  read_held(reader, arc.held_start, arc.held_goal);
  const Eigen::Vector3d out = arc.p_start - arc.centre;
  constexpr double kSquare = 1e-9;
  if (std::abs(out.dot(arc.normal)) > kSquare * (1.0 + out.norm())) {
    reader.diagnostics().error(Code::kOutOfRange, reader.at("normal"), "the normal leans towards the start of the arc",
                               "Choose a normal perpendicular to the line from the centre to the start");
  }
  return arc;
}

/// The six coefficients of a polynomial, each a list of `size` numbers (0: all of one length).
std::vector<std::vector<double>> coefficients(ObjectReader& reader, const std::string& key, std::size_t size) {
  std::vector<std::vector<double>> rows;
  const Json* list = reader.array(key);
  const auto complain = [&] {
    reader.diagnostics().error(
        Code::kWrongSize, reader.at(key), "no six coefficients of one length",
        size == 0 ? "Give six lists of numbers" : fmt::format("Give six lists of {} numbers", size));
    return std::vector<std::vector<double>>(6, std::vector<double>(size, 0.0));
  };
  if (!list || list->size() != 6) return complain();
  for (const Json& row : *list) {
    const bool numbers_only =
        row.is_array() && std::ranges::all_of(row, [](const Json& entry) { return entry.is_number(); });
    if (!numbers_only) return complain();
    rows.push_back(row.get<std::vector<double>>());
    const std::size_t wanted = size == 0 ? rows.front().size() : size;
    if (rows.back().size() != wanted || wanted > kinematics::kMaxJoints) return complain();
  }
  return rows;
}

template <class T>
Quintic<T> read_quintic(ObjectReader& reader, const std::string& key, std::size_t size) {
  const auto rows = coefficients(reader, key, size);
  Quintic<T> polynomial;
  for (std::size_t i = 0; i < 6; ++i) {
    polynomial.c[i] = Eigen::Map<const Eigen::VectorXd>(rows[i].data(), static_cast<Eigen::Index>(rows[i].size()));
  }
  return polynomial;
}

Geometry read_joint_curve(ObjectReader& reader) {
  return JointCurve{read_quintic<JointVector>(reader, "coefficients", 0)};
}

Geometry read_cartesian_curve(ObjectReader& reader) {
  CartesianCurve curve;
  const std::vector<double> w = reader.numbers("reference", 4, std::vector<double>{1, 0, 0, 0});
  curve.R_ref = Eigen::Quaterniond(w[0], w[1], w[2], w[3]);
  check_unit(reader, "reference", curve.R_ref.norm());
  curve.p = read_quintic<Eigen::Vector3d>(reader, "position", 3);
  curve.phi = read_quintic<Eigen::Vector3d>(reader, "turn", 3);
  curve.held_curve = read_quintic<JointVector>(reader, "held", 0);
  return curve;
}

struct Kind {
  std::string name;
  Geometry (*read)(ObjectReader&);
};

const Kind kKinds[] = {{"joint_line", read_joint_line},       {"cartesian_line", read_cartesian_line},
                       {"cartesian_arc", read_cartesian_arc}, {"carried_line", read_carried_line},
                       {"joint_curve", read_joint_curve},     {"cartesian_curve", read_cartesian_curve}};

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.push_back(kind.name);
  return names;
}

Geometry read_geometry(ObjectReader& reader, const std::string& name) {
  Geometry geometry;
  for (const Kind& kind : kKinds) {
    if (kind.name != name) continue;
    geometry = kind.read(reader);
    reader.finish();
  }
  return geometry;
}

Json pose_numbers(const Eigen::Vector3d& p, const Eigen::Quaterniond& R) {
  return {p.x(), p.y(), p.z(), R.w(), R.x(), R.y(), R.z()};
}

Json write(const JointLine& line) {
  return {{"kind", "joint_line"}, {"start", numbers(line.q_start)}, {"goal", numbers(line.q_goal)}};
}

Json write(const CartesianLine& line) {
  return {{"kind", "cartesian_line"},
          {"start", pose_numbers(line.p_start, line.R_start)},
          {"direction", numbers(line.direction)},
          {"length_m", line.length},
          {"axis", numbers(line.axis)},
          {"angle_rad", line.angle},
          {"held_start", numbers(line.held_start)},
          {"held_goal", numbers(line.held_goal)}};
}

template <class T>
Json write(const Quintic<T>& polynomial) {
  Json json = Json::array();
  for (const T& c : polynomial.c) json.push_back(numbers(c));
  return json;
}

Json write(const CartesianArc& arc) {
  return {{"kind", "cartesian_arc"},
          {"start", pose_numbers(arc.p_start, arc.R_start)},
          {"centre", numbers(arc.centre)},
          {"normal", numbers(arc.normal)},
          {"arc_rad", arc.arc},
          {"axis", numbers(arc.axis)},
          {"angle_rad", arc.angle},
          {"held_start", numbers(arc.held_start)},
          {"held_goal", numbers(arc.held_goal)}};
}

Json write(const CarriedLine& carried) {
  return {{"kind", "carried_line"},
          {"line", write(carried.line)},
          {"carrier_start", numbers(carried.carrier_start)},
          {"carrier_goal", numbers(carried.carrier_goal)},
          {"mount", pose_numbers(carried.X_FA.translation(), Eigen::Quaterniond(carried.X_FA.linear()))}};
}

Json write(const JointCurve& curve) { return {{"kind", "joint_curve"}, {"coefficients", write(curve.q)}}; }

Json write(const CartesianCurve& curve) {
  const Eigen::Quaterniond& R = curve.R_ref;
  return {{"kind", "cartesian_curve"},
          {"reference", {R.w(), R.x(), R.y(), R.z()}},
          {"position", write(curve.p)},
          {"turn", write(curve.phi)},
          {"held", write(curve.held_curve)}};
}

Json write(const CompositePath& path) {
  Json pieces = Json::array();
  for (const PathPiece& piece : path.pieces) {
    pieces.push_back({{"s", {piece.s_begin, piece.s_end}},
                      {"own", {piece.own_begin, piece.own_end}},
                      {"geometry", std::visit([](const auto& geometry) { return write(geometry); }, piece.geometry)}});
  }
  return {{"kind", "composite"}, {"pieces", std::move(pieces)}};
}

PathPiece read_piece(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  const auto s = reader.numbers("s", 2, std::vector<double>{0, 1});
  const auto own = reader.numbers("own", 2, std::vector<double>{0, 1});
  PathPiece piece{.geometry = {}, .s_begin = s[0], .s_end = s[1], .own_begin = own[0], .own_end = own[1]};
  if (const Json* geometry = reader.object("geometry")) {
    ObjectReader inner(*geometry, reader.at("geometry"), diagnostics);
    const std::string name = inner.choice("kind", kind_names());
    piece.geometry = read_geometry(inner, name);
  }
  reader.finish();
  if (!(piece.s_begin < piece.s_end))
    diagnostics.error(Code::kOutOfRange, pointer + "/s", "a piece without length", "Begin below the end");
  return piece;
}

/// Two pieces of one space meet where one ends and the next begins.
bool meet(const PathPiece& a, const PathPiece& b) {
  const PathSample end = sample(a.geometry, {.s = a.own_end});
  const PathSample begin = sample(b.geometry, {.s = b.own_begin});
  if (end.cartesian != begin.cartesian) return true;
  constexpr double kGap = 1e-6;  // m or rad: less is rounding
  if (!end.cartesian)
    return end.joints.q.size() == begin.joints.q.size() && (end.joints.q - begin.joints.q).norm() < kGap;
  return (end.frame.X_BM.matrix() - begin.frame.X_BM.matrix()).norm() < kGap &&
         end.held.q.size() == begin.held.q.size();
}

void check_pieces(const CompositePath& path, const std::string& pointer, Diagnostics& diagnostics) {
  double s = 0.0;
  for (std::size_t i = 0; i < path.pieces.size(); ++i) {
    const PathPiece& piece = path.pieces[i];
    const std::string place = pointer + pointer_segment(i);
    if (piece.s_begin != s)
      diagnostics.error(Code::kOutOfRange, place + "/s", fmt::format("begins at {}", piece.s_begin),
                        fmt::format("{}", s));
    s = piece.s_end;
    if (i > 0 && !meet(path.pieces[i - 1], piece)) {
      diagnostics.error(Code::kOutOfRange, place, "begins where the piece before does not end",
                        "Let pieces begin where the one before ends");
    }
  }
  if (s != 1.0) diagnostics.error(Code::kOutOfRange, pointer, fmt::format("the pieces end at s = {}", s), "End at 1");
}

CompositePath read_composite(ObjectReader& reader) {
  CompositePath path;
  const Json* pieces = reader.array("pieces");
  const std::string pointer = reader.at("pieces");
  for (std::size_t i = 0; pieces && i < pieces->size(); ++i) {
    path.pieces.push_back(read_piece((*pieces)[i], pointer + pointer_segment(i), reader.diagnostics()));
  }
  reader.finish();
  if (!reader.diagnostics().has_errors()) check_pieces(path, pointer, reader.diagnostics());
  return path;
}

/// Lines and arcs stand alone; curves only in a composite.
Path as_path(Geometry geometry) {
  return std::visit(
      [](auto& alternative) -> Path {
        using T = std::decay_t<decltype(alternative)>;
        if constexpr (std::is_constructible_v<Path, T>) {
          return std::move(alternative);
        } else {
          return CompositePath{{{.geometry = std::move(alternative)}}};
        }
      },
      geometry);
}

}  // namespace

Json to_json(const Path& path) {
  return std::visit([](const auto& alternative) { return write(alternative); }, path);
}

Result<Path> path_from_json(const Json& json, const std::string& pointer) {
  Diagnostics diagnostics;
  ObjectReader reader(json, pointer, diagnostics);
  std::vector<std::string> names = kind_names();
  names.emplace_back("composite");
  const std::string name = reader.choice("kind", names);
  Path path = name == "composite" ? Path(read_composite(reader)) : as_path(read_geometry(reader, name));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return path;
}

}  // namespace takt::motion
