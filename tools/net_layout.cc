// Layout of a picture of a net: sizes of the cards, then Graphviz's dot for places and curves.
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/graphviz.h"
#include "tools/net_picture.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Advance widths of the letters from ' ' to '~', 1/1000 of the size: DejaVu Sans, of which Verdana is a sister.
constexpr std::array<int, 95> kWidths = {
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361,  318, 337, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632,
    575, 775, 752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635,  611, 732, 684, 989, 685,
    611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352,  635, 634, 278, 278, 579,
    278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592,  525, 636, 337, 636, 838};
constexpr int kOtherWidth = 700;
constexpr double kBold = 1.12;  ///< how much wider bold letters run

void write_card(std::string& dot, const NetPicture::Card& card, std::size_t number) {
  const CardSize size = size_of(card);
  const auto cell = [&](const char* kind, int port, double width, double height) {
    const std::string name = port < 0 ? std::string() : fmt::format(" PORT=\"{}{}\"", kind, port);
    return fmt::format("<TD{} FIXEDSIZE=\"TRUE\" WIDTH=\"{:.0f}\" HEIGHT=\"{:.0f}\"></TD>", name, width, height);
  };
  dot += fmt::format("c{} [label=<<TABLE BORDER=\"0\" CELLBORDER=\"0\" CELLSPACING=\"0\" CELLPADDING=\"0\">", number);
  dot += fmt::format("<TR><TD COLSPAN=\"2\" FIXEDSIZE=\"TRUE\" WIDTH=\"{:.0f}\" HEIGHT=\"{:.0f}\"></TD></TR>",
                     size.width(), size.top);
  for (int row = 0; row < size.rows; ++row) {
    const bool in = row < static_cast<int>(card.inputs.size());
    const bool out = row < static_cast<int>(card.outputs.size());
    dot += "<TR>" + cell("i", in ? row : -1, size.left, CardSize::kPort) +
           cell("o", out ? row : -1, size.right, CardSize::kPort) + "</TR>";
  }
  dot += "</TABLE>>];\n";
}

/// Frames that hold a card, directly or in a frame inside.
std::vector<bool> filled_frames(const NetPicture& picture) {
  std::vector<bool> filled(picture.frames.size());
  for (const auto& card : picture.cards) {
    for (int f = card.frame; f >= 0; f = picture.frames[static_cast<std::size_t>(f)].parent) {
      filled[static_cast<std::size_t>(f)] = true;
    }
  }
  return filled;
}

/// The cards of a frame, and the frames in it, as clusters.
void write_frame(std::string& dot, const NetPicture& picture, const std::vector<bool>& filled, int frame) {
  if (frame > 0) {
    const auto& one = picture.frames[static_cast<std::size_t>(frame)];
    const double width = text_width(one.label, 12, true) + text_width(one.note, 10) + 30;
    dot += fmt::format(
        "subgraph cluster_{} {{ margin=14; labeljust=l; label=<<TABLE BORDER=\"0\" CELLBORDER=\"0\" CELLSPACING=\"0\" "
        "CELLPADDING=\"0\"><TR><TD FIXEDSIZE=\"TRUE\" WIDTH=\"{:.0f}\" HEIGHT=\"14\"></TD></TR></TABLE>>;\n",
        frame, width);
  }
  for (std::size_t c = 0; c < picture.cards.size(); ++c) {
    if (picture.cards[c].frame == frame) write_card(dot, picture.cards[c], c);
  }
  for (std::size_t f = 1; f < picture.frames.size(); ++f) {
    if (picture.frames[f].parent == frame && filled[f]) write_frame(dot, picture, filled, static_cast<int>(f));
  }
  if (frame > 0) dot += "}\n";
}

/// Sources of the net itself stand leftmost, what it ends in rightmost.
void write_ranks(std::string& dot, const NetPicture& picture) {
  std::vector<bool> fed(picture.cards.size()), read(picture.cards.size());
  for (const auto& wire : picture.wires) {
    if (!wire.delayed) fed[static_cast<std::size_t>(wire.to)] = true;
    read[static_cast<std::size_t>(wire.from)] = true;
  }
  std::string sources, sinks;
  for (std::size_t c = 0; c < picture.cards.size(); ++c) {
    const auto& card = picture.cards[c];
    if (card.frame != 0) continue;
    if (!fed[c] && card.role == NetPicture::Role::kSource) sources += fmt::format("c{}; ", c);
    const bool ends = card.role == NetPicture::Role::kDevice || card.role == NetPicture::Role::kEnd ||
                      card.role == NetPicture::Role::kMonitor;
    if (!read[c] && fed[c] && ends) sinks += fmt::format("c{}; ", c);
  }
  if (!sources.empty()) dot += "{ rank=source; " + sources + "}\n";
  if (!sinks.empty()) dot += "{ rank=sink; " + sinks + "}\n";
}

std::string to_dot(const NetPicture& picture) {
  std::string dot =
      "digraph net { rankdir=LR; nodesep=0.22; ranksep=0.55; splines=true; remincross=true; nslimit=4; nslimit1=4; "
      "node [shape=plain]; edge [arrowhead=none];\n";
  write_frame(dot, picture, filled_frames(picture), 0);
  write_ranks(dot, picture);
  for (std::size_t w = 0; w < picture.wires.size(); ++w) {
    const auto& wire = picture.wires[w];
    dot += fmt::format("c{}:o{}:e -> c{}:i{}:w [class=\"{}\", weight={}];\n", wire.from, wire.from_port, wire.to,
                       wire.to_port, w, wire.delayed ? 1 : (wire.critical ? 6 : 3));
  }
  return dot + "}\n";
}

std::vector<double> numbers_in(const std::string& text) {
  std::vector<double> numbers;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) {
    double number = 0.0;  // of any locale of the process: dot writes a point
    (void)std::from_chars(word.data(), word.data() + word.size(), number);
    numbers.push_back(number);
  }
  return numbers;
}

/// "x,y x,y ..." with y turned downwards.
std::vector<PlacedNet::Point> curve_of(const std::string& text, double height) {
  std::vector<PlacedNet::Point> points;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) {
    if (word.starts_with("s,") || word.starts_with("e,")) continue;
    const auto xy = numbers_in(word);
    if (xy.size() == 2) points.push_back({xy[0], height - xy[1]});
  }
  return points;
}

PlacedNet read_places(const Json& json, const NetPicture& picture) {
  PlacedNet placed;
  const auto whole = numbers_in(json.at("bb").get<std::string>());
  placed.width = whole.at(2);
  placed.height = whole.at(3);
  placed.cards.resize(picture.cards.size());
  placed.frames.resize(picture.frames.size());
  placed.wires.resize(picture.wires.size());
  for (const Json& one : json.value("objects", Json::array())) {
    const auto name = one.at("name").get<std::string>();
    if (name.starts_with("cluster_")) {
      const auto box = numbers_in(one.at("bb").get<std::string>());
      placed.frames.at(std::stoul(name.substr(8))) = {box.at(0), placed.height - box.at(3), box.at(2) - box.at(0),
                                                      box.at(3) - box.at(1)};
    } else if (name.starts_with("c")) {
      const std::size_t card = std::stoul(name.substr(1));
      const auto centre = numbers_in(one.at("pos").get<std::string>());
      const CardSize size = size_of(picture.cards.at(card));
      placed.cards.at(card) = {centre.at(0) - size.width() / 2, placed.height - centre.at(1) - size.height() / 2,
                               size.width(), size.height()};
    }
  }
  for (const Json& one : json.value("edges", Json::array())) {
    placed.wires.at(std::stoul(one.at("class").get<std::string>())) =
        curve_of(one.at("pos").get<std::string>(), placed.height);
  }
  return placed;
}

}  // namespace

double text_width(std::string_view text, double size, bool bold) {
  int sum = 0;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if ((code & 0xc0) == 0x80) continue;  // the rest of a letter
    sum += code >= ' ' && code <= '~' ? kWidths[code - ' '] : kOtherWidth;
  }
  return sum * size / 1000.0 * (bold ? kBold : 1.0);
}

CardSize size_of(const NetPicture::Card& card) {
  CardSize size;
  const bool gate = card.role == NetPicture::Role::kGate;
  size.rows = gate ? 1 : static_cast<int>(std::max(card.inputs.size(), card.outputs.size()));
  size.top = gate ? 4 : CardSize::kHeader + static_cast<double>(card.lines.size()) * CardSize::kLine;
  if (!gate && !card.lines.empty()) size.top += 6;
  if (!gate && size.rows > 0) size.top += 4;
  for (const auto& port : card.inputs) {
    const std::string text = port.constant.empty() ? port.name : port.name + " = " + port.constant;
    size.left = std::max(size.left, text_width(text, 10) + 1.7 * CardSize::kMargin);
  }
  for (const auto& port : card.outputs) {
    size.right = std::max(size.right, text_width(port.name, 10) + 1.7 * CardSize::kMargin);
  }
  double wanted = gate ? 0 : std::max(text_width(card.label, 12, true), text_width(card.type, 10));
  for (const std::string& line : card.lines) wanted = std::max(wanted, text_width(line, 10));
  wanted += 2 * CardSize::kMargin;
  if (const double missing = wanted - size.width(); missing > 0) {
    size.left += missing / 2;
    size.right += missing / 2;
  }
  size.left = std::ceil(std::max(size.left, 12.0));
  size.right = std::ceil(std::max(size.right, 12.0));
  return size;
}

Result<PlacedNet> place(const NetPicture& picture) {
  const auto placed = run_dot(to_dot(picture), "json0", "--graph");
  if (!placed) return std::unexpected(placed.error());
  try {
    return read_places(Json::parse(*placed), picture);
  } catch (const std::exception& error) {
    return failure(Code::kSyntax, "--graph", fmt::format("dot's answer cannot be read: {}", error.what()));
  }
}

}  // namespace takt::tools
