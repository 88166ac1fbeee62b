// The drawing: cards, frames, wires, legend.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/base/xml_text.h"
#include "tools/net_picture.h"

namespace takt::tools {
namespace {

using Role = NetPicture::Role;

constexpr double kEdge = 24;    ///< around everything
constexpr double kTitle = 62;   ///< height of the title
constexpr double kLegend = 46;  ///< height of the legend

struct RoleLook {
  const char* colour;
  const char* name;  ///< in the legend
};
/// In the order of the roles.
constexpr std::array<RoleLook, 7> kLooks = {{{"#475569", "primitive"},
                                             {"#047857", "source"},
                                             {"#1d4ed8", "drives a device"},
                                             {"#b91c1c", "ends or cancels"},
                                             {"#6d28d9", "monitor"},
                                             {"#b45309", "activation"},
                                             {"#0f172a", "closed fragment"}}};
constexpr const char* kWire = "#64748b";
constexpr const char* kCritical = "#be185d";
constexpr const char* kNull = "#f59e0b";

const RoleLook& look(Role role) { return kLooks.at(static_cast<std::size_t>(role)); }

std::string text_at(double x, double y, std::string_view style, std::string_view text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"{}\">{}</text>\n", x, y, style, xml_text(text));
}

constexpr const char* kStyle = R"(<style>
text { font-family: Verdana, 'DejaVu Sans', 'Bitstream Vera Sans', sans-serif; fill: #334155; font-size: 10px; }
.title { font-size: 19px; font-weight: bold; fill: #0f172a; }
.subtitle { font-size: 11px; fill: #64748b; }
.label { font-size: 12px; font-weight: bold; fill: #ffffff; }
.type { fill: #ffffff; fill-opacity: 0.82; }
.line { fill: #64748b; }
.out, .end { text-anchor: end; }
.constant { fill: #94a3b8; }
.name { font-size: 12px; font-weight: bold; fill: #475569; }
.note { fill: #94a3b8; font-style: italic; }
path { fill: none; }
</style>
)";

/// A rectangle with round corners above and straight ones below.
std::string header_path(const PlacedNet::Box& box, double height, bool whole) {
  constexpr double r = 6;
  if (whole) {
    return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"{}\"", box.x, box.y,
                       box.width, box.height, r);
  }
  return fmt::format("<path d=\"M{:.1f},{:.1f}v{:.1f}a{r},{r} 0 0 1 {r},-{r}h{:.1f}a{r},{r} 0 0 1 {r},{r}v{:.1f}z\"",
                     box.x, box.y + height, r - height, box.width - 2 * r, height - r, fmt::arg("r", r));
}

/// The point half way along a curve.
PlacedNet::Point middle_of(const std::vector<PlacedNet::Point>& points) {
  constexpr int kSteps = 20;
  std::vector<PlacedNet::Point> way = {points.front()};
  std::vector<double> length = {0.0};
  for (std::size_t i = 0; i + 3 < points.size(); i += 3) {
    for (int k = 1; k <= kSteps; ++k) {
      const double t = static_cast<double>(k) / kSteps, u = 1 - t;
      const auto at = [&](double PlacedNet::Point::*c) {
        return u * u * u * points[i].*c + 3 * t * u * u * points[i + 1].*c + 3 * t * t * u * points[i + 2].*c +
               t * t * t * points[i + 3].*c;
      };
      way.push_back({at(&PlacedNet::Point::x), at(&PlacedNet::Point::y)});
      const auto& before = way[way.size() - 2];
      length.push_back(length.back() + std::hypot(way.back().x - before.x, way.back().y - before.y));
    }
  }
  return way[static_cast<std::size_t>(std::ranges::lower_bound(length, length.back() / 2) - length.begin())];
}

class Drawing {
 public:
  Drawing(const NetPicture& picture, const PlacedNet& placed) : picture_(picture), placed_(placed) {}

  std::string draw() {
    const double legend_width = legend_items(0).second + 2 * kEdge;
    const double title_width = std::max(text_width(picture_.title, 19, true), text_width(subtitle(), 11)) + 2 * kEdge;
    const double width = std::max({placed_.width + 2 * kEdge, legend_width, title_width});
    const double height = placed_.height + 2 * kEdge + kTitle + kLegend;
    svg_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0f}\" height=\"{:.0f}\" "
        "viewBox=\"0 0 {:.0f} {:.0f}\">\n",
        width, height, width, height);
    svg_ += kStyle;
    svg_ += "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
    svg_ += text_at(kEdge, kEdge + 18, "title", picture_.title);
    svg_ += text_at(kEdge, kEdge + 37, "subtitle", subtitle());
    const double dx = std::max(kEdge, (width - placed_.width) / 2);
    svg_ += fmt::format("<g transform=\"translate({:.1f},{:.1f})\">\n", dx, kEdge + kTitle);
    for (std::size_t f = 1; f < picture_.frames.size(); ++f) frame(f);
    // What is marked lies on top of what is not.
    for (std::size_t w = 0; w < picture_.wires.size(); ++w) {
      if (picture_.wires[w].null_path) under(w);
    }
    for (const bool critical : {false, true}) {
      for (std::size_t w = 0; w < picture_.wires.size(); ++w) {
        if (picture_.wires[w].critical == critical) wire(w);
      }
    }
    for (std::size_t c = 0; c < picture_.cards.size(); ++c) card(c);
    svg_ += "</g>\n" + legend_items(height - kEdge - kLegend / 2).first + "</svg>\n";
    return std::move(svg_);
  }

 private:
  [[nodiscard]] std::string subtitle() const {
    return picture_.subtitle + (picture_.critical.empty() ? "" : "; slowest reaction: " + picture_.critical);
  }

  int depth(std::size_t frame) const {
    int depth = 0;
    for (int f = picture_.frames[frame].parent; f > 0; f = picture_.frames[static_cast<std::size_t>(f)].parent) ++depth;
    return depth;
  }

  void frame(std::size_t number) {
    const auto& box = placed_.frames[number];
    const auto& one = picture_.frames[number];
    if (box.width <= 0) return;  // it lies in a closed one
    svg_ += fmt::format(
        "<rect class=\"frame\" data-id=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"10\" "
        "fill=\"{}\" "
        "stroke=\"#cbd5e1\"{}/>\n",
        xml_text(one.id), box.x, box.y, box.width, box.height, depth(number) % 2 == 0 ? "#f1f5f9" : "#e6ecf4",
        one.note.empty() ? "" : " stroke-dasharray=\"5 3\"");
    svg_ += text_at(box.x + 12, box.y + 18, "name", one.label);
    if (!one.note.empty()) svg_ += text_at(box.x + 20 + text_width(one.label, 12, true), box.y + 18, "note", one.note);
  }

  [[nodiscard]] std::string curve(std::size_t number) const {
    const auto& points = placed_.wires[number];
    std::string d;
    for (std::size_t i = 0; i < points.size(); ++i) {
      d += fmt::format("{}{:.1f},{:.1f}", i == 0 ? "M" : (i == 1 ? "C" : " "), points[i].x, points[i].y);
    }
    return d;
  }

  void under(std::size_t number) {
    svg_ +=
        fmt::format("<path d=\"{}\" stroke=\"{}\" stroke-width=\"6\" stroke-opacity=\"0.5\"/>\n", curve(number), kNull);
  }

  void wire(std::size_t number) {
    const auto& one = picture_.wires[number];
    const auto& points = placed_.wires[number];
    if (points.empty()) return;
    const auto& from = picture_.cards[static_cast<std::size_t>(one.from)];
    const auto& to = picture_.cards[static_cast<std::size_t>(one.to)];
    const std::string ends =
        fmt::format("{}.{}|{}.{}", from.id, from.outputs[static_cast<std::size_t>(one.from_port)].name, to.id,
                    to.inputs[static_cast<std::size_t>(one.to_port)].name);
    svg_ += fmt::format(
        "<path class=\"wire\" data-wire=\"{}\" d=\"{}\" stroke=\"{}\" stroke-width=\"{}\"{}><title>{}</title></path>\n",
        xml_text(ends), curve(number), one.critical ? kCritical : kWire, one.critical ? "2.6" : "1.3",
        one.delayed ? " stroke-dasharray=\"6 4\"" : "", xml_text(shown_id(ends)));
    const auto& end = points.back();
    svg_ += fmt::format("<path d=\"M{:.1f},{:.1f}l-8,-3.6v7.2z\" style=\"fill:{}\"/>\n", end.x - 2.5, end.y,
                        one.critical ? kCritical : kWire);
    if (one.delayed) delay_mark(points);
  }

  /// A pill in the middle of the curve.
  void delay_mark(const std::vector<PlacedNet::Point>& points) {
    const PlacedNet::Point middle = middle_of(points);
    svg_ += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"26\" height=\"14\" rx=\"7\" fill=\"#ffffff\" stroke=\"{}\"/>\n",
        middle.x - 13, middle.y - 7, kWire);
    svg_ +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">z⁻¹</text>\n", middle.x, middle.y + 3.5);
  }

  void card(std::size_t number) {
    const auto& one = picture_.cards[number];
    const auto& box = placed_.cards[number];
    const CardSize size = size_of(one);
    const bool gate = one.role == Role::kGate;
    svg_ += fmt::format("<g class=\"card\" data-id=\"{}\"><title>{}</title>\n", xml_text(one.id), xml_text(one.about));
    svg_ += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"6\" fill=\"#ffffff\" "
        "stroke=\"{}\"/>\n",
        box.x, box.y, box.width, box.height, gate ? look(one.role).colour : "#94a3b8");
    if (!gate) header(one, box, size);
    for (std::size_t i = 0; i < one.inputs.size(); ++i) port(one.inputs[i], true, box, size, i);
    for (std::size_t i = 0; i < one.outputs.size(); ++i) port(one.outputs[i], false, box, size, i);
    svg_ += "</g>\n";
  }

  void header(const NetPicture::Card& one, const PlacedNet::Box& box, const CardSize& size) {
    const bool only = size.rows == 0 && one.lines.empty();
    svg_ += header_path(box, CardSize::kHeader, only) + fmt::format(" style=\"fill:{}\"/>\n", look(one.role).colour);
    svg_ += text_at(box.x + CardSize::kMargin, box.y + 15, "label", one.label);
    svg_ += text_at(box.x + CardSize::kMargin, box.y + 28, "type", one.type);
    double y = box.y + CardSize::kHeader + CardSize::kLine;
    for (const std::string& line : one.lines) {
      svg_ += text_at(box.x + CardSize::kMargin, y, "line", line);
      y += CardSize::kLine;
    }
  }

  void port(const NetPicture::Port& one, bool input, const PlacedNet::Box& box, const CardSize& size, std::size_t row) {
    const double y = box.y + size.top + (static_cast<double>(row) + 0.5) * CardSize::kPort;
    const double x = input ? box.x : box.x + box.width;
    const bool constant = !one.constant.empty();
    const std::string text = constant ? one.name + " = " + one.constant : one.name;
    if (!constant) {
      svg_ += fmt::format(
          "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\" stroke=\"#475569\"><title>{}</title></circle>\n", x,
          y, input ? "#475569" : "#ffffff", xml_text(one.about));
    }
    svg_ += text_at(input ? x + CardSize::kMargin : x - CardSize::kMargin, y + 3.5,
                    constant ? "constant" : (input ? "in" : "out"), text);
  }

  /// The signs that occur, in one row around this height. @return the drawing, and where it ends.
  [[nodiscard]] std::pair<std::string, double> legend_items(double y) const {
    std::string out;
    double x = kEdge;
    const auto words = [&](std::string_view text) {
      out += text_at(x, y + 3.5, "line", text);
      x += text_width(text, 10) + 20;
    };
    for (std::size_t role = 0; role < kLooks.size(); ++role) {
      if (std::ranges::none_of(picture_.cards, [&](const auto& c) { return c.role == static_cast<Role>(role); }))
        continue;
      out += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"12\" height=\"12\" rx=\"3\" fill=\"{}\"/>\n", x,
                         y - 6, kLooks[role].colour);
      x += 17;
      words(kLooks[role].name);
    }
    const auto sample = [&](bool shown, std::string_view attributes, std::string_view text) {
      if (!shown) return;
      out += fmt::format("<path d=\"M{:.1f},{:.1f}h30\" {}/>\n", x, y, attributes);
      x += 36;
      words(text);
    };
    const auto any = [&](bool NetPicture::Wire::*flag) {
      return std::ranges::any_of(picture_.wires, [&](const auto& wire) { return wire.*flag; });
    };
    sample(any(&NetPicture::Wire::delayed),
           fmt::format("stroke=\"{}\" stroke-width=\"1.3\" stroke-dasharray=\"6 4\"", kWire), "delayed by one cycle");
    sample(any(&NetPicture::Wire::null_path),
           fmt::format("stroke=\"{}\" stroke-width=\"6\" stroke-opacity=\"0.5\"", kNull),
           "null can reach a stop or a device");
    sample(any(&NetPicture::Wire::critical), fmt::format("stroke=\"{}\" stroke-width=\"2.6\"", kCritical),
           "slowest reaction");
    return {out, x};
  }

  const NetPicture& picture_;
  const PlacedNet& placed_;
  std::string svg_;
};

}  // namespace

std::string to_svg(const NetPicture& picture, const PlacedNet& placed) { return Drawing(picture, placed).draw(); }

}  // namespace takt::tools
