#pragma once

#include <string_view>

namespace takt::record {

/// Zoom along time and cursors in the pictures of a report: all pictures move together. The page is complete without.
inline constexpr std::string_view kReportScript = R"js(
(() => {
const SVG = document.querySelector('svg.plot')?.namespaceURI, LEFT = 64, RIGHT = 988, WIDTH = RIGHT - LEFT;
const plots = [...document.querySelectorAll('svg.plot')].map(node => {
  const numbers = name => node.dataset[name].split(' ').map(Number);
  const add = (kind, attributes) => {
    const one = document.createElementNS(SVG, kind);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    node.append(one);
    return one;
  };
  const height = node.viewBox.baseVal.height;
  return {node, add, height, time: numbers('time'), value: numbers('value'), strip: numbers('strip'),
          unit: node.dataset.unit, pane: node.querySelector('svg.window'), ticks: [],
          line: add('path', {stroke: '#1c2330', 'stroke-width': 1, visibility: 'hidden'}),
          mark: add('path', {stroke: '#16794c', 'stroke-width': 1, visibility: 'hidden'}),
          band: add('rect', {y: 0, height, fill: '#1f6feb', 'fill-opacity': 0.15, visibility: 'hidden'}),
          read: add('text', {x: RIGHT, y: 14, 'text-anchor': 'end'})};
});
if (!plots.length) return;
const all = [Math.min(...plots.map(p => p.time[0])), Math.max(...plots.map(p => p.time[1]))];
let shown = all, marked = null, pressed = null;

// A point of the picture as it is shown to its time, and back; as it is drawn: from the whole time of the picture.
const timeAt = x => shown[0] + (x - LEFT) / WIDTH * (shown[1] - shown[0]);
const placeOf = time => LEFT + (time - shown[0]) / (shown[1] - shown[0]) * WIDTH;
const drawn = (plot, time) => LEFT + (time - plot.time[0]) / (plot.time[1] - plot.time[0]) * WIDTH;

// Points of a drawn curve; a path is "Mx y" and steps "ldx dy".
function points(plot, name) {
  const path = plot.pane.querySelector('path.' + name);
  if (!path) return null;
  if (plot[name]) return plot[name];
  const list = [];
  let x = 0, y = 0;
  for (const [, kind, dx, dy] of path.getAttribute('d').matchAll(/([Ml])(-?[\d.e-]+) (-?[\d.e-]+)/g)) {
    if (kind === 'M') { if (list.length) list.push([Number(dx), NaN]); x = Number(dx); y = Number(dy); }
    else { x += Number(dx); y += Number(dy); }
    list.push([x, y]);
  }
  return plot[name] = list;
}
function valueAt(plot, name, time) {
  const list = points(plot, name);
  if (!list || !list.length) return null;
  const x = drawn(plot, time);
  let low = 0, high = list.length - 1;
  if (x < list[0][0] - 0.1 || x > list[high][0] + 0.1) return null;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle][0] <= x) low = middle; else high = middle;
  }
  const [x0, y0] = list[low], [x1, y1] = list[high];
  const share = x1 > x0 ? Math.min(1, Math.max(0, (x - x0) / (x1 - x0))) : 1, y = y0 + (y1 - y0) * share;
  return plot.value[1] - (y - plot.strip[0]) / plot.strip[1] * (plot.value[1] - plot.value[0]);
}
const text = (value, unit) =>
  value === null || Number.isNaN(value) ? 'null' : `${Number(value.toPrecision(4))} ${unit}`.trim();

function zoom(from, to) {
  shown = to - from > 1e-6 ? [Math.max(all[0], from), Math.min(all[1], to)] : shown;
  const whole = shown[0] === all[0] && shown[1] === all[1];
  for (const plot of plots) {
    const x0 = drawn(plot, shown[0]), x1 = drawn(plot, shown[1]);
    plot.pane.setAttribute('viewBox', `${x0} 0 ${x1 - x0} ${plot.height}`);
    // Names of steps would be stretched with the curves.
    for (const label of [...plot.pane.querySelectorAll('text'), ...plot.node.querySelectorAll('text.time')])
      label.setAttribute('visibility', whole ? 'visible' : 'hidden');
    for (const tick of plot.ticks.splice(0)) tick.remove();
    for (let i = 0; !whole && i <= 5; ++i) {
      const y = plot.strip[0] + plot.strip[1] + 16;
      const tick = plot.add('text', {x: LEFT + WIDTH * i / 5, y, 'text-anchor': 'middle'});
      tick.textContent = `${(shown[0] + (shown[1] - shown[0]) * i / 5).toFixed(3)} s`;
      plot.ticks.push(tick);
    }
  }
  draw(null);
}
function upright(line, plot, time) {
  const x = placeOf(time), seen = x >= LEFT && x <= RIGHT;
  line.setAttribute('visibility', seen ? 'visible' : 'hidden');
  line.setAttribute('d', `M${x} ${plot.strip[0]}V${plot.height}`);
}
function draw(time) {
  for (const plot of plots) {
    if (marked !== null) upright(plot.mark, plot, marked); else plot.mark.setAttribute('visibility', 'hidden');
    if (time === null) { plot.line.setAttribute('visibility', 'hidden'); plot.read.textContent = ''; continue; }
    upright(plot.line, plot, time);
    const parts = [`${time.toFixed(3)} s`, `A ${text(valueAt(plot, 'a', time), plot.unit)}`];
    if (points(plot, 'b')) parts.push(`B ${text(valueAt(plot, 'b', time), plot.unit)}`);
    if (marked !== null) {
      parts.push(`since the mark ${(time - marked).toFixed(3)} s`);
      const before = valueAt(plot, 'a', marked), now = valueAt(plot, 'a', time);
      if (before !== null && now !== null) parts.push(`A ${text(now - before, plot.unit)}`);
    }
    plot.read.textContent = parts.join('   ');
  }
}
for (const plot of plots) {
  const at = event => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(plot.node.getScreenCTM().inverse());
    return Math.min(RIGHT, Math.max(LEFT, point.x));
  };
  plot.node.addEventListener('pointerdown', event => {
    pressed = at(event);
    plot.node.setPointerCapture(event.pointerId);
  });
  plot.node.addEventListener('pointermove', event => {
    const x = at(event);
    draw(timeAt(x));
    if (pressed === null) return;
    plot.band.setAttribute('visibility', 'visible');
    plot.band.setAttribute('x', Math.min(pressed, x));
    plot.band.setAttribute('width', Math.abs(x - pressed));
  });
  plot.node.addEventListener('pointerup', event => {
    const x = at(event), from = timeAt(Math.min(pressed, x)), to = timeAt(Math.max(pressed, x));
    plot.band.setAttribute('visibility', 'hidden');
    if (Math.abs(x - pressed) > 4) zoom(from, to); else { marked = timeAt(x); draw(marked); }
    pressed = null;
  });
  plot.node.addEventListener('pointerleave', () => { if (pressed === null) draw(null); });
  plot.node.addEventListener('dblclick', () => { marked = null; zoom(...all); });
}
})();
)js";

}  // namespace takt::record
