#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/net/description.h"
#include "core/net/net_report.h"

namespace takt::tools {

/// A net as it is drawn: cards for primitives, frames around those of a fragment, wires between ports. Made from what
/// LOAD knows; without places yet.
struct NetPicture {
  enum class Role { kPlain, kSource, kDevice, kEnd, kMonitor, kGate, kClosed };
  struct Port {
    std::string name;
    std::string constant;  ///< of an input without a wire: its value; else empty
    std::string about;     ///< type, unit, documentation: shown under the pointer
  };
  struct Card {
    std::string id;                  ///< full id
    std::string label;               ///< id without the fragments around
    std::string type;                ///< second line
    std::string about;               ///< shown under the pointer
    std::vector<std::string> lines;  ///< parameters, "name = value"
    std::vector<Port> inputs, outputs;
    Role role = Role::kPlain;
    int frame = 0;
  };
  struct Frame {
    std::string id;  ///< full id
    std::string label;
    std::string note;  ///< what it does while it rests; empty if it never does
    int parent = -1;   ///< number 0 is the net itself
  };
  struct Wire {
    int from = 0, from_port = 0, to = 0, to_port = 0;  ///< cards and their ports
    bool delayed = false;
    bool null_path = false;  ///< null reaches a stop or an actuator this way
    bool critical = false;   ///< on the critical path of the certificate's slowest line
    bool operator==(const Wire&) const = default;
  };
  std::string title, subtitle;
  std::string critical;  ///< the line of the certificate whose path is marked; empty: none
  std::vector<Card> cards;
  std::vector<Frame> frames;
  std::vector<Wire> wires;
};

/// @return the picture; with many primitives the inner fragments are drawn as one card each. Diagnostics: there are too
/// many even so. Realtime: setup.
[[nodiscard]] Result<NetPicture> picture_of(const net::NetReport& report, const net::NetDescription& description);

/// An id for people: what it has in place of characters that ids cannot have ("%2f") is what it stands for.
[[nodiscard]] std::string shown_id(std::string_view id);

/// Where everything lies, in pixels, y downwards.
struct PlacedNet {
  struct Box {
    double x = 0, y = 0, width = 0, height = 0;
  };
  struct Point {
    double x = 0, y = 0;
  };
  double width = 0, height = 0;
  std::vector<Box> cards, frames;         ///< frame 0 is empty
  std::vector<std::vector<Point>> wires;  ///< cubic Bezier curves: 1 + 3 n points
};

/// Sizes of a card's parts in pixels; the layout and the drawing agree on them.
struct CardSize {
  static constexpr double kHeader = 34, kLine = 14, kPort = 17, kMargin = 9;
  double left = 0, right = 0;  ///< columns of inputs and outputs
  double top = 0;              ///< header and parameters
  int rows = 0;                ///< of ports
  [[nodiscard]] double width() const { return left + right; }
  [[nodiscard]] double height() const { return top + rows * kPort; }
};
[[nodiscard]] CardSize size_of(const NetPicture::Card& card);
/// Width of a text in DejaVu Sans or Verdana, pixels.
[[nodiscard]] double text_width(std::string_view text, double size, bool bold = false);

/// Lays the picture out in layers from left to right, with Graphviz's `dot`. Diagnostics: the program is missing or
/// failed.
[[nodiscard]] Result<PlacedNet> place(const NetPicture& picture);

/// The picture as SVG. Groups and paths carry ids and ends as data attributes, for tools.
[[nodiscard]] std::string to_svg(const NetPicture& picture, const PlacedNet& placed);

}  // namespace takt::tools
